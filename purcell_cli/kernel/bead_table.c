/* The table of the resistance of links that feel each other, over the limbs' bends and the angle between their planes. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define PI 3.14159265358979323846

/* T_0 ... T_(n-1) of x, and their derivatives times `inner`. */
static void chebyshev(double x, double inner, int n, double *out, double *slope) {
    out[0] = 1.0;
    out[1] = x;
    slope[0] = 0.0;
    slope[1] = inner;
    for (int k = 2; k < n; k++) {
        out[k] = 2.0 * x * out[k - 1] - out[k - 2];
        slope[k] = 2.0 * (inner * out[k - 1] + x * slope[k - 1]) - slope[k - 2];
    }
}

/* Cosines and sines of an angle's multiples. */
static void multiples(double cosine, double sine, int n, double *cosines, double *sines) {
    cosines[0] = 1.0;
    sines[0] = 0.0;
    for (int k = 1; k < n; k++) {
        cosines[k] = cosines[k - 1] * cosine - sines[k - 1] * sine;
        sines[k] = sines[k - 1] * cosine + cosines[k - 1] * sine;
    }
}

/* How a motion's component behaves when the plane of limb 1 is mirrored: v_z, omega_x, omega_y and the like change. */
static const int MIRRORED[COLUMNS] = {0, 0, 1, 1, 1, 0, 1, 1, 0, 1, 1, 0};

/* The bend of an axis, as far as the table reaches, and the direction aside: cosine and sine about the base's axis, of any
 * angle where straight. */
static double bend_of(const struct swimmer *s, const double a[3], double *cosine, double *sine) {
    const double aside = sqrt(a[1] * a[1] + a[2] * a[2]);
    *cosine = aside > 0.0 ? a[1] / aside : 1.0;
    *sine = aside > 0.0 ? a[2] / aside : 0.0;
    const double bend = purcell_arctan2_of(aside, a[0]);
    return bend < s->reach ? bend : s->reach;
}

/* A part of the table's sum over one limb's bend, for all the rest: with the polynomials, and with their slopes. Chebyshev
 * series converge fast, so that most coefficients of high degree in all three are rounding: they are left out. */
static void fix(const struct swimmer *s, int limb, double bend, struct known *out) {
    const int n = (int)s->bends, m = (int)s->multiples, rest = m * RESISTANCE;
    const SIZE stride = limb ? rest : (SIZE)n * rest, row = limb ? (SIZE)n * rest : rest;
    const double *counts = s->table + (2 * out->exact + limb) * n * m, *coefficients = s->table + 4 * n * m;
    double weight[MOST_BENDS], slope[MOST_BENDS];
    if (out->limb == limb && out->bend == bend) return;
    chebyshev(2.0 * bend / s->reach - 1.0, 2.0 / s->reach, n, weight, slope);
    out->limb = limb;
    out->bend = bend;
    out->used = 1;
    for (int c = 0; c < m; c++) out->many[c] = 0;
    for (int b = 0; b < n; b++)
        for (int c = 0; c < m; c++) {
            const int count = (int)counts[b * m + c];
            const double *table = coefficients + b * row + c * RESISTANCE;
            double *const sum = out->sums[0] + b * rest + c * RESISTANCE;
            double *const sloped = out->sums[1] + b * rest + c * RESISTANCE;
            for (int e = 0; e < out->entries; e++) sum[e] = 0.0;
            for (int e = 0; out->slopes && e < out->entries; e++) sloped[e] = 0.0;
            if (count) out->many[c] = b + 1;
            if (count && c >= out->used) out->used = c + 1;
            for (int a = 0; a < count; a++)
                for (int e = 0; e < out->entries; e++) sum[e] += weight[a] * table[a * stride + e];
            for (int a = 1; out->slopes && a < count; a++) /* T_0 has none */
                for (int e = 0; e < out->entries; e++) sloped[e] += slope[a] * table[a * stride + e];
        }
}

/* The sum over the other limb's bend. */
static void contracted(const struct known *known, int slopes, const double *weight, int m, double *out) {
    for (int c = 0; c < known->used; c++) {
        const double *from = known->sums[slopes] + c * RESISTANCE;
        double *const to = out + c * RESISTANCE;
        for (int e = 0; e < known->entries; e++) to[e] = 0.0;
        for (int b = 0; b < known->many[c]; b++)
            for (int e = 0; e < known->entries; e++) to[e] += weight[b] * from[b * m * RESISTANCE + e];
    }
}

/* The series in the angle between the planes, as a full matrix: even entries by `even`, those that a mirror changes by
 * `odd`. */
static void summed(const double *all, const double *even, const double *odd, int m, int entries,
                   double out[COLUMNS][COLUMNS]) {
    double plain[RESISTANCE], mirrored[RESISTANCE];
    for (int e = 0; e < entries; e++) plain[e] = even[0] * all[e];
    for (int e = 0; e < entries; e++) mirrored[e] = odd[0] * all[e];
    for (int c = 1; c < m; c++) {
        for (int e = 0; e < entries; e++) plain[e] += even[c] * all[c * RESISTANCE + e];
        for (int e = 0; e < entries; e++) mirrored[e] += odd[c] * all[c * RESISTANCE + e];
    }
    for (int i = 0; i < COLUMNS; i++)
        for (int j = 0; j <= i; j++) {
            const int e = entry(i, j);
            out[i][j] = out[j][i] = e >= entries ? 0.0 : MIRRORED[i] != MIRRORED[j] ? mirrored[e] : plain[e];
        }
}

/* All four vectors turned about x, as the lower half. */
static void turned_about_x(double full[COLUMNS][COLUMNS], double c, double d, double *out) {
    double turned[COLUMNS][COLUMNS];
    for (int i = 0; i < COLUMNS; i += 3)
        for (int j = 0; j < COLUMNS; j++) {
            turned[i][j] = full[i][j];
            turned[i + 1][j] = c * full[i + 1][j] - d * full[i + 2][j];
            turned[i + 2][j] = d * full[i + 1][j] + c * full[i + 2][j];
        }
    for (int i = 0; i < COLUMNS; i++)
        for (int j = 0; j <= i; j++) {
            const int axis = j % 3, first = j - axis;
            out[entry(i, j)] = axis == 0   ? turned[i][j]
                     : axis == 1 ? c * turned[i][first + 1] - d * turned[i][first + 2]
                                 : d * turned[i][first + 1] + c * turned[i][first + 2];
        }
}

/* How that changes with the angle, from no turn on. */
static void turning_about_x(double full[COLUMNS][COLUMNS], double out[COLUMNS][COLUMNS]) {
    for (int i = 0; i < COLUMNS; i++)
        for (int j = 0; j < COLUMNS; j++) {
            const int r = i % 3, c = j % 3;
            double sum = r == 1 ? -full[i + 1][j] : r == 2 ? full[i - 1][j] : 0.0;
            out[i][j] = sum + (c == 1 ? -full[i][j + 1] : c == 2 ? full[i][j - 1] : 0.0);
        }
}

#define STRAIGHT 1e-4 /* below this bend [rad] a quotient by its sine is taken as a derivative by the bend */

/* The resistance at a shape, and, where `known` has slopes, how it changes when limb i is turned about axis j of the
 * base, at [3 i + j] of `change`. */
static void looked_up(const struct swimmer *s, double axes[2][3], const struct known *known, double *out,
                      double (*change)[RESISTANCE]) {
    const int n = (int)s->bends, m = (int)s->multiples, used = known->used, entries = known->entries;
    const int other = 1 - known->limb;
    double cosine[2], sine[2], bend[2], weight[MOST_BENDS], slope[MOST_BENDS];
    double even[MOST_MULTIPLES], odd[MOST_MULTIPLES], even_slope[MOST_MULTIPLES], odd_slope[MOST_MULTIPLES];
    double all[MOST_MULTIPLES * RESISTANCE], by_bend[2][MOST_MULTIPLES * RESISTANCE];
    double full[COLUMNS][COLUMNS], parts[2][3][COLUMNS][COLUMNS];
    for (int limb = 0; limb < 2; limb++) bend[limb] = bend_of(s, axes[limb], cosine + limb, sine + limb);
    const double turn = cosine[0] * cosine[1] + sine[0] * sine[1], aside = cosine[0] * sine[1] - sine[0] * cosine[1];
    chebyshev(2.0 * bend[other] / s->reach - 1.0, 2.0 / s->reach, n, weight, slope);
    multiples(turn, aside, used, even, odd);
    contracted(known, 0, weight, m, all);
    summed(all, even, odd, used, entries, full);
    turned_about_x(full, cosine[0], sine[0], out); /* back from the frame in which limb 1 is bent along y */
    if (!known->slopes) return;
    double by_angle[COLUMNS][COLUMNS], whole[COLUMNS][COLUMNS], bent[2][COLUMNS][COLUMNS], quotient[2];
    double sharp[2][COLUMNS][COLUMNS];
    for (int c = 0; c < used; c++) {
        even_slope[c] = -c * odd[c];
        odd_slope[c] = c * even[c];
    }
    contracted(known, 1, weight, m, by_bend[known->limb]);
    contracted(known, 0, slope, m, by_bend[other]);
    summed(all, even_slope, odd_slope, used, entries, by_angle);
    turning_about_x(full, whole);
    for (int limb = 0; limb < 2; limb++) {
        double mixed[COLUMNS][COLUMNS], spun[COLUMNS][COLUMNS], aside_of, along_of;
        summed(by_bend[limb], even, odd, used, entries, bent[limb]);
        purcell_sin_cos_of(bend[limb], &aside_of, &along_of);
        quotient[limb] = bend[limb] < STRAIGHT ? 1.0 : along_of / aside_of;
        if (bend[limb] >= STRAIGHT) continue;
        summed(by_bend[limb], even_slope, odd_slope, used, entries, mixed);
        turning_about_x(bent[limb], spun);
        for (int i = 0; i < COLUMNS; i++)
            for (int j = 0; j < COLUMNS; j++) sharp[limb][i][j] = limb ? mixed[i][j] : spun[i][j] - mixed[i][j];
    }
    /* About the axes of that frame: turning limb 1 about x turns the frame and leaves limb 2 behind. */
    for (int i = 0; i < COLUMNS; i++)
        for (int j = 0; j < COLUMNS; j++) {
            const double first = whole[i][j] - by_angle[i][j], second = by_angle[i][j];
            const double one = quotient[0] * (bend[0] < STRAIGHT ? sharp[0][i][j] : first);
            const double two = quotient[1] * (bend[1] < STRAIGHT ? sharp[1][i][j] : second);
            parts[0][0][i][j] = first;
            parts[0][1][i][j] = -one;
            parts[0][2][i][j] = bent[0][i][j];
            parts[1][0][i][j] = second;
            parts[1][1][i][j] = -aside * bent[1][i][j] - turn * two;
            parts[1][2][i][j] = turn * bent[1][i][j] - aside * two;
        }
    for (int limb = 0; limb < 2; limb++) {
        for (int i = 0; i < COLUMNS; i++)
            for (int j = 0; j < COLUMNS; j++) {
                const double y = parts[limb][1][i][j], z = parts[limb][2][i][j];
                parts[limb][1][i][j] = cosine[0] * y - sine[0] * z;
                parts[limb][2][i][j] = sine[0] * y + cosine[0] * z;
            }
        for (int axis = 0; axis < 3; axis++)
            turned_about_x(parts[limb][axis], cosine[0], sine[0], change[3 * limb + axis]);
    }
}

void purcell_fill_field(const struct swimmer *s, double begun[2][3], double rates[2][3], double start, double length,
                        int nodes, struct known *known, struct field *out) {
    double middle[3], cosine, sine;
    const int still = DOT(rates[0], rates[0]) == 0.0 ? 0 : DOT(rates[1], rates[1]) == 0.0 ? 1 : -1;
    if (out->count != nodes) {
        for (int k = 0; k < nodes; k++)
            purcell_sin_cos_of(PI * (k + 0.5) / nodes, out->sines + k, out->nodes + k);
        if (still >= 0) fix(s, still, bend_of(s, begun[still], &cosine, &sine), known);
    }
    out->count = nodes;
    out->entries = known->entries;
    out->start = start;
    out->length = length;
    for (int k = 0; k < nodes; k++) {
        double axes[2][3];
        for (int limb = 0; limb < 2; limb++) {
            for (int i = 0; i < 3; i++) middle[i] = rates[limb][i] * (start + 0.5 * length * (1.0 + out->nodes[k]));
            purcell_rotate(middle, begun[limb], axes[limb]);
        }
        if (still < 0) fix(s, 0, bend_of(s, axes[0], &cosine, &sine), known);
        looked_up(s, axes, known, out->values[k][0], out->values[k] + 1);
    }
}

/* The barycentric formula with Chebyshev's nodes of the first kind (Berrut and Trefethen 2004, SIAM Review 46). */
void purcell_of_field(const struct field *f, lane time, int count, lane (*out)[RESISTANCE]) {
    const lane part = 2.0 * (time - f->start) / f->length - 1.0;
    lane weight[PANEL_NODES], total = {0.0, 0.0};
    int exact[LANES] = {-1, -1};
    for (int k = 0; k < f->count; k++) {
        const double sine = k % 2 ? -f->sines[k] : f->sines[k];
        for (int l = 0; l < LANES; l++) {
            const double gap = part[l] - f->nodes[k];
            if (gap == 0.0) exact[l] = k;
            weight[k][l] = sine / (gap == 0.0 ? 1.0 : gap);
        }
        total += weight[k];
    }
    for (int l = 0; l < LANES; l++)
        if (exact[l] >= 0) {
            for (int k = 0; k < f->count; k++) weight[k][l] = k == exact[l] ? 1.0 : 0.0;
            total[l] = 1.0;
        }
    for (int k = 0; k < f->count; k++) weight[k] /= total;
    for (int c = 0; c < count; c++) {
        for (int e = 0; e < f->entries; e++) out[c][e] = weight[0] * f->values[0][c][e];
        for (int k = 1; k < f->count; k++)
            for (int e = 0; e < f->entries; e++) out[c][e] += weight[k] * f->values[k][c][e];
    }
}

void purcell_at_shape(const struct swimmer *s, double axes[2][3], int changes, double (*out)[RESISTANCE]) {
    struct known known;
    double cosine, sine;
    known.limb = -1;
    known.exact = 1;
    known.slopes = changes;
    known.entries = RESISTANCE;
    fix(s, 0, bend_of(s, axes[0], &cosine, &sine), &known);
    looked_up(s, axes, &known, out[0], out + 1);
}

/* The table's resistances at n shapes, and how they change. (n, 2, 3) to (n, 7, 78). */
API void purcell_looked_up(const double *numbers, SIZE n, const double *axes, double *out) {
    for (SIZE k = 0; k < n; k++) {
        double a[2][3];
        for (int i = 0; i < 6; i++) a[i / 3][i % 3] = axes[6 * k + i];
        purcell_at_shape((const struct swimmer *)numbers, a, 1, (double (*)[RESISTANCE])(out + 7 * RESISTANCE * k));
    }
}
