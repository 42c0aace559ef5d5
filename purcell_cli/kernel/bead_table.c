/* The table of the resistance of links that feel each other, over the limbs' bends and the angle between their planes.
 *
 * Seen from limb 1's plane an entry is the sum over multiples c of that angle of cos(c angle) or, where the mirror of the
 * plane changes it, sin(c angle) times x_1^(c + p) x_2^c G(2 x_1^2 - 1, 2 x_2^2 - 1), with x a bend as a part of the reach
 * and only the parity of the exponents: p is odd where half a turn about x changes the entry. That is how an entry behaves
 * where a limb is bent through straight to the other side. The table has Chebyshev's coefficients of G. */
#include <math.h>

#include "kernel.h"

/* How many entries of a row are summed: windows begin with P and the couplings of the limb that is not summed over, then
 * come the other's couplings, and what only the power needs. They end with blocks, which may reach into what is not needed. */
static const int ENTRIES_OF[] = {40, 64, WIDTH};

/* Which entry of the resistance a row has, of the sums over limb 1's bend and over limb 2's; in each part first those that
 * the mirror of limb 1's plane leaves alone, then those that it changes. NOTHING fills up a block. */
#define NOTHING RESISTANCE
static const int ENTRIES[2][WIDTH] = {
    {0,  1,  2,  5,  8,  9,  12, 13, 14, 15, 16, 20, 41, 42, 43, 47, 48, 49, 51, 52, 56, 3,  4,  6,  7,  10, 11,
     17, 18, 19, 39, 40, 44, 45, 46, 50, 53, 54, 55, NOTHING, 23, 24, 25, 29, 30, 31, 33, 34, 38, 21, 22, 26, 27, 28,
     32, 35, 36, 37, 57, 58, 59, 62, 63, 64, 66, 67, 68, 70, 71, 74, 77, 60, 61, 65, 69, 72, 73, 75, 76, NOTHING},
    {0,  1,  2,  5,  8,  9,  12, 13, 14, 15, 16, 20, 23, 24, 25, 29, 30, 31, 33, 34, 38, 3,  4,  6,  7,  10, 11,
     17, 18, 19, 21, 22, 26, 27, 28, 32, 35, 36, 37, NOTHING, 41, 42, 43, 47, 48, 49, 51, 52, 56, 39, 40, 44, 45, 46,
     50, 53, 54, 55, 57, 58, 59, 62, 63, 64, 66, 67, 68, 70, 71, 74, 77, 60, 61, 65, 69, 72, 73, 75, 76, NOTHING},
};
/* Whether half a turn about x changes an entry's sign, and whether the mirror does. */
static const int FLIPPED[WIDTH] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 0, 1, 0, 0, 1, 1, 0,
                                   0, 1, 0, 0, 1, 1, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 1, 1, 0,
                                   0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 0};
const int purcell_mirrored[WIDTH] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1,
                                     1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1,
                                     1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1};

/* T_0 ... T_(n-1) of y, and their derivatives by y. */
static void chebyshev(double y, int n, double *out, double *slope) {
    out[0] = 1.0;
    out[1] = y;
    slope[0] = 0.0;
    slope[1] = 1.0;
    for (int k = 2; k < n; k++) {
        out[k] = 2.0 * y * out[k - 1] - out[k - 2];
        slope[k] = 2.0 * (out[k - 1] + y * slope[k - 1]) - slope[k - 2];
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

/* The bend of an axis, as far as the table reaches, and the direction aside: cosine and sine about the base's axis, of any
 * angle where straight. */
static double bend_of(const struct bead_table *table, const double a[3], double *cosine, double *sine) {
    const double aside = sqrt(a[1] * a[1] + a[2] * a[2]);
    *cosine = aside > 0.0 ? a[1] / aside : 1.0;
    *sine = aside > 0.0 ? a[2] / aside : 0.0;
    const double bend = purcell_arctan2_of(aside, a[0]);
    return bend < table->reach ? bend : table->reach;
}

static double of_bend(const struct bead_table *table, double bend) {
    const double x = bend / table->reach;
    return 2.0 * x * x - 1.0;
}

const struct bead_table *purcell_table_for(const struct swimmer *s, int shapes, double (*axes)[2][3]) {
    const struct bead_table *table = (const struct bead_table *)s->numbers;
    double least = 1.0;
    for (int k = 0; k < shapes; k++)
        for (int limb = 0; limb < 2; limb++) least = axes[k][limb][0] < least ? axes[k][limb][0] : least;
    for (int k = 1; k < (int)s->tables && least < table->least; k++) {
        const SIZE n = (SIZE)table->bends, m = (SIZE)table->multiples;
        table = (const struct bead_table *)(table->numbers + n * m * (4 + 2 * n * WIDTH));
    }
    return table;
}

/* A part of the table's sum over one limb's bend, for all the rest: with the polynomials, and with their slopes. Chebyshev
 * series converge fast, so that most coefficients of high degree in all three are rounding: they are left out. */
void purcell_fix(int limb, const double axis[3], struct known *out) {
    const struct bead_table *table = out->table;
    const int n = (int)table->bends, m = (int)table->multiples, entries = ENTRIES_OF[out->window];
    const double *counts = table->numbers + (2 * out->exact + limb) * n * m;
    const double *coefficients = table->numbers + n * m * (4 + (SIZE)limb * n * WIDTH);
    double weight[MOST_BENDS], slope[MOST_BENDS], cosine, sine;
    const double bend = bend_of(table, axis, &cosine, &sine);
    if (out->limb == limb && out->bend == bend && out->fixed == out->window && out->of == table) return;
    chebyshev(of_bend(table, bend), n, weight, slope);
    out->limb = limb;
    out->bend = bend;
    out->fixed = out->window;
    out->of = table;
    out->used = 1;
    out->entries = entries;
    double *sum = out->sums;
    for (int c = 0; c < m; c++) {
        out->many[c] = 0;
        for (int b = 0; b < n; b++)
            if (counts[c * n + b] > 0.0) out->many[c] = b + 1;
        if (out->many[c]) out->used = c + 1;
        for (int b = 0; b < out->many[c]; b++) {
            double *const sloped = out->slopes ? sum + entries : 0;
            purcell_table_rows(coefficients + (SIZE)(c * n + b) * n * WIDTH, (int)counts[c * n + b], entries, weight, slope,
                               sum, sloped);
            sum += out->slopes ? 2 * entries : entries;
        }
    }
}

/* P's lower half, and of a motion with constant rates what they add to the base's wrench; or how both change. */
struct pull {
    double p[21], q[6];
};

/* The couplings' wrench on the base for a rate of a limb. */
static void wrench(const double *resistance, int limb, const double rate[3], double out[6]) {
    const double *q = resistance + 21 + 18 * limb;
    for (int i = 0; i < 6; i++) out[i] = q[i] * rate[0] + q[6 + i] * rate[1] + q[12 + i] * rate[2];
}

static void pull_of(const double *resistance, double rates[2][3], const int moving[2], struct pull *out) {
    for (int i = 0; i < 21; i++) out->p[i] = resistance[i];
    for (int i = 0; i < 6; i++) out->q[i] = 0.0;
    for (int limb = 0; limb < 2; limb++) {
        double by[6];
        if (!moving[limb]) continue;
        wrench(resistance, limb, rates[limb], by);
        for (int i = 0; i < 6; i++) out->q[i] += by[i];
    }
}

/* A symmetric block of P turned about x, of which a is the first entry and rows have so many entries more each. */
static void turned_block(const double *p, int first, int row, double c, double s, double *out) {
    const int a = first, b = a + row, d = b + 1, e = b + row + 1, f = e + 1, g = f + 1;
    const double cs = c * s, cc = c * c, ss = s * s, twice = 2.0 * cs * p[f];
    out[a] = p[a];
    out[b] = c * p[b] - s * p[e];
    out[e] = s * p[b] + c * p[e];
    out[d] = cc * p[d] - twice + ss * p[g];
    out[g] = ss * p[d] + twice + cc * p[g];
    out[f] = cs * (p[d] - p[g]) + (cc - ss) * p[f];
}

/* A block of three by three turned about x; rows have so many entries. */
static void turned_square(const double *in, int row, double c, double s, double *out) {
    double rows[3][3];
    for (int j = 0; j < 3; j++) {
        rows[0][j] = in[j];
        rows[1][j] = c * in[row + j] - s * in[2 * row + j];
        rows[2][j] = s * in[row + j] + c * in[2 * row + j];
    }
    for (int i = 0; i < 3; i++) {
        out[i * row] = rows[i][0];
        out[i * row + 1] = c * rows[i][1] - s * rows[i][2];
        out[i * row + 2] = s * rows[i][1] + c * rows[i][2];
    }
}

/* Everything turned about x. */
static void turned_about_x(const struct pull *in, double c, double s, struct pull *out) {
    turned_block(in->p, 0, 1, c, s, out->p);
    turned_block(in->p, 9, 4, c, s, out->p);
    const double square[9] = {in->p[6], in->p[7], in->p[8], in->p[10], in->p[11], in->p[12], in->p[15], in->p[16], in->p[17]};
    double turned[9];
    turned_square(square, 3, c, s, turned);
    for (int i = 0; i < 9; i++) out->p[entry(3 + i / 3, i % 3)] = turned[i];
    for (int k = 0; k < 6; k += 3) {
        out->q[k] = in->q[k];
        out->q[k + 1] = c * in->q[k + 1] - s * in->q[k + 2];
        out->q[k + 2] = s * in->q[k + 1] + c * in->q[k + 2];
    }
}

/* How that changes with the angle, from no turn on; `turning` is the couplings' wrench for rates e_x x u. */
static void turning_about_x(const struct pull *in, const double turning[6], struct pull *out) {
    double full[6][6];
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) full[i][j] = full[j][i] = in->p[entry(i, j)];
    for (int i = 0; i < 6; i++) {
        const int r = i % 3;
        for (int j = 0; j <= i; j++) {
            const int c = j % 3;
            const double sum = r == 1 ? -full[i + 1][j] : r == 2 ? full[i - 1][j] : 0.0;
            out->p[entry(i, j)] = sum + (c == 1 ? -full[i][j + 1] : c == 2 ? full[i][j - 1] : 0.0);
        }
        out->q[i] = (r == 1 ? -in->q[i + 1] : r == 2 ? in->q[i - 1] : 0.0) - turning[i];
    }
}

#define STRAIGHT 1e-4 /* below this bend [rad] a quotient by its sine is taken as a derivative by the bend */

/* a x + b y, of all numbers. */
static void mixed(const struct pull *x, double a, const struct pull *y, double b, struct pull *out) {
    for (int i = 0; i < 21; i++) out->p[i] = a * x->p[i] + b * y->p[i];
    for (int i = 0; i < 6; i++) out->q[i] = a * x->q[i] + b * y->q[i];
}

/* The resistance from series: weights of the even and odd one by whether half a turn about x changes an entry. */
static void assembled(const struct series *series, const double even[2], const double odd[2], const struct known *known,
                      int more, double out[RESISTANCE + 1]) {
    for (int k = 0; k < known->entries; k++) {
        const int flipped = FLIPPED[k], at = ENTRIES[known->limb][k];
        const double sum = even[flipped] * series->even[k] + odd[flipped] * series->odd[k];
        out[at] = more ? out[at] + sum : sum;
    }
}

/* The couplings turned about x, and what the power needs besides. */
static void coupled(const double resistance[RESISTANCE], double c, double s, int power, double out[GIVEN]) {
    double square[36], turned[36];
    for (int i = 0; i < 36; i += 18)
        for (int j = 0; j < 6; j += 3) turned_square(resistance + 21 + i + j, 6, c, s, out + COUPLINGS + i + j);
    if (!power) return;
    const double *u = resistance + WITHOUT_POWER;
    for (int i = 0; i < 36; i++) square[i] = i / 6 < i % 6 ? u[entry(i % 6, i / 6)] : u[entry(i / 6, i % 6)];
    for (int i = 0; i < 36; i += 18)
        for (int j = 0; j < 6; j += 3) turned_square(square + i + j, 6, c, s, turned + i + j);
    for (int i = 0; i < 36; i++)
        if (i % 6 <= i / 6) out[POWERS + entry(i / 6, i % 6)] = turned[i];
}

/* The resistance at a shape, and, where `known` has slopes, how it changes when a limb is turned; see `purcell_at_shape`. */
void purcell_look_up(double axes[2][3], double rates[2][3], const struct known *known, double out[GIVEN]) {
    const struct bead_table *table = known->table;
    const int n = (int)table->bends, used = known->used, other = 1 - known->limb, entries = known->entries;
    const int moving[2] = {known->window != MOTION || other == 0, known->window != MOTION || other == 1};
    double cosine[2], sine[2], bend[2], x[2], weight[MOST_BENDS], slope[MOST_BENDS];
    double even[MOST_MULTIPLES], odd[MOST_MULTIPLES], even_slope[MOST_MULTIPLES], odd_slope[MOST_MULTIPLES];
    double whole[RESISTANCE + 1], seen[2][3];
    struct contracted all;
    struct series series, by_angle, by_bend[2];
    struct pull *const pulls = (struct pull *)out, now;
    for (int limb = 0; limb < 2; limb++) {
        bend[limb] = bend_of(table, axes[limb], cosine + limb, sine + limb);
        x[limb] = bend[limb] / table->reach;
    }
    /* Seen from the frame in which limb 1 is bent along y. */
    const double c = cosine[0], d = sine[0], turn = c * cosine[1] + d * sine[1], aside = c * sine[1] - d * cosine[1];
    for (int limb = 0; limb < 2; limb++) {
        seen[limb][0] = rates[limb][0];
        seen[limb][1] = c * rates[limb][1] + d * rates[limb][2];
        seen[limb][2] = c * rates[limb][2] - d * rates[limb][1];
    }
    chebyshev(of_bend(table, bend[other]), n, weight, slope);
    multiples(turn, aside, used, even, odd);
    purcell_contract(known, weight, slope, &all);
    purcell_angle_series(all.value, used, entries, even, odd, &series);
    const double as_even[2] = {1.0, x[0]}, as_odd[2] = {x[0] * x[1], x[1]};
    assembled(&series, as_even, as_odd, known, 0, whole);
    pull_of(whole, seen, moving, &now);
    for (int i = 0; i < GIVEN; i++) out[i] = 0.0;
    turned_about_x(&now, c, d, pulls);
    if (known->couplings) coupled(whole, c, d, known->window == WITH_POWER, out);
    if (!known->slopes) return;
    for (int k = 0; k < used; k++) {
        even_slope[k] = -k * odd[k];
        odd_slope[k] = k * even[k];
    }
    purcell_angle_series(all.value, used, entries, even_slope, odd_slope, &by_angle);
    purcell_angle_series(all.other, used, entries, even, odd, &by_bend[other]);
    purcell_angle_series(all.known, used, entries, even, odd, &by_bend[known->limb]);
    /* The couplings' wrenches for the rates turned about x, y and z with their limb. */
    double turning[2][3][6], about_x[6];
    for (int limb = 0; limb < 2; limb++)
        for (int axis = 0; axis < 3; axis++) {
            double turned[3] = {0.0, 0.0, 0.0};
            const int j = (axis + 1) % 3, k = (axis + 2) % 3;
            turned[j] = -seen[limb][k];
            turned[k] = seen[limb][j];
            for (int i = 0; i < 6; i++) turning[limb][axis][i] = 0.0;
            if (moving[limb]) wrench(whole, limb, turned, turning[limb][axis]);
        }
    for (int i = 0; i < 6; i++) about_x[i] = turning[0][0][i] + turning[1][0][i];
    double sloped[RESISTANCE + 1], crossed[RESISTANCE + 1];
    struct pull angle, spun, bent[2], other_side[2], both;
    const double per = 1.0 / table->reach;
    assembled(&by_angle, as_even, as_odd, known, 0, sloped);
    pull_of(sloped, seen, moving, &angle);
    turning_about_x(&now, about_x, &spun);
    for (int limb = 0; limb < 2; limb++) {
        /* By the bend: of the powers of x that stand before the polynomials, and of these. */
        const double power_even[2] = {0.0, limb ? 0.0 : per}, power_odd[2] = {per * x[1 - limb], limb ? per : 0.0};
        const double steep = 4.0 * x[limb] * per;
        const double own_even[2] = {steep, steep * x[0]}, own_odd[2] = {steep * as_odd[0], steep * x[1]};
        assembled(&series, power_even, power_odd, known, 0, sloped);
        assembled(&by_bend[limb], own_even, own_odd, known, 1, sloped);
        pull_of(sloped, seen, moving, &bent[limb]);
        /* About the other axis aside: turning limb 1 about x turns the frame and leaves limb 2 behind. */
        if (bend[limb] >= STRAIGHT) {
            double along, aside_of;
            purcell_sin_cos_of(bend[limb], &aside_of, &along);
            const double quotient = along / aside_of;
            mixed(limb ? &angle : &spun, quotient, &angle, limb ? 0.0 : -quotient, &other_side[limb]);
            continue;
        }
        assembled(&by_angle, power_even, power_odd, known, 0, crossed);
        pull_of(crossed, seen, moving, &both);
        if (limb) {
            other_side[1] = both;
            continue;
        }
        for (int i = 0; i < 6; i++) about_x[i] = 0.0;
        for (int l = 0; l < 2; l++) {
            const double turned[3] = {0.0, -seen[l][2], seen[l][1]};
            double by[6];
            if (!moving[l]) continue;
            wrench(sloped, l, turned, by);
            for (int i = 0; i < 6; i++) about_x[i] += by[i];
        }
        turning_about_x(&bent[0], about_x, &other_side[0]);
        mixed(&other_side[0], 1.0, &both, -1.0, &other_side[0]);
    }
    for (int limb = 0; limb < 2; limb++) {
        struct pull part[3], turned[2];
        if (limb) {
            part[0] = angle;
            mixed(&bent[1], -aside, &other_side[1], -turn, &part[1]);
            mixed(&bent[1], turn, &other_side[1], -aside, &part[2]);
        } else {
            mixed(&spun, 1.0, &angle, -1.0, &part[0]);
            mixed(&other_side[0], -1.0, &other_side[0], 0.0, &part[1]);
            part[2] = bent[0];
        }
        for (int axis = 0; axis < 3; axis++)
            for (int i = 0; i < 6; i++) part[axis].q[i] += turning[limb][axis][i];
        mixed(&part[1], c, &part[2], -d, &turned[0]);
        mixed(&part[1], d, &part[2], c, &turned[1]);
        turned_about_x(&part[0], c, d, pulls + 1 + 3 * limb);
        turned_about_x(&turned[0], c, d, pulls + 2 + 3 * limb);
        turned_about_x(&turned[1], c, d, pulls + 3 + 3 * limb);
    }
}
