/* Motions brought to their goal, and shortened: Newton steps and linear programs on the angles that are free. */
#include <math.h>
#include <stddef.h>

#include "points.h"

#define RESTORING 8      /* the most Newton steps that move a point back to the arrival */
#define RESTORED 1e-4    /* a point whose residuals and broken limits sum to less than this is at the arrival [L, rad] */
#define SHARE 0.3        /* what is then missing counts as no more than this part of what a program promised */
#define LEAST_MISS 1e-7  /* and need not be less than this [L, rad] */
#define RETURN_REACH 0.25 /* the least reach of those Newton steps: the largest change of an angle in one [rad] */
#define IN_USE 1e-9      /* only angles larger than this move a point back [rad] */
#define HELPS 0.9        /* a Newton step that leaves more than this part of the violation is the last */
#define SWIFT 0.25       /* one that leaves more than this is the last by a derivative from elsewhere */
/* Of an angle with a radius of its own: where its change turns back its share shrinks, where it goes on it grows. */
#define BACK 0.7
#define ON 1.2
#define LEAST_SHARE 0.1
#define LARGEST_SHARE 4.0
#define WORTH 1e-5       /* a linear program that promises to save less joint travel than this is the last [rad] */
#define STRICT 100.0     /* weight of a broken limit beside a missed goal on the approach: the last steps change bends too */
#define COARSE 1e-5      /* what a step may leave of what is missing that is not refined: much more than it does */
#define APPROACHING 20   /* the most Newton steps of an approach */
static const double parts[] = {1.0, 0.4, 0.15, 0.05}; /* of a Newton step, tried in turn until the residual falls */
#define PARTS 4

/* How many numbers are worked in, and whole ones; see `purcell_descend`. */
API SIZE purcell_descent_room(SIZE n, SIZE free, SIZE equations, SIZE k, SIZE most, SIZE added, SIZE *whole) {
    const SIZE r = equations + most;
    const SIZE point = purcell_point_room(n, free, equations, most, added);
    *whole = 9 * most + 3 * r + 4 * free;
    return 3 * point + 94 * n + 36 * k + (equations + 6) * n + CLEARANCE_ROOM + (21 + 2 * r) * free + 10 * r +
           purcell_step_room(r, free);
}

struct descent {
    struct motion m;
    struct point points[3], *here, *there, *next;
    double *share, *change, *low, *high, *x, *step, *table, *kept, *right, *left, *room, *work;
    SIZE *whole, *use;
};

static void exchange(struct point **a, struct point **b) {
    struct point *const kept = *a;
    *a = *b;
    *b = kept;
}

/* A point moved back to the arrival and within the limits by the angles in use: d->there, until no more than `enough` is
 * missing. By the equations' derivative at another point as long as that brings it swiftly nearer, if there is one. */
static SIZE restore(struct descent *d, double reach, double enough, const double *derivative) {
    const struct motion *m = &d->m;
    for (int round = 0; round < RESTORING && !(d->there->violation < enough); round++) {
        const int own = !derivative;
        SIZE fault = own && !d->there->sloped ? purcell_point_equations(m, d->there, 1) : 0, used = 0;
        if (fault) return fault;
        if (own) derivative = d->there->derivative;
        const struct point *p = d->there;
        for (SIZE j = 0; j < m->free; j++)
            if (fabs(p->angle[j]) > IN_USE) d->use[used++] = j;
        if (!used) return 0;
        const SIZE rooms = purcell_point_slopes(m, p, TURNING, d->left, d->kept);
        for (SIZE i = 0; i < m->equations + rooms; i++) {
            const double *from = i < m->equations ? derivative + i * m->free : d->kept + (i - m->equations) * m->free;
            for (SIZE j = 0; j < used; j++) d->table[i * used + j] = from[d->use[j]];
        }
        purcell_bounded_step(m->equations, rooms, used, d->table, p->residual, d->left, d->table + m->equations * used,
                             reach, 0, d->work, d->step);
        for (SIZE j = 0; j < m->free; j++) d->next->angle[j] = p->angle[j];
        for (SIZE j = 0; j < used; j++) d->next->angle[d->use[j]] += d->step[j];
        if ((fault = purcell_point_evaluated(m, d->next))) return fault;
        const double left = d->next->violation / d->there->violation;
        const int taken = left <= (own ? HELPS : SWIFT);
        if (own && !taken) break;
        if (taken) exchange(&d->there, &d->next);
        if (!(left <= SWIFT)) derivative = 0;
    }
    return 0;
}

/* The angles that minimise the linearised merit within reach: d->x. Returns whether there are any, and that merit. */
static int propose(struct descent *d, double reach, double *merit) {
    const struct motion *m = &d->m;
    const struct point *p = d->here;
    const SIZE n = m->free, rooms = purcell_point_slopes(m, p, IDLE, d->left, d->table), rows = m->equations + rooms;
    for (SIZE j = 0; j < n; j++) {
        double square = p->derivative[j] * p->derivative[j];
        for (int i = 1; i < 6; i++) square += p->derivative[i * n + j] * p->derivative[i * n + j];
        const double within = d->share[j] * reach / sqrt(1.0 + sqrt(square));
        d->low[j] = p->angle[j] - within;
        d->high[j] = p->angle[j] + within;
        d->x[j] = p->angle[j];
    }
    for (SIZE i = 0; i < rows; i++) {
        const int equal = i < m->equations;
        const double *from = equal ? p->derivative + i * n : d->table + (i - m->equations) * n;
        double *to = d->kept + i * n, sum = 0.0;
        for (SIZE j = 0; j < n; j++) {
            to[j] = equal ? from[j] : -from[j];
            sum += to[j] * d->x[j];
        }
        d->right[i] = sum - (equal ? p->residual[i] : -d->left[i - m->equations]);
        if (!(fabs(d->right[i]) <= DBL_MAX)) return 0;
    }
    if (purcell_program(rows, n, m->equations, m->equations + p->turning, m->price, d->kept, d->right, m->weight, d->low,
                        d->high, d->x, d->table, d->room, d->whole) < 0)
        return 0;
    double travel = 0.0, missed = 0.0;
    for (SIZE j = 0; j < n; j++) travel += m->weight[j] * fabs(d->x[j]);
    for (SIZE i = 0; i < m->equations + p->turning; i++) { /* what the merit counts */
        double miss = -d->right[i];
        for (SIZE j = 0; j < n; j++) miss += d->kept[i * n + j] * d->x[j];
        missed += i < m->equations ? fabs(miss) : miss > 0.0 ? miss : 0.0;
    }
    *merit = travel + m->price * missed;
    return 1;
}

/* The shares of the reach after a step, from here to there: programs alone go to and fro where the arrival is curved, and
 * would go slowly where it is straight, with one radius for all (Svanberg 1987, Int. J. Numer. Methods Eng. 24, 359). */
static void share_out(struct descent *d) {
    for (SIZE j = 0; j < d->m.free; j++) {
        const double change = d->there->angle[j] - d->here->angle[j], along = change * d->change[j];
        if (along < 0.0) d->share[j] *= d->share[j] > LEAST_SHARE / BACK ? BACK : 1.0;
        if (along > 0.0) d->share[j] *= d->share[j] < LARGEST_SHARE / ON ? ON : 1.0;
        if (change != 0.0) d->change[j] = change;
    }
}

/* Linear programs within a trust region (Fletcher and de la Maza 1989). reaches: the first, the largest, the least. own:
 * whether each angle has a share of it. worth: see `purcell_descend`. */
static SIZE descend(struct descent *d, SIZE steps, int own, double worth, const double reaches[3]) {
    double reach = reaches[0];
    for (SIZE j = 0; j < d->m.free; j++) {
        d->share[j] = 1.0;
        d->change[j] = 0.0;
    }
    for (SIZE k = 0; k < steps; k++) {
        double merit;
        SIZE fault = d->here->sloped ? 0 : purcell_point_equations(&d->m, d->here, 1);
        if (fault) return fault;
        if (!propose(d, reach, &merit)) break;
        const double promised = d->here->merit - merit;
        for (SIZE j = 0; j < d->m.free; j++) d->there->angle[j] = d->x[j];
        if ((fault = purcell_point_evaluated(&d->m, d->there))) return fault;
        if (d->here->merit - d->there->merit < 0.5 * promised) {
            const double part = SHARE * promised / d->m.price, enough = part < RESTORED ? part : RESTORED;
            fault = restore(d, reach > RETURN_REACH ? reach : RETURN_REACH, enough > LEAST_MISS ? enough : LEAST_MISS,
                            d->here->derivative);
            if (fault) return fault;
        }
        if (purcell_step_taken(promised, d->here->merit - d->there->merit, reaches[1], &reach)) {
            if (own) share_out(d);
            exchange(&d->here, &d->there);
        }
        if (reach < reaches[2] || promised < WORTH || promised < worth * d->here->merit) break;
    }
    return 0;
}

static void begin(struct descent *d, double *room, SIZE *whole) {
    struct motion *m = &d->m;
    const SIZE r = m->equations + m->most;
    m->plain = m->free == m->n;
    for (SIZE p = 0; p < m->n && m->plain; p++) m->plain = m->index[p] == p && m->sign[p] == 1.0;
    for (int i = 0; i < 3; i++) purcell_point_of(m, &room, &whole, d->points + i);
    d->here = d->points;
    d->there = d->points + 1;
    d->next = d->points + 2;
    m->flow = taken(&room, 94 * m->n + 36 * m->k);
    m->columns = taken(&room, m->equations * m->n);
    m->axes = taken(&room, 6 * m->n);
    m->cut = taken(&room, CLEARANCE_ROOM);
    d->share = taken(&room, m->free);
    d->change = taken(&room, m->free);
    d->low = taken(&room, m->free);
    d->high = taken(&room, m->free);
    d->x = taken(&room, m->free);
    d->step = taken(&room, m->free);
    d->table = taken(&room, r * m->free);
    d->kept = taken(&room, r * m->free);
    d->right = taken(&room, r);
    d->left = taken(&room, r);
    d->room = taken(&room, 8 * r + 15 * m->free);
    d->work = room;
    d->use = whole_taken(&whole, m->free);
    d->whole = whole;
}

#define MOTION                                                                                                       \
    const double *swimmer, SIZE stages, const double *nodes, const double *weights, const double *to_node, double step, \
        double settled, SIZE n, SIZE free, const SIZE *control, const SIZE *index, const SIZE *fixed, SIZE k,        \
        const SIZE *repeats, SIZE t, const SIZE *stops, const double *start, const double *given, const double *sign, \
        const double *wanted, const double *ends, const double *least, double near, const double *apart,              \
        const double *links, double straight, double near_apart, SIZE most, SIZE added, watcher *watch, double *told, \
        double *more_room, double *more_slope, double *room, SIZE *whole
#define THE_MOTION                                                                                                   \
    {                                                                                                                \
        .swimmer = swimmer, .rule = {stages, nodes, weights, to_node, step, settled}, .n = n, .free = free,          \
        .equations = 6 + 6 * t, .most = most, .added = added, .control = control, .index = index, .fixed = fixed,    \
        .k = k, .t = t, .repeats = repeats, .stops = stops, .start = start, .given = given, .sign = sign,            \
        .wanted = wanted, .ends = ends, .least = least, .near = near, .apart = apart, .links = links,                \
        .straight = straight, .near_apart = near_apart, .watch = watch, .told = told, .more_room = more_room,        \
        .more_slope = more_slope                                                                                     \
    }

/* Free angles of less joint travel, at which what is missing and limits broken, at a price, count as joint travel.
 *
 * control, fixed: see `purcell_bend_rooms`. index, sign, given: of each of n primitives its free angle, -1 for none, its
 * sign, and its angle where it has none. repeats, stops, start, wanted, ends: see `purcell_equations`. least: see
 * `purcell_bend_rooms`, as near. apart: null, or `least` of `purcell_clearance_rooms`, and links `numbers`. most: of
 * inequalities; added: of those that come from watch, which is null or is told all angles, (n,), and gives them and their
 * derivatives by free angles. room, whole: to work in, see `purcell_descent_room`.
 * weight: joint travel per free angle. A beginning that misses by `close` or more is moved back first, and given up
 * where it then misses by `astray` or more. worth: a program that promises less than this part of the merit is the last.
 * own, reaches: see `descend`. angle: the free angles, changed. missed: the violations where the programs begin, infinite
 * where it is given up, and where they end.
 * Returns 0, -1 where the watcher stopped it, or the number of a piece that is too long, counted from 1. */
API SIZE purcell_descend(MOTION, const double *weight, double price, double close, double astray, double worth, SIZE steps,
                         SIZE own, const double *reaches, double *angle, double *missed) {
    struct descent d = {.m = THE_MOTION};
    d.m.weight = weight;
    d.m.price = price;
    int given_up = 0;
    begin(&d, room, whole);
    for (SIZE j = 0; j < free; j++) d.there->angle[j] = angle[j];
    SIZE fault = purcell_point_evaluated(&d.m, d.there);
    if (!fault && !(d.there->violation < close)) {
        fault = restore(&d, RETURN_REACH, RESTORED, 0);
        given_up = !(d.there->violation < astray);
    }
    exchange(&d.here, &d.there);
    missed[0] = given_up ? INFINITY : d.here->violation;
    if (!fault && !given_up) fault = descend(&d, steps, own != 0, worth, reaches);
    missed[1] = d.here->violation;
    for (SIZE j = 0; j < free; j++) angle[j] = d.here->angle[j];
    return fault;
}

/* Whether the next step would be half as long, by the derivative that is known (the natural monotonicity test: Deuflhard,
 * Newton methods for nonlinear problems, 2004). Where links are nearly straight a small step rolls the base by much, so
 * what is missing may grow although the arrival is nearer. */
static int nearer(struct descent *d, double reach) {
    const struct motion *m = &d->m;
    double *const next = d->low;
    purcell_bounded_step(m->equations, 0, m->free, d->here->derivative, d->next->residual, NULL, NULL, reach, 0, d->work, next);
    return largest(m->free, next) < 0.5 * largest(m->free, d->step);
}

/* Free angles at which little is missing and no limit is broken, by Newton steps; see `purcell_descend`.
 *
 * enough: what may be missing. reach: the largest change of an angle in a step. patience: rounds without a halved
 * residual, and stuck: steps in a row of which the smallest part or none helps, before it is given up. hopeless: a
 * beginning that misses by more is given up, and so is what still does after `trials` evaluations. most_tried: after
 * so many evaluations of parts of steps whatever is missing is given up. nearly:
 * where less is missing a step is judged by the next one, too.
 * angle: changed. residual, derivative, shapes: there. off: what is missing there. Returns as above. */
API SIZE purcell_approach(MOTION, double enough, double reach, SIZE patience, SIZE stuck,
                          SIZE trials, double hopeless, SIZE most_tried, double nearly, double *angle, double *residual, double *derivative,
                          double *shapes, double *off) {
    struct descent d = {.m = THE_MOTION};
    const struct motion *m = &d.m;
    double best = INFINITY, halved = INFINITY;
    SIZE idle = 0, poor = 0, tried = 1;
    begin(&d, room, whole);
    for (SIZE j = 0; j < free; j++) d.here->angle[j] = angle[j];
    SIZE fault = purcell_point_equations(m, d.here, 1);
    int part = 0;
    for (int round = 0; round < APPROACHING && !fault; round++) {
        struct point *p = d.here;
        double worst = 0.0;
        if ((!p->sloped && (fault = purcell_point_equations(m, p, 1))) || (fault = purcell_point_limits(m, p))) break;
        for (SIZE i = 0; i < p->rooms; i++) worst = p->room[i] < worst ? p->room[i] : worst;
        const double left = p->size < STRICT * -worst ? STRICT * -worst : p->size;
        if (left < best || !round) {
            best = left < best ? left : best;
            for (SIZE j = 0; j < free; j++) angle[j] = p->angle[j];
            for (SIZE i = 0; i < m->equations; i++) residual[i] = p->residual[i];
            for (SIZE i = 0; i < m->equations * free; i++) derivative[i] = p->derivative[i];
            for (SIZE i = 0; i < 18 * (n + 1); i++) shapes[i] = p->shapes[i];
        }
        idle = best < 0.5 * halved ? 0 : idle + 1;
        halved = idle ? halved : best;
        if (best < enough || idle > patience || poor > stuck || !free) break;
        if ((left > hopeless && (!round || tried >= trials)) || tried > most_tried) break;
        const SIZE rooms = purcell_point_slopes(m, p, PASSING, d.left, d.kept);
        purcell_bounded_step(m->equations, rooms, free, p->derivative, p->residual, d.left, d.kept, reach,
                             !(COARSE * left < enough), d.work, d.step);
        const int whole_before = !part; /* then this one may be, too */
        for (part = 0; part < PARTS; part++, tried++) {
            for (SIZE j = 0; j < free; j++) d.next->angle[j] = p->angle[j] + parts[part] * d.step[j];
            if ((fault = purcell_point_equations(m, d.next, whole_before && !part)) || d.next->size < p->size) break;
            if (!part && p->size < nearly && nearer(&d, reach)) {
                idle--;
                break;
            }
        }
        poor = part >= PARTS - 1 ? poor + 1 : 0;
        exchange(&d.here, &d.next);
    }
    *off = best;
    return fault;
}
