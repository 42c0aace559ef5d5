/* Chains of rolls and loops of both limbs: what they do and cost, by the loops' series, and how they settle on a
 * displacement. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define DIFFERENCE 1e-6  /* the step of difference quotients by bend, offset share and roll [rad] */
#define NEARBY 3e-3      /* chains that miss by less are compared by cost, others by what they miss [L, rad] */
#define FAR 1.0          /* over distances above this, errors across the way count in proportion to it: a heading [L] */
#define FAR_AHEAD 1000.0 /* the same along the way [L] */
#define THRIFT 2.0       /* step along the cost gradient in each round, in joint travel [rad] */
#define LONGEST 0.3      /* the largest change of a bend, an offset share or a roll in one step [rad] */
#define MOST_TERMS 16    /* Chebyshev terms of a series in one variable */
#define PI 3.141592653589793
enum { TRAVEL, ENERGY, SWITCHES };

/* The loops of one kind, as the numbers before their series. */
struct loops {
    double least_bend, most_bend, least_offset_share, most_offset_share;
    double power;        /* 1 or 2: the root of the offset share that is the series' second variable */
    double across;       /* whether they are bent to one side across their plane */
    double unit;         /* what a cost of 1 rad is in the measure */
    double rows, columns, values; /* of the series: terms in the bend, in the root, and numbers each */
};

struct arc {
    double cycle[3][6], ways[3][6]; /* twists, and how they change with bend and offset share */
    double paid, by[2];             /* cost, and how it changes */
};

/* What paying for loops of a half side and an offset makes by joint travel: a cycle, and the ways there and back. */
static void travel_of(const struct loops *l, double bend, double offset_share, double out[2]) {
    double half_side = bend * (1.0 - offset_share), offset = bend * offset_share;
    if (l->across != 0.0) {
        double sb, cb, sa, ca;
        purcell_sin_cos_of(bend, &sb, &cb);
        purcell_sin_cos_of(offset_share, &sa, &ca);
        const double s = sb * sa;
        half_side = purcell_arctan2_of(sb / cb * ca, 1.0);
        offset = purcell_arctan2_of(s, sqrt((1.0 - s) * (1.0 + s)));
    }
    out[0] = 8.0 * half_side;
    out[1] = 4.0 * (l->across != 0.0 ? half_side + offset : fabs(half_side - offset));
}

static void look_up(const struct loops *l, const double *series, int measure, double cycles, double bend, double offset_share,
                    struct arc *out) {
    const int rows = (int)l->rows, columns = (int)l->columns, values = (int)l->values;
    const double over = 2.0 / (l->most_bend - l->least_bend);
    const double share = offset_share > l->least_offset_share ? offset_share : l->least_offset_share;
    const double part = share / l->most_offset_share;
    const double root = l->power == 2.0 ? sqrt(part) : part, x = over * (bend - l->least_bend) - 1.0, y = 2.0 * root - 1.0;
    double first[MOST_TERMS], second[MOST_TERMS], found[3][14] = {{0.0}};
    first[0] = second[0] = 1.0;
    first[1] = x;
    second[1] = y;
    for (int k = 2; k < rows; k++) first[k] = 2.0 * x * first[k - 1] - first[k - 2];
    for (int k = 2; k < columns; k++) second[k] = 2.0 * y * second[k - 1] - second[k - 2];
    for (int s = 0; s < 3; s++)
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < columns; j++, series += values) {
                const double weight = first[i] * second[j];
                for (int v = 0; v < values; v++) found[s][v] += weight * series[v];
            }
    const double inner = 2.0 / (l->power * l->most_offset_share * (l->power == 2.0 ? root : 1.0));
    for (int v = 0; v < values; v++) found[2][v] *= inner;
    for (int s = 0; s < 3; s++)
        for (int i = 0; i < 6; i++) {
            out->cycle[s][i] = found[s][i];
            out->ways[s][i] = found[s][6 + i];
        }
    if (measure == ENERGY) {
        out->paid = (cycles * found[0][12] + found[0][13]) / l->unit;
        for (int s = 0; s < 2; s++) out->by[s] = (cycles * found[1 + s][12] + found[1 + s][13]) / l->unit;
    } else if (measure == SWITCHES) {
        out->paid = (cycles * 4.0 + (l->across != 0.0 ? 8.0 : 6.0)) / l->unit;
        out->by[0] = out->by[1] = 0.0;
    } else {
        double here[2], more[2][2];
        travel_of(l, bend, offset_share, here);
        travel_of(l, bend + DIFFERENCE, offset_share, more[0]);
        travel_of(l, bend, offset_share + DIFFERENCE, more[1]);
        out->paid = (cycles * here[0] + here[1]) / l->unit;
        for (int s = 0; s < 2; s++) out->by[s] = ((cycles * more[s][0] + more[s][1]) / l->unit - out->paid) / DIFFERENCE;
    }
}

/* The greatest whole number that is not above x. */
static double floor_of(double x) {
    if (!(fabs(x) < 1e15)) return x;
    const double k = (double)(SIZE)x;
    return k > x ? k - 1.0 : k;
}

/* The joint travel of roll strokes, by the roll of one: `count` rolls, ascending from 0, and what those travel. */
static double rolled(SIZE count, const double *rolls, const double *travel, double largest, double angle) {
    double size = angle + PI - 2.0 * PI * floor_of((angle + PI) / (2.0 * PI)) - PI;
    size = fabs(size);
    const double least = -floor_of(-size / largest), strokes = least > 1.0 ? least : 1.0;
    size /= strokes;
    SIZE k = 1;
    while (k + 1 < count && rolls[k] < size) k++;
    if (!(size < rolls[count - 1])) return strokes * travel[count - 1];
    return strokes * (travel[k - 1] + (travel[k] - travel[k - 1]) * ((size - rolls[k - 1]) / (rolls[k] - rolls[k - 1])));
}

/* exp(n L) exp(U), mirrored, and undone where it is swum backwards. */
static void moved(double cycles, const double cycle[6], const double ways[6], SIZE mirrored, SIZE backwards,
                  double out[16]) {
    double twists[12], both[32], made[16];
    for (int i = 0; i < 6; i++) {
        twists[i] = cycles * cycle[i];
        twists[6 + i] = ways[i];
    }
    purcell_exp(2, twists, both);
    product(both, both + 16, made, 4, 4, 4);
    /* Half a turn about x, which negating all yaws and pitches conjugates by. */
    for (int i = 0; mirrored && i < 16; i++)
        if ((i / 4 == 1 || i / 4 == 2) != (i % 4 == 1 || i % 4 == 2)) made[i] = -made[i];
    if (backwards)
        inverse_pose(made, out);
    else
        for (int i = 0; i < 16; i++) out[i] = made[i];
}

static void after_roll(double angle, const double g[16], double out[16]) {
    double s, c;
    purcell_sin_cos_of(angle, &s, &c);
    for (int j = 0; j < 4; j++) {
        out[j] = g[j];
        out[4 + j] = c * g[4 + j] - s * g[8 + j];
        out[8 + j] = s * g[4 + j] + c * g[8 + j];
        out[12 + j] = g[12 + j];
    }
}

/* What a displacement is missed by; of far ones what lies across counts less, for it is a heading. */
static double missed(const double residual[6], const double wanted[16]) {
    const double p[3] = {wanted[3], wanted[7], wanted[11]}, way = sqrt(DOT(p, p));
    double along = 0.0, ahead[3], across = 0.0, spun = 0.0;
    for (int i = 0; i < 3; i++) {
        ahead[i] = (wanted[i] * p[0] + wanted[4 + i] * p[1] + wanted[8 + i] * p[2]) / (way > 1e-300 ? way : 1e-300);
        along += ahead[i] * residual[i];
    }
    for (int i = 0; i < 3; i++) {
        const double off = fabs(residual[i] - along * ahead[i]), spin = fabs(residual[3 + i]);
        across = off > across ? off : across;
        spun = spin > spun ? spin : spun;
    }
    along = fabs(along) / (1.0 + way / FAR_AHEAD);
    across /= 1.0 + way / FAR;
    along = across > along ? across : along;
    return spun > along ? spun : along;
}

struct table {
    SIZE rolls;
    const double *const *kind; /* of each kind of loops: its numbers, and its series */
    const double *roll, *travel;
    double largest;
    int measure;
};

/* One chain at x: bends, offset shares and rolls. whole: (4, 4); residual: (6,); columns: (6, 3 m + 1); slope: (3 m + 1,).
 * room: 16 (2 m + 1) + 48 m numbers. Returns the cost. */
static double evaluated(const struct table *t, SIZE m, const SIZE *which, const double *cycles, const SIZE *mirrored,
                        const SIZE *backwards, const double wanted[16], const double *x, double *room, double whole[16],
                        double residual[6], double *columns, double *slope) {
    const SIZE width = 3 * m + 1;
    double *const after = room, *const moves = after + 16 * (2 * m + 1), off[16], inverse[16], ad[36], cost = 0.0, twist[6], seen[6];
    identity(after + 32 * m, 4);
    for (SIZE j = 0; j < 6 * width; j++) columns[j] = 0.0;
    for (SIZE j = 0; j < 2 * m; j++) slope[j] = 0.0;
    for (SIZE j = m - 1; j >= 0; j--) {
        double *const move = moves + 48 * j;
        after_roll(x[2 * m + j + 1], after + 16 * (2 * j + 2), after + 16 * (2 * j + 1));
        if (which[j] < 0) {
            for (int i = 0; i < 16; i++) after[32 * j + i] = after[16 * (2 * j + 1) + i];
            continue;
        }
        struct arc arc;
        const struct loops *loops = (const struct loops *)t->kind[2 * which[j]];
        look_up(loops, t->kind[2 * which[j] + 1], t->measure, cycles[j], x[j], x[m + j], &arc);
        for (int s = 0; s < 3; s++) {
            double cycle[6], ways[6];
            for (int i = 0; i < 6; i++) {
                cycle[i] = s ? arc.cycle[0][i] + DIFFERENCE * arc.cycle[s][i] : arc.cycle[0][i];
                ways[i] = s ? arc.ways[0][i] + DIFFERENCE * arc.ways[s][i] : arc.ways[0][i];
            }
            moved(cycles[j], cycle, ways, mirrored[j], backwards[j], move + 16 * s);
        }
        cost += arc.paid;
        slope[j] = arc.by[0];
        slope[m + j] = arc.by[1];
        product(move, after + 16 * (2 * j + 1), after + 32 * j, 4, 4, 4);
        inverse_pose(after + 16 * (2 * j + 1), inverse);
        adjoint(inverse, ad);
        inverse_pose(move, inverse);
        for (int s = 0; s < 2; s++) {
            product(inverse, move + 16 * (s + 1), off, 4, 4, 4);
            for (int i = 0; i < 3; i++) {
                const int a = (i + 2) % 3, b = (i + 1) % 3;
                twist[i] = off[4 * i + 3] / DIFFERENCE;
                twist[3 + i] = 0.5 * (off[4 * a + b] - off[4 * b + a]) / DIFFERENCE;
            }
            product(ad, twist, seen, 6, 6, 1);
            for (int i = 0; i < 6; i++) columns[i * width + s * m + j] = seen[i];
        }
    }
    for (SIZE j = 0; j <= m; j++) {
        const double here = rolled(t->rolls, t->roll, t->travel, t->largest, x[2 * m + j]);
        cost += here;
        slope[2 * m + j] = (rolled(t->rolls, t->roll, t->travel, t->largest, x[2 * m + j] + DIFFERENCE) - here) / DIFFERENCE;
        inverse_pose(after + 32 * j, inverse);
        adjoint(inverse, ad);
        for (int i = 0; i < 6; i++) columns[i * width + 2 * m + j] = ad[6 * i + 3];
    }
    after_roll(x[2 * m], after, whole);
    inverse_pose(wanted, inverse);
    product(inverse, whole, off, 4, 4, 4);
    purcell_orthonormalise(1, 4, off);
    purcell_log(1, off, residual);
    return cost;
}

/* Changes bends, offset shares and rolls of n chains of m arcs and m + 1 rolls until they make displacements, at little cost:
 * every round takes the least step to the displacement from where the cost alone would lead, within bounds.
 *
 * kinds: (k, 2) of addresses: each kind of loops, `struct loops` and its series, (3, rows columns, values). rolls: see
 * `rolled`. measure: what is paid. which: the kind of each arc, -1 for none. which, cycles, mirrored, backwards: (n, m).
 * wanted: (n, 4, 4). x, low, high, loose: (n, 3 m + 1); loose is the inverse of how much an unknown's change counts.
 * room: 16 (2 m + 1) + 48 m + 7 (3 m + 1) numbers. x becomes the best of all rounds; off, paid: what those
 * miss and cost, (n,). last, whole, residual, columns, slope: what was found in the last round, (n,), (n, 4, 4), (n, 6),
 * (n, 6, 3 m + 1) and (n, 3 m + 1). */
API void purcell_settle(SIZE n, SIZE m, SIZE rounds, const double *const *kinds, SIZE rolls, const double *roll,
                        const double *travel, double largest, SIZE measure, const SIZE *which, const double *cycles,
                        const SIZE *mirrored, const SIZE *backwards, const double *wanted, const double *low,
                        const double *high, const double *loose, double *room, double *x, double *off, double *paid,
                        double *last, double *whole, double *residual, double *columns, double *slope) {
    const struct table t = {.kind = kinds, .rolls = rolls, .roll = roll, .travel = travel, .largest = largest, .measure = (int)measure};
    const SIZE width = 3 * m + 1;
    double *const here = room + 16 * (2 * m + 1) + 48 * m, *const thrifty = here + width, *const under = thrifty + width;
    double *const over = under + width, *const step = over + width, *const spare = step + width;
    for (SIZE c = 0; c < n; c++, which += m, cycles += m, mirrored += m, backwards += m, wanted += 16, low += width, high += width,
              loose += width, x += width, off++, paid++, last++, whole += 16, residual += 6, columns += 6 * width, slope += width) {
        *off = *paid = INFINITY;
        for (SIZE j = 0; j < width; j++) here[j] = x[j];
        for (SIZE round = 0; round <= rounds; round++) {
            const double cost = *last = evaluated(&t, m, which, cycles, mirrored, backwards, wanted, here, room, whole, residual, columns, slope);
            const double size = missed(residual, wanted), worse = size > *off ? size : *off;
            if (worse < NEARBY ? cost < *paid : size < *off) {
                *off = size;
                *paid = cost;
                for (SIZE j = 0; j < width; j++) x[j] = here[j];
            }
            if (round == rounds) break;
            double right[6], longest = 1e-300;
            for (int i = 0; i < 6; i++) right[i] = -residual[i];
            for (SIZE j = 0; j < width; j++) {
                thrifty[j] = -THRIFT * loose[j] * slope[j];
                under[j] = low[j] - here[j];
                over[j] = high[j] - here[j];
            }
            purcell_least_steps(1, width, columns, right, thrifty, loose, under, over, spare, step);
            for (SIZE j = 0; j < width; j++) longest = fabs(step[j]) > longest ? fabs(step[j]) : longest;
            const double part = LONGEST / longest < 1.0 ? LONGEST / longest : 1.0;
            for (SIZE j = 0; j < width; j++) here[j] += step[j] * part;
        }
    }
}
