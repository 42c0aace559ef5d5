/* Rotations and poses by the thousand: exponentials, logarithms and quaternions. */
#include <math.h>

#include "kernel.h"
#include "small.h"

static void quaternion_of(const double *r, int stride, double q[4]) {
    const double *x = r, *y = r + stride, *z = r + 2 * stride, d0 = x[0], d1 = y[1], d2 = z[2];
    /* The four ways to read a quaternion off a matrix; the one with the largest divisor is accurate. */
    const double ways[4] = {1.0 + d0 + d1 + d2, 1.0 + d0 - d1 - d2, 1.0 - d0 + d1 - d2, 1.0 - d0 - d1 + d2};
    const double low[3] = {z[1] - y[2], x[2] - z[0], y[0] - x[1]};
    const double sum[3] = {z[1] + y[2], x[2] + z[0], y[0] + x[1]};
    int best = 0;
    for (int i = 1; i < 4; i++)
        if (ways[i] > ways[best]) best = i;
    q[0] = best == 0 ? ways[0] : low[best - 1];
    for (int i = 0; i < 3; i++)
        q[1 + i] = best == 0 ? low[i] : best == 1 + i ? ways[best] : sum[3 - i - (best - 1)];
    double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (q[0] < 0.0) size = -size;
    for (int i = 0; i < 4; i++) q[i] /= size;
}

/* Unit quaternions (w, x, y, z), w >= 0. Shapes (n, 3, 3) to (n, 4). */
API void purcell_quaternions(SIZE n, const double *rotations, double *out) {
    for (SIZE k = 0; k < n; k++) quaternion_of(rotations + 9 * k, 3, out + 4 * k);
}

/* The displacements of constant body twists in unit time. Shapes (n, 6) to (n, 4, 4). */
API void purcell_exp(SIZE n, const double *twists, double *out) {
    for (SIZE k = 0; k < n; k++, twists += 6, out += 16) {
        const double *v = twists, *w = twists + 3;
        double c[3], r[9], wv[3], wwv[3];
        purcell_exp_of(DOT(w, w), c);
        purcell_rotation_of(w, r);
        CROSS(wv, w, v);
        CROSS(wwv, w, wv);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) out[4 * i + j] = r[3 * i + j];
            out[4 * i + 3] = v[i] + c[1] * wv[i] + c[2] * wwv[i];
            out[12 + i] = 0.0;
        }
        out[15] = 1.0;
    }
}

#define SERIES 0.0625 /* squared angle under which (1 - t/2 cot t/2) / t^2 sums its series */

/* The twists of poses, rotated by at most pi. Shapes (n, 4, 4) to (n, 6). */
API void purcell_log(SIZE n, const double *poses, double *out) {
    for (SIZE k = 0; k < n; k++, poses += 16, out += 6) {
        const double p[3] = {poses[3], poses[7], poses[11]};
        double q[4], wp[3], wwp[3], *w = out + 3, rest;
        quaternion_of(poses, 4, q);
        const double sine = sqrt(DOT(q + 1, q + 1)), half = purcell_arctan2_of(sine, q[0]);
        const double stretch = sine > 0.0 ? 2.0 * (half / sine) : 2.0, x = 4.0 * half * half;
        for (int i = 0; i < 3; i++) w[i] = stretch * q[1 + i];
        if (x < SERIES)
            rest = (1.0 + x / 60.0 * (1.0 + x / 42.0 * (1.0 + x / 40.0 * (1.0 + 5.0 * x / 198.0)))) / 12.0;
        else
            rest = (1.0 - 0.5 * stretch * q[0]) / x;
        CROSS(wp, w, p);
        CROSS(wwp, w, wp);
        for (int i = 0; i < 3; i++) out[i] = p[i] - 0.5 * wp[i] + rest * wwp[i];
    }
}

/* Rotation matrices of rotation vectors. Shapes (n, 3) to (n, 3, 3). */
API void purcell_rotations(SIZE n, const double *vectors, double *out) {
    for (SIZE k = 0; k < n; k++) purcell_rotation_of(vectors + 3 * k, out + 9 * k);
}

/* Ad_g. Shapes (n, 4, 4) to (n, 6, 6). */
API void purcell_adjoints(SIZE n, const double *poses, double *out) {
    for (SIZE k = 0; k < n; k++) adjoint(poses + 16 * k, out + 36 * k);
}

/* Shapes (n, 4, 4). */
API void purcell_inverses(SIZE n, const double *poses, double *out) {
    for (SIZE k = 0; k < n; k++) inverse_pose(poses + 16 * k, out + 16 * k);
}

/* One Newton step of the polar factor of each 3 by 3 corner of matrices (n, d, d), in place. */
API void purcell_orthonormalise(SIZE n, SIZE d, double *matrices) {
    for (SIZE k = 0; k < n; k++, matrices += d * d) {
        double r[9];
        for (int i = 0; i < 9; i++) r[i] = matrices[d * (i / 3) + i % 3];
        purcell_orthonormalise_of(r);
        for (int i = 0; i < 9; i++) matrices[d * (i / 3) + i % 3] = r[i];
    }
}
