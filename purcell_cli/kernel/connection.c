/* The local connection in closed form (section III-C), and its derivatives by the limbs' orientations and rates.
 *
 * Drag depends on a limb only through its axis a_i = A_i e_x. With rates in base coordinates, u_i = A_i omega_i, the
 * base's twist xi = -P^-1 q is a function of (a_1, a_2, u_1, u_2) alone, linear in the rates. What another drag law
 * changes is `resistance` and `limb_wrench` in `connection_body.h`, and `purcell_distance` here.
 */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define VARIANT static
#define NAMED(name) name##_narrow
#define LANE lane
#define SIDE_BY_SIDE LANES
#define NONE ((lane){0.0, 0.0})
#define OF(x, l) ((x)[l])
#include "connection_body.h"
#include "collocation_body.h"
#include "steps_body.h"

#ifdef WIDE
#undef VARIANT
#undef NAMED
#undef LANE
#undef SIDE_BY_SIDE
#undef NONE
typedef double quad __attribute__((vector_size(32), aligned(8), may_alias));
#define VARIANT __attribute__((target("avx2"))) static
#define NAMED(name) name##_wide
#define LANE quad
#define SIDE_BY_SIDE 4
#define NONE ((quad){0.0, 0.0, 0.0, 0.0})
#include "connection_body.h"
#include "collocation_body.h"
#include "steps_body.h"
#endif

void purcell_solve_steps(const struct swimmer *s, const struct rule *rule, SIZE many, const struct step *steps, int slopes,
                         struct travelled *out) {
#ifdef WIDE
    if (purcell_is_wide()) {
        solve_steps_wide(s, rule, many, steps, slopes, out);
        return;
    }
#endif
    solve_steps_narrow(s, rule, many, steps, slopes, out);
}

void purcell_node_states(const struct step *step, lane time, lane axes[2][3], lane rates[2][3]) {
    node_states_narrow(step, time, axes, rates);
}

void purcell_at_nodes(const struct swimmer *s, const struct step *step, int many, const double *times, int m,
                      const double *weights, double (*twists)[6], double (*changes)[6][6], double (*per_rates)[6][6]) {
#ifdef WIDE
    if (many > LANES && purcell_is_wide()) {
        at_nodes_wide(s, step, many, times, m, weights, twists, changes, per_rates);
        return;
    }
#endif
    at_nodes_narrow(s, step, many, times, m, weights, twists, changes, per_rates);
}

/* The same of links that feel each other. */
static void together(lane rates[2][3], const lane given[GIVEN], lane xi[6], lane change[6][6], lane per_rate[6][6],
                     lane *power) {
    lane p[6][6];
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) p[i][j] = given[entry(i, j)];
        xi[i] = -given[21 + i];
    }
    factor_narrow(p);
    solve_narrow(p, xi);
    for (int k = 0; per_rate && k < 6; k++) {
        for (int i = 0; i < 6; i++) per_rate[k][i] = -given[COUPLINGS + 6 * k + i];
        solve_narrow(p, per_rate[k]);
    }
    for (int c = 0; change && c < 6; c++) {
        const lane *changed = given + PULL * (1 + c);
        for (int i = 0; i < 6; i++) {
            lane sum = changed[21 + i];
            for (int j = 0; j < 6; j++) sum += changed[i < j ? entry(j, i) : entry(i, j)] * xi[j];
            change[c][i] = -sum;
        }
        solve_narrow(p, change[c]);
    }
    if (!power) return;
    *power = (lane){0.0, 0.0};
    for (int k = 0; k < 6; k++) {
        lane torque = {0.0, 0.0};
        for (int i = 0; i < 6; i++) {
            torque += given[COUPLINGS + 6 * k + i] * xi[i];
            torque += given[POWERS + (i < k ? entry(k, i) : entry(i, k))] * rates[i / 3][i % 3];
        }
        *power += torque * rates[k / 3][k % 3];
    }
}

void purcell_connection(const struct swimmer *s, lane axes[2][3], lane rates[2][3], const lane *given, lane xi[6],
                        lane change[6][6], lane per_rate[6][6], lane *power) {
    if (given)
        together(rates, given, xi, change, per_rate, power);
    else
        alone_narrow(s, axes, rates, xi, change, per_rate, power);
}

/* The sum of the two smaller eigenvalues of a symmetric matrix (Smith 1961, Comm. ACM 4, 168). */
static double spread(double m[3][3]) {
    const double trace = m[0][0] + m[1][1] + m[2][2], mean = trace / 3.0;
    const double d[3] = {m[0][0] - mean, m[1][1] - mean, m[2][2] - mean};
    const double a = m[0][1], b = m[0][2], c = m[1][2];
    double square = (DOT(d, d) + 2.0 * (a * a + b * b + c * c)) / 6.0, cosine, sine;
    square = square > 1e-300 ? square : 1e-300;
    const double size = sqrt(square);
    double half = 0.5 * (d[0] * (d[1] * d[2] - c * c) - a * (a * d[2] - c * b) + b * (a * c - d[1] * b)) /
                  (size * size * size);
    half = half > 1.0 ? 1.0 : half < -1.0 ? -1.0 : half;
    const double angle = 2.0 * purcell_arctan2_of(sqrt(1.0 - half), sqrt(1.0 + half));
    purcell_sin_cos_of(angle / 3.0, &sine, &cosine);
    return trace - (mean + 2.0 * size * cosine);
}

#define ROUNDED 1e-12 /* more than rounding errors, as a part */
#define FARTHEST 1.0 /* distances count up to here [rad]: A(r) varies with the bends themselves */

/* The spread of the links about the line that fits them best resists roll about that line; spin drag does where there
 * is no spread. The largest eigenvalue is no larger than the matrix itself (Frobenius): that mostly tells that the distance
 * is enough. */
double purcell_distance(const struct swimmer *s, double axes[2][3], double enough) {
    double first[3] = {0.0, 0.0, 0.0}, second[3][3] = {{0.0}}, total = 2.0 * s->half;
    for (int limb = 0; limb < 2; limb++) {
        const struct limb *l = s->limbs + limb;
        const double *a = axes[limb], length = 2.0 * l->half, inner = 2.0 / 3.0 * l->half * l->half * l->half;
        double c[3];
        for (int i = 0; i < 3; i++) c[i] = l->side * ((i ? 0.0 : s->half) + l->half * a[i]);
        total += length;
        for (int i = 0; i < 3; i++) {
            first[i] += length * c[i];
            for (int j = i; j < 3; j++) second[i][j] += length * (c[i] * c[j]) + inner * (a[i] * a[j]);
        }
    }
    second[0][0] += 2.0 / 3.0 * s->half * s->half * s->half;
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) second[i][j] -= first[i] * first[j] / total;
    double trace = 0.0, square = 0.0;
    for (int i = 0; i < 3; i++) {
        trace += second[i][i];
        for (int j = i; j < 3; j++) square += (i == j ? 1.0 : 2.0) * (second[i][j] * second[i][j]);
    }
    const double at_least = s->sharpness * s->sharpness + (trace * (1.0 - ROUNDED) - sqrt(square)) / s->straight_spread;
    if (enough <= FARTHEST && at_least > enough * enough) return FARTHEST;
    const double found = spread(second), positive = found > 0.0 ? found : 0.0;
    const double distance = sqrt(s->sharpness * s->sharpness + positive / s->straight_spread);
    return distance < FARTHEST ? distance : FARTHEST;
}

/* Lane by lane, for the Python side. Shapes (n, 2, 3), (n, 2, 3), (n, 6), (n, 6, 6), (n, 6, 6) and (n,); the last three
 * may be null. */
API void purcell_connections(const double *numbers, SIZE n, const double *axes, const double *rates, double *xi,
                             double *change, double *per_rate, double *power) {
    const struct swimmer *s = (const struct swimmer *)numbers;
    for (SIZE k = 0; k < n; k += LANES) {
        lane a[2][3], u[2][3], out[6], slopes[6][6], each[6][6], work, given[GIVEN];
        for (int i = 0; i < 6; i++)
            for (int w = 0; w < LANES; w++) {
                const SIZE at = 6 * (k + w < n ? k + w : n - 1) + i;
                a[i / 3][i % 3][w] = axes[at];
                u[i / 3][i % 3][w] = rates[at];
            }
        if (s->tables > 0.0)
            for (int w = 0; w < LANES; w++) {
                double axes_of[2][3], rates_of[2][3], found[GIVEN] = {0.0};
                for (int i = 0; i < 6; i++) {
                    axes_of[i / 3][i % 3] = a[i / 3][i % 3][w];
                    rates_of[i / 3][i % 3] = u[i / 3][i % 3][w];
                }
                purcell_at_shape(s, axes_of, rates_of, change != 0, per_rate || power, found);
                for (int e = 0; e < GIVEN; e++) given[e][w] = found[e];
            }
        purcell_connection(s, a, u, s->tables > 0.0 ? given : 0, out, change ? slopes : 0, per_rate ? each : 0, power ? &work : 0);
        for (int w = 0; w < LANES && k + w < n; w++) {
            for (int i = 0; i < 6; i++) xi[6 * (k + w) + i] = out[i][w];
            for (int i = 0; i < 36; i++) {
                if (change) change[36 * (k + w) + i] = slopes[i / 6][i % 6][w];
                if (per_rate) per_rate[36 * (k + w) + i] = each[i / 6][i % 6][w];
            }
            if (power) power[k + w] = work[w];
        }
    }
}
