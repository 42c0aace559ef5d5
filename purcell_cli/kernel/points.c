/* The equations of a motion's arrival and its limits at a point.
 *
 * A primitive turns by its own angle, or by `sign` times the free angle `index`; one free angle may turn several. */
#include "points.h"

SIZE purcell_point_room(SIZE n, SIZE free, SIZE equations, SIZE most, SIZE added) {
    return free + n + 18 * (n + 1) + equations + equations * free + 7 * most + added * free;
}

void purcell_point_of(const struct motion *m, double **room, SIZE **whole, struct point *p) {
    p->angle = taken(room, m->free);
    p->all = taken(room, m->n);
    p->shapes = taken(room, 18 * (m->n + 1));
    p->residual = taken(room, m->equations);
    p->derivative = taken(room, m->equations * m->free);
    p->room = taken(room, m->most);
    p->torque = taken(room, 6 * m->most);
    p->slope = taken(room, m->added * m->free);
    p->of = whole_taken(whole, m->most);
    p->stop = whole_taken(whole, m->most);
    p->kind = whole_taken(whole, m->most);
}

/* Derivatives by the free angles, of those by the angles of all primitives. */
static void by_free(const struct motion *m, const double *columns, SIZE rows, double *out) {
    for (SIZE i = 0; i < rows * m->free; i++) out[i] = 0.0;
    for (SIZE i = 0; i < rows; i++, columns += m->n, out += m->free)
        for (SIZE p = 0; p < m->n; p++)
            if (m->index[p] >= 0) out[m->index[p]] += m->sign[p] * columns[p];
}

SIZE purcell_point_equations(const struct motion *m, struct point *p, int sloped) {
    for (SIZE q = 0; q < m->n; q++) p->all[q] = m->index[q] < 0 ? m->given[q] : m->sign[q] * p->angle[m->index[q]];
    const SIZE long_piece = purcell_equations(m->swimmer, m->rule.stages, m->rule.nodes, m->rule.weights, m->rule.to_node,
                                              m->rule.step, m->rule.settled, m->n, m->start, m->control, p->all, m->k,
                                              m->repeats, m->wanted, m->t, m->stops, m->ends, m->flow, p->shapes,
                                              p->residual, !sloped ? 0 : m->plain ? p->derivative : m->columns);
    p->sloped = sloped;
    if (sloped && !m->plain) by_free(m, m->columns, m->equations, p->derivative);
    p->size = largest(m->equations, p->residual);
    return long_piece;
}

/* Which rooms are of primitives at angle zero; one kind of room after the other. */
static void find_idle(struct point *p, SIZE first, const SIZE *control) {
    SIZE later[2] = {-1, -1}; /* the next room that is the same while angles are zero, by the limb that it is of */
    for (SIZE i = p->rooms - 1; i >= first; i--) {
        const SIZE primitive = p->of[i];
        const int limb = control ? LIMB_OF(control[primitive]) : 0, idle = p->all[primitive] == 0.0;
        int passing = idle && later[limb] >= 0;
        for (SIZE q = primitive + 1; passing && q <= later[limb]; q++) passing = p->all[q] == 0.0;
        p->kind[i] = !idle ? TURNING : passing ? PASSING : IDLE;
        later[limb] = primitive;
    }
}

SIZE purcell_point_limits(const struct motion *m, struct point *p) {
    p->rooms = purcell_bend_rooms(m->n, m->control, p->all, p->shapes, m->least, m->fixed, m->near, p->room, p->of, p->stop,
                                  p->torque);
    find_idle(p, 0, m->control);
    if (m->apart) {
        const SIZE first = p->rooms;
        p->rooms += purcell_clearance_rooms(m->n, m->control, p->all, p->shapes, m->apart, m->links, m->straight,
                                            m->near_apart, m->cut, p->room + first, p->of + first, p->stop + first,
                                            p->torque + 6 * first);
        find_idle(p, first, 0);
    }
    p->known = p->rooms;
    p->turning = 0;
    for (SIZE i = 0; i < p->rooms; i++) p->turning += p->kind[i] == TURNING;
    if (!m->watch) return 0;
    for (SIZE i = 0; m->added && i < m->n; i++) m->told[i] = p->all[i];
    const SIZE more = m->watch();
    if (more < 0 || more > m->added) return -1;
    for (SIZE i = 0; i < more; i++) {
        p->room[p->rooms] = m->more_room[i];
        p->kind[p->rooms++] = TURNING;
        p->turning++;
    }
    for (SIZE i = 0; i < more * m->free; i++) p->slope[i] = m->more_slope[i];
    return 0;
}

SIZE purcell_point_slopes(const struct motion *m, const struct point *p, SIZE last_kind, double *room, double *slope) {
    SIZE j = 0;
    purcell_turning_axes(m->n, m->control, p->shapes, m->axes);
    for (SIZE kind = TURNING; kind <= last_kind; kind++)
        for (SIZE i = 0; i < p->rooms; i++) {
            if (p->kind[i] != kind) continue;
            double *const out = slope + j * m->free, *const columns = m->plain ? out : m->columns;
            const SIZE added = i - p->known;
            room[j++] = p->room[i];
            for (SIZE u = 0; added >= 0 && u < m->free; u++) out[u] = p->slope[added * m->free + u];
            if (added >= 0) continue;
            purcell_room_slope(p->stop[i], p->torque + 6 * i, m->n, m->control, p->shapes, m->axes, columns);
            if (!m->plain) by_free(m, columns, 1, out);
        }
    return j;
}

SIZE purcell_point_evaluated(const struct motion *m, struct point *p) {
    const SIZE fault = purcell_point_equations(m, p, 0);
    if (fault) return fault;
    if (purcell_point_limits(m, p) < 0) return -1;
    double missed = 0.0, broken = 0.0, travel = 0.0;
    for (SIZE i = 0; i < m->equations; i++) missed += fabs(p->residual[i]);
    for (SIZE i = 0; i < p->rooms; i++) broken += p->kind[i] == TURNING && p->room[i] < 0.0 ? p->room[i] : 0.0;
    for (SIZE j = 0; j < m->free; j++) travel += m->weight[j] * fabs(p->angle[j]);
    p->violation = missed - broken;
    p->merit = travel + m->price * p->violation;
    return 0;
}
