/* Sines, arc tangents and the coefficients of rotations, the same bits everywhere: a few units in the last place. */
#include <math.h>
#include <string.h>

#include "kernel.h"

/* Adding and taking away 1.5 * 2^52 leaves the nearest whole number, ties to even, up to 2^51. */
#define ROUNDER 6755399441055744.0

static double nearest(double x) { return fabs(x) < 2251799813685248.0 ? (x + ROUNDER) - ROUNDER : x; }

static int negative(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (int)(bits >> 63);
}

/* pi/2 in three parts of 33 bits: their products with whole numbers below 2^20 are exact (Cody and Waite 1980). */
static const double HALF_PI[3] = {1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21};
#define PI 3.14159265358979323846
#define PI_REST 1.2246467991473531772e-16 /* what pi has beyond its double */
#define TWO_BY_PI (2.0 / PI)

/* Taylor coefficients of (sin r - r) / r^3 and (cos r - 1 + r^2 / 2) / r^4 in r^2: truncation below 1e-19 to pi/4. */
#define TERMS 9
static const double SIN_COS[TERMS][2] = {
    {-1.0 / 6.0, 1.0 / 24.0},
    {1.0 / 120.0, -1.0 / 720.0},
    {-1.0 / 5040.0, 1.0 / 40320.0},
    {1.0 / 362880.0, -1.0 / 3628800.0},
    {-1.0 / 39916800.0, 1.0 / 479001600.0},
    {1.0 / 6227020800.0, -1.0 / 87178291200.0},
    {-1.0 / 1307674368000.0, 1.0 / 20922789888000.0},
    {1.0 / 355687428096000.0, -1.0 / 6402373705728000.0},
    {-1.0 / 121645100408832000.0, 1.0 / 2432902008176640000.0},
};

void purcell_sin_cos_of(double angle, double *sine, double *cosine) {
    if (!(angle - angle == 0.0)) { /* not finite */
        *sine = *cosine = angle - angle;
        return;
    }
    const double quarter = nearest(angle * TWO_BY_PI);
    const double r = ((angle - quarter * HALF_PI[0]) - quarter * HALF_PI[1]) - quarter * HALF_PI[2];
    const double z = r * r;
    double first = SIN_COS[TERMS - 1][0], second = SIN_COS[TERMS - 1][1];
    for (int k = TERMS - 2; k >= 0; k--) {
        first = first * z + SIN_COS[k][0];
        second = second * z + SIN_COS[k][1];
    }
    const double half = 0.5 * z, near = 1.0 - half;
    const double s = r + r * (z * first), c = near + (((1.0 - near) - half) + z * (z * second));
    const double turns = quarter * 0.25;
    double place = quarter - 4.0 * nearest(turns); /* -2, -1, 0, 1 or 2 */
    if (!(fabs(quarter) < 4503599627370496.0)) place = 0.0; /* so large an angle has no digit left */
    if (place < 0.0) place += 4.0;
    if (place == 0.0) {
        *sine = s;
        *cosine = c;
    } else if (place == 1.0) {
        *sine = c;
        *cosine = -s;
    } else if (place == 2.0) {
        *sine = -s;
        *cosine = -c;
    } else {
        *sine = -c;
        *cosine = s;
    }
}

/* Taylor coefficients of (atan u - u) / u^3 in u^2: truncation below 1e-20 to u = 1/16. */
static const double ATAN[7] = {-1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0, -1.0 / 15.0};
/* atan(k / 8), to all digits of a double. */
static const double EIGHTHS[9] = {
    0.0,
    0.12435499454676143503,
    0.24497866312686415417,
    0.35877067027057222040,
    0.46364760900080611621,
    0.55859931534356243597,
    0.64350110879328438680,
    0.71882999962162450541,
    0.78539816339744830962,
};

double purcell_arctan2_of(double y, double x) {
    if (!(x == x) || !(y == y)) return x + y;
    const double up = fabs(y), along = fabs(x);
    const double low = up < along ? up : along;
    double high = up < along ? along : up;
    if (!(high > 0.0)) high = 1.0;
    if (!(high - high == 0.0)) { /* infinite: the axis, or the diagonal */
        const double angle = low - low == 0.0 ? 0.0 : EIGHTHS[8];
        const double turned = up > along ? 0.5 * PI : angle;
        const double whole = negative(x) ? PI - turned : turned;
        return negative(y) ? -whole : whole;
    }
    const double eighth = nearest(8.0 * (low / high)), node = 0.125 * eighth;
    const double u = (low - node * high) / (high + node * low);
    const double z = u * u;
    double series = ATAN[6];
    for (int k = 5; k >= 0; k--) series = series * z + ATAN[k];
    double angle = EIGHTHS[(int)eighth] + (u + u * (z * series));
    if (up > along) angle = (0.5 * PI - angle) + 0.5 * PI_REST;
    if (negative(x)) angle = (PI - angle) + PI_REST;
    return negative(y) ? -angle : angle;
}

/* Taylor coefficients of sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 in t^2: truncation below 1e-17 to 2.25. */
const double purcell_series[SERIES_TERMS][3] = {
    {1.0, 1.0 / 2.0, 1.0 / 6.0},
    {-1.0 / 6.0, -1.0 / 24.0, -1.0 / 120.0},
    {1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0},
    {-1.0 / 5040.0, -1.0 / 40320.0, -1.0 / 362880.0},
    {1.0 / 362880.0, 1.0 / 3628800.0, 1.0 / 39916800.0},
    {-1.0 / 39916800.0, -1.0 / 479001600.0, -1.0 / 6227020800.0},
    {1.0 / 6227020800.0, 1.0 / 87178291200.0, 1.0 / 1307674368000.0},
    {-1.0 / 1307674368000.0, -1.0 / 20922789888000.0, -1.0 / 355687428096000.0},
    {1.0 / 355687428096000.0, 1.0 / 6402373705728000.0, 1.0 / 121645100408832000.0},
    {-1.0 / 121645100408832000.0, -1.0 / 2432902008176640000.0, -1.0 / 51090942171709440000.0},
    {1.0 / 51090942171709440000.0, 1.0 / 1124000727777607680000.0, 1.0 / 25852016738884976640000.0},
    {-1.0 / 25852016738884976640000.0, -1.0 / 620448401733239439360000.0, -1.0 / 15511210043330985984000000.0},
};

void purcell_exp_of(double x, double out[3]) {
    if (x > SERIES_BELOW) {
        const double t = sqrt(x);
        double sine, cosine;
        purcell_sin_cos_of(t, &sine, &cosine);
        out[0] = sine / t;
        out[1] = (1.0 - cosine) / (t * t);
        out[2] = (t - sine) / (t * t * t);
        return;
    }
    /* Fewer terms do where t^2 is small: truncation below 1e-17. */
    const int terms = x <= 0.01 ? 5 : x <= 0.25 ? 8 : SERIES_TERMS;
    for (int i = 0; i < 3; i++) out[i] = purcell_series[terms - 1][i];
    for (int k = terms - 2; k >= 0; k--)
        for (int i = 0; i < 3; i++) out[i] = out[i] * x + purcell_series[k][i];
}

API void purcell_sin_cos(SIZE n, const double *angle, double *sine, double *cosine) {
    for (SIZE k = 0; k < n; k++) purcell_sin_cos_of(angle[k], sine + k, cosine + k);
}

API double purcell_sine(double angle) {
    double sine, cosine;
    purcell_sin_cos_of(angle, &sine, &cosine);
    return sine;
}

API double purcell_cosine(double angle) {
    double sine, cosine;
    purcell_sin_cos_of(angle, &sine, &cosine);
    return cosine;
}

API double purcell_angle(double y, double x) { return purcell_arctan2_of(y, x); }

API void purcell_arctan2(SIZE n, const double *y, const double *x, double *out) {
    for (SIZE k = 0; k < n; k++) out[k] = purcell_arctan2_of(y[k], x[k]);
}

/* Shapes (n,) to (3, n). */
API void purcell_exp_coefficients(SIZE n, const double *angle_squared, double *out) {
    for (SIZE k = 0; k < n; k++) {
        double each[3];
        purcell_exp_of(angle_squared[k], each);
        for (int i = 0; i < 3; i++) out[i * n + k] = each[i];
    }
}
