/* Displacements in double-double arithmetic (Dekker 1971; Hida, Li and Bailey 2001): some 32 digits.
 *
 * Where a motion repeats n times, an error of its heading grows with n squared. So steps, pieces and cycles are put
 * together with twice the digits, from sums and products of doubles alone: the same bits on every machine.
 */
#include "kernel.h"

static twofold two_sum(double a, double b) {
    const double s = a + b, v = s - a;
    return (twofold){s, (a - (s - v)) + (b - v)};
}

static twofold quick_two_sum(double a, double b) {
    const double s = a + b;
    return (twofold){s, b - (s - a)};
}

static void split(double a, double *high, double *low) {
    const double t = 134217729.0 * a; /* 2^27 + 1 */
    *high = t - (t - a);
    *low = a - *high;
}

static twofold two_product(double a, double b) {
    const double p = a * b;
    double ah, al, bh, bl;
    split(a, &ah, &al);
    split(b, &bh, &bl);
    return (twofold){p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

static twofold add(twofold a, twofold b) {
    twofold s = two_sum(a.high, b.high), t = two_sum(a.low, b.low);
    s.low += t.high;
    s = quick_two_sum(s.high, s.low);
    s.low += t.low;
    return quick_two_sum(s.high, s.low);
}

static twofold times(twofold a, twofold b) {
    twofold p = two_product(a.high, b.high);
    p.low += a.high * b.low + a.low * b.high;
    return quick_two_sum(p.high, p.low);
}

static twofold of(double a) { return (twofold){a, 0.0}; }

void purcell_wide_identity(wide_pose *g) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) g->m[i][j] = of(i == j ? 1.0 : 0.0);
}

void purcell_wide_product(const wide_pose *a, const wide_pose *b, wide_pose *out) {
    wide_pose made;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            twofold sum = times(a->m[i][0], b->m[0][j]);
            sum = add(sum, times(a->m[i][1], b->m[1][j]));
            sum = add(sum, times(a->m[i][2], b->m[2][j]));
            made.m[i][j] = j == 3 ? add(sum, a->m[i][3]) : sum;
        }
    *out = made;
}

void purcell_wide_times(wide_pose *g, const double move[16]) {
    wide_pose b;
    for (int i = 0; i < 12; i++) b.m[i / 4][i % 4] = of(move[i]);
    purcell_wide_product(g, &b, g);
}

/* One Newton step of the polar factor, R (3 - R^T R) / 2: it squares the defect. */
void purcell_wide_normalise(wide_pose *g) {
    wide_pose made = *g;
    twofold defect[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            twofold sum = times(g->m[0][i], g->m[0][j]);
            sum = add(sum, times(g->m[1][i], g->m[1][j]));
            sum = add(sum, times(g->m[2][i], g->m[2][j]));
            defect[i][j] = add(of(i == j ? 1.5 : 0.0), (twofold){-0.5 * sum.high, -0.5 * sum.low});
        }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            twofold sum = times(g->m[i][0], defect[0][j]);
            sum = add(sum, times(g->m[i][1], defect[1][j]));
            made.m[i][j] = add(sum, times(g->m[i][2], defect[2][j]));
        }
    *g = made;
}

/* By squaring; the first power is the pose to the bit. */
void purcell_wide_power(const wide_pose *g, SIZE exponent, wide_pose *out) {
    wide_pose square = *g, made;
    int begun = 0;
    purcell_wide_identity(&made);
    for (SIZE left = exponent; left > 0; left /= 2) {
        if (left % 2 && begun)
            purcell_wide_product(&made, &square, &made);
        else if (left % 2) {
            made = square;
            begun = 1;
        }
        if (left > 1) {
            purcell_wide_product(&square, &square, &square);
            purcell_wide_normalise(&square);
        }
    }
    *out = made;
}

void purcell_wide_round(const wide_pose *g, double out[16]) {
    for (int i = 0; i < 12; i++) out[i] = g->m[i / 4][i % 4].high;
    for (int i = 0; i < 4; i++) out[12 + i] = i == 3 ? 1.0 : 0.0;
}

void purcell_wide_load(const double *high_low, wide_pose *g) {
    for (int i = 0; i < 12; i++) g->m[i / 4][i % 4] = (twofold){high_low[2 * i], high_low[2 * i + 1]};
}

void purcell_wide_store(const wide_pose *g, double *high_low) {
    for (int i = 0; i < 12; i++) {
        high_low[2 * i] = g->m[i / 4][i % 4].high;
        high_low[2 * i + 1] = g->m[i / 4][i % 4].low;
    }
}
