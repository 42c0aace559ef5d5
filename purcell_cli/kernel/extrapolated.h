/* The certificate's integrator, for numbers of one kind: `NUMBER`, of which `MANY` holds `AT_ONCE` pieces' at once.
 *
 * Included once for each kind; see `certificate.c`. */
/* P xi + q = 0. With K = d_2 1 + (d_1 - d_2) a a^T, and T of the torques likewise, a limb adds
 * [[K, -K hat(c)], [hat(c) K, T - hat(c) K hat(c)]] to P, and to q the wrench of its turning by u about its joint. */
static void NAMED(twist)(const struct link *links, MANY axes[2][3], MANY rates[2][3], MANY xi[6]) {
    MANY p[6][6], q[6];
    for (int i = 0; i < 6; i++) {
        q[i] = TOGETHER(0.0, 0.0);
        for (int j = 0; j < 6; j++) p[i][j] = TOGETHER(0.0, 0.0) + (i == j ? links[0].drag[i] : 0.0);
    }
    for (int limb = 0; limb < 2; limb++) {
        const struct link *l = links + 1 + limb;
        const double side = limb ? -1.0 : 1.0, *d = l->drag, reach = side * l->half;
        const MANY *a = axes[limb], *u = rates[limb];
        MANY c[3], k[3][3], torque[3][3], arm[3][3], push[3], lever[3];
        for (int i = 0; i < 3; i++) c[i] = reach * a[i];
        c[0] += side * links[0].half;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const MANY both = a[i] * a[j];
                k[i][j] = (d[0] - d[1]) * both + (i == j ? d[1] : 0.0);
                torque[i][j] = (d[3] - d[4]) * both + (i == j ? d[4] : 0.0);
            }
        for (int j = 0; j < 3; j++) { /* hat(c) K, column by column */
            const MANY column[3] = {k[0][j], k[1][j], k[2][j]};
            MANY across[3];
            CROSS(across, c, column);
            for (int i = 0; i < 3; i++) arm[i][j] = across[i];
        }
        for (int j = 0; j < 3; j++) {
            MANY across[3]; /* -hat(c) K hat(c) = hat(c) (hat(c) K)^T */
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
        const MANY spin = (d[3] - d[4]) * DOT(a, u);
        for (int i = 0; i < 3; i++) {
            q[i] += push[i];
            q[3 + i] += d[4] * u[i] + spin * a[i] + lever[i];
        }
    }
    for (int j = 0; j < 6; j++) /* elimination, then back */
        for (int i = j + 1; i < 6; i++) {
            const MANY factor = p[i][j] / p[j][j];
            for (int m = j + 1; m < 6; m++) p[i][m] -= factor * p[j][m];
            q[i] -= factor * q[j];
        }
    for (int j = 5; j >= 0; j--) {
        MANY sum = q[j];
        for (int m = j + 1; m < 6; m++) sum -= p[j][m] * q[m];
        q[j] = sum / p[j][j];
        xi[j] = -q[j];
    }
}

/* The derivative of the rotation's columns, less 1, and of the position. */
static void NAMED(slope)(const MANY xi[6], MANY state[4][3], MANY out[4][3]) {
    MANY r[3][3];
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
API void NAMED(purcell_extrapolated)(const double *numbers, SIZE n, SIZE t, const NUMBER *axes, const NUMBER *rates,
                              const NUMBER *length, SIZE r, const SIZE *steps, const SIZE *place, NUMBER *fine,
                              NUMBER *rough) {
    const struct link *links = (const struct link *)numbers;
    for (SIZE p = 0; p < n; p += AT_ONCE) {
        const SIZE other = p + 1 < n ? p + 1 : p;
        const MANY lasts = TOGETHER(length[p], length[other]);
        MANY xi[MOST_TIMES][6], u[2][3], column[MOST_ROWS][4][3];
        for (int i = 0; i < 6; i++) u[i / 3][i % 3] = TOGETHER(rates[i * n + p], rates[i * n + other]);
        for (SIZE k = 0; k < t; k++) {
            MANY a[2][3];
            for (int i = 0; i < 6; i++) {
                const NUMBER *row = axes + (i * t + k) * n;
                a[i / 3][i % 3] = TOGETHER(row[p], row[other]);
            }
            NAMED(twist)(links, a, u, xi[k]);
            for (int i = 0; i < 6; i++) xi[k][i] *= lasts;
        }
        const SIZE *at = place;
        for (SIZE row = 0; row < r; row++) {
            const NUMBER step = (NUMBER)1.0 / (NUMBER)steps[row];
            MANY earlier[4][3], state[4][3], by[4][3];
            for (int i = 0; i < 12; i++) earlier[i / 3][i % 3] = TOGETHER(0.0, 0.0);
            NAMED(slope)(xi[*at++], earlier, by);
            for (int i = 0; i < 12; i++) state[i / 3][i % 3] = step * by[i / 3][i % 3];
            for (SIZE m = 1; m < steps[row]; m++) {
                NAMED(slope)(xi[*at++], state, by);
                for (int i = 0; i < 12; i++) {
                    const MANY next = earlier[i / 3][i % 3] + 2.0 * step * by[i / 3][i % 3];
                    earlier[i / 3][i % 3] = state[i / 3][i % 3];
                    state[i / 3][i % 3] = next;
                }
            }
            /* Aitken and Neville: T_j = T_(j-1) + (T_(j-1) - T of the row before) / ((n_i / n_(i-j))^2 - 1). */
            for (int i = 0; i < 12; i++) {
                MANY here = state[i / 3][i % 3];
                for (SIZE j = 0; j < row; j++) {
                    const NUMBER ratio = (NUMBER)steps[row] / (NUMBER)steps[row - j - 1];
                    const MANY before = column[j][i / 3][i % 3];
                    column[j][i / 3][i % 3] = here;
                    here += (here - before) / (ratio * ratio - 1.0);
                }
                column[row][i / 3][i % 3] = here;
            }
        }
        for (int w = 0; w < AT_ONCE && p + w < n; w++)
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < 4; c++) {
                    fine[12 * (p + w) + 4 * i + c] = ONE_OF(column[r - 1][c][i], w);
                    rough[12 * (p + w) + 4 * i + c] = ONE_OF(column[r > 1 ? r - 2 : 0][c][i], w);
                }
    }
}

#undef NUMBER
#undef MANY
#undef AT_ONCE
#undef TOGETHER
#undef ONE_OF
#undef NAMED
