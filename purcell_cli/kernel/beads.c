/* Links that feel each other's flow: the resistance of lines of beads. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define PI_6 18.849555921538759431 /* 6 pi */
#define PI_8 25.132741228718345908 /* 8 pi */

/* The mobility of two beads in a fluid of unit viscosity, same 1 + along r r^T / r^2 (Zuk et al. 2014, equations 1-3). */
static void mobility_of(double a, double b, double square, double *same, double *along) {
    const double r = sqrt(square), apart = (a - b) * (a - b);
    if (r >= a + b) {
        const double sum = (a * a + b * b) / square;
        *same = (1.0 + sum / 3.0) / (PI_8 * r);
        *along = (1.0 - sum) / (PI_8 * r);
    } else if (square > apart) {
        const double near = PI_6 * a * b, cube = 32.0 * square * r, wide = apart + 3.0 * square;
        *same = (0.5 * (a + b) - wide * wide / cube) / near;
        *along = 3.0 * ((apart - square) * (apart - square)) / cube / near;
    } else {
        *same = 1.0 / (PI_6 * (a > b ? a : b));
        *along = 0.0;
    }
}

/* What a plane wall without slip adds to that, 3 x 3 in rows of `stride` numbers: Blake's image of a point force (1971,
 * Proc. Camb. Phil. Soc. 70) averaged over both spheres, (1 + a^2/6 Laplace)(1 + b^2/6 Laplace) of it, as Swan and Brady
 * (2007, Phys. Fluids 19, 113306) have it for equal spheres. R goes from the second bead's mirror image to the first
 * bead, f = 1/R, u = R f, n is the wall's normal, c = u . n, W = n u^T - u n^T, S = 1 - 2 n n^T, h' and h are the heights
 * of the first and the second bead, and F_k is f's k-th derivative, all but two times along n. Times 8 pi it is
 * -f (1 + u u^T) + (a^2 + b^2)/3 F_2
 * + (2 h h' F_2 + (2 h f^2 - 2 b^2 c f^3) W + 2/3 (a^2 h + b^2 h') F_3 + 2/9 a^2 b^2 F_4) S.
 *
 * gap: from the second bead to the first. high, low: the heights of the first and the second. */
static void add_image(double a, double b, const double gap[3], double high, double low, const double normal[3],
                      double *m, SIZE stride) {
    double away[3], skew[3][3], mixed[3], far[3][3];
    for (int i = 0; i < 3; i++) away[i] = gap[i] + 2.0 * low * normal[i];
    const double f = 1.0 / sqrt(DOT(away, away)), f2 = f * f, f3 = f2 * f, f4 = f2 * f2, f5 = f2 * f3;
    for (int i = 0; i < 3; i++) away[i] *= f;
    const double c = DOT(away, normal), a2 = a * a, b2 = b * b;
    const double by_two = 2.0 * low * high, by_skew = 2.0 * low * f2 - 2.0 * b2 * c * f3;
    const double by_three = (2.0 / 3.0) * (a2 * low + b2 * high), by_four = (2.0 / 9.0) * (a2 * b2);
    for (int i = 0; i < 3; i++) {
        mixed[i] = 0.0;
        for (int j = 0; j < 3; j++) {
            const double same = i == j ? 1.0 : 0.0, both = away[i] * away[j], normals = normal[i] * normal[j];
            const double one = normal[i] * away[j], other = normal[j] * away[i], sum = one + other;
            const double two = (3.0 * both - same) * f3;
            const double three = (3.0 * (sum + same * c) - 15.0 * both * c) * f4;
            const double four = (105.0 * both * c * c - 15.0 * (same * c * c + 2.0 * c * sum + both)
                                 + 3.0 * (same + 2.0 * normals)) * f5;
            far[i][j] = ((a2 + b2) / 3.0) * two - (same + both) * f;
            skew[i][j] = by_two * two + by_skew * (one - other) + by_three * three + by_four * four;
            mixed[i] += skew[i][j] * normal[j];
        }
        for (int j = 0; j < 3; j++)
            m[i * stride + j] += (far[i][j] + skew[i][j] - 2.0 * mixed[i] * normal[j]) / PI_8;
    }
}

/* The resistance K^T M^-1 K of n beads in a fluid of unit viscosity, 1 if M is positive definite and 0 if not.
 *
 * place, arm: the beads' centres, and their places from their limb's joint. (n, 3).
 * link: 0 for the base, 1 or 2 for a limb. (n,).
 * wall: null without one; else its normal, into the fluid, and how high the origin of places is above it. (4,).
 * room: to work in. (3 n, 3 n) and after that (3 n, 12). */
API SIZE purcell_bead_resistance(SIZE n, const double *place, const double *arm, const double *radius,
                                 const SIZE *link, const double *wall, double *room, double *out) {
    const SIZE size = 3 * n;
    double *const m = room, *const y = room + size * size;
    for (SIZE i = 0; i < n; i++)
        for (SIZE j = 0; j <= i; j++) {
            double gap[3], same = 1.0 / (PI_6 * radius[i]), along = 0.0, square = 1.0;
            for (int c = 0; c < 3; c++) gap[c] = place[3 * i + c] - place[3 * j + c];
            if (j < i) {
                square = DOT(gap, gap);
                mobility_of(radius[i], radius[j], square, &same, &along);
            }
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++)
                    m[(3 * i + r) * size + 3 * j + c] = along * (gap[r] * gap[c] / square) + (r == c ? same : 0.0);
            if (wall)
                add_image(radius[i], radius[j], gap, wall[3] + DOT(wall, place + 3 * i),
                          wall[3] + DOT(wall, place + 3 * j), wall, m + 3 * i * size + 3 * j, size);
        }
    int positive;
    purcell_cholesky(size, m, &positive);
    if (!positive) return 0;
    /* K, and in its place L^-1 K. */
    for (SIZE i = 0; i < n; i++)
        for (int r = 0; r < 3; r++) {
            double *row = y + (3 * i + r) * COLUMNS;
            const int s = (r + 1) % 3, t = (r + 2) % 3;
            for (int c = 0; c < COLUMNS; c++) row[c] = 0.0;
            row[r] = 1.0;
            row[3 + s] = place[3 * i + t]; /* omega x place */
            row[3 + t] = -place[3 * i + s];
            if (link[i]) {
                row[3 + 3 * link[i] + s] = arm[3 * i + t];
                row[3 + 3 * link[i] + t] = -arm[3 * i + s];
            }
        }
    for (SIZE i = 0; i < size; i++) {
        double *row = y + i * COLUMNS;
        for (SIZE k = 0; k < i; k++) {
            const double factor = m[i * size + k];
            for (int c = 0; c < COLUMNS; c++) row[c] -= factor * y[k * COLUMNS + c];
        }
        for (int c = 0; c < COLUMNS; c++) row[c] /= m[i * size + i];
    }
    for (int e = 0; e < RESISTANCE; e++) out[e] = 0.0;
    for (SIZE k = 0; k < size; k++) {
        const double *row = y + k * COLUMNS;
        for (int i = 0; i < COLUMNS; i++)
            for (int j = 0; j <= i; j++) out[entry(i, j)] += row[i] * row[j];
    }
    return 1;
}
