/* Products, linear systems and orthogonal factors of small matrices, row by row. */
#include <math.h>

#include "kernel.h"
#include "small.h"

/* Products of `count` pairs of matrices (n, k) and (k, m), each sum from the first term on; the next matrices are
 * a_step and b_step numbers on. */
API void purcell_products(SIZE count, SIZE n, SIZE k, SIZE m, const double *a, SIZE a_step, const double *b,
                          SIZE b_step, double *out) {
    for (SIZE c = 0; c < count; c++, a += a_step, b += b_step, out += n * m) {
        if (n == 6 && k == 6 && m == 6)
            product(a, b, out, 6, 6, 6);
        else if (n == 4 && k == 4 && m == 4)
            product(a, b, out, 4, 4, 4);
        else if (n == 3 && k == 3 && m == 3)
            product(a, b, out, 3, 3, 3);
        else
            product(a, b, out, n, k, m);
    }
}

/* Solutions of `count` square systems by elimination with the largest pivot of each column; not finite where a matrix
 * is singular. a: (count, k, k), spoilt. x: right sides, which become the solutions, (count, k, m). */
API void purcell_solve(SIZE count, SIZE k, SIZE m, double *a, double *x) {
    for (SIZE c = 0; c < count; c++, a += k * k, x += k * m) {
        for (SIZE j = 0; j < k; j++) {
            SIZE best = j;
            for (SIZE i = j + 1; i < k; i++)
                if (fabs(a[i * k + j]) > fabs(a[best * k + j])) best = i;
            for (SIZE i = j; best != j && i < k; i++) {
                const double kept = a[j * k + i];
                a[j * k + i] = a[best * k + i];
                a[best * k + i] = kept;
            }
            for (SIZE i = 0; best != j && i < m; i++) {
                const double kept = x[j * m + i];
                x[j * m + i] = x[best * m + i];
                x[best * m + i] = kept;
            }
            for (SIZE i = j + 1; i < k; i++) {
                const double factor = a[i * k + j] / a[j * k + j];
                if (factor == 0.0) continue;
                for (SIZE l = j + 1; l < k; l++) a[i * k + l] -= factor * a[j * k + l];
                for (SIZE l = 0; l < m; l++) x[i * m + l] -= factor * x[j * m + l];
            }
        }
        for (SIZE j = k - 1; j >= 0; j--)
            for (SIZE l = 0; l < m; l++) {
                double sum = x[j * m + l];
                for (SIZE i = j + 1; i < k; i++) sum -= a[j * k + i] * x[i * m + l];
                x[j * m + l] = sum / a[j * k + j];
            }
    }
}

/* Orthonormal rows, and what they make the rows of, by modified Gram and Schmidt with the longest row left taken next.
 * rows: (k, n), spoilt. basis: (r, n), made: (r, k), with r the smaller of n and k. Rows of which less than the part
 * `weakest` of the longest is left depend on those before. Returns how many are independent. */
API SIZE purcell_orthogonal_rows(SIZE k, SIZE n, double *rows, double weakest, double *basis, double *made) {
    const SIZE most = k < n ? k : n;
    double largest = 0.0;
    for (SIZE j = 0; j < most; j++) {
        SIZE best = 0;
        double size = -1.0;
        for (SIZE i = 0; i < k; i++) {
            const double square = inner_product(n, rows + i * n, rows + i * n);
            if (square > size) {
                size = square;
                best = i;
            }
        }
        size = sqrt(size > 0.0 ? size : 0.0);
        largest = size > largest ? size : largest;
        if (!(size > weakest * largest)) return j;
        double *vector = basis + j * n;
        for (SIZE i = 0; i < n; i++) vector[i] = rows[best * n + i] / size;
        for (SIZE l = 0; l < j; l++) { /* cleared of the earlier ones once more, which rounding has left in it */
            const double part = inner_product(n, basis + l * n, vector);
            for (SIZE i = 0; i < n; i++) vector[i] -= part * basis[l * n + i];
        }
        const double length = sqrt(inner_product(n, vector, vector));
        for (SIZE i = 0; i < n; i++) vector[i] /= length;
        for (SIZE i = 0; i < k; i++) {
            double *row = rows + i * n;
            const double part = made[j * k + i] = inner_product(n, row, vector);
            for (SIZE l = 0; l < n; l++) row[l] = i == best ? 0.0 : row[l] - part * vector[l];
        }
    }
    return most;
}

#define SWEEPS 40
#define SKEW 3e-16 /* the cosine between two rows that counts as none; some eight sweeps are made */

/* Rows made orthogonal by one-sided Jacobi rotations (Hestenes 1958), and the rotations. both: (k, n + k), the rows
 * and the identity beside them. */
API void purcell_orthogonal_by_rotations(SIZE k, SIZE n, double *both) {
    const SIZE width = n + k;
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS; sweep++) {
        turned = 0;
        for (SIZE i = 0; i < k; i++)
            for (SIZE j = i + 1; j < k; j++) {
                double *left = both + i * width, *right = both + j * width;
                const double p = inner_product(n, left, left), q = inner_product(n, right, right), cross = inner_product(n, left, right);
                if (!(fabs(cross) > SKEW * sqrt(p * q))) continue;
                const double slope = (q - p) / (2.0 * cross), size = fabs(slope) + sqrt(1.0 + slope * slope);
                const double tangent = slope < 0.0 ? -1.0 / size : 1.0 / size;
                const double cosine = 1.0 / sqrt(1.0 + tangent * tangent), sine = cosine * tangent;
                turned = 1;
                for (SIZE l = 0; l < width; l++) {
                    const double a = left[l], b = right[l];
                    left[l] = cosine * a - sine * b;
                    right[l] = sine * a + cosine * b;
                }
            }
    }
}

/* Inner products of n pairs of vectors (n, k). */
API void purcell_inner(SIZE n, SIZE k, const double *a, const double *b, double *out) {
    for (SIZE i = 0; i < n; i++) out[i] = inner_product(k, a + i * k, b + i * k);
}

/* Cross products of n pairs of vectors (n, 3). */
API void purcell_cross(SIZE n, const double *a, const double *b, double *out) {
    for (SIZE i = 0; i < 3 * n; i += 3) CROSS(out + i, a + i, b + i);
}

static double clipped(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

#define EQUATIONS 6
#define ROUNDS 6       /* Newton steps on the multipliers */
#define MET 1e-4       /* a problem ends when no equation misses by more than this */
#define DAMPING 1e-8   /* of the multipliers' equations, as a part of the trace */

/* The steps nearest to others, between bounds, that meet six equations as far as they can, of n problems of k unknowns:
 * Newton's method on the multipliers of the equations (Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865).
 *
 * columns: the equations, (n, 6, k). wanted: (n, 6). begun, loose, low, high: (n, k); loose is the inverse of how much
 * an unknown's change counts. room: (2, k). out: (n, k). */
API void purcell_least_steps(SIZE n, SIZE k, const double *columns, const double *wanted, const double *begun,
                             const double *loose, const double *low, const double *high, double *room, double *out) {
    double *const step = room, *const free = room + k;
    for (SIZE p = 0; p < n; p++, columns += EQUATIONS * k, wanted += EQUATIONS, begun += k, loose += k, low += k, high += k,
              out += k) {
        double lead[EQUATIONS] = {0.0}, least = 0.0;
        for (SIZE j = 0; j < k; j++) out[j] = step[j] = clipped(begun[j], low[j], high[j]);
        for (int round = 0; round < ROUNDS; round++) {
            double missing[EQUATIONS], system[EQUATIONS * EQUATIONS], size = 0.0, trace = 0.0;
            for (int i = 0; i < EQUATIONS; i++) {
                missing[i] = wanted[i] - inner_product(k, columns + i * k, step);
                size = fabs(missing[i]) > size ? fabs(missing[i]) : size;
            }
            if (round == 0 || size < least) {
                least = size;
                for (SIZE j = 0; j < k; j++) out[j] = step[j];
            }
            if (size < MET) break;
            for (int i = 0; i < EQUATIONS; i++) {
                for (SIZE j = 0; j < k; j++)
                    free[j] = step[j] > low[j] && step[j] < high[j] ? loose[j] * columns[i * k + j] : 0.0;
                for (int l = 0; l < EQUATIONS; l++) system[EQUATIONS * i + l] = inner_product(k, free, columns + l * k);
                trace += system[(EQUATIONS + 1) * i];
            }
            /* Damped slightly, since the free unknowns may be too few for all equations. */
            for (int i = 0; i < EQUATIONS; i++) system[(EQUATIONS + 1) * i] += DAMPING * trace + 1e-30;
            purcell_solve(1, EQUATIONS, 1, system, missing);
            for (int i = 0; i < EQUATIONS; i++) lead[i] += missing[i];
            for (SIZE j = 0; j < k; j++) {
                double sum = lead[0] * columns[j];
                for (int i = 1; i < EQUATIONS; i++) sum += lead[i] * columns[i * k + j];
                step[j] = clipped(begun[j] + loose[j] * sum, low[j], high[j]);
            }
        }
    }
}
