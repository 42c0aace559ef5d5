/* The cheapest sequence of motions along and about single axes, one after the other, that makes a displacement. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define HALF_TURN 3.14159265358979323846
#define TURN (2.0 * HALF_TURN)
#define NEGLIGIBLE 1e-13 /* displacements below this are none, and sines below this are zero [L, rad] */
#define GRID 9           /* yaws towards the goal that are tried, from none to the whole bearing */
#define BESIDE 5         /* and more of them beside the best: some 4 degrees apart, and then 1 */
#define DIGITS 1e9       /* prices are compared to so many units, so that rounding errors decide no order */
#define MOST 7           /* motions */

enum { X, Y, Z, ROLL, PITCH, YAW };

struct way {
    int count, along[MOST];
    double amount[MOST], price;
};

/* Of every motion the strokes that make it, each of three numbers: what its approach, and each cycle, travels [rad], and
 * how far a cycle goes [L or rad]. */
struct book {
    const SIZE *counts;
    const double *strokes[6];
};

static double nearest(double x) { return fabs(x) < 2251799813685248.0 ? (x + 6755399441055744.0) - 6755399441055744.0 : x; }

/* The remainder of the nearest whole number of turns, exactly for up to two. */
static double within_half_a_turn(double angle) { return angle - TURN * nearest(angle / TURN); }

/* Cube roots by Newton's method. */
static double cube_root(double x) {
    if (!(x > 0.0)) return 0.0;
    double scale = 1.0;
    for (; x >= 8.0 && x < 1e300; x *= 0.125) scale *= 2.0;
    for (; x < 1.0 && x > 1e-300; x *= 8.0) scale *= 0.5;
    double root = 1.0 + 0.15 * (x - 1.0);
    for (int k = 0; k < 7; k++) root -= (root * root * root - x) / (3.0 * root * root);
    return scale * root;
}

/* About the joint travel of a motion: of n cycles, or of a part of one, at smaller amplitudes that go less far. */
static double price_of(const struct book *book, int along, double amount) {
    double least = INFINITY;
    const double *stroke = book->strokes[along];
    for (SIZE k = 0; k < book->counts[along]; k++, stroke += 3) {
        const double count = fabs(amount) / stroke[2], below = count < 4503599627370496.0 ? nearest(count) : count;
        const double whole = below < count ? below + 1.0 : below;
        const double found = stroke[0] + stroke[1] * cube_root(whole * whole * count);
        least = found < least ? found : least;
    }
    return least;
}

/* Adds a motion, to the one before where that goes the same way. */
static void add(struct way *way, int along, double amount) {
    if (fabs(amount) <= NEGLIGIBLE) return;
    if (way->count && way->along[way->count - 1] == along) {
        amount += way->amount[--way->count];
        if (along == ROLL || along == YAW) amount = within_half_a_turn(amount);
    }
    way->along[way->count] = along;
    way->amount[way->count++] = amount;
}

static void keep_cheaper(const struct book *book, struct way *way, struct way *best) {
    double price = 0.0;
    for (int k = 0; k < way->count; k++) price += price_of(book, way->along[k], way->amount[k]);
    way->price = nearest(DIGITS * price);
    if (way->price < best->price) *best = *way;
}

/* Ends a way with the turns that make a rotation: roll, yaw, roll, in both ways there are, or pitch alone. */
static void turned(const struct book *book, const struct way *begun, const double r[9], struct way *best) {
    const double sine = sqrt(r[3] * r[3] + r[6] * r[6]), yaw = purcell_arctan2_of(sine, r[0]);
    const int single = sine < NEGLIGIBLE;
    double first, last;
    if (single) {
        first = 0.0;
        last = r[0] > 0.0 ? purcell_arctan2_of(r[7], r[4]) : -purcell_arctan2_of(-r[7], -r[4]);
    } else {
        first = purcell_arctan2_of(r[6], r[3]);
        last = purcell_arctan2_of(r[2], -r[1]);
    }
    for (int other = 0; other < (single ? 1 : 2); other++) {
        struct way way = *begun;
        add(&way, ROLL, other ? within_half_a_turn(first + HALF_TURN) : first);
        add(&way, YAW, other ? -yaw : yaw);
        add(&way, ROLL, other ? within_half_a_turn(last + HALF_TURN) : last);
        keep_cheaper(book, &way, best);
    }
    double s, c, off = 0.0;
    const double pitch = purcell_arctan2_of(r[2], r[0]);
    purcell_sin_cos_of(pitch, &s, &c);
    const double alone[9] = {c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c};
    for (int i = 0; i < 9; i++) off = fabs(alone[i] - r[i]) > off ? fabs(alone[i] - r[i]) : off;
    if (off < NEGLIGIBLE) {
        struct way way = *begun;
        add(&way, PITCH, pitch);
        keep_cheaper(book, &way, best);
    }
}

/* A roll brings the way to go into the x-y plane, a yaw turns a part of the way towards it, and x and y go it. */
static struct way towards(const struct book *book, const double r[9], const double p[3], double roll, double y,
                          double part) {
    struct way begun = {.count = 0}, best = {.price = INFINITY};
    const double yaw = part * (purcell_arctan2_of(y, p[0]) - HALF_TURN * nearest(purcell_arctan2_of(y, p[0]) / HALF_TURN));
    double s, c, done[9], back[9], left[9], sine, cosine;
    purcell_sin_cos_of(yaw, &s, &c);
    add(&begun, ROLL, roll);
    add(&begun, YAW, yaw);
    add(&begun, X, c * p[0] + s * y);
    add(&begun, Y, c * y - s * p[0]);
    purcell_sin_cos_of(roll, &sine, &cosine);
    const double rolled[9] = {1.0, 0.0, 0.0, 0.0, cosine, -sine, 0.0, sine, cosine};
    const double yawed[9] = {c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0};
    product(rolled, yawed, done, 3, 3, 3);
    for (int i = 0; i < 9; i++) back[i] = done[3 * (i % 3) + i / 3];
    product(back, r, left, 3, 3, 3);
    turned(book, &begun, left, &best);
    return best;
}

/* The cheapest motions found: straight along the axes, or, a roll first, forwards or backwards towards the goal.
 *
 * displacement: (4, 4). counts: how many strokes make each of the six motions, (6,), and strokes: those, (n, 3).
 * along, amount: which motions, and how far, (MOST,). Returns how many they are. */
API SIZE purcell_sequence(const double *displacement, const SIZE *counts, const double *strokes, SIZE *along,
                          double *amount) {
    struct book book = {.counts = counts};
    double r[9], p[3];
    for (int i = 0; i < 6; i++) {
        book.strokes[i] = strokes;
        strokes += 3 * counts[i];
    }
    for (int i = 0; i < 9; i++) r[i] = displacement[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) p[i] = displacement[4 * i + 3];
    const double aside = sqrt(p[1] * p[1] + p[2] * p[2]);
    const int few = aside > NEGLIGIBLE ? GRID : 1;
    const double first_roll = aside > NEGLIGIBLE ? purcell_arctan2_of(p[2], p[1]) : 0.0;
    struct way begun = {.count = 0}, best = {.price = INFINITY};
    for (int i = 0; i < 3; i++) add(&begun, i, p[i]);
    turned(&book, &begun, r, &best);
    for (int sense = 1; sense >= -1; sense -= 2) {
        const double roll = within_half_a_turn(first_roll + (sense > 0 ? 0.0 : HALF_TURN)), y = sense * aside;
        double least = INFINITY, near = 0.0;
        for (int k = 0; k < few; k++) {
            const double part = few > 1 ? (double)k / (GRID - 1) : 0.0;
            const struct way found = towards(&book, r, p, roll, y, part);
            if (found.price < least) {
                least = found.price;
                near = part;
            }
            if (found.price < best.price) best = found;
        }
        const double low = near - 1.0 / GRID, high = near + 1.0 / GRID, step = (high - low) / (BESIDE - 1);
        for (int k = 0; k < BESIDE && few > 1; k++) {
            const double part = k + 1 < BESIDE ? k * step + low : high;
            if (!(0.0 < part && part < 1.0)) continue;
            const struct way found = towards(&book, r, p, roll, y, part);
            if (found.price < best.price) best = found;
        }
    }
    for (int k = 0; k < best.count; k++) {
        along[k] = best.along[k];
        amount[k] = best.amount[k];
    }
    return best.count;
}
