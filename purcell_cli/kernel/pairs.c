/* What pairs of displacements, and the way between them, are estimated to cost. */
#include <math.h>

#include "kernel.h"
#include "small.h"

/* The estimate of a change of heading t, a distance d and its part aside s:
 * sqrt(turn2 t^2 + turn1 t + aside min(s scale, most) + way1 d) root + way d. */
struct price {
    double turn2, turn1, aside, scale, most, way1, root, way;
};

/* Costs of the displacements a_i b_j, with what is spent besides: of all pairs, or the least of each a_i or each b_j.
 *
 * a, b: (n, 4, 4) and (m, 4, 4). before, after: (n,) and (m,). of: 0 for all pairs, (n, m), 1 for each a_i, (n,), and
 * 2 for each b_j, (m,). */
API void purcell_pair_prices(SIZE n, SIZE m, const double *a, const double *b, const double *before,
                             const double *after, const double *numbers, SIZE of, double *out) {
    const struct price *p = (const struct price *)numbers;
    for (SIZE k = 0; of && k < (of == 1 ? n : m); k++) out[k] = INFINITY;
    for (SIZE i = 0; i < n; i++) {
        const double *g = a + 16 * i;
        for (SIZE j = 0; j < m; j++) {
            const double *h = b + 16 * j, spent = before[i] + after[j];
            double *const least = of == 0 ? out + i * m + j : of == 1 ? out + i : out + j, place[3];
            for (int c = 0; c < 3; c++)
                place[c] = g[4 * c] * h[3] + g[4 * c + 1] * h[7] + g[4 * c + 2] * h[11] + g[4 * c + 3];
            double heading = g[0] * h[0] + g[1] * h[4] + g[2] * h[8];
            heading = heading < -1.0 ? -1.0 : heading > 1.0 ? 1.0 : heading;
            const double distance = sqrt(DOT(place, place)), aside = sqrt(place[1] * place[1] + place[2] * place[2]);
            const double near = aside * p->scale, some = near < p->most ? near : p->most;
            const double fixed = p->aside * some + p->way1 * distance, straight = p->way * distance + spent;
            /* An angle is at least its chord: most pairs that are not the least are seen without an arc tangent. */
            const double square = 2.0 * (1.0 - heading);
            if (of && p->root * sqrt(p->turn2 * square + p->turn1 * sqrt(square) + fixed) + straight > *least) continue;
            const double turn = 2.0 * purcell_arctan2_of(sqrt(1.0 - heading), sqrt(1.0 + heading));
            const double cost = p->root * sqrt(p->turn2 * (turn * turn) + p->turn1 * turn + fixed) + straight;
            if (!of || cost < *least) *least = cost;
        }
    }
}
