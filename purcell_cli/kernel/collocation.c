/* The flow g' = g hat(xi) on a step by Gauss collocation, orientations as quaternions, and the graded mesh. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define VARIANT static
#define NAMED(name) name##_one
#define LANE double
#define SIDE_BY_SIDE 1
#define NONE 0.0
#define OF(x, l) (x)
#include "collocation_body.h"

#define SPIN_SHARE 0.25 /* what a spin about the own axis counts in the length of steps */
#define UNMOVED 1e-28 /* the square of how little axes swing that stay where they are, as a part of the rates' */
#define MOST_PARTS 8
#define MOST_DEPTH 60 /* of cutting */
#define MOST_STEPS 2000000 /* of a piece: some seconds, in which Ctrl-C waits */

/* The times of nodes k and k + 1; beyond the last it again. */
static lane node_times(const struct rule *rule, const struct step *step, SIZE k) {
    const SIZE next = k + 1 < rule->stages ? k + 1 : k;
    return (lane){rule->nodes[k] * step->duration, rule->nodes[next] * step->duration};
}

/* Written for any number m of stages, and compiled for each that is used, so that short loops become straight lines. */
static inline __attribute__((always_inline)) void solve_step(const int m, const struct swimmer *s, const struct rule *rule,
                                                             const struct step *step, enum wanted wanted,
                                                             struct solved *out) {
    double velocity[MOST_STAGES][3], half[MOST_STAGES][3], q[MOST_STAGES][4], rotation[9], position[3];
    double times[MOST_STAGES + 1], weights[MOST_STAGES], twists[MOST_STAGES + 1][6];
    const int ending = wanted >= CHANGE;
    for (int k = 0; k < m; k++) {
        times[k] = rule->nodes[k] * step->duration;
        weights[k] = rule->weights[k] * step->duration;
    }
    times[m] = step->duration;
    if (!step->field)
        purcell_at_nodes(s, step, m + ending, times, m, weights, twists, wanted >= CHANGE ? out->change : 0,
                         wanted >= PER_RATE ? out->per_rate : 0);
    for (int k = 0; step->field && k < m; k += LANES) {
        lane axes[2][3], rates[2][3], xi[6], change[6][6], per_rate[6][6], given[GIVEN];
        purcell_node_states(step, node_times(rule, step, k), axes, rates);
        purcell_of_field(step->field, step->start + node_times(rule, step, k), wanted >= CHANGE, given);
        purcell_connection(s, axes, rates, given, xi, wanted >= CHANGE ? change : 0, wanted >= PER_RATE ? per_rate : 0, 0);
        for (int l = 0; l < LANES && k + l < m; l++) {
            for (int i = 0; i < 6; i++) twists[k + l][i] = xi[i][l];
            for (int i = 0; wanted >= CHANGE && i < 36; i++)
                out->change[k + l][i / 6][i % 6] = weights[k + l] * change[i / 6][i % 6][l];
            for (int i = 0; wanted >= PER_RATE && i < 36; i++)
                out->per_rate[k + l][i / 6][i % 6] = weights[k + l] * per_rate[i / 6][i % 6][l];
        }
    }
    for (int i = 0; ending && !step->field && i < 6; i++) out->ending[i] = twists[m][i];
    for (int k = 0; k < m; k++)
        for (int i = 0; i < 3; i++) {
            velocity[k][i] = twists[k][i] * step->duration;
            half[k][i] = 0.5 * (twists[k][3 + i] * step->duration);
        }
    displaced_one(m, rule, velocity, half, q, rotation, position);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) out->pose[4 * i + j] = rotation[3 * i + j];
        out->pose[4 * i + 3] = position[i];
        out->pose[12 + i] = 0.0;
    }
    out->pose[15] = 1.0;
    for (int k = 0; wanted >= CHANGE && k < m; k++)
        at_node_one(m, rule, k, velocity, q, out->rotation[k], out->position[k]);
}

void purcell_solve_step(const struct swimmer *s, const struct rule *rule, const struct step *step, enum wanted wanted,
                        struct solved *out) {
    if (rule->stages == 3)
        solve_step(3, s, rule, step, wanted, out);
    else if (rule->stages == 5)
        solve_step(5, s, rule, step, wanted, out);
    else if (rule->stages == 8)
        solve_step(8, s, rule, step, wanted, out);
    else
        solve_step((int)rule->stages, s, rule, step, wanted, out);
}

void purcell_carried(const struct solved *solved, SIZE stages, double changes[][6][6], double out[36]) {
    for (int i = 0; i < 36; i++) out[i] = 0.0;
    for (SIZE k = 0; k < stages; k++) add_carried_one(solved->rotation[k], solved->position[k], changes[k], out);
}

/* The integral over a step of the power of the joints' torques, or of its root. */
double purcell_step_power(const struct swimmer *s, const struct rule *rule, const struct step *step, int root) {
    double sum = 0.0;
    for (SIZE k = 0; k < rule->stages; k += LANES) {
        lane axes[2][3], rates[2][3], xi[6], power, given[GIVEN];
        purcell_node_states(step, node_times(rule, step, k), axes, rates);
        if (step->field) purcell_of_field(step->field, step->start + node_times(rule, step, k), 0, given);
        purcell_connection(s, axes, rates, step->field ? given : 0, xi, 0, 0, &power);
        for (int l = 0; l < LANES && k + l < rule->stages; l++) {
            const double found = power[l] > 0.0 ? power[l] : 0.0;
            sum += rule->weights[k + l] * (root ? sqrt(found) : found);
        }
    }
    return sum * step->duration;
}

struct cutting {
    const struct swimmer *s;
    double finest, sweep, begun[2][3];
    struct step step;
    visitor *visit;
    void *state;
    SIZE steps;
};

/* Where the limbs' axes are at a time. */
static void axes_at(const struct cutting *c, double time, double axes[2][3]) {
    for (int limb = 0; limb < 2; limb++) {
        const double *rate = c->step.rates[limb], *begun = c->begun[limb], turned[3] = {rate[0] * time, rate[1] * time, rate[2] * time};
        if (turned[0] != 0.0 || turned[1] != 0.0 || turned[2] != 0.0)
            purcell_rotate(turned, begun, axes[limb]);
        else
            for (int i = 0; i < 3; i++) axes[limb][i] = begun[i];
    }
}

/* The step from start, or its parts where it is long against the distance from a straight line.
 *
 * The distance changes at most `steepness` times as fast as the limbs turn, so a step that is short enough at its
 * middle is everywhere. */
static void cut(struct cutting *c, double start, double length, int depth) {
    double axes[2][3];
    if (depth > MOST_DEPTH || c->steps >= MOST_STEPS) {
        c->steps = -1;
        return;
    }
    axes_at(c, start + 0.5 * length, axes);
    const double arc = c->sweep * length;
    const double near = purcell_distance(c->s, axes, arc / c->finest);
    if (arc > c->finest * near) {
        const double low = near - 0.5 * c->s->steepness * arc;
        const double ratio = arc / (c->finest * (low > c->s->sharpness ? low : c->s->sharpness));
        int parts = 2;
        while (parts < MOST_PARTS && parts < ratio) parts++;
        const double part = length / parts;
        for (int k = 0; k < parts && c->steps >= 0; k++) cut(c, start + k * part, part, depth + 1);
        return;
    }
    axes_at(c, start, c->step.axes);
    c->step.start = start;
    c->step.duration = length;
    c->visit(&c->step, c->state);
    c->steps++;
}

SIZE purcell_mesh(const struct swimmer *s, const struct rule *rule, const double shape[18], const double rate[6],
                  double duration, enum wanted wanted, struct known *known, visitor *visit, void *state) {
    const double finest = rule->step;
    struct cutting c = {.s = s, .finest = finest, .visit = visit, .state = state};
    double square = 0.0, swung = 0.0;
    if (duration == 0.0) return 0;
    for (int limb = 0; limb < 2; limb++) {
        const double *a = shape + 9 * limb, *w = rate + 3 * limb;
        double swept[3];
        for (int i = 0; i < 3; i++) {
            c.begun[limb][i] = a[3 * i];
            c.step.rates[limb][i] = a[3 * i] * w[0] + a[3 * i + 1] * w[1] + a[3 * i + 2] * w[2];
        }
        CROSS(swept, c.step.rates[limb], c.begun[limb]);
        const double spun = SPIN_SHARE * DOT(c.step.rates[limb], c.begun[limb]);
        swung += DOT(swept, swept);
        square += DOT(swept, swept) + spun * spun;
    }
    c.sweep = sqrt(square);
    if (c.sweep * duration > finest * MOST_STEPS) return -1; /* no step is longer than `finest` */
    if (s->tables == 0.0) {
        cut(&c, 0.0, duration, 0);
        return c.steps;
    }
    struct field field;
    field.count = 0;
    known->exact = rule->stages > ROUGH_STAGES;
    known->slopes = wanted >= CHANGE;
    known->power = wanted == POWER;
    known->couplings = wanted == POWER || wanted >= PER_RATE;
    const SIZE panels = (SIZE)(c.sweep * duration / PANEL_RAD) + 1;
    const double length = duration / (double)panels, arc = c.sweep * length;
    const int stays = swung < UNMOVED * c.sweep * c.sweep; /* a limb that turns about its own axis changes nothing */
    const int wanted_nodes = stays ? 1 : (int)rule->stages + (int)(4.0 * arc); /* err no more than the rule does */
    const int nodes = wanted_nodes < PANEL_NODES ? wanted_nodes : PANEL_NODES;
    c.step.field = &field;
    for (SIZE k = 0; k < panels && c.steps >= 0; k++) {
        purcell_fill_field(s, c.begun, c.step.rates, (double)k * length, length, nodes, known, &field);
        cut(&c, (double)k * length, length, 0);
    }
    return c.steps;
}

static void store(const struct step *step, void *state) {
    struct queue *const q = state;
    if (q->stored == QUEUE && q->full) q->full(q->state);
    if (q->stored < QUEUE) {
        q->of[q->stored] = q->piece;
        q->steps[q->stored] = *step;
    }
    q->stored++;
}

int purcell_queued(struct queue *q, const struct swimmer *s, const struct rule *rule, SIZE piece, const double shape[18],
                   const double rate[6], double duration, struct known *known) {
    const SIZE before = q->stored;
    q->piece = piece;
    if (purcell_mesh(s, rule, shape, rate, duration, DISPLACEMENT, known, store, q) >= 0 && q->stored <= QUEUE) return 1;
    q->stored = before;
    return 0;
}
