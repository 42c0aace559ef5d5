/* The local connection in closed form (section III-C), and its derivatives by the limbs' orientations and rates.
 *
 * Drag depends on a limb only through its axis a_i = A_i e_x. With rates in base coordinates, u_i = A_i omega_i, the
 * base's twist xi = -P^-1 q is a function of (a_1, a_2, u_1, u_2) alone, linear in the rates. What another drag law
 * changes is here: `resistance`, `limb_wrench` and `purcell_distance`.
 */
#include <math.h>

#include "kernel.h"
#include "small.h"

/* P of the frozen shape about the base's centre, its lower half. */
static void resistance(const struct swimmer *s, lane axes[2][3], lane p[6][6]) {
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) p[i][j] = (lane){0.0, 0.0} + (i == j ? s->drag[i] : 0.0);
    for (int limb = 0; limb < 2; limb++) {
        const struct limb *l = s->limbs + limb;
        const lane *a = axes[limb];
        lane c[3], moment[6];
        for (int i = 0; i < 3; i++) {
            c[i] = (l->side * l->half) * a[i];
            moment[i] = a[i];
        }
        c[0] += l->side * s->half;
        CROSS(moment + 3, c, a);
        for (int i = 0; i < 6; i++) { /* the drag along the axis is less */
            const lane less = (-l->lateral * l->defect) * moment[i];
            for (int j = 0; j <= i; j++) p[i][j] += less * moment[j];
        }
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const lane arm = l->lateral * c[i], more = (l->spin - l->turn) * a[i];
            p[i][i] += l->lateral;
            p[3 + k][j] += arm; /* hat(c) */
            p[3 + j][k] -= arm;
            /* Of |c|^2 - c c^T and turn (1 - a a^T) the diagonal without differences, which would lose digits. */
            p[3 + i][3 + i] += l->lateral * (c[j] * c[j] + c[k] * c[k]) + l->turn * (a[j] * a[j] + a[k] * a[k]) +
                               l->spin * (a[i] * a[i]);
            for (int m = 0; m < i; m++) p[3 + i][3 + m] += more * a[m] - arm * c[m];
        }
    }
}

/* L and D of P = L D L^T, without pivots: D's reciprocals on the diagonal and L below it. */
static void factor(lane p[6][6]) {
    for (int j = 0; j < 6; j++) {
        lane row[6];
        p[j][j] = 1.0 / p[j][j];
        for (int i = j + 1; i < 6; i++) row[i] = p[i][j];
        for (int i = j + 1; i < 6; i++) {
            p[i][j] = row[i] * p[j][j];
            for (int k = j + 1; k <= i; k++) p[i][k] -= p[i][j] * row[k];
        }
    }
}

static void solve(lane p[6][6], lane x[6]) {
    for (int j = 0; j < 5; j++)
        for (int i = j + 1; i < 6; i++) x[i] -= p[i][j] * x[j];
    for (int j = 0; j < 6; j++) x[j] *= p[j][j];
    for (int j = 4; j >= 0; j--)
        for (int i = j + 1; i < 6; i++) x[j] -= p[i][j] * x[i];
}

/* Force and torque about the joint that move a limb with its joint's velocity and a rate. */
static void limb_wrench(const struct limb *l, const lane a[3], const lane velocity[3], const lane rate[3],
                        lane wrench[6]) {
    lane arm[3], at[3], lever[3];
    for (int i = 0; i < 3; i++) arm[i] = (l->side * l->half) * a[i];
    CROSS(at, rate, arm);
    for (int i = 0; i < 3; i++) at[i] += velocity[i];
    const lane along = l->defect * DOT(a, at), spin = (l->spin - l->turn) * DOT(a, rate);
    for (int i = 0; i < 3; i++) wrench[i] = l->lateral * (at[i] - along * a[i]);
    CROSS(lever, arm, wrench);
    for (int i = 0; i < 3; i++) wrench[3 + i] = lever[i] + l->turn * rate[i] + spin * a[i];
}

/* A wrench about the base's centre from one about a joint. */
static void to_base(const struct swimmer *s, const struct limb *l, lane wrench[6]) {
    const double arm = l->side * s->half;
    wrench[4] -= arm * wrench[2];
    wrench[5] += arm * wrench[1];
}

static void unit(int axis, lane out[3]) {
    for (int i = 0; i < 3; i++) out[i] = (lane){0.0, 0.0} + (i == axis ? 1.0 : 0.0);
}

/* e_axis x v */
static void unit_cross(int axis, const lane v[3], lane out[3]) {
    const int j = (axis + 1) % 3, k = (axis + 2) % 3;
    out[axis] = (lane){0.0, 0.0};
    out[j] = -v[k];
    out[k] = v[j];
}

static void alone(const struct swimmer *s, lane axes[2][3], lane rates[2][3], lane xi[6], lane change[6][6],
                  lane per_rate[6][6], lane *power) {
    const lane zero = {0.0, 0.0}, rest[3] = {zero, zero, zero};
    lane p[6][6], wrench[2][6];
    resistance(s, axes, p);
    factor(p);
    for (int limb = 0; limb < 2; limb++) {
        limb_wrench(s->limbs + limb, axes[limb], rest, rates[limb], wrench[limb]);
        to_base(s, s->limbs + limb, wrench[limb]);
    }
    for (int i = 0; i < 6; i++) xi[i] = -(wrench[0][i] + wrench[1][i]);
    solve(p, xi);
    if (power) *power = zero;
    if (!change && !power && !per_rate) return;
    for (int limb = 0; limb < 2; limb++) {
        const struct limb *l = s->limbs + limb;
        const double arm = l->side * s->half;
        const lane joint[3] = {xi[0], xi[1] + arm * xi[5], xi[2] - arm * xi[4]};
        const lane spun[3] = {xi[3] + rates[limb][0], xi[4] + rates[limb][1], xi[5] + rates[limb][2]};
        lane whole[6];
        limb_wrench(l, axes[limb], joint, spun, whole);
        if (power) *power += DOT(whole + 3, rates[limb]);
        /* Turning axis and rate of a limb turns its wrench and the motion it sees; only the base's motion stays.
         * That gives the derivative without differentiating P. */
        for (int axis = 0; change && axis < 3; axis++) {
            lane velocity[3], rate[3], force[3], torque[3], *out = change[3 * limb + axis];
            unit_cross(axis, joint, velocity);
            unit_cross(axis, xi + 3, rate);
            limb_wrench(l, axes[limb], velocity, rate, out);
            unit_cross(axis, whole, force);
            unit_cross(axis, whole + 3, torque);
            for (int i = 0; i < 3; i++) {
                out[i] -= force[i];
                out[3 + i] -= torque[i];
            }
            to_base(s, l, out);
            solve(p, out);
        }
        for (int axis = 0; per_rate && axis < 3; axis++) {
            lane rate[3], *out = per_rate[3 * limb + axis];
            unit(axis, rate);
            limb_wrench(l, axes[limb], rest, rate, out);
            to_base(s, l, out);
            for (int i = 0; i < 6; i++) out[i] = -out[i];
            solve(p, out);
        }
    }
}

/* The same of links that feel each other. */
static void together(lane rates[2][3], const lane given[GIVEN], lane xi[6], lane change[6][6], lane per_rate[6][6],
                     lane *power) {
    lane p[6][6];
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) p[i][j] = given[entry(i, j)];
        xi[i] = -given[21 + i];
    }
    factor(p);
    solve(p, xi);
    for (int k = 0; per_rate && k < 6; k++) {
        for (int i = 0; i < 6; i++) per_rate[k][i] = -given[COUPLINGS + 6 * k + i];
        solve(p, per_rate[k]);
    }
    for (int c = 0; change && c < 6; c++) {
        const lane *changed = given + PULL * (1 + c);
        for (int i = 0; i < 6; i++) {
            lane sum = changed[21 + i];
            for (int j = 0; j < 6; j++) sum += changed[i < j ? entry(j, i) : entry(i, j)] * xi[j];
            change[c][i] = -sum;
        }
        solve(p, change[c]);
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
        alone(s, axes, rates, xi, change, per_rate, power);
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

#define FARTHEST 1.0 /* distances count up to here [rad]: A(r) varies with the bends themselves */

/* The spread of the links about the line that fits them best resists roll about that line; spin drag does where there
 * is no spread. */
double purcell_distance(const struct swimmer *s, double axes[2][3]) {
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
