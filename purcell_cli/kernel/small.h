/* Vectors and matrices of a few numbers, for doubles and for lanes alike. */
#ifndef PURCELL_SMALL_H
#define PURCELL_SMALL_H

#include "kernel.h"

#define CLEARLY 1e-9 /* more than rounding errors [L, rad, or of cosines] */

#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])
#define CROSS(out, a, b)                        \
    do {                                        \
        (out)[0] = (a)[1] * (b)[2] - (a)[2] * (b)[1]; \
        (out)[1] = (a)[2] * (b)[0] - (a)[0] * (b)[2]; \
        (out)[2] = (a)[0] * (b)[1] - (a)[1] * (b)[0]; \
    } while (0)

/* out = a b for matrices (n, k) and (k, m), each sum from the first term on. out must be neither. */
static inline void product(const double *a, const double *b, double *restrict out, SIZE n, SIZE k, SIZE m) {
    for (SIZE i = 0; i < n; i++) {
        SIZE c = 0;
        for (; c + 4 <= m; c += 4) { /* four sums side by side stay in registers */
            double s[4];
            for (int l = 0; l < 4; l++) s[l] = a[i * k] * b[c + l];
            for (SIZE j = 1; j < k; j++)
                for (int l = 0; l < 4; l++) s[l] += a[i * k + j] * b[j * m + c + l];
            for (int l = 0; l < 4; l++) out[i * m + c + l] = s[l];
        }
        for (; c < m; c++) {
            double s = a[i * k] * b[c];
            for (SIZE j = 1; j < k; j++) s += a[i * k + j] * b[j * m + c];
            out[i * m + c] = s;
        }
    }
}

/* An inner product in four sums side by side, which the processor makes at once. */
static inline double inner_product(SIZE n, const double *a, const double *b) {
    double s[4] = {0.0, 0.0, 0.0, 0.0};
    SIZE k = 0;
    for (; k + 4 <= n; k += 4)
        for (int i = 0; i < 4; i++) s[i] += a[k + i] * b[k + i];
    for (int i = 0; k + i < n; i++) s[i] += a[k + i] * b[k + i];
    return (s[0] + s[1]) + (s[2] + s[3]);
}

/* 1 + b hat(w) + c hat(w)^2: the rotation by w, or how it turns as w changes. */
static inline void hat_series(const double w[3], double b, double c, double out[9]) {
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[4 * i] = 1.0 - c * (w[j] * w[j] + w[k] * w[k]);
        out[3 * i + j] = c * (w[i] * w[j]) - b * w[k];
        out[3 * i + k] = c * (w[i] * w[k]) + b * w[j];
    }
}

static inline void identity(double *out, int n) {
    for (int i = 0; i < n * n; i++) out[i] = i % (n + 1) == 0 ? 1.0 : 0.0;
}

/* Ad_g, which carries a body twist into the frame g is seen from: [[R, hat(p) R], [0, R]]. */
static inline void adjoint(const double g[16], double out[36]) {
    const double p[3] = {g[3], g[7], g[11]};
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int c = 0; c < 3; c++) {
            out[6 * i + c] = out[6 * (i + 3) + c + 3] = g[4 * i + c];
            out[6 * i + c + 3] = p[j] * g[4 * k + c] - p[k] * g[4 * j + c];
            out[6 * (i + 3) + c] = 0.0;
        }
    }
}

static inline void inverse_pose(const double g[16], double out[16]) {
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) out[4 * i + j] = g[4 * j + i];
        out[4 * i + 3] = -(g[i] * g[3] + g[4 + i] * g[7] + g[8 + i] * g[11]);
        out[12 + i] = 0.0;
    }
    out[15] = 1.0;
}

#endif
