/* The certificate's integrator, for doubles: it shares no formula with the planner's connection and collocation.
 *
 * g' = g hat(xi) on pieces by the modified midpoint rule with several numbers of steps, extrapolated to no step. The
 * twist is -P^-1 q of the plain equation, set up link by link; two pieces at once, each as it would be alone. */
#include "kernel.h"
#include "small.h"

#define MOST_ROWS 8
#define MOST_TIMES 64

struct link {
    double half;    /* half its length */
    double drag[6]; /* along and across its axis, and torques about them */
};

/* P xi + q = 0. With K = d_2 1 + (d_1 - d_2) a a^T, and T of the torques likewise, a limb adds
 * [[K, -K hat(c)], [hat(c) K, T - hat(c) K hat(c)]] to P, and to q the wrench of its turning by u about its joint. */
static void twist(const struct link *links, lane axes[2][3], lane rates[2][3], lane xi[6]) {
    lane p[6][6], q[6];
    for (int i = 0; i < 6; i++) {
        q[i] = (lane){0.0, 0.0};
        for (int j = 0; j < 6; j++) p[i][j] = (lane){0.0, 0.0} + (i == j ? links[0].drag[i] : 0.0);
    }
    for (int limb = 0; limb < 2; limb++) {
        const struct link *l = links + 1 + limb;
        const double side = limb ? -1.0 : 1.0, *d = l->drag, reach = side * l->half;
        const lane *a = axes[limb], *u = rates[limb];
        lane c[3], k[3][3], torque[3][3], arm[3][3], push[3], lever[3];
        for (int i = 0; i < 3; i++) c[i] = reach * a[i];
        c[0] += side * links[0].half;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const lane both = a[i] * a[j];
                k[i][j] = (d[0] - d[1]) * both + (i == j ? d[1] : 0.0);
                torque[i][j] = (d[3] - d[4]) * both + (i == j ? d[4] : 0.0);
            }
        for (int j = 0; j < 3; j++) { /* hat(c) K, column by column */
            const lane column[3] = {k[0][j], k[1][j], k[2][j]};
            lane across[3];
            CROSS(across, c, column);
            for (int i = 0; i < 3; i++) arm[i][j] = across[i];
        }
        for (int j = 0; j < 3; j++) {
            lane across[3]; /* -hat(c) K hat(c) = hat(c) (hat(c) K)^T */
            CROSS(across, c, arm[j]);
            for (int i = 0; i < 3; i++) {
                p[i][j] += k[i][j];
                p[3 + i][j] += arm[i][j];
                p[i][3 + j] += arm[j][i];
                p[3 + i][3 + j] += torque[i][j] + across[i];
            }
        }
        CROSS(push, u, a);
        for (int i = 0; i < 3; i++) push[i] *= reach * d[1];
        CROSS(lever, c, push);
        const lane spin = (d[3] - d[4]) * DOT(a, u);
        for (int i = 0; i < 3; i++) {
            q[i] += push[i];
            q[3 + i] += d[4] * u[i] + spin * a[i] + lever[i];
        }
    }
    for (int j = 0; j < 6; j++) /* elimination, then back */
        for (int i = j + 1; i < 6; i++) {
            const lane factor = p[i][j] / p[j][j];
            for (int m = j + 1; m < 6; m++) p[i][m] -= factor * p[j][m];
            q[i] -= factor * q[j];
        }
    for (int j = 5; j >= 0; j--) {
        lane sum = q[j];
        for (int m = j + 1; m < 6; m++) sum -= p[j][m] * q[m];
        q[j] = sum / p[j][j];
        xi[j] = -q[j];
    }
}

/* The derivative of the rotation's columns, less 1, and of the position. */
static void slope(const lane xi[6], lane state[4][3], lane out[4][3]) {
    lane r[3][3];
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) r[i][c] = state[i][c] + (i == c ? 1.0 : 0.0);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int c = 0; c < 3; c++) out[i][c] = xi[3 + k] * r[j][c] - xi[3 + j] * r[k][c];
    }
    for (int c = 0; c < 3; c++) out[3][c] = xi[0] * r[0][c] + xi[1] * r[1][c] + xi[2] * r[2][c];
}

/* By how much displacements differ from none: the columns of the rotation less 1, and the position.
 *
 * numbers: of the base and the limbs half the length and the drag on (v, omega), (3, 7).
 * axes: the limbs' axes at t times of n pieces, (2, 3, t, n). rates: their rates in base coordinates, (2, 3, n).
 * length: how long each piece lasts, (n,). steps: numbers of midpoint steps, (r,). place: at which of the times each
 * step of each number begins, row after row. fine, rough: extrapolated from all, and without the last extrapolation,
 * (n, 3, 4). */
API void purcell_extrapolated(const double *numbers, SIZE n, SIZE t, const double *axes, const double *rates,
                              const double *length, SIZE r, const SIZE *steps, const SIZE *place, double *fine,
                              double *rough) {
    const struct link *links = (const struct link *)numbers;
    for (SIZE p = 0; p < n; p += LANES) {
        const SIZE other = p + 1 < n ? p + 1 : p;
        const lane lasts = {length[p], length[other]};
        lane xi[MOST_TIMES][6], u[2][3], column[MOST_ROWS][4][3];
        for (int i = 0; i < 6; i++) u[i / 3][i % 3] = (lane){rates[i * n + p], rates[i * n + other]};
        for (SIZE k = 0; k < t; k++) {
            lane a[2][3];
            for (int i = 0; i < 6; i++) {
                const double *row = axes + (i * t + k) * n;
                a[i / 3][i % 3] = (lane){row[p], row[other]};
            }
            twist(links, a, u, xi[k]);
            for (int i = 0; i < 6; i++) xi[k][i] *= lasts;
        }
        const SIZE *at = place;
        for (SIZE row = 0; row < r; row++) {
            const double step = 1.0 / (double)steps[row];
            lane earlier[4][3], state[4][3], by[4][3];
            for (int i = 0; i < 12; i++) earlier[i / 3][i % 3] = (lane){0.0, 0.0};
            slope(xi[*at++], earlier, by);
            for (int i = 0; i < 12; i++) state[i / 3][i % 3] = step * by[i / 3][i % 3];
            for (SIZE m = 1; m < steps[row]; m++) {
                slope(xi[*at++], state, by);
                for (int i = 0; i < 12; i++) {
                    const lane next = earlier[i / 3][i % 3] + 2.0 * step * by[i / 3][i % 3];
                    earlier[i / 3][i % 3] = state[i / 3][i % 3];
                    state[i / 3][i % 3] = next;
                }
            }
            /* Aitken and Neville: T_j = T_(j-1) + (T_(j-1) - T of the row before) / ((n_i / n_(i-j))^2 - 1). */
            for (int i = 0; i < 12; i++) {
                lane here = state[i / 3][i % 3];
                for (SIZE j = 0; j < row; j++) {
                    const double ratio = (double)steps[row] / (double)steps[row - j - 1];
                    const lane before = column[j][i / 3][i % 3];
                    column[j][i / 3][i % 3] = here;
                    here += (here - before) / (ratio * ratio - 1.0);
                }
                column[row][i / 3][i % 3] = here;
            }
        }
        for (int w = 0; w < LANES && p + w < n; w++)
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < 4; c++) {
                    fine[12 * (p + w) + 4 * i + c] = column[r - 1][c][i][w];
                    rough[12 * (p + w) + 4 * i + c] = column[r > 1 ? r - 2 : 0][c][i][w];
                }
    }
}
