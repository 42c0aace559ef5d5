/* The certificate's integrator in doubles, for `MANY` of them: `AT_ONCE` pieces at once, each computed as it would be alone;
 * `certificate.c` includes this for each kind of register. */

/* P xi + q = 0. With K = d_2 1 + (d_1 - d_2) a a^T, and T of the torques likewise, a limb adds
 * [[K, -K hat(c)], [hat(c) K, T - hat(c) K hat(c)]] to P: its lower half here. */
VARIANT void NAMED(resisted)(const struct link *l, double side, double base, const MANY a[3], MANY p[6][6]) {
    const double reach = side * l->half, arm = side * base, *d = l->drag, along = d[0] - d[1], spin = d[3] - d[4];
    const MANY c[3] = {arm + reach * a[0], reach * a[1], reach * a[2]};
    const MANY w[3] = {0.0 * a[0], -arm * a[2], arm * a[1]}; /* c x a */
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int m = 0; m < 3; m++) p[3 + i][m] = along * (w[i] * a[m]);
        p[3 + i][j] -= d[1] * c[k];
        p[3 + i][k] += d[1] * c[j];
        for (int m = 0; m <= i; m++) {
            p[i][m] = along * (a[i] * a[m]) + (i == m ? d[1] : 0.0);
            p[3 + i][3 + m] = spin * (a[i] * a[m]) - d[1] * (c[i] * c[m]) + along * (w[i] * w[m]);
        }
        /* Sums of squares: where links are straight there are no digits to lose. */
        p[3 + i][3 + i] = d[3] * (a[i] * a[i]) + d[4] * (a[j] * a[j] + a[k] * a[k]);
        p[3 + i][3 + i] += d[1] * (c[j] * c[j] + c[k] * c[k]) + along * (w[i] * w[i]);
    }
}

/* To q a limb adds the wrench of its turning by u about its joint. */
VARIANT void NAMED(pushed)(const struct link *l, double side, double base, const MANY a[3], const MANY u[3], MANY q[6]) {
    const double reach = side * l->half, *d = l->drag;
    const MANY c[3] = {side * base + reach * a[0], reach * a[1], reach * a[2]}, spin = (d[3] - d[4]) * DOT(a, u);
    MANY push[3], lever[3];
    CROSS(push, u, a);
    for (int i = 0; i < 3; i++) push[i] *= reach * d[1];
    CROSS(lever, c, push);
    for (int i = 0; i < 3; i++) {
        q[i] += push[i];
        q[3 + i] += d[4] * u[i] + spin * a[i] + lever[i];
    }
}

/* L D L^T = P in place of its lower half, with the inverse of D. */
VARIANT void NAMED(factored)(MANY p[6][6]) {
    for (int j = 0; j < 6; j++) {
        MANY column[6];
        p[j][j] = 1.0 / p[j][j];
        for (int i = j + 1; i < 6; i++) {
            column[i] = p[i][j];
            p[i][j] *= p[j][j];
            for (int m = j + 1; m <= i; m++) p[i][m] -= p[i][j] * column[m];
        }
    }
}

VARIANT void NAMED(solved)(MANY p[6][6], MANY x[6]) {
    for (int j = 0; j < 6; j++)
        for (int i = j + 1; i < 6; i++) x[i] -= p[i][j] * x[j];
    for (int j = 0; j < 6; j++) x[j] *= p[j][j];
    for (int j = 5; j > 0; j--)
        for (int i = 0; i < j; i++) x[i] -= p[j][i] * x[j];
}

/* The derivative of the rotation's columns, less 1, and of the position. */
VARIANT void NAMED(slope)(const MANY xi[6], MANY state[4][3], MANY out[4][3]) {
    MANY r[3][3];
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) r[i][c] = i == c ? state[i][c] + 1.0 : state[i][c];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int c = 0; c < 3; c++) out[i][c] = xi[3 + k] * r[j][c] - xi[3 + j] * r[k][c];
    }
    for (int c = 0; c < 3; c++) out[3][c] = xi[0] * r[0][c] + xi[1] * r[1][c] + xi[2] * r[2][c];
}

/* A limb's axis at a time: a + sin(w t)/w u x a + (1 - cos(w t))/w^2 u x (u x a), by some terms of the series of both. */
VARIANT void NAMED(turned)(MANY start[3][3], MANY square, MANY time, const double (*series)[2], MANY axis[3]) {
    const MANY z = square * (time * time);
    MANY sine = 0.0 * z + series[TERMS - 1][0], other = 0.0 * z + series[TERMS - 1][1];
    for (int k = TERMS - 2; k >= 0; k--) {
        sine = sine * z + series[k][0];
        other = other * z + series[k][1];
    }
    sine *= time;
    other *= time * time;
    for (int i = 0; i < 3; i++) axis[i] = start[0][i] + (sine * start[1][i] + other * start[2][i]);
}

VARIANT int NAMED(rests)(MANY square) {
    for (int w = 0; w < AT_ONCE; w++)
        if (square[w] != 0.0) return 0;
    return 1;
}

/* The twists at t times of `AT_ONCE` pieces, times how long these last. */
VARIANT void NAMED(twists)(const struct link *links, MANY start[2][3][3], MANY rates[2][3], MANY lasts, SIZE t,
                           const double *parts, const double (*series)[2], MANY (*xi)[6]) {
    MANY square[2];
    for (int limb = 0; limb < 2; limb++) square[limb] = DOT(rates[limb], rates[limb]);
    MANY own[2][6][6];
    int still[2];
    for (int limb = 0; limb < 2; limb++) { /* what a limb at rest resists stays */
        still[limb] = NAMED(rests)(square[limb]);
        if (still[limb])
            NAMED(resisted)(links + 1 + limb, limb ? -1.0 : 1.0, links[0].half, start[limb][0], own[limb]);
    }
    for (SIZE k = 0; k < t; k++) {
        MANY p[6][6], q[6], axis[3];
        for (int i = 0; i < 6; i++) q[i] = 0.0 * lasts;
        for (int limb = 0; limb < 2; limb++) {
            if (still[limb]) continue;
            NAMED(turned)(start[limb], square[limb], parts[k] * lasts, series, axis);
            NAMED(resisted)(links + 1 + limb, limb ? -1.0 : 1.0, links[0].half, axis, own[limb]);
            NAMED(pushed)(links + 1 + limb, limb ? -1.0 : 1.0, links[0].half, axis, rates[limb], q);
        }
        for (int i = 0; i < 6; i++)
            for (int j = 0; j <= i; j++) p[i][j] = (i == j ? own[0][i][j] + links[0].drag[i] : own[0][i][j]) + own[1][i][j];
        NAMED(factored)(p);
        NAMED(solved)(p, q);
        for (int i = 0; i < 6; i++) xi[k][i] = -q[i] * lasts;
    }
}

VARIANT inline MANY NAMED(further)(MANY here, double weight, MANY before) { return here + weight * (here - before); }

/* Aitken and Neville: T_j = T_(j-1) + (T_(j-1) - T of the row before) / ((n_i / n_(i-j))^2 - 1), of each number of a state,
 * by the weights and columns at hand. */
#define EXTRAPOLATE(NUMBER, state, further)                        \
    for (int i = 0; i < 12; i++) {                                 \
        NUMBER here = state[i / 3][i % 3];                         \
        for (SIZE j = 0; j < row; j++) {                           \
            const NUMBER before = column[j][i / 3][i % 3];         \
            column[j][i / 3][i % 3] = here;                        \
            here = further(here, weight[row][j], before);          \
        }                                                          \
        column[row][i / 3][i % 3] = here;                          \
    }

/* By how much displacements differ from none: the columns of the rotation less 1, and the position.
 *
 * numbers: of the base and the limbs half the length and the drag on (v, omega), (3, 7).
 * axes, rates: the limbs' axes where n pieces begin, and their rates, in base coordinates, both (2, 3, n).
 * length: how long each piece lasts, (n,). parts: the times at which midpoint steps begin, as parts of a piece, (t,).
 * steps: numbers of midpoint steps, (r,). place: at which of the times each step of each number begins, row after row.
 * fine, rough: extrapolated from all, and without the last extrapolation, (n, 3, 4). */
VARIANT void NAMED(extrapolated)(const double *numbers, SIZE n, const double *axes, const double *rates, const double *length,
                                 SIZE t, const double *parts, SIZE r, const SIZE *steps, const SIZE *place, double *fine,
                                 double *rough) {
    const struct link *links = (const struct link *)numbers;
    double series[TERMS][2], weight[MOST_ROWS][MOST_ROWS];
    series_of_sine(series);
    for (SIZE row = 0; row < r; row++) /* 1 / ((n_i / n_(i-j))^2 - 1) */
        for (SIZE j = 0; j < row; j++) {
            const double other = (double)(steps[row - j - 1] * steps[row - j - 1]);
            weight[row][j] = other / ((double)(steps[row] * steps[row]) - other);
        }
    for (SIZE p = 0; p < n; p += AT_ONCE) {
        MANY xi[MOST_TIMES][6], start[2][3][3], u[2][3], lasts, column[MOST_ROWS][4][3];
        for (int w = 0; w < AT_ONCE; w++) {
            const SIZE mine = p + w < n ? p + w : p;
            lasts[w] = length[mine];
            for (int i = 0; i < 6; i++) {
                start[i / 3][0][i % 3][w] = axes[i * n + mine] + 0.0; /* no zero but the positive one: it stays */
                u[i / 3][i % 3][w] = rates[i * n + mine];
            }
        }
        for (int limb = 0; limb < 2; limb++) {
            CROSS(start[limb][1], u[limb], start[limb][0]);
            CROSS(start[limb][2], u[limb], start[limb][1]);
        }
        NAMED(twists)(links, start, u, lasts, t, parts, (const double(*)[2])series, xi);
        const SIZE *at = place;
        for (SIZE row = 0; row < r; row++) {
            const double step = (double)1.0 / (double)steps[row], twice = step + step;
            MANY earlier[4][3], state[4][3], by[4][3];
            for (int i = 0; i < 12; i++) earlier[i / 3][i % 3] = 0.0 * lasts;
            NAMED(slope)(xi[*at++], earlier, by);
            for (int i = 0; i < 12; i++) state[i / 3][i % 3] = step * by[i / 3][i % 3];
            for (SIZE m = 1; m < steps[row]; m++) {
                NAMED(slope)(xi[*at++], state, by);
                for (int i = 0; i < 12; i++) {
                    const MANY next = earlier[i / 3][i % 3] + twice * by[i / 3][i % 3];
                    earlier[i / 3][i % 3] = state[i / 3][i % 3];
                    state[i / 3][i % 3] = next;
                }
            }
            EXTRAPOLATE(MANY, state, NAMED(further));
        }
        for (int w = 0; w < AT_ONCE && p + w < n; w++)
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < 4; c++) {
                    fine[12 * (p + w) + 4 * i + c] = column[r - 1][c][i][w];
                    rough[12 * (p + w) + 4 * i + c] = column[r > 1 ? r - 2 : 0][c][i][w];
                }
    }
}
