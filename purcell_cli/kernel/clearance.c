/* The circles that limbs' axes run along, how far limbs bend on them, and how near they come to each other. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define HALF_TURN 3.14159265358979323846
#define TURN (2.0 * HALF_TURN)
#define PARTS 4 /* into how many a stretch is cut where a smaller distance may be: 2 to 8 find the same one; the more, the
                 * fewer rounds */

/* At time t of a piece the axis of limb i is centre + cos(turn t) cosine + sin(turn t) sine. */
struct circle {
    const double *centre, *cosine, *sine;
    double turn;
};

struct circles {
    const double *centre, *cosine, *sine, *turn, *duration; /* (n, 2, 3), (n, 2), (n,) */
};

static struct circle circle_of(const struct circles *all, SIZE piece, int limb) {
    const SIZE k = 2 * piece + limb;
    return (struct circle){all->centre + 3 * k, all->cosine + 3 * k, all->sine + 3 * k, all->turn[k]};
}

static void axis_at(const struct circle *c, double angle, double out[3]) {
    double sine, cosine;
    purcell_sin_cos_of(angle, &sine, &cosine);
    for (int i = 0; i < 3; i++) out[i] = c->centre[i] + cosine * c->cosine[i] + sine * c->sine[i];
}

/* Circles of n pieces. shapes (n, 2, 3, 3), rates (n, 6) to centre, cosine, sine (n, 2, 3) and turn (n, 2). */
API void purcell_circles(SIZE n, const double *shapes, const double *rates, double *centre, double *cosine, double *sine,
                         double *turn) {
    for (SIZE k = 0; k < 2 * n; k++, shapes += 9, rates += 3, centre += 3, cosine += 3, sine += 3, turn++) {
        double about[3];
        const double axis[3] = {shapes[0], shapes[3], shapes[6]};
        product(shapes, rates, about, 3, 3, 1);
        *turn = sqrt(inner_product(3, about, about));
        for (int i = 0; i < 3; i++) about[i] /= *turn > 0.0 ? *turn : 1.0;
        const double along = inner_product(3, about, axis);
        for (int i = 0; i < 3; i++) {
            centre[i] = along * about[i];
            cosine[i] = axis[i] - centre[i];
        }
        CROSS(sine, about, axis);
    }
}

/* The angle, from 0 to 2 pi, at which cos(angle) cosine + sin(angle) sine is least. */
static double lowest(double cosine, double sine) {
    const double angle = purcell_arctan2_of(-sine, -cosine);
    return angle < 0.0 ? angle + TURN : angle + 0.0;
}

/* The largest bend of a limb on a piece that lasts so long, and when. */
static double largest_bend(const struct circle *c, double duration, double *time) {
    const double end = c->turn * duration, least = lowest(c->cosine[0], c->sine[0]);
    const double angles[3] = {0.0, end, least < end ? least : end};
    double most = -1.0;
    for (int i = 0; i < 3; i++) {
        double axis[3];
        axis_at(c, angles[i], axis);
        const double bend = purcell_arctan2_of(sqrt(axis[1] * axis[1] + axis[2] * axis[2]), axis[0]);
        if (!(bend > most)) continue;
        most = bend;
        *time = angles[i] / (c->turn > 0.0 ? c->turn : 1.0);
    }
    return most;
}

/* Whether a limb bends more than a right angle on a piece. Mostly all of its circle or where it begins tells. */
static int folds(const struct circles *all, SIZE piece, int limb) {
    const struct circle c = circle_of(all, piece, limb);
    const double least = c.centre[0] - sqrt(c.cosine[0] * c.cosine[0] + c.sine[0] * c.sine[0]);
    const double begun = c.centre[0] + c.cosine[0];
    double time;
    if (least > CLEARLY || (c.turn == 0.0 && begun > CLEARLY)) return 0;
    return begun < -CLEARLY || largest_bend(&c, all->duration[piece], &time) > 0.5 * HALF_TURN;
}

#define CIRCLES const double *centre, const double *cosine, const double *sine, const double *turn, const double *duration
#define THE_CIRCLES {centre, cosine, sine, turn, duration}

/* Each limb's largest bend on each of n pieces, and when: (n, 2). */
API void purcell_largest_bends(SIZE n, CIRCLES, double *bend, double *time) {
    const struct circles all = THE_CIRCLES;
    for (SIZE k = 0; k < 2 * n; k++) {
        const struct circle c = circle_of(&all, k / 2, (int)(k % 2));
        bend[k] = largest_bend(&c, duration[k / 2], time + k);
    }
}

/* The search for the least distance between the limbs' surfaces, of all pieces together or of each piece. */
struct search {
    const double *numbers; /* half the base's length, both limbs' lengths, both radii together, and what is small */
    struct circles all;
    SIZE apart;            /* whether each piece is a group of its own */
    double enough, *best, *when;
    SIZE *where;
};

static double distance(const struct search *s, SIZE piece, double time) {
    const double gap[3] = {2.0 * s->numbers[0], 0.0, 0.0};
    double axes[2][3], nearest[3];
    for (int i = 0; i < 2; i++) {
        const struct circle c = circle_of(&s->all, piece, i);
        axis_at(&c, c.turn * time, axes[i]);
        const double full = i ? -s->numbers[2] : s->numbers[1];
        for (int j = 0; j < 3; j++) axes[i][j] *= full;
    }
    purcell_nearest(gap, axes[0], axes[1], nearest);
    const double found = nearest[2] - s->numbers[3];
    const SIZE group = s->apart ? piece : 0;
    if (found < s->best[group]) {
        s->best[group] = found;
        s->where[group] = piece;
        s->when[group] = time;
    }
    return found;
}

/* How fast a limb's tip moves, and how fast its speed turns. */
static double tip_speed(const struct search *s, const struct circle *c, int limb) {
    return s->numbers[1 + limb] * (c->turn * sqrt(inner_product(3, c->sine, c->sine)));
}

/* What the distance cannot go below on a stretch between two distances. */
static double bound(const struct search *s, SIZE piece, double length, double low, double high) {
    double tips[2], pulls[2];
    for (int i = 0; i < 2; i++) {
        const struct circle c = circle_of(&s->all, piece, i);
        tips[i] = tip_speed(s, &c, i);
        pulls[i] = tips[i] * c.turn;
    }
    const double radii = s->numbers[3], move = (tips[0] + tips[1]) * length;
    const double straight = 0.5 * (low + high - move);
    const double a = (low + radii) * (low + radii), b = (high + radii) * (high + radii);
    const double reach = 2.0 * s->numbers[0] + move;
    const double bulge = 2.0 * (move * move) + 2.0 * reach * (pulls[0] + pulls[1]) * (length * length);
    const double tilt = fabs(b - a);
    const double inside = 0.5 * (a + b) - 0.125 * bulge - 0.5 * (tilt * tilt) / (bulge > 0.0 ? bulge : 1.0);
    const double square = tilt < 0.5 * bulge ? inside : a < b ? a : b;
    const double root = sqrt(square > 0.0 ? square : 0.0) - radii;
    return straight > root ? straight : root;
}

/* By how much that undercuts what is known already, or what is enough. */
static double missing(const struct search *s, SIZE piece, double length, double low, double high) {
    const double best = s->best[s->apart ? piece : 0];
    return (best < s->enough ? best : s->enough) - bound(s, piece, length, low, high);
}

/* Whether a limb's axis has no part against a vector from angle `low` to `high` of its circle. */
static int never_against(const struct circle *c, const double along[3], double low, double high) {
    const double a = inner_product(3, c->cosine, along), b = inner_product(3, c->sine, along), least = lowest(a, b);
    double least_part = least > low && least < high ? -sqrt(a * a + b * b) : INFINITY;
    for (int i = 0; i < 2; i++) {
        double sine, cosine;
        purcell_sin_cos_of(i ? high : low, &sine, &cosine);
        const double part = a * cosine + b * sine;
        least_part = part < least_part ? part : least_part;
    }
    return inner_product(3, c->centre, along) + least_part >= 0.0;
}

/* Whether a limb rests on a stretch of a piece and the other one's joint stays the point nearest to it: the square of the
 * distance is convex in the places along both limbs, so that is so where the moving limb never leads nearer to the point
 * of the resting limb that is nearest to the joint. */
static int constant(const struct search *s, SIZE piece, double begun, double length) {
    for (int i = 0; i < 2; i++) {
        const struct circle mine = circle_of(&s->all, piece, i), other = circle_of(&s->all, piece, 1 - i);
        const double base = 2.0 * s->numbers[0], full = s->numbers[2 - i];
        double apart[3];
        if (other.turn * sqrt(inner_product(3, other.sine, other.sine)) != 0.0) continue;
        for (int j = 0; j < 3; j++) apart[j] = full * (other.centre[j] + other.cosine[j]);
        const double place = -base * apart[0] / (full * full), part = place > 0.0 ? place < 1.0 ? place : 1.0 : 0.0;
        for (int j = 0; j < 3; j++) apart[j] *= part;
        apart[0] += base;
        if (never_against(&mine, apart, mine.turn * begun, mine.turn * (begun + length))) return 1;
    }
    return 0;
}

#define SEARCH                                                                                                     \
    const double *numbers, CIRCLES, SIZE apart, double enough, double *best, double *when, SIZE *where
#define THE_SEARCH {numbers, THE_CIRCLES, apart, enough, best, when, where}

/* Looks at both ends of n pieces, and returns how many may have a smaller distance between: their numbers, when they
 * begin, how long they last and the distances at both ends stand in `stretches`, (n, 5).
 *
 * numbers: see `struct search`. best, when, where: the least distance of each group, when and on which piece it is;
 * changed. */
API SIZE purcell_clearance_begun(SIZE n, SEARCH, double *stretches) {
    const struct search s = THE_SEARCH;
    SIZE count = 0;
    for (SIZE k = 0; k < n; k++) stretches[5 * k + 3] = distance(&s, k, 0.0);
    for (SIZE k = 0; k < n; k++) stretches[5 * k + 4] = distance(&s, k, duration[k]);
    for (SIZE k = 0; k < n; k++) {
        double speed = 0.0;
        for (int i = 0; i < 2; i++) {
            const struct circle c = circle_of(&s.all, k, i);
            speed += tip_speed(&s, &c, i);
        }
        if (!(speed * duration[k] > 0.0)) continue;
        /* While no limb bends more than a right angle the joints are nearest to each other. */
        if (!(folds(&s.all, k, 0) || folds(&s.all, k, 1)) || constant(&s, k, 0.0, duration[k])) continue;
        const double one[5] = {(double)k, 0.0, duration[k], stretches[5 * k + 3], stretches[5 * k + 4]};
        for (int i = 0; i < 5; i++) stretches[5 * count + i] = one[i];
        count++;
    }
    return count;
}

/* Cuts those of n stretches where the distance may be smaller by more than is small into PARTS each, `cut`, and returns
 * how many those are. Where more than `most` would be cut none is, and it returns -1 and by how much the distance may be
 * smaller at the most, `error`. */
API SIZE purcell_clearance_cut(SIZE n, SEARCH, double *stretches, SIZE most, double *cut, double *error) {
    const struct search s = THE_SEARCH;
    SIZE open = 0;
    *error = -INFINITY;
    for (SIZE k = 0; k < n; k++) {
        const double *one = stretches + 5 * k;
        const double below = missing(&s, (SIZE)one[0], one[2], one[3], one[4]);
        *error = below > *error ? below : *error;
        if (!(below > numbers[4])) continue;
        if (fabs(one[4] - one[3]) <= numbers[4] && constant(&s, (SIZE)one[0], one[1], one[2])) continue;
        for (int i = 0; i < 5; i++) stretches[5 * open + i] = one[i];
        open++;
    }
    if (open > most) return -1;
    for (SIZE k = 0; k < open; k++) {
        const double *one = stretches + 5 * k, length = one[2] / PARTS;
        double low = one[3];
        for (int i = 0; i < PARTS; i++, cut += 5) {
            const double begun = one[1] + length * i, ended = one[1] + length * (i + 1);
            const double high = i + 1 < PARTS ? distance(&s, (SIZE)one[0], ended) : one[4];
            cut[0] = one[0];
            cut[1] = begun;
            cut[2] = length;
            cut[3] = low;
            cut[4] = high;
            low = high;
        }
    }
    return PARTS * open;
}
