/* The certificate's integrator with twice the digits of doubles, after `extrapolated_body.h`: the equations are solved in
 * doubles, and what the solution leaves unbalanced, seen with all digits, is taken away from it. */

/* Numbers as sums of two doubles, the second some units of the first's last digit at the most: they hold some 100 binary
 * digits (Dekker 1971). They are not put in order after each step, which would take a third of the time. */
typedef struct {
    MANY high, low;
} NAMED(twice);
#define TWICE NAMED(twice)

VARIANT inline TWICE NAMED(sum_of)(MANY a, MANY b) {
    const MANY s = a + b, v = s - a;
    return (TWICE){s, (a - (s - v)) + (b - v)};
}

VARIANT inline TWICE NAMED(plus)(TWICE a, TWICE b) {
    const TWICE s = NAMED(sum_of)(a.high, b.high);
    return (TWICE){s.high, s.low + (a.low + b.low)};
}

VARIANT inline TWICE NAMED(minus)(TWICE a, TWICE b) { return NAMED(plus)(a, (TWICE){-b.high, -b.low}); }

VARIANT inline TWICE NAMED(times)(TWICE a, TWICE b) {
    const MANY p = a.high * b.high;
    return (TWICE){p, LOST(a.high, b.high, p) + (a.high * b.low + a.low * b.high)};
}

VARIANT inline TWICE NAMED(scaled)(TWICE a, MANY b) {
    const MANY p = a.high * b;
    return (TWICE){p, LOST(a.high, b, p) + a.low * b};
}

VARIANT inline TWICE NAMED(further_twice)(TWICE here, TWICE weight, TWICE before) {
    return NAMED(plus)(here, NAMED(times)(weight, NAMED(minus)(here, before)));
}

VARIANT inline TWICE NAMED(all)(double high, double low) {
    const MANY zero = {0.0};
    return (TWICE){zero + high, zero + low};
}

VARIANT inline void NAMED(crossed)(const TWICE a[3], const TWICE b[3], TWICE out[3]) {
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = NAMED(minus)(NAMED(times)(a[j], b[k]), NAMED(times)(a[k], b[j]));
    }
}

VARIANT inline TWICE NAMED(inner)(const TWICE a[3], const TWICE b[3]) {
    return NAMED(plus)(NAMED(plus)(NAMED(times)(a[0], b[0]), NAMED(times)(a[1], b[1])), NAMED(times)(a[2], b[2]));
}

/* The force and torque on the base that a twist leaves, link by link: 0 where it is the one by which the body moves. */
VARIANT void NAMED(unbalanced)(const struct link *links, TWICE axes[2][3], TWICE rates[2][3], const MANY xi[6], MANY out[6]) {
    const MANY zero = 0.0 * xi[0], *v = xi, *omega = xi + 3;
    TWICE sum[6];
    for (int i = 0; i < 6; i++) sum[i] = NAMED(scaled)((TWICE){xi[i], zero}, zero + links[0].drag[i]);
    for (int limb = 0; limb < 2; limb++) {
        const struct link *l = links + 1 + limb;
        const double side = limb ? -1.0 : 1.0, *d = l->drag, reach = side * l->half;
        const TWICE *a = axes[limb], *u = rates[limb];
        TWICE arm[3], c[3], turn[3], moved[3], force[3], lever[3];
        for (int i = 0; i < 3; i++) {
            arm[i] = c[i] = NAMED(scaled)(a[i], zero + reach);
            turn[i] = NAMED(plus)(u[i], (TWICE){omega[i], zero});
        }
        c[0] = NAMED(plus)(c[0], (TWICE){zero + side * links[0].half, zero});
        NAMED(crossed)(u, arm, moved);
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const TWICE swung = NAMED(minus)(NAMED(scaled)(c[k], omega[j]), NAMED(scaled)(c[j], omega[k]));
            moved[i] = NAMED(plus)(NAMED(plus)(moved[i], swung), (TWICE){v[i], zero});
        }
        const TWICE along = NAMED(scaled)(NAMED(inner)(a, moved), zero + (d[0] - d[1]));
        const TWICE spin = NAMED(scaled)(NAMED(inner)(a, turn), zero + (d[3] - d[4]));
        for (int i = 0; i < 3; i++) force[i] = NAMED(plus)(NAMED(scaled)(moved[i], zero + d[1]), NAMED(times)(along, a[i]));
        NAMED(crossed)(c, force, lever);
        for (int i = 0; i < 3; i++) {
            const TWICE torque = NAMED(plus)(NAMED(scaled)(turn[i], zero + d[4]), NAMED(times)(spin, a[i]));
            sum[i] = NAMED(plus)(sum[i], force[i]);
            sum[3 + i] = NAMED(plus)(sum[3 + i], NAMED(plus)(lever[i], torque));
        }
    }
    for (int i = 0; i < 6; i++) out[i] = sum[i].high + sum[i].low;
}

/* As `turned`: the first terms of the series have twice the digits, the others are too small to need them. */
VARIANT void NAMED(turned_twice)(TWICE start[3][3], TWICE square, TWICE time, const double (*series)[2],
                                 const TWICE (*exact)[2], TWICE axis[3]) {
    const TWICE t2 = NAMED(times)(time, time), z = NAMED(times)(square, t2);
    TWICE sum[2];
    for (int f = 0; f < 2; f++) {
        MANY tail = 0.0 * z.high + series[TERMS - 1][f];
        for (int k = TERMS - 2; k >= EXACT; k--) tail = tail * z.high + series[k][f];
        sum[f] = (TWICE){tail, 0.0 * tail};
        for (int k = EXACT - 1; k >= 0; k--) sum[f] = NAMED(plus)(NAMED(times)(sum[f], z), exact[k][f]);
        sum[f] = NAMED(times)(sum[f], f ? t2 : time);
    }
    for (int i = 0; i < 3; i++) {
        const TWICE by = NAMED(plus)(NAMED(times)(sum[0], start[1][i]), NAMED(times)(sum[1], start[2][i]));
        axis[i] = NAMED(plus)(start[0][i], by);
    }
}

VARIANT void NAMED(twists_twice)(const struct link *links, TWICE start[2][3][3], TWICE rates[2][3], TWICE lasts, SIZE t,
                                 const double *parts, const double (*series)[2], const TWICE (*exact)[2], TWICE (*xi)[6]) {
    TWICE square[2], axes[2][3];
    MANY u[2][3], a[2][3], own[2][6][6];
    int still[2];
    for (int limb = 0; limb < 2; limb++) {
        const double side = limb ? -1.0 : 1.0;
        square[limb] = NAMED(inner)(rates[limb], rates[limb]);
        still[limb] = NAMED(rests)(square[limb].high);
        for (int i = 0; i < 3; i++) {
            u[limb][i] = rates[limb][i].high;
            a[limb][i] = start[limb][0][i].high;
            axes[limb][i] = start[limb][0][i];
        }
        if (still[limb]) NAMED(resisted)(links + 1 + limb, side, links[0].half, a[limb], own[limb]);
    }
    for (SIZE k = 0; k < t; k++) {
        MANY p[6][6], q[6], left[6];
        const TWICE time = NAMED(times)(lasts, NAMED(all)(parts[k], parts[t + k]));
        for (int i = 0; i < 6; i++) q[i] = 0.0 * time.high;
        for (int limb = 0; limb < 2; limb++) {
            if (still[limb]) continue;
            NAMED(turned_twice)(start[limb], square[limb], time, series, exact, axes[limb]);
            for (int i = 0; i < 3; i++) a[limb][i] = axes[limb][i].high;
            NAMED(resisted)(links + 1 + limb, limb ? -1.0 : 1.0, links[0].half, a[limb], own[limb]);
            NAMED(pushed)(links + 1 + limb, limb ? -1.0 : 1.0, links[0].half, a[limb], u[limb], q);
        }
        for (int i = 0; i < 6; i++)
            for (int j = 0; j <= i; j++) p[i][j] = (i == j ? own[0][i][j] + links[0].drag[i] : own[0][i][j]) + own[1][i][j];
        NAMED(factored)(p);
        NAMED(solved)(p, q);
        for (int i = 0; i < 6; i++) q[i] = -q[i];
        NAMED(unbalanced)(links, axes, rates, q, left);
        NAMED(solved)(p, left);
        for (int i = 0; i < 6; i++) xi[k][i] = NAMED(times)(NAMED(sum_of)(q[i], -left[i]), lasts);
    }
}

/* As `slope`, for twists that a step has been multiplied by. */
VARIANT void NAMED(slope_twice)(const TWICE xi[6], TWICE state[4][3], TWICE out[4][3]) {
    const MANY one = 0.0 * xi[0].high + 1.0, zero = 0.0 * xi[0].high;
    for (int c = 0; c < 3; c++) {
        TWICE r[3];
        for (int i = 0; i < 3; i++) r[i] = i == c ? NAMED(plus)(state[i][c], (TWICE){one, zero}) : state[i][c];
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            out[i][c] = NAMED(minus)(NAMED(times)(xi[3 + k], r[j]), NAMED(times)(xi[3 + j], r[k]));
        }
        out[3][c] = NAMED(inner)(xi, r);
    }
}

/* a / b of whole numbers. */
VARIANT TWICE NAMED(ratio)(double a, double b) {
    const MANY zero = {0.0}, many = zero + b, first = zero + a / b;
    const TWICE left = NAMED(minus)((TWICE){zero + a, zero}, NAMED(scaled)((TWICE){first, zero}, many));
    return (TWICE){first, (left.high + left.low) / many};
}

/* As `extrapolated`, with twice the digits: of numbers (2, ...) the first part is the higher one. */
VARIANT void NAMED(extrapolated_twice)(const double *numbers, SIZE n, const double *axes, const double *rates,
                                       const double *length, SIZE t, const double *parts, SIZE r, const SIZE *steps,
                                       const SIZE *place, double *fine, double *rough) {
    const struct link *links = (const struct link *)numbers;
    double series[TERMS][2];
    TWICE exact[EXACT][2], weight[MOST_ROWS][MOST_ROWS];
    series_of_sine(series);
    double factorial = 1.0;
    for (int k = 0; k < EXACT; k++)
        for (int f = 0; f < 2; f++) {
            factorial *= (double)(2 * k + 1 + f);
            exact[k][f] = NAMED(ratio)(k % 2 ? -1.0 : 1.0, factorial);
        }
    for (SIZE row = 0; row < r; row++)
        for (SIZE j = 0; j < row; j++) {
            const double other = (double)(steps[row - j - 1] * steps[row - j - 1]);
            weight[row][j] = NAMED(ratio)(other, (double)(steps[row] * steps[row]) - other);
        }
    for (SIZE p = 0; p < n; p += AT_ONCE) {
        TWICE xi[MOST_TIMES][6], start[2][3][3], u[2][3], lasts, column[MOST_ROWS][4][3];
        const TWICE none = NAMED(all)(0.0, 0.0);
        for (int w = 0; w < AT_ONCE; w++) {
            const SIZE mine = p + w < n ? p + w : p;
            lasts.high[w] = length[mine];
            lasts.low[w] = length[n + mine];
            for (int i = 0; i < 6; i++) {
                start[i / 3][0][i % 3].high[w] = axes[i * n + mine] + 0.0; /* no zero but the positive one: it stays */
                start[i / 3][0][i % 3].low[w] = axes[(6 + i) * n + mine] + 0.0;
                u[i / 3][i % 3].high[w] = rates[i * n + mine];
                u[i / 3][i % 3].low[w] = rates[(6 + i) * n + mine];
            }
        }
        for (int limb = 0; limb < 2; limb++) {
            NAMED(crossed)(u[limb], start[limb][0], start[limb][1]);
            NAMED(crossed)(u[limb], start[limb][1], start[limb][2]);
        }
        NAMED(twists_twice)(links, start, u, lasts, t, parts, (const double(*)[2])series, (const TWICE(*)[2])exact, xi);
        const SIZE *at = place;
        for (SIZE row = 0; row < r; row++) {
            const TWICE step = NAMED(ratio)(1.0, (double)steps[row]);
            TWICE earlier[4][3], state[4][3], by[4][3], moved[6];
            for (int i = 0; i < 12; i++) earlier[i / 3][i % 3] = none;
            for (int i = 0; i < 6; i++) moved[i] = NAMED(times)(step, xi[*at][i]);
            at++;
            NAMED(slope_twice)(moved, earlier, state);
            for (SIZE m = 1; m < steps[row]; m++, at++) {
                for (int i = 0; i < 6; i++) {
                    const TWICE once = NAMED(times)(step, xi[*at][i]);
                    moved[i] = (TWICE){2.0 * once.high, 2.0 * once.low};
                }
                NAMED(slope_twice)(moved, state, by);
                for (int i = 0; i < 12; i++) {
                    const TWICE next = NAMED(plus)(earlier[i / 3][i % 3], by[i / 3][i % 3]);
                    earlier[i / 3][i % 3] = state[i / 3][i % 3];
                    state[i / 3][i % 3] = next;
                }
            }
            EXTRAPOLATE(TWICE, state, NAMED(further_twice));
        }
        for (int w = 0; w < AT_ONCE && p + w < n; w++)
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < 4; c++) {
                    const TWICE *last = &column[r - 1][c][i], *before = &column[r > 1 ? r - 2 : 0][c][i];
                    double *put = fine + 12 * (p + w) + 4 * i + c, *other = rough + 12 * (p + w) + 4 * i + c;
                    put[0] = last->high[w];
                    put[12 * n] = last->low[w];
                    other[0] = before->high[w];
                    other[12 * n] = before->low[w];
                }
    }
}

#undef TWICE
