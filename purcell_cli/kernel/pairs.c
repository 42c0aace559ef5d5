/* What pairs of displacements, and the way between them, are estimated to cost, and which pairs all but meet. */
#include <math.h>

#include "kernel.h"
#include "small.h"

/* The estimate of a change of heading t, a distance d and its part aside s:
 * sqrt(turn2 t^2 + turn1 t + aside min(s scale, most) + way1 d) root + way d. */
struct price {
    double turn2, turn1, aside, scale, most, way1, root, way;
};

#define BLOCK 32 /* displacements whose costs are made side by side */

/* The same statements for registers of either width: all is made number by number. */
#define EITHER_WIDTH static inline __attribute__((always_inline)) void

/* Costs of the displacements a_i b_j, with what is spent besides.
 *
 * a, b: (n, 4, 4) and (m, 4, 4). before, after: (n,) and (m,). of: 0 for all pairs, (n, m), 1 for the least of each
 * a_i, (n,), 2 for that of each b_j, (m,), and 3 for both, (n + m,). most: of all pairs those that cost more may be told to
 * cost infinitely much. */
EITHER_WIDTH pair_prices(SIZE n, SIZE m, const double *a, const double *b, const double *before, const double *after,
                         const double *numbers, SIZE of, double most, double *out) {
    const struct price *p = (const struct price *)numbers;
    const SIZE firsts = of % 2 ? n : 0, every = firsts + (of > 1 ? m : 0);
    for (SIZE k = 0; k < every; k++) out[k] = INFINITY;
    for (SIZE low = 0; low < m; low += BLOCK) {
        const SIZE some = m - low < BLOCK ? m - low : BLOCK;
        double h[6][BLOCK] = {{0.0}}, heading[BLOCK], fixed[BLOCK], straight[BLOCK], bound[BLOCK], spent[BLOCK] = {0.0};
        for (SIZE l = 0; l < some; l++) {
            for (int c = 0; c < 3; c++) {
                h[c][l] = b[16 * (low + l) + 4 * c + 3];
                h[3 + c][l] = b[16 * (low + l) + 4 * c];
            }
            spent[l] = after[low + l];
        }
        for (SIZE i = 0; i < n; i++) {
            const double *g = a + 16 * i, begun = before[i];
            for (int l = 0; l < BLOCK; l++) { /* side by side */
                double place[3];
                for (int c = 0; c < 3; c++)
                    place[c] = g[4 * c] * h[0][l] + g[4 * c + 1] * h[1][l] + g[4 * c + 2] * h[2][l] + g[4 * c + 3];
                const double turned = g[0] * h[3][l] + g[1] * h[4][l] + g[2] * h[5][l];
                const double above = turned < -1.0 ? -1.0 : turned;
                heading[l] = above > 1.0 ? 1.0 : above;
                const double beside = place[1] * place[1] + place[2] * place[2];
                const double distance = sqrt(place[0] * place[0] + place[1] * place[1] + place[2] * place[2]);
                const double aside = sqrt(beside), near = aside * p->scale, part = near < p->most ? near : p->most;
                fixed[l] = p->aside * part + p->way1 * distance;
                straight[l] = p->way * distance + (begun + spent[l]);
                /* By the first terms of t^2 in 1 - cos t, all of which are positive, and less than rounding may add: most
                 * pairs that are not the least are seen without an arc tangent. */
                const double x = 1.0 - heading[l];
                const double square = x * (2.0 + x * (1.0 / 3.0 + x * (4.0 / 45.0 + x * (1.0 / 35.0 + x * (16.0 / 1575.0)))));
                const double under = p->turn2 * square + p->turn1 * sqrt(square) + fixed[l];
                bound[l] = (p->root * sqrt(under) + straight[l]) * (1.0 - 1e-14);
            }
            for (SIZE l = 0; l < some; l++) {
                double *const first = out + i, *const last = out + firsts + low + l;
                if (!of) out[i * m + low + l] = INFINITY;
                if (!(!of && bound[l] <= most) && !(of % 2 && bound[l] <= *first) && !(of > 1 && bound[l] <= *last)) continue;
                const double turn = 2.0 * purcell_arctan2_of(sqrt(1.0 - heading[l]), sqrt(1.0 + heading[l]));
                const double cost = p->root * sqrt(p->turn2 * (turn * turn) + p->turn1 * turn + fixed[l]) + straight[l];
                if (!of) out[i * m + low + l] = cost;
                if (of % 2 && cost < *first) *first = cost;
                if (of > 1 && cost < *last) *last = cost;
            }
        }
    }
}

#ifdef WIDE
__attribute__((target("avx2"))) static void pair_prices_wide(SIZE n, SIZE m, const double *a, const double *b,
                                                             const double *before, const double *after,
                                                             const double *numbers, SIZE of, double most, double *out) {
    pair_prices(n, m, a, b, before, after, numbers, of, most, out);
}
#endif

API void purcell_pair_prices(SIZE n, SIZE m, const double *a, const double *b, const double *before, const double *after,
                             const double *numbers, SIZE of, double most, double *out) {
#ifdef WIDE
    if (purcell_is_wide()) {
        pair_prices_wide(n, m, a, b, before, after, numbers, of, most, out);
        return;
    }
#endif
    pair_prices(n, m, a, b, before, after, numbers, of, most, out);
}

/* What of a straight way counts, and how much: see `purcell_meetings`. */
struct meeting {
    double swing, far, aside, along;
};

/* How far the tips of two unit vectors are apart. */
static double tips_apart(const double *a, const double *b) {
    const double between[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(DOT(between, between));
}

/* For each beginning a_i of a straight way the end b_j that costs least, with what is spent besides, and that cost.
 *
 * A way of length r along the unit vector u, which leaves aside of the heading of a_i by s, costs along r and
 * swing |heading a - heading b| + aside s, or along r and far (|heading a - u| + |heading b - u|), forwards or
 * backwards, whichever is less.
 * a, b: position and heading, (n, 6) and (6, m). before: (n,). after: (m,), ascending. most, within: ways that cost
 * as much, or so many times the least by then, are none, missing: nor those on which the costs but that of the length
 * are more. cost: (n,), infinite where there is none. index: (n,). */
EITHER_WIDTH meetings(SIZE n, SIZE m, const double *a, const double *b, const double *before, const double *after,
                      const double *prices, double most, double within, double missing, double *cost, SIZE *index) {
    const struct meeting *p = (const struct meeting *)prices;
    const double along = p->along * p->along, swing = p->swing < p->far ? p->swing : p->far;
    double least = most / within;
    for (SIZE i = 0; i < n; i++) {
        const double *g = a + 6 * i, *heading = g + 3;
        double best = within * least;
        cost[i] = INFINITY;
        index[i] = -1;
        for (SIZE low = 0; low < m && before[i] + after[low] < best; low += BLOCK) {
            const int some = m - low < BLOCK ? (int)(m - low) : BLOCK;
            double square[BLOCK], worth[BLOCK];
            for (int l = 0; l < some; l++) { /* side by side */
                const double *h = b + low + l, x = h[0] - g[0], y = h[m] - g[1], z = h[2 * m] - g[2];
                const double begun = before[i] + after[low + l], left = best - begun, enough = missing;
                square[l] = x * x + y * y + z * z;
                const double turn = heading[0] * h[3 * m] + heading[1] * h[4 * m] + heading[2] * h[5 * m];
                /* Two directions are apart by no more than both are from a third. The last digits may be rounding's. */
                const double cosine = turn < 1.0 ? turn : 1.0, apart = 2.0 * swing * swing * (1.0 - cosine);
                const double way = along * square[l], both = (apart + way + 2.0 * sqrt(apart * way)) * (1.0 - 1e-13);
                const double over = apart * (1.0 - 1e-13) - enough * enough, spare = left * left - both;
                worth[l] = over > 0.0 || left < 0.0 ? 0.0 : spare;
            }
            for (int l = 0; l < some; l++) {
                const SIZE j = low + l;
                if (!(worth[l] > 0.0) || !(before[i] + after[j] < best)) continue;
                const double h[6] = {b[j], b[m + j], b[2 * m + j], b[3 * m + j], b[4 * m + j], b[5 * m + j]};
                const double way[3] = {h[0] - g[0], h[1] - g[1], h[2] - g[2]}, length = sqrt(square[l]);
                const double on = DOT(way, heading), sign = on < 0.0 ? -1.0 : 1.0, beside = square[l] - on * on;
                double spent = p->swing * tips_apart(heading, h + 3) + p->aside * sqrt(beside > 0.0 ? beside : 0.0);
                if (length > 0.0) {
                    const double u[3] = {sign * way[0] / length, sign * way[1] / length, sign * way[2] / length};
                    const double far = p->far * (tips_apart(heading, u) + tips_apart(h + 3, u));
                    spent = far < spent ? far : spent;
                }
                if (spent > missing) continue;
                spent += before[i] + after[j] + p->along * length;
                if (spent < best) {
                    cost[i] = best = spent;
                    index[i] = j;
                }
            }
        }
        least = cost[i] < least ? cost[i] : least;
    }
}

#ifdef WIDE
__attribute__((target("avx2"))) static void meetings_wide(SIZE n, SIZE m, const double *a, const double *b,
                                                          const double *before, const double *after, const double *prices,
                                                          double most, double within, double missing, double *cost,
                                                          SIZE *index) {
    meetings(n, m, a, b, before, after, prices, most, within, missing, cost, index);
}
#endif

API void purcell_meetings(SIZE n, SIZE m, const double *a, const double *b, const double *before, const double *after,
                          const double *prices, double most, double within, double missing, double *cost, SIZE *index) {
#ifdef WIDE
    if (purcell_is_wide()) {
        meetings_wide(n, m, a, b, before, after, prices, most, within, missing, cost, index);
        return;
    }
#endif
    meetings(n, m, a, b, before, after, prices, most, within, missing, cost, index);
}
