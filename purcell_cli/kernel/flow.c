/* Displacements of pieces of constant limb rates, and the work done on them. */
#include "kernel.h"

struct flowing {
    const struct swimmer *s;
    const struct rule *rule;
    wide_pose here;
    double work;
    int root;
    struct known known;
    struct solved solved;
    struct queue queue;
    SIZE done; /* pieces whose poses are told */
    double *out, *wide;
};

static void advance(const struct step *step, void *state) {
    struct flowing *f = state;
    purcell_solve_step(f->s, f->rule, step, DISPLACEMENT, &f->solved);
    purcell_wide_times(&f->here, f->solved.pose);
}

/* Tells the poses of pieces up to one. */
static void finish(struct flowing *f, SIZE until) {
    for (; f->done < until; f->done++) {
        purcell_wide_normalise(&f->here);
        purcell_wide_round(&f->here, f->out + 16 * f->done);
        if (f->wide) purcell_wide_store(&f->here, f->wide + 24 * f->done);
        purcell_wide_identity(&f->here);
    }
}

static void put_on(void *state) {
    struct flowing *const f = state;
    struct queue *const q = &f->queue;
    purcell_solve_steps(f->s, f->rule, q->stored, q->steps, 0, q->travelled);
    for (SIZE i = 0; i < q->stored; i++) {
        finish(f, q->of[i]);
        purcell_wide_times(&f->here, q->travelled[i].pose);
    }
    q->stored = 0;
}

static void spend(const struct step *step, void *state) {
    struct flowing *f = state;
    f->work += purcell_step_power(f->s, f->rule, step, f->root);
}

/* The displacement of each of n pieces. Shapes (n, 2, 3, 3), (n, 6), (n,) to (n, 4, 4), and (n, 3, 4, 2) in twofold
 * precision unless that is null. Returns 0, or the number of a piece that is too long, counted from 1. */
API SIZE purcell_flow_of_pieces(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                                const double *to_node, double step, double settled, SIZE n, const double *shapes,
                                const double *rates, const double *durations, double *out, double *wide) {
    const struct rule rule = {stages, nodes, weights, to_node, step, settled};
    struct flowing f;
    f.s = (const struct swimmer *)swimmer;
    f.rule = &rule;
    f.known.limb = -1;
    f.queue.full = put_on;
    f.queue.state = &f;
    f.queue.stored = f.done = 0;
    f.out = out;
    f.wide = wide;
    purcell_wide_identity(&f.here);
    for (SIZE k = 0; k < n; k++) {
        const double *const shape = shapes + 18 * k, *const rate = rates + 6 * k;
        if (f.s->tables > 0.0) {
            if (purcell_mesh(f.s, &rule, shape, rate, durations[k], DISPLACEMENT, &f.known, advance, &f) < 0) return k + 1;
            finish(&f, k + 1);
        } else if (!purcell_queued(&f.queue, f.s, &rule, k, shape, rate, durations[k], &f.known)) {
            return k + 1;
        }
    }
    put_on(&f);
    finish(&f, n);
    return 0;
}

/* The integral over each piece of the dissipated power, or of its root. Shape (n,). Returns as above. */
API SIZE purcell_work_on_pieces(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                                const double *to_node, double step, double settled, SIZE n, const double *shapes,
                                const double *rates, const double *durations, SIZE root, double *out) {
    const struct rule rule = {stages, nodes, weights, to_node, step, settled};
    struct flowing f;
    f.s = (const struct swimmer *)swimmer;
    f.rule = &rule;
    f.root = root != 0;
    f.known.limb = -1;
    for (SIZE k = 0; k < n; k++) {
        f.work = 0.0;
        if (purcell_mesh(f.s, &rule, shapes + 18 * k, rates + 6 * k, durations[k], POWER, &f.known, spend, &f) < 0) return k + 1;
        out[k] = f.work;
    }
    return 0;
}

/* What runs of displacements, in twofold precision, make when each is played so and so often.
 * Shapes (n, 3, 4, 2), (k,) and (k,), the counts being n together, to (k, 4, 4). */
API void purcell_runs(const double *wide, SIZE k, const SIZE *counts, const SIZE *cycles, double *out) {
    for (SIZE i = 0; i < k; i++) {
        wide_pose once, move;
        purcell_wide_identity(&once);
        for (SIZE j = 0; j < counts[i]; j++, wide += 24) {
            purcell_wide_load(wide, &move);
            purcell_wide_product(&once, &move, &once);
        }
        purcell_wide_normalise(&once);
        purcell_wide_power(&once, cycles[i], &once);
        purcell_wide_round(&once, out + 16 * i);
    }
}

/* Poses before each of n displacements played over and over, in order; `here`, in twofold precision, is where the
 * first begins and becomes where the last ends. Shapes (3, 4, 2), (n, 4, 4) to (cycles, n, 4, 4). */
API void purcell_played(double *here, SIZE n, const double *moves, SIZE cycles, double *out) {
    wide_pose begun, once, along;
    purcell_wide_load(here, &begun);
    purcell_wide_identity(&once);
    for (SIZE k = 0; k < n; k++) purcell_wide_times(&once, moves + 16 * k);
    purcell_wide_normalise(&once);
    for (SIZE c = 0; c < cycles; c++) {
        along = begun;
        for (SIZE k = 0; k < n; k++, out += 16) {
            purcell_wide_round(&along, out);
            purcell_wide_times(&along, moves + 16 * k);
        }
        purcell_wide_product(&begun, &once, &begun);
        purcell_wide_normalise(&begun);
    }
    purcell_wide_store(&begun, here);
}
