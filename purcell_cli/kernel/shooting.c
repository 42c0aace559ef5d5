/* The equations of an exact arrival, the bend limit as inequalities, and the least steps under both. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define AXIS_OF(control) ((int)((control) < BASE_YAW ? (control) % 3 : 2))
#define FULL_TURN 6.283185307179586

/* The axis that a primitive turns its limb about, where it begins. */
void purcell_turning_axis(SIZE control, const double *shape, double out[3]) {
    const double *limb = shape + 9 * LIMB_OF(control);
    for (int i = 0; i < 3; i++) out[i] = control < BASE_YAW ? limb[3 * i + AXIS_OF(control)] : i == 2;
}

/* Whether a limb turns about the base's z on any of n primitives: its pitches then turn it about its own y later. */
void purcell_turns_about_base(SIZE n, const SIZE *control, int out[2]) {
    out[0] = out[1] = 0;
    for (SIZE p = 0; p < n; p++)
        if (control[p] >= BASE_YAW) out[LIMB_OF(control[p])] = 1;
}

/* The rotation vectors from a wanted shape to a found one, in base coordinates, for each limb. */
void purcell_gap_between(const double *found, const double *wanted, double out[6]) {
    for (int limb = 0; limb < 2; limb++, found += 9, wanted += 9) {
        double turned[9], q[4];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) turned[3 * i + j] = DOT(found + 3 * i, wanted + 3 * j);
        purcell_quaternions(1, turned, q);
        const double sine = sqrt(DOT(q + 1, q + 1));
        const double stretch = sine > 1e-150 ? 2.0 * purcell_arctan2_of(sine, q[0]) / sine : 2.0;
        for (int i = 0; i < 3; i++) out[3 * limb + i] = stretch * q[1 + i];
    }
}

/* What is missing of a displacement and of shapes where phases end, and its derivative by the angles of n primitives.
 *
 * start: (2, 3, 3). control, angle: (n,). repeats: see `purcell_flow_and_derivatives`, (k, 3). wanted: the inverse of
 * the displacement, (4, 4). stops, ends: before which primitives shapes are wanted, and those, (t,) and (t, 2, 3, 3).
 * room: to work in, (n, 94) and (k, 36). shapes: (n + 1, 2, 3, 3). residual: (6 + 6 t,). derivative: (6 + 6 t, n),
 * or null where none is wanted. Returns 0, or the number of a piece that is too long, counted from 1. */
API SIZE purcell_equations(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                           const double *to_node, double step, double settled, SIZE n, const double *start,
                           const SIZE *control, const double *angle, SIZE k, const SIZE *repeats, const double *wanted,
                           SIZE t, const SIZE *stops, const double *ends, double *room, double *shapes,
                           double *residual, double *derivative) {
    double pose[16], off[16];
    purcell_shapes(n, start, control, angle, shapes);
    const SIZE long_piece = purcell_flow_and_derivatives(swimmer, stages, nodes, weights, to_node, step, settled, n,
                                                         shapes, control, angle, k, repeats, room, pose, derivative);
    if (long_piece) return long_piece;
    product(wanted, pose, off, 4, 4, 4);
    purcell_orthonormalise(1, 4, off);
    purcell_log(1, off, residual);
    for (SIZE e = 0; e < t; e++, ends += 18) {
        const double *end = shapes + 18 * stops[e];
        int universal[2];
        purcell_turns_about_base(stops[e], control, universal);
        purcell_gap_between(end, ends, residual + 6 * (e + 1));
        if (!derivative) continue;
        double *rows = derivative + 6 * (e + 1) * n;
        for (SIZE i = 0; i < 6 * n; i++) rows[i] = 0.0;
        for (SIZE p = 0; p < stops[e]; p++) {
            const int limb = LIMB_OF(control[p]);
            double axis[3];
            purcell_turning_axis(control[p], shapes + 18 * p, axis);
            for (int i = 0; i < 3; i++)
                rows[(3 * limb + i) * n + p] =
                    universal[limb] && control[p] < BASE_YAW ? end[9 * limb + 3 * i + 1] : axis[i];
        }
    }
    return 0;
}

/* The room left below the bend limit at the ends or far sides of primitives, and its derivative by all angles.
 *
 * shapes: (n + 1, 2, 3, 3). least: the least cosine of each limb's bend on each primitive, (n, 2). fixed: whether a
 * primitive's room does not matter, (n,). near: more room than this does not matter. place: to work in, (n, 6).
 * room, slope: (m,) and (m, n). Returns m, n at most. */
API SIZE purcell_bend_rows(SIZE n, const SIZE *control, const double *angle, const double *shapes, const double *least,
                           const SIZE *fixed, double near, double *places, double *room, double *slope) {
    SIZE m = 0;
    int universal[2];
    purcell_turns_about_base(n, control, universal);
    double *const abouts = places + 3 * n;
    for (SIZE p = 0; p < n; p++) purcell_turning_axis(control[p], shapes + 18 * p, abouts + 3 * p);
    for (SIZE p = 0; p < n; p++) {
        const int limb = LIMB_OF(control[p]), axis = AXIS_OF(control[p]);
        if (axis == 0 || fixed[p]) continue;
        const double *before = shapes + 18 * p + 9 * limb, *after = before + 18, *about = abouts + 3 * p;
        const double begin[3] = {before[0], before[3], before[6]}, size = angle[p] < 0.0 ? -angle[p] : angle[p];
        double place[3] = {after[0], after[3], after[6]}, across[3];
        CROSS(across, about, begin);
        for (int i = 0; i < 3; i++) across[i] *= angle[p] < 0.0 ? -1.0 : 1.0;
        /* A primitive passes the circle's far side if its rotation reaches it before the end. */
        double far = purcell_arctan2_of(-across[0], -begin[0]);
        if (far < 0.0) far += FULL_TURN;
        const int passed = far < size && control[p] < BASE_YAW;
        if (passed) {
            double sine, cosine;
            purcell_sin_cos_of(far, &sine, &cosine);
            for (int i = 0; i < 3; i++) place[i] = cosine * begin[i] + sine * across[i];
        }
        const double left = place[0] - least[2 * p + limb];
        if (!(left < near)) continue;
        room[m] = left;
        double *row = slope + m * n;
        const double own_y[3] = {after[1], after[4], after[7]};
        for (SIZE q = 0; q < n; q++) {
            if (q > p - passed || LIMB_OF(control[q]) != limb) {
                row[q] = 0.0;
                continue;
            }
            const double *by = universal[limb] && control[q] < BASE_YAW ? own_y : abouts + 3 * q;
            row[q] = by[1] * place[2] - by[2] * place[1];
        }
        m++;
    }
    return m;
}

#define ACTIVE_ROUNDS 12  /* in which the active constraints are looked for; the set that breaks limits least is kept */
#define SLACK 1e-9        /* a step may break a limit by this */
#define DAMPING 1e-13     /* of the Gram matrix, as a part of its trace, so that dependent constraints leave it regular */
#define WEAKEST 1e-9      /* rows of which less than this part of the longest is left depend on the others */

/* x of least norm for which rows x come nearest to a vector, by a complete orthogonal factorisation.
 * rows: (r, n), spoilt. basis: (q, n); work: (3 q, r) and (2 q,), q the smaller of r and n. */
static void least_norm(SIZE r, SIZE n, double *rows, const double *wanted, double *basis, double *work, double *x) {
    const SIZE most = r < n ? r : n;
    double *made = work, *across = made + most * r, *triangle = across + most * r, *lead = triangle + most * r;
    const SIZE rank = purcell_orthogonal_rows(r, n, rows, WEAKEST, basis, made);
    for (SIZE i = 0; i < n; i++) x[i] = 0.0;
    if (!rank || purcell_orthogonal_rows(rank, r, made, 0.0, across, triangle) < rank) return;
    product(across, wanted, lead, rank, r, 1);
    purcell_solve(1, rank, 1, triangle, lead);
    product(lead, basis, x, 1, rank, n);
}

#define REFINED 3         /* the most solutions that refine one another */
#define SOLVED 1e-11      /* what rows may miss then, as a part of the largest that is wanted */

/* x of least norm for which rows x is a vector, by the damped Gram matrix of the rows, refined; whether that was found.
 * Rows that are all but dependent have none: `least_norm` then does. gram: (r, r). work: (r, r) and (3 r,). */
static int least_by_gram(SIZE r, SIZE n, const double *rows, const double *gram, const double *wanted, double *work,
                         double *x) {
    double *system = work, *left = system + r * r, *multiplier = left + r, *step = multiplier + r, most = 0.0;
    for (SIZE i = 0; i < r; i++) {
        const double size = fabs(wanted[i]);
        most = size > most ? size : most;
        left[i] = wanted[i];
        multiplier[i] = 0.0;
    }
    for (int round = 0; round < REFINED; round++) {
        double missed = 0.0;
        for (SIZE i = 0; i < r * r; i++) system[i] = gram[i];
        for (SIZE i = 0; i < r; i++) step[i] = left[i];
        purcell_solve(1, r, 1, system, step);
        for (SIZE i = 0; i < r; i++) multiplier[i] += step[i];
        product(multiplier, rows, x, 1, r, n);
        for (SIZE i = 0; i < r; i++) {
            left[i] = wanted[i] - inner_product(n, rows + i * n, x);
            const double size = fabs(left[i]);
            missed = size <= missed ? missed : size; /* what is no number stays */
        }
        if (missed <= SOLVED * most) return 1;
        if (missed != missed) return 0;
    }
    return 0;
}

/* The inner products of rows (r, n), and a little more on the diagonal. gram: (r, r). */
static void damped_gram(SIZE r, SIZE n, const double *rows, double damping, double *gram) {
    for (SIZE i = 0; i < r; i++) {
        for (SIZE l = 0; l <= i; l++) gram[i * r + l] = gram[l * r + i] = inner_product(n, rows + i * n, rows + l * n);
        gram[i * r + i] += damping;
    }
}

/* The least step to the arrival under inequalities (primal-dual active sets: Hintermueller, Ito and Kunisch 2002, SIAM
 * J. Optim. 13, 865). An angle that moves the base by much counts for more.
 *
 * arrival: derivative of what is missing, that of the base's pose first, (m, n). missing: (m,). room, slope: of the
 * inequalities, (k,) and (k, n). reach: of the step's largest component. fine: whether it is refined once it
 * is known which bind; the Gram matrix, with which that is looked for, knows it to half the digits, enough where more
 * steps follow. work: 2 n + 3 r n + 4 r r + 8 r + 8 numbers, r being m + k. out: (n,). */
API void purcell_bounded_step(SIZE m, SIZE k, SIZE n, const double *arrival, const double *missing, const double *room,
                              const double *slope, double reach, SIZE fine, double *work, double *out) {
    const SIZE r = m + k, most = r < n ? r : n;
    double *weight = work, *found = weight + n, *rows = found + n, *few = rows + r * n, *wanted = few + r * n;
    double *multiplier = wanted + r, *basis = multiplier + r, *part = basis + most * n, *rest = part + 3 * most * r + 2 * most;
    double *system = rest + r;
    char *active = (char *)(system + r * r), *kept = active + r, *renewed = kept + r, *tried = renewed + r;
    for (SIZE j = 0; j < n; j++) {
        double square = arrival[j] * arrival[j];
        for (int i = 1; i < 6; i++) square += arrival[i * n + j] * arrival[i * n + j];
        weight[j] = 1.0 / sqrt(1.0 + sqrt(square));
    }
    double trace = 0.0, least = INFINITY;
    for (SIZE i = 0; i < r; i++) {
        const double *from = i < m ? arrival + i * n : slope + (i - m) * n;
        wanted[i] = i < m ? -missing[i] : -room[i - m];
        for (SIZE j = 0; j < n; j++) rows[i * n + j] = from[j] * weight[j];
        trace += inner_product(n, rows + i * n, rows + i * n);
        active[i] = kept[i] = i < m;
    }
    const double damping = DAMPING * trace + 1e-30;
    for (int round = 0; round < ACTIVE_ROUNDS; round++) {
        SIZE count = 0, broken = 0, known = 0;
        double worst = 0.0;
        for (SIZE i = 0; i < r; i++) {
            if (!active[i]) continue;
            for (SIZE j = 0; j < n; j++) few[count * n + j] = rows[i * n + j];
            multiplier[count++] = wanted[i];
        }
        damped_gram(count, n, few, damping, system);
        purcell_solve(1, count, 1, system, multiplier);
        for (SIZE j = 0; j < n; j++) found[j] = 0.0;
        for (SIZE i = 0; i < count; i++)
            for (SIZE j = 0; j < n; j++) found[j] += multiplier[i] * few[i * n + j];
        for (SIZE i = r - 1; i >= 0; i--) rest[i] = active[i] ? multiplier[--count] : 0.0;
        for (SIZE i = 0; i < r; i++) {
            const double excess = active[i] ? 0.0 : wanted[i] - inner_product(n, rows + i * n, found);
            const int over = excess > SLACK;
            worst = excess > worst ? excess : worst;
            broken += over;
            renewed[i] = (char)(i < m || rest[i] > 0.0 || over);
            multiplier[i] = over;
        }
        if (worst < least) {
            least = worst;
            for (SIZE i = 0; i < r; i++) kept[i] = active[i];
            for (SIZE j = 0; j < n; j++) out[j] = found[j];
        }
        if (!broken) break;
        for (SIZE i = 0; i < r; i++) tried[round * r + i] = active[i];
        for (int s = 0; s <= round && !known; s++) {
            known = 1;
            for (SIZE i = 0; i < r && known; i++) known = tried[s * r + i] == renewed[i];
        }
        for (SIZE i = 0; i < r; i++) active[i] = known ? (char)(active[i] || multiplier[i] > 0.0) : renewed[i];
    }
    SIZE count = 0;
    for (SIZE i = 0; i < r && fine; i++) {
        if (!kept[i]) continue;
        for (SIZE j = 0; j < n; j++) few[count * n + j] = rows[i * n + j];
        multiplier[count++] = wanted[i];
    }
    if (fine) {
        damped_gram(count, n, few, damping, system);
        if (count > n || !least_by_gram(count, n, few, system, multiplier, part, out))
            least_norm(count, n, few, multiplier, basis, part, out);
    }
    double largest = 0.0;
    for (SIZE j = 0; j < n; j++) {
        out[j] *= weight[j];
        const double size = fabs(out[j]);
        largest = size > largest ? size : largest;
    }
    const double ratio = reach / (largest > 1e-300 ? largest : 1e-300), shorter = ratio < 1.0 ? ratio : 1.0;
    for (SIZE j = 0; j < n; j++) out[j] *= shorter;
}
