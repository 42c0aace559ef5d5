/* The certificate's integrator, in doubles and with twice their digits: it shares no formula with the planner's connection
 * and collocation.
 *
 * g' = g hat(xi) on pieces by the modified midpoint rule with several numbers of steps, extrapolated to no step. The
 * twist is -P^-1 q of the plain equation, set up link by link; several pieces at once, each as it would be alone. Pieces
 * are strung in the machine's `long double`. */
#include <math.h>
#include <string.h>

#include "kernel.h"
#include "small.h"

#define MOST_ROWS 8
#define MOST_TIMES 64

struct link {
    double half;    /* half its length */
    double drag[6]; /* along and across its axis, and torques about them */
};

/* Terms of the series of sin(t)/t and (1 - cos t)/t^2 in t^2 up to half a radian, and how many of them count for twice the
 * digits of a double. */
#define TERMS 10
#define EXACT 3

static void series_of_sine(double series[TERMS][2]) {
    series[0][0] = 1.0;
    series[0][1] = 0.5;
    for (int k = 1; k < TERMS; k++) {
        series[k][0] = -series[k - 1][0] / (double)(2 * k * (2 * k + 1));
        series[k][1] = -series[k - 1][1] / (double)((2 * k + 1) * (2 * k + 2));
    }
}

/* What rounding took from a product p = a b (Dekker 1971). */
static inline lane lost(lane a, lane b, lane p) {
    const lane s = 134217729.0 * a, t = 134217729.0 * b; /* 2^27 + 1 */
    const lane ah = s - (s - a), bh = t - (t - b), al = a - ah, bl = b - bh;
    return ((ah * bh - p) + ah * bl + al * bh) + al * bl;
}

#define MANY lane
#define AT_ONCE LANES
#define NAMED(name) name##_narrow
#define VARIANT static
#define LOST lost
#include "extrapolated_body.h"
#include "extrapolated_twice_body.h"

#ifdef WIDE
#undef LOST
#undef MANY
#undef AT_ONCE
#undef NAMED
#undef VARIANT
#include <immintrin.h>
typedef double quad __attribute__((vector_size(32), aligned(16)));
#define MANY quad
#define AT_ONCE 4
#define NAMED(name) name##_wide
#define VARIANT __attribute__((target("avx2,fma"))) static
#define LOST(a, b, p) ((quad)_mm256_fmsub_pd((__m256d)(a), (__m256d)(b), (__m256d)(p))) /* the same to the bit */
#include "extrapolated_body.h"
#include "extrapolated_twice_body.h"
#define EITHER(name)                                                                                     \
    if (purcell_is_wide()) {                                                                             \
        name##_wide(numbers, n, axes, rates, length, t, parts, r, steps, place, fine, rough);            \
        return;                                                                                          \
    }                                                                                                    \
    name##_narrow(numbers, n, axes, rates, length, t, parts, r, steps, place, fine, rough)
#else
#define EITHER(name) name##_narrow(numbers, n, axes, rates, length, t, parts, r, steps, place, fine, rough)
#endif

API void purcell_extrapolated(const double *numbers, SIZE n, const double *axes, const double *rates, const double *length,
                              SIZE t, const double *parts, SIZE r, const SIZE *steps, const SIZE *place, double *fine,
                              double *rough) {
    EITHER(extrapolated);
}

API void purcell_extrapolated_twice(const double *numbers, SIZE n, const double *axes, const double *rates,
                                    const double *length, SIZE t, const double *parts, SIZE r, const SIZE *steps,
                                    const SIZE *place, double *fine, double *rough) {
    EITHER(extrapolated_twice);
}

/* How many bytes a `long double` has. */
API SIZE purcell_extended_size(void) { return sizeof(long double); }

/* Products of displacements in extended precision, of each run of them one.
 *
 * counts: how many each of m runs has, in order. pieces: by how much they differ from none, (n, 3, 4). out: (m, 4, 4). */
API void purcell_strung(SIZE m, const SIZE *counts, const long double *pieces, long double *out) {
    for (SIZE k = 0; k < m; k++, out += 16) {
        for (int i = 0; i < 16; i++) out[i] = i % 5 == 0 ? 1.0 : 0.0;
        for (SIZE left = counts[k]; left > 0; left--, pieces += 12)
            for (int i = 0; i < 3; i++) {
                long double *row = out + 4 * i, by[4];
                for (int c = 0; c < 4; c++) by[c] = row[0] * pieces[c] + row[1] * pieces[4 + c] + row[2] * pieces[8 + c];
                for (int c = 0; c < 4; c++) row[c] += by[c];
            }
    }
}

/* What small turns move the end of a motion by, in which displacements come again and again.
 *
 * moves: (k, 4, 4). which: which of them are made, in order, (n,). least: a length. out: of each displacement the sum, over
 * where it is made, of how far the end is from where it ends, and of that length; and how often it is made, (2, k). */
API void purcell_reach(SIZE n, const SIZE *which, SIZE k, const double *moves, double least, double *out) {
    double end[3] = {0.0, 0.0, 0.0}; /* seen from where a displacement ends */
    for (SIZE j = 0; j < 2 * k; j++) out[j] = 0.0;
    for (SIZE j = n - 1; j >= 0; j--) {
        const double *by = moves + 16 * which[j], there[3] = {end[0], end[1], end[2]};
        out[which[j]] += sqrt(DOT(there, there)) + least;
        out[k + which[j]] += 1.0;
        for (int i = 0; i < 3; i++) end[i] = DOT(by + 4 * i, there) + by[4 * i + 3];
    }
}

/* How far two shapes are from where A(r) is sharp, as a bend [rad], and by an eighth less at the most: P has a
 * small eigenvalue there, and the trace of P^-8 is the sum of all eigenvalues' -8th powers. */
static lane sharp_distance(const struct link *links, double spread, lane axes[2][3]) {
    lane p[6][6], own[2][6][6], inverse[6][6], square[6][6], sum = {0.0, 0.0};
    for (int limb = 0; limb < 2; limb++)
        resisted_narrow(links + 1 + limb, limb ? -1.0 : 1.0, links[0].half, axes[limb], own[limb]);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) p[i][j] = (i == j ? own[0][i][j] + links[0].drag[i] : own[0][i][j]) + own[1][i][j];
    factored_narrow(p);
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) inverse[i][j] = sum + (i == j ? 1.0 : 0.0);
        solved_narrow(p, inverse[i]);
    }
    for (int again = 0; again < 2; again++) {
        for (int i = 0; i < 6; i++)
            for (int j = 0; j <= i; j++) {
                lane s = inverse[i][0] * inverse[j][0];
                for (int m = 1; m < 6; m++) s += inverse[i][m] * inverse[j][m];
                square[i][j] = square[j][i] = s;
            }
        memcpy(inverse, square, sizeof square);
    }
    for (int i = 0; i < 36; i++) sum += square[i / 6][i % 6] * square[i / 6][i % 6];
    for (int w = 0; w < LANES; w++)
        sum[w] = sum[w] <= DBL_MAX ? 1.0 / (sqrt(sqrt(sqrt(sqrt(sum[w])))) * sqrt(spread)) : 0.0;
    return sum;
}

struct part {
    double start, length, near, ratio;
};

/* Cuts segments into pieces that are short against the distance from where A(r) is sharp, all along them.
 *
 * numbers: of the links, see above. bounds: what a bend adds to the spread of the links, how fast the distance can change
 * with a limb's turn, the least that counts, the longest pieces as a part of it, and the longest [rad], (5,).
 * axes, rates: the limbs' axes where m segments begin and their rates, in base coordinates, (m, 2, 3).
 * swept: how far they turn the limbs, (m,). lasts: how long, (m,). most: how many pieces there is room for.
 * owner: which segment each piece is of, (most,). pieces: where each begins and how long it is, as parts of the segment,
 * and the distance in its middle, (most, 3). Returns how many pieces there are, or -1 where they cannot be told. */
API SIZE purcell_pieces(const double *numbers, const double *bounds, SIZE m, const double *axes, const double *rates,
                        const double *swept, const double *lasts, SIZE most, SIZE *owner, double *pieces) {
    enum { ROOM = 1024, PARTS = 8 };
    const struct link *links = (const struct link *)numbers;
    struct part left[ROOM];
    SIZE count = 0;
    for (SIZE s = 0; s < m; s++, axes += 6, rates += 6) {
        if (lasts[s] == 0.0) continue;
        double turn[2][2][3], speed[2]; /* n x a and n x (n x a) of the axes n of turning */
        for (int limb = 0; limb < 2; limb++) {
            const double *u = rates + 3 * limb;
            speed[limb] = sqrt(DOT(u, u));
            double about[3];
            for (int i = 0; i < 3; i++) about[i] = speed[limb] > 0.0 ? u[i] / speed[limb] : 0.0;
            CROSS(turn[limb][0], about, axes + 3 * limb);
            CROSS(turn[limb][1], about, turn[limb][0]);
        }
        SIZE parts = 1, waiting = 0;
        double start = 0.0, length = 1.0;
        for (;;) {
            if (waiting + parts > ROOM) return -1;
            for (SIZE k = 0; k < parts; k += LANES) { /* the first on top */
                lane at[2][3];
                for (int w = 0; w < LANES; w++) {
                    const double middle = start + ((double)(k + w < parts ? k + w : k) + 0.5) * length;
                    for (int limb = 0; limb < 2; limb++) {
                        double sine, cosine;
                        purcell_sin_cos_of(speed[limb] * (middle * lasts[s]), &sine, &cosine);
                        for (int i = 0; i < 3; i++)
                            at[limb][i][w] =
                                axes[3 * limb + i] + sine * turn[limb][0][i] + (1.0 - cosine) * turn[limb][1][i];
                    }
                }
                const lane near = sharp_distance(links, bounds[0], at);
                for (int w = 0; w < LANES && k + w < parts; w++) {
                    const double arc = swept[s] * length, nearest = near[w] - 0.5 * bounds[1] * arc;
                    const double least = bounds[3] * (nearest > bounds[2] ? nearest : bounds[2]);
                    left[waiting + parts - 1 - (k + w)] = (struct part){
                        start + (double)(k + w) * length, length, near[w], arc / (least < bounds[4] ? least : bounds[4])};
                }
            }
            waiting += parts;
            while (waiting > 0 && !(left[waiting - 1].ratio > 1.0)) {
                const struct part *one = left + --waiting;
                if (count < most) {
                    const double own[3] = {one->start, one->length, one->near};
                    owner[count] = s;
                    memcpy(pieces + 3 * count, own, sizeof own);
                }
                count++;
            }
            if (!waiting) break;
            const struct part *one = left + --waiting;
            parts = one->ratio > 4.0 ? PARTS : one->ratio > 2.0 ? 4 : 2; /* so that all numbers stay exact */
            start = one->start;
            length = one->length / (double)parts;
        }
    }
    return count;
}

/* Finds neighbours that come again and again: runs of rows, bit by bit the same as those a period before.
 *
 * rows: (n, width). longest: the longest period. first, period, count: where each run begins, how many rows come again,
 * and how often, each (n,); what does not come again is a run that comes once. Returns how many runs there are. */
API SIZE purcell_repeats(SIZE n, SIZE width, const double *rows, SIZE longest, SIZE *first, SIZE *period, SIZE *count) {
    const size_t bytes = (size_t)width * sizeof(double);
    SIZE runs = 0, once = 0; /* where rows begin that do not come again */
    for (SIZE i = 0; i < n;) {
        SIZE best = 0, every = 1, times = 1;
        for (SIZE p = 1; p <= longest && i + p < n && best < longest; p++) {
            SIZE same = 0;
            while (i + p + same < n && !memcmp(rows + (i + same) * width, rows + (i + p + same) * width, bytes)) same++;
            if (same / p * p > best) {
                best = same / p * p;
                every = p;
                times = same / p + 1;
            }
        }
        if (best) {
            if (once < i) {
                first[runs] = once;
                period[runs] = i - once;
                count[runs++] = 1;
            }
            first[runs] = i;
            period[runs] = every;
            count[runs++] = times;
            i += every * times;
            once = i;
        } else
            i++;
    }
    if (once < n) {
        first[runs] = once;
        period[runs] = n - once;
        count[runs++] = 1;
    }
    return runs;
}
