/* The equations of an exact arrival, the room below limits, and the least steps under both. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define AXIS_OF(control) ((int)((control) < BASE_YAW ? (control) % 3 : 2))
#define FULL_TURN 6.283185307179586
#define LESS_THAN_HALF 3.0 /* an angle below half a turn [rad] */

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

/* Whether a limb passes the far side of its circle, where it bends most, on a primitive before that ends; about: the axis
 * that it turns about, where it goes. far: at which angle, if it does. */
static int passes(const double about[3], const double begin[3], const double end[3], double size, double *far) {
    const double falls = about[1] * begin[2] - about[2] * begin[1], still = about[1] * end[2] - about[2] * end[1];
    if (size == 0.0 || (size < LESS_THAN_HALF && (falls > 0.0 || still < -CLEARLY))) return 0;
    *far = purcell_arctan2_of(-falls, -begin[0]);
    if (*far < 0.0) *far += FULL_TURN;
    return *far < size;
}

/* The room left below the bend limit at the ends or far sides of primitives, where it is small.
 *
 * shapes: (n + 1, 2, 3, 3). least: the least cosine of each limb's bend on each primitive, (n, 2). fixed: whether a
 * primitive's room does not matter, (n,). near: more room than this does not matter.
 * room: (m,). of: the primitives, (m,). stop, torque: what `purcell_room_slopes` takes, (m,) and (m, 2, 3). Returns m, n
 * at most. */
API SIZE purcell_bend_rooms(SIZE n, const SIZE *control, const double *angle, const double *shapes, const double *least,
                            const SIZE *fixed, double near, double *room, SIZE *of, SIZE *stop, double *torque) {
    SIZE m = 0;
    for (SIZE p = 0; p < n; p++) {
        const int limb = LIMB_OF(control[p]), axis = AXIS_OF(control[p]);
        if (axis == 0 || fixed[p]) continue;
        const double *before = shapes + 18 * p + 9 * limb, *after = before + 18;
        const double begin[3] = {before[0], before[3], before[6]}, size = angle[p] < 0.0 ? -angle[p] : angle[p];
        double place[3] = {after[0], after[3], after[6]}, about[3], across[3], far;
        purcell_turning_axis(control[p], shapes + 18 * p, about);
        for (int i = 0; i < 3; i++) about[i] *= angle[p] < 0.0 ? -1.0 : 1.0;
        const int passed = control[p] < BASE_YAW && passes(about, begin, place, size, &far);
        if (passed) {
            double sine, cosine;
            purcell_sin_cos_of(far, &sine, &cosine);
            CROSS(across, about, begin);
            for (int i = 0; i < 3; i++) place[i] = cosine * begin[i] + sine * across[i];
        }
        const double left = place[0] - least[2 * p + limb];
        if (!(left < near)) continue;
        room[m] = left;
        of[m] = p;
        stop[m] = p + 1 - passed;
        for (int i = 0; i < 6; i++) torque[6 * m + i] = 0.0;
        torque[6 * m + 3 * limb + 1] = place[2];
        torque[6 * m + 3 * limb + 2] = -place[1];
        m++;
    }
    return m;
}

/* The axes that n primitives turn limb 1 and limb 2 about, zero for the other limb: (6, n). */
void purcell_turning_axes(SIZE n, const SIZE *control, const double *shapes, double *axes) {
    for (SIZE i = 0; i < 6 * n; i++) axes[i] = 0.0;
    for (SIZE q = 0; q < n; q++) {
        double about[3];
        purcell_turning_axis(control[q], shapes + 18 * q, about);
        for (int i = 0; i < 3; i++) axes[(3 * LIMB_OF(control[q]) + i) * n + q] = about[i];
    }
}

/* How a room changes with the angles of the first `stop` of n primitives, by torques on both limbs after those: (n,). */
void purcell_room_slope(SIZE stop, const double *torque, SIZE n, const SIZE *control, const double *shapes,
                        const double *axes, double *slope) {
    int universal[2];
    for (SIZE q = 0; q < stop; q++)
        slope[q] = (axes[q] * torque[0] + axes[n + q] * torque[1] + axes[2 * n + q] * torque[2]) +
                   (axes[3 * n + q] * torque[3] + axes[4 * n + q] * torque[4] + axes[5 * n + q] * torque[5]);
    for (SIZE q = stop; q < n; q++) slope[q] = 0.0;
    purcell_turns_about_base(n, control, universal);
    for (SIZE q = 0; (universal[0] || universal[1]) && q < stop; q++) { /* pitches turn such a limb about its own y */
        const int limb = LIMB_OF(control[q]);
        const double *there = shapes + 18 * stop + 9 * limb, own_y[3] = {there[1], there[4], there[7]};
        if (universal[limb] && control[q] < BASE_YAW) slope[q] = DOT(own_y, torque + 3 * limb);
    }
}

/* The same of m rooms. stop, torque: (m,) and (m, 2, 3). shapes: (n + 1, 2, 3, 3). axes: to work in, (6, n). slope: (m, n). */
API void purcell_room_slopes(SIZE m, const SIZE *stop, const double *torque, SIZE n, const SIZE *control,
                             const double *shapes, double *axes, double *slope) {
    purcell_turning_axes(n, control, shapes, axes);
    for (SIZE k = 0; k < m; k++) purcell_room_slope(stop[k], torque + 6 * k, n, control, shapes, axes, slope + k * n);
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

/* Rows that were active once, next to one another, and their inner products, a little more on the diagonal. */
struct system {
    SIZE n, most, count;
    double *rows, *gram;   /* (most, n), and (most, most), of which the lower half is known */
    double *factor;        /* of those that are active now; TILE more rows and columns than those */
    SIZE active, width;
};

static void include(struct system *k, const double *row, double damping) {
    double *const own = k->rows + k->count * k->n, *const gram = k->gram + k->count * k->most;
    for (SIZE j = 0; j < k->n; j++) own[j] = row[j];
    purcell_inner_products(k->n, ++k->count, k->rows, own, gram);
    gram[k->count - 1] += damping;
}

/* Cholesky's factor of the Gram matrix of some of them; whether there is one. */
static int factorise(struct system *k, SIZE active, const SIZE *which) {
    const SIZE width = (active + TILE - 1) / TILE * TILE;
    int positive;
    k->active = active;
    k->width = width;
    for (SIZE a = 0; a < width; a++) {
        double *const row = k->factor + a * width;
        for (SIZE b = 0; b < width; b++) row[b] = a == b && a >= active ? 1.0 : 0.0;
        for (SIZE b = 0; b <= a && a < active; b++) {
            const SIZE i = which[a], j = which[b];
            row[b] = i > j ? k->gram[i * k->most + j] : k->gram[j * k->most + i];
        }
    }
    purcell_cholesky(width, k->factor, &positive);
    return positive;
}

/* The solution of the system of that Gram matrix, in place of its right side. */
static void solve(const struct system *k, double *x) {
    for (SIZE a = 0; a < k->active; a++) {
        const double *row = k->factor + a * k->width;
        x[a] = (x[a] - inner_product(a, row, x)) / row[a];
    }
    for (SIZE a = k->active - 1; a >= 0; a--) {
        const double *row = k->factor + a * k->width;
        x[a] /= row[a];
        for (SIZE b = 0; b < a; b++) x[b] -= x[a] * row[b];
    }
}

/* The sum of multiples of some of the rows: (n,). */
static void combine(const struct system *k, SIZE count, const SIZE *which, const double *multiplier, double *x) {
    for (SIZE j = 0; j < k->n; j++) x[j] = 0.0;
    for (SIZE a = 0; a < count; a++) {
        const double *row = k->rows + which[a] * k->n;
        for (SIZE j = 0; j < k->n; j++) x[j] += multiplier[a] * row[j];
    }
}

#define REFINED 3         /* the most solutions that refine one another */
#define SOLVED 1e-11      /* what rows may miss then, as a part of the largest that is wanted */

/* x of least norm for which active rows x is a vector, by their damped Gram matrix's factor, refined; whether that was
 * found. Rows that are all but dependent have none: `least_norm` then does. work: (3, active). */
static int least_by_gram(const struct system *k, const SIZE *which, const double *wanted, double *work, double *x) {
    const SIZE r = k->active;
    double *left = work, *multiplier = left + r, *step = multiplier + r, most = 0.0;
    for (SIZE i = 0; i < r; i++) {
        const double size = fabs(wanted[i]);
        most = size > most ? size : most;
        left[i] = wanted[i];
        multiplier[i] = 0.0;
    }
    for (int round = 0; round < REFINED; round++) {
        double missed = 0.0;
        for (SIZE i = 0; i < r; i++) step[i] = left[i];
        solve(k, step);
        for (SIZE i = 0; i < r; i++) multiplier[i] += step[i];
        combine(k, r, which, multiplier, x);
        for (SIZE i = 0; i < r; i++) {
            left[i] = wanted[i] - inner_product(k->n, k->rows + which[i] * k->n, x);
            const double size = fabs(left[i]);
            missed = size <= missed ? missed : size; /* what is no number stays */
        }
        if (missed <= SOLVED * most) return 1;
        if (missed != missed) return 0;
    }
    return 0;
}

/* How many numbers `purcell_bounded_step` works in, of r equations and inequalities. */
API SIZE purcell_step_room(SIZE r, SIZE n) {
    const SIZE most = r < n ? r : n, width = r + TILE;
    return 2 * n + 2 * r * n + 9 * r + r * r + width * width + most * n + 3 * most * r + 2 * most + 4;
}

/* The least step to the arrival under inequalities (primal-dual active sets: Hintermueller, Ito and Kunisch 2002, SIAM
 * J. Optim. 13, 865). An angle that moves the base by much counts for more.
 *
 * arrival: derivative of what is missing, that of the base's pose first, (m, n). missing: (m,). room, slope: of the
 * inequalities, (k,) and (k, n). reach: of the step's largest component. fine: whether it is refined once it
 * is known which bind; the Gram matrix, with which that is looked for, knows it to half the digits, enough where more
 * steps follow. work: `purcell_step_room` numbers, r being m + k. out: (n,). */
API void purcell_bounded_step(SIZE m, SIZE k, SIZE n, const double *arrival, const double *missing, const double *room,
                              const double *slope, double reach, SIZE fine, double *work, double *out) {
    const SIZE r = m + k, most = r < n ? r : n;
    double *weight = work, *found = weight + n, *rows = found + n, *wanted = rows + r * n, *multiplier = wanted + r;
    double *excess = multiplier + r, *few = excess + r, *gram = few + r * n, *factor = gram + r * r;
    double *basis = factor + (r + TILE) * (r + TILE), *part = basis + most * n;
    SIZE *which = (SIZE *)(part + 3 * most * r + 2 * most + 2 * r), *place = which + r;
    char *active = (char *)(place + r), *kept = active + r, *renewed = kept + r, *tried = renewed + r;
    struct system system = {.n = n, .most = r, .rows = few, .gram = gram, .factor = factor};
    for (SIZE j = 0; j < n; j++) {
        double square = arrival[j] * arrival[j];
        out[j] = 0.0;
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
        place[i] = -1;
    }
    const double damping = DAMPING * trace + 1e-30;
    for (int round = 0; round < ACTIVE_ROUNDS; round++) {
        SIZE count = 0, broken = 0, again = 0;
        double worst = 0.0;
        for (SIZE i = 0; i < r; i++) {
            if (!active[i]) continue;
            if (place[i] < 0) {
                place[i] = system.count;
                include(&system, rows + i * n, damping);
            }
            which[count] = place[i];
            multiplier[count++] = wanted[i];
        }
        if (!factorise(&system, count, which)) break;
        solve(&system, multiplier);
        combine(&system, count, which, multiplier, found);
        purcell_inner_products(n, r, rows, found, excess);
        count = 0;
        for (SIZE i = 0; i < r; i++) {
            const int held = active[i] && multiplier[count++] > 0.0, over = !active[i] && wanted[i] - excess[i] > SLACK;
            if (!active[i] && wanted[i] - excess[i] > worst) worst = wanted[i] - excess[i];
            broken += over;
            renewed[i] = (char)(i < m || held || over);
        }
        if (worst < least) {
            least = worst;
            for (SIZE i = 0; i < r; i++) kept[i] = active[i];
            for (SIZE j = 0; j < n; j++) out[j] = found[j];
        }
        if (!broken) break;
        for (SIZE i = 0; i < r; i++) tried[round * r + i] = active[i];
        for (int s = 0; s <= round && !again; s++) {
            again = 1;
            for (SIZE i = 0; i < r && again; i++) again = tried[s * r + i] == renewed[i];
        }
        for (SIZE i = 0; i < r; i++) active[i] = again ? (char)(active[i] || renewed[i]) : renewed[i];
    }
    SIZE count = 0;
    for (SIZE i = 0; i < r && fine; i++) {
        if (!kept[i]) continue;
        which[count] = place[i];
        multiplier[count++] = wanted[i];
    }
    if (fine && (count > n || !factorise(&system, count, which) || !least_by_gram(&system, which, multiplier, part, out))) {
        for (SIZE a = 0; a < count; a++)
            for (SIZE j = 0; j < n; j++) rows[a * n + j] = few[which[a] * n + j];
        least_norm(count, n, rows, multiplier, basis, part, out);
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
