/* The flow of a whole sequence with its derivatives by every angle. */
#include "kernel.h"
#include "small.h"

static void transform(const double matrix[36], const double x[6], double out[6]) { product(matrix, x, out, 6, 6, 1); }

/* rotation(w), or J with rotation(w + dw) = rotation(J dw) rotation(w) to leading order. */
static void about(const double w[3], int left_jacobian, double out[9]) {
    double c[3];
    purcell_exp_of(DOT(w, w), c);
    const double a = c[left_jacobian], b = c[left_jacobian + 1], square = DOT(w, w);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[4 * i] = 1.0 + b * (w[i] * w[i] - square);
        out[3 * i + j] = b * (w[i] * w[j]) - a * w[k];
        out[3 * i + k] = b * (w[i] * w[k]) + a * w[j];
    }
}

/* Columns by the rotation vectors of one limb and the other as columns by others: out = [m_1 t_1, m_2 t_2]. */
static void by_limb(const double m[36], const double t[18], double out[36]) {
    for (int i = 0; i < 6; i++)
        for (int c = 0; c < 6; c++) {
            const double *row = m + 6 * i + 3 * (c / 3), *column = t + 9 * (c / 3) + c % 3;
            out[6 * i + c] = row[0] * column[0] + row[1] * column[3] + row[2] * column[6];
        }
}

struct chain {
    const struct swimmer *s;
    const struct rule *rule;
    int moves;            /* whether pieces are moves, not primitives */
    int based;            /* the limb that the piece turns about the base's z, or -1 */
    wide_pose here, once; /* from the path's start and from the repeat's */
    int plain;            /* whether a flow is so rough that it is put together in doubles: `at`, `once_at` */
    double at[16], once_at[16];
    double pitch_axis[3]; /* that limb's own y where the piece begins */
    int repeating;
    double *total, *own;  /* of the piece: what turning limbs changes on it, and what its own turn does */
    struct known known;
    lane given[GIVEN]; /* of links that feel each other, where a piece ends */
    struct solved solved;
    struct queue queue;
};

/* What a limb's pitch changes while the limb turns about the base's z: its shape turns about its own y, which turns with
 * it, but its rate stays along z. In place of the changes by turns of the limb about x, y, z, its rate with it. */
static void by_pitch(struct chain *c, const struct step *step) {
    const int limb = c->based;
    const double rate = step->rates[limb][2];
    for (SIZE k = 0; k < c->rule->stages; k++) {
        const double part = step->start + c->rule->nodes[k] * step->duration;
        const double turned[3] = {0.0, 0.0, part * rate};
        double rotation[9], n[3], changed[6];
        about(turned, 0, rotation);
        product(rotation, c->pitch_axis, n, 3, 3, 1);
        for (int i = 0; i < 6; i++) {
            double sum = rate * (c->solved.per_rate[k][3 * limb + 1][i] * n[0] - c->solved.per_rate[k][3 * limb][i] * n[1]);
            for (int j = 0; j < 3; j++) sum += c->solved.change[k][3 * limb + j][i] * n[j];
            changed[i] = sum;
        }
        for (int j = 0; j < 6; j++)
            for (int i = 0; i < 6; i++) c->solved.change[k][j][i] = j == limb ? changed[i] : 0.0;
    }
}

/* The twists for a unit rate of limb i about axis j of the base at two shapes, [3 i + j]; of links that do not feel each
 * other. */
static void all_rates(const struct chain *c, const double *shape, const double *other, double out[LANES][6][6]) {
    lane axes[2][3], rates[2][3], xi[6], per_rate[6][6];
    for (int i = 0; i < 6; i++) {
        const int at = 9 * (i / 3) + 3 * (i % 3);
        axes[i / 3][i % 3] = (lane){shape[at], other[at]};
        rates[i / 3][i % 3] = (lane){0.0, 0.0};
    }
    purcell_connection(c->s, axes, rates, 0, xi, 0, per_rate, 0);
    for (int l = 0; l < LANES; l++)
        for (int i = 0; i < 36; i++) out[l][i / 6][i % 6] = per_rate[i / 6][i % 6][l];
}

/* The twist at the end of a primitive of links that feel each other. */
static void ending(const struct chain *c, const double *shape, SIZE control, double sign, SIZE steps, double out[6]) {
    const int limb = LIMB_OF(control), axis = (int)(control % 3);
    lane axes[2][3], rates[2][3], xi[6], given[GIVEN];
    double at_end[2][3], rate[2][3], found[GIVEN];
    for (int i = 0; i < 6; i++) {
        const double along = control >= BASE_YAW ? i % 3 == 2 : shape[9 * limb + 3 * (i % 3) + axis];
        const double u = i / 3 == limb ? along : 0.0;
        at_end[i / 3][i % 3] = shape[18 + 9 * (i / 3) + 3 * (i % 3)];
        axes[i / 3][i % 3] = (lane){0.0, 0.0} + at_end[i / 3][i % 3];
        rates[i / 3][i % 3] = (lane){u, u};
        rate[i / 3][i % 3] = u;
    }
    if (!steps) purcell_at_shape(c->s, at_end, rate, 0, 0, found);
    for (int e = 0; e < PULL; e++) given[e] = steps ? c->given[e] : (lane){found[e], found[e]};
    purcell_connection(c->s, axes, rates, given, xi, 0, 0, 0);
    for (int i = 0; i < 6; i++) out[i] = steps ? sign * xi[i][0] : xi[i][0]; /* of the rate as it was played */
}

static void go_on(double at[16], const double by[16]) {
    double pose[16];
    for (int i = 0; i < 16; i++) pose[i] = at[i];
    product(pose, by, at, 4, 4, 4);
}

static void put_on(struct chain *c, const double pose[16]) {
    if (c->plain) {
        go_on(c->at, pose);
        if (c->repeating) go_on(c->once_at, pose);
    } else {
        purcell_wide_times(&c->here, pose);
        if (c->repeating) purcell_wide_times(&c->once, pose);
    }
}

/* Changes that are seen from where a step begins are added to those that are seen from where the path does. */
static void add_seen(const struct chain *c, const double seen[36], double *sum) {
    double pose[16], ad[36], moved[36];
    for (int i = 0; c->plain && i < 16; i++) pose[i] = c->at[i];
    if (!c->plain) purcell_wide_round(&c->here, pose);
    adjoint(pose, ad);
    product(ad, seen, moved, 6, 6, 6);
    for (int i = 0; i < 36; i++) sum[i] += moved[i];
}

/* g^n put on, by doubling; g is spoilt. */
static void go_on_often(double at[16], double g[16], SIZE cycles) {
    double square[16];
    for (SIZE left = cycles; left > 0; left /= 2) {
        if (left % 2) go_on(at, g);
        product(g, g, square, 4, 4, 4);
        purcell_orthonormalise(1, 4, square);
        for (int i = 0; i < 16; i++) g[i] = square[i];
    }
}

/* A step of a path of which no derivative is wanted. */
static void pass(const struct step *step, void *state) {
    struct chain *c = state;
    purcell_solve_step(c->s, c->rule, step, DISPLACEMENT, &c->solved);
    put_on(c, c->solved.pose);
}

static void link(const struct step *step, void *state) {
    struct chain *c = state;
    double seen[36];
    purcell_solve_step(c->s, c->rule, step, c->moves || c->based >= 0 ? PER_RATE : CHANGE, &c->solved);
    if (step->field && !c->moves) {
        const double end = step->start + step->duration;
        purcell_of_field(step->field, (lane){end, end}, 0, c->given);
    }
    purcell_carried(&c->solved, c->rule->stages, c->solved.change, seen);
    add_seen(c, seen, c->total);
    /* Changing a turn by dv turns the limb, a part s into the move, by J(s u) s A dv in the base frame, and adds the
     * turned A dv to its rate. */
    for (SIZE k = 0; c->moves && k < c->rule->stages; k++) {
        const double part = step->start + c->rule->nodes[k] * step->duration;
        double changed[6][6];
        for (int limb = 0; limb < 2; limb++) {
            double turned[3], turning[9], rotation[9];
            for (int i = 0; i < 3; i++) turned[i] = part * step->rates[limb][i];
            about(turned, 1, turning);
            about(turned, 0, rotation);
            for (int j = 0; j < 3; j++)
                for (int i = 0; i < 6; i++) {
                    double sum = 0.0;
                    for (int r = 0; r < 3; r++)
                        sum += c->solved.change[k][3 * limb + r][i] * (part * turning[3 * r + j]) +
                               c->solved.per_rate[k][3 * limb + r][i] * rotation[3 * r + j];
                    changed[3 * limb + j][i] = sum;
                }
        }
        for (int i = 0; i < 36; i++) c->solved.change[k][i / 6][i % 6] = changed[i / 6][i % 6];
    }
    if (c->moves) {
        purcell_carried(&c->solved, c->rule->stages, c->solved.change, seen);
        add_seen(c, seen, c->own);
    }
    if (c->based >= 0) {
        by_pitch(c, step);
        purcell_carried(&c->solved, c->rule->stages, c->solved.change, seen);
        add_seen(c, seen, c->own);
    }
    put_on(c, c->solved.pose);
}

/* 1 + Ad_g + ... + Ad_g^(n-1), by doubling. */
static void power_sum(const double g[16], SIZE cycles, double total[36]) {
    double power[36], block[36], done[36], made[36];
    adjoint(g, power);
    identity(block, 6);
    identity(done, 6);
    for (int i = 0; i < 36; i++) total[i] = 0.0;
    for (SIZE left = cycles; left > 0; left /= 2) {
        if (left % 2) {
            product(done, block, made, 6, 6, 6);
            for (int i = 0; i < 36; i++) total[i] += made[i];
            product(done, power, made, 6, 6, 6);
            for (int i = 0; i < 36; i++) done[i] = made[i];
        }
        product(power, block, made, 6, 6, 6);
        for (int i = 0; i < 36; i++) block[i] += made[i];
        product(power, power, made, 6, 6, 6);
        for (int i = 0; i < 36; i++) power[i] = made[i];
    }
}

/* What piece p does from a shape: the rates, and how long it lasts. */
static double played(const SIZE *control, const double *amount, const double *shape, SIZE p, double rate[6]) {
    if (!control) {
        for (int i = 0; i < 6; i++) rate[i] = amount[6 * p + i];
        return 1.0;
    }
    for (int i = 0; i < 6; i++) rate[i] = 0.0;
    const double sign = amount[p] < 0.0 ? -1.0 : 1.0;
    const int limb = LIMB_OF(control[p]);
    if (control[p] < BASE_YAW) rate[control[p]] = sign;
    else
        for (int i = 0; i < 3; i++) rate[3 * limb + i] = sign * shape[9 * limb + 6 + i];
    return amount[p] < 0.0 ? -amount[p] : amount[p];
}

/* Solves the steps of the next pieces together, as far as there is room and no more than their changes is wanted of them.
 * Returns the first piece of which none is. */
static SIZE solve_ahead(struct chain *c, SIZE p, SIZE n, const double *shapes, const SIZE *control, const double *amount,
                        int slopes) {
    struct queue *const q = &c->queue;
    q->stored = 0;
    for (; p < n && c->s->tables == 0.0 && !(slopes && (c->moves || control[p] >= BASE_YAW)); p++) {
        double rate[6];
        const double duration = played(control, amount, shapes + 18 * p, p, rate);
        if (!purcell_queued(q, c->s, c->rule, p, shapes + 18 * p, rate, duration, &c->known)) break;
    }
    purcell_solve_steps(c->s, c->rule, q->stored, q->steps, slopes, q->travelled);
    return p;
}

/* The displacement along n pieces and its derivatives, as body twists at the end.
 *
 * Lengthening a primitive turns the limb's whole later path by a constant rotation in the base frame, about the axis
 * that the limb turned on. So one pass that carries six such rotations back from the end gives all derivatives. The
 * pitch of a limb that turns about the base's z too is another matter: it turns the later path about the limb's own y,
 * wherever that is, so that is carried back as well, one column a limb. A part
 * that is repeated costs one cycle: the others are conjugate to it. Its own angles may only change together, so that
 * it still closes; what they do within a cycle is then all they do.
 *
 * shapes: before, between and after the pieces. (n + 1, 2, 3, 3).
 * control, amount: of primitives their controls and angles, (n,) and (n,); of moves null and their turns, (n, 6).
 * repeats: first piece, the piece after the last, cycles, in order. (k, 3).
 * room: to work in. (n, 88), (n, 6) after that and, for repeats, (k, 36).
 * pose, derivative: (4, 4), and (6, n) or (6, n, 6); null where no derivative is wanted, which takes half of the time.
 * Returns 0, or the number of a piece that is too long, counted from 1. */
API SIZE purcell_flow_and_derivatives(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                                      const double *to_node, double step, double settled, SIZE n, const double *shapes,
                                      const SIZE *control, const double *amount, SIZE k, const SIZE *repeats,
                                      double *room, double *pose, double *derivative) {
    const struct rule rule = {stages, nodes, weights, to_node, step, settled};
    struct chain c;
    const struct queue *const q = &c.queue;
    c.s = (const struct swimmer *)swimmer;
    c.rule = &rule;
    c.moves = control == 0;
    c.queue.full = 0;
    c.repeating = 0;
    c.known.limb = -1;
    double *const spread = room + 94 * n, begun[16], once[16], there[16], ad[36], back[36], sum[36], made[36];
    const int columns = control ? 1 : 6, slopes = derivative != 0;
    const enum wanted most = c.moves ? PER_RATE : CHANGE;
    double standing[LANES][6][6];
    SIZE later = -1; /* the primitive from which the second of them counts */
    SIZE r = 0, solved = 0, done = 0; /* up to which piece steps are solved, and how many of them are put on */
    purcell_wide_identity(&c.here);
    c.plain = stages <= ROUGH_STAGES;
    identity(c.at, 4);
    for (SIZE p = 0; p < n; p++) {
        if (p >= solved) {
            solved = solve_ahead(&c, p, n, shapes, control, amount, slopes);
            done = 0;
        }
        c.based = control && control[p] >= BASE_YAW ? LIMB_OF(control[p]) : -1;
        for (int i = 0; c.based >= 0 && i < 3; i++) c.pitch_axis[i] = shapes[18 * p + 9 * c.based + 3 * i + 1];
        if (r < k && p == repeats[3 * r]) {
            c.repeating = 1;
            purcell_wide_identity(&c.once);
            identity(c.once_at, 4);
            purcell_wide_round(&c.here, begun);
            for (int i = 0; c.plain && i < 16; i++) begun[i] = c.at[i];
        }
        c.total = room + 88 * p;
        c.own = c.total + 36;
        for (int i = 0; slopes && i < 72; i++) c.total[i] = 0.0;
        SIZE steps = 0;
        for (; p < solved && done < q->stored && q->of[done] == p; done++, steps++) {
            if (slopes) add_seen(&c, q->travelled[done].seen, c.total);
            put_on(&c, q->travelled[done].pose);
        }
        const double *ended = steps ? q->travelled[done - 1].ending : c.solved.ending;
        if (p >= solved) {
            double rate[6];
            const double duration = played(control, amount, shapes + 18 * p, p, rate);
            steps = purcell_mesh(c.s, &rule, shapes + 18 * p, rate, duration,
                                 !slopes ? DISPLACEMENT : c.based >= 0 ? PER_RATE : most, &c.known, slopes ? link : pass, &c);
            if (steps < 0) return p + 1;
        }
        const double sign = control && amount[p] < 0.0 ? -1.0 : 1.0;
        double *const end = room + 88 * n + 6 * p;
        if (slopes && control && c.s->tables > 0.0) {
            ending(&c, shapes + 18 * p, control[p], sign, steps, end);
        } else if (slopes && control && steps) {
            for (int i = 0; i < 6; i++) end[i] = sign * ended[i];
        } else if (slopes && control) {
            /* Primitives that turn by nothing, offered in case that they may, all stand at one shape. */
            const int limb = LIMB_OF(control[p]), axis = (int)(control[p] % 3);
            if ((!p || amount[p - 1] != 0.0) && p != later) {
                later = p + 1; /* where such primitives begin next */
                while (later < n && (amount[later] != 0.0 || amount[later - 1] == 0.0)) later++;
                if (later == n) later = p;
                all_rates(&c, shapes + 18 * p, shapes + 18 * later, standing);
            }
            const int second = p >= later;
            for (int i = 0; i < 6; i++) {
                end[i] = 0.0;
                for (int j = 0; j < 3; j++)
                    end[i] += standing[second][3 * limb + j][i] *
                              (control[p] >= BASE_YAW ? j == 2 : shapes[18 * p + 9 * limb + 3 * j + axis]);
            }
        }
        if (steps > 0 && !c.plain) purcell_wide_normalise(&c.here);
        if (!c.plain) purcell_wide_round(&c.here, c.total + 72);
        for (int i = 0; c.plain && i < 16; i++) c.total[72 + i] = c.at[i];
        if (r < k && p + 1 == repeats[3 * r + 1]) {
            const SIZE again = repeats[3 * r + 2] - 1;
            if (c.plain) {
                purcell_orthonormalise(1, 4, c.once_at);
                for (int i = 0; i < 16; i++) once[i] = c.once_at[i];
                go_on_often(c.at, c.once_at, again);
            } else {
                wide_pose rest;
                purcell_wide_normalise(&c.once);
                purcell_wide_round(&c.once, once);
                purcell_wide_power(&c.once, again, &rest);
                purcell_wide_product(&c.here, &rest, &c.here);
            }
            c.repeating = 0;
            r++;
            if (!slopes) continue;
            adjoint(begun, ad);
            inverse_pose(begun, there);
            adjoint(there, back);
            power_sum(once, repeats[3 * r - 1], sum);
            product(ad, sum, made, 6, 6, 6);
            product(made, back, spread + 36 * (r - 1), 6, 6, 6);
        }
    }
    if (c.plain) {
        purcell_orthonormalise(1, 4, c.at);
        for (int i = 0; i < 16; i++) pose[i] = c.at[i];
    } else {
        purcell_wide_normalise(&c.here);
        purcell_wide_round(&c.here, pose);
    }
    if (!slopes) return 0;
    inverse_pose(pose, there);
    adjoint(there, back);
    double outside[36] = {0.0}, inside[36] = {0.0};
    double pitched_outside[12] = {0.0}, pitched_inside[12] = {0.0};  /* by the pitch of limb 1, limb 2: rows of two */
    int universal[2] = {0, 0};
    for (SIZE p = 0; control && p < n; p++)
        if (control[p] >= BASE_YAW) universal[LIMB_OF(control[p])] = 1;
    for (SIZE p = n - 1; p >= 0; p--) {
        const double *total = room + 88 * p, *own = total + 36, *end = total + 72, *shape = shapes + 18 * p;
        while (r > 0 && p < repeats[3 * r - 3]) r--;
        if (r > 0 && p + 1 == repeats[3 * r - 2]) {
            for (int i = 0; i < 36; i++) inside[i] = 0.0;
            for (int i = 0; i < 12; i++) pitched_inside[i] = 0.0;
        }
        const double *all = r > 0 && p < repeats[3 * r - 2] ? spread + 36 * (r - 1) : 0;
        const double *later = all ? inside : outside;
        double column[36], seen[36];
        if (control) {
            const int limb = LIMB_OF(control[p]), based = control[p] >= BASE_YAW, axis = (int)(control[p] % 3);
            double n_k[3];
            for (int i = 0; i < 3; i++) n_k[i] = based ? i == 2 : shape[9 * limb + 3 * i + axis];
            adjoint(end, ad);
            transform(ad, room + 88 * n + 6 * p, column);
            const double *pitched = all ? pitched_inside : pitched_outside;
            for (int i = 0; i < 6; i++)
                column[i] += universal[limb] && !based ? pitched[2 * i + limb] : DOT(later + 6 * i + 3 * limb, n_k);
            for (int l = 0; l < 2; l++)
                if (universal[l]) {
                    double made_l[6], by[6];
                    for (int i = 0; i < 6; i++) {
                        const double own_y[3] = {shape[9 * l + 1], shape[9 * l + 4], shape[9 * l + 7]};
                        by[i] = based && l == limb ? own[6 * i + l] : DOT(total + 6 * i + 3 * l, own_y);
                    }
                    if (all) transform(all, by, made_l);
                    for (int i = 0; i < 6; i++) {
                        pitched_outside[2 * i + l] += all ? made_l[i] : by[i];
                        if (all) pitched_inside[2 * i + l] += by[i];
                    }
                }
        } else {
            double turn[18], shifted[36];
            for (int limb = 0; limb < 2; limb++) {
                double w[3];
                product(shape + 9 * limb, amount + 6 * p + 3 * limb, w, 3, 3, 1);
                about(w, 1, turn + 9 * limb);
            }
            by_limb(later, turn, shifted);
            for (int i = 0; i < 36; i++) shifted[i] += own[i];
            by_limb(shifted, shape, column);
        }
        if (all) {
            product(all, column, made, 6, 6, columns);
            product(back, made, seen, 6, 6, columns);
            product(all, total, made, 6, 6, 6);
            for (int i = 0; i < 36; i++) inside[i] += total[i];
        } else {
            product(back, column, seen, 6, 6, columns);
            for (int i = 0; i < 36; i++) made[i] = total[i];
        }
        for (int i = 0; i < 36; i++) outside[i] += made[i];
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < columns; j++) derivative[(i * n + p) * columns + j] = seen[i * columns + j];
    }
    return 0;
}
