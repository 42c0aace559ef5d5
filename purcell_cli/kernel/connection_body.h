/* The local connection at nodes of a step, as many of them side by side as a LANE has numbers; `connection.c` includes
 * this for each kind of register. Each node's numbers are the same, whatever stands beside them. */

/* Where the limbs' axes are when they have turned. */
VARIANT void NAMED(turned_axis)(LANE w[3], const LANE start[3], LANE out[3]) {
    const LANE x = DOT(w, w);
    LANE a, b, first[3], second[3];
    a = NONE + purcell_series[SERIES_TERMS - 1][0];
    b = NONE + purcell_series[SERIES_TERMS - 1][1];
    for (int k = SERIES_TERMS - 2; k >= 0; k--) {
        a = a * x + purcell_series[k][0];
        b = b * x + purcell_series[k][1];
    }
    for (int l = 0; l < SIDE_BY_SIDE; l++) {
        if (x[l] <= SERIES_BELOW) continue;
        double c[3];
        purcell_exp_of(x[l], c);
        a[l] = c[0];
        b[l] = c[1];
    }
    CROSS(first, w, start);
    CROSS(second, w, first);
    for (int i = 0; i < 3; i++) out[i] = start[i] + a * first[i] + b * second[i];
}

/* The limbs' axes and rates at two nodes of a step. */
VARIANT void NAMED(node_states)(const struct step *step, LANE time, LANE axes[2][3], LANE rates[2][3]) {
    for (int limb = 0; limb < 2; limb++) {
        const double *u = step->rates[limb];
        LANE turned[3], start[3];
        for (int i = 0; i < 3; i++) {
            rates[limb][i] = NONE + u[i];
            axes[limb][i] = start[i] = NONE + step->axes[limb][i];
            turned[i] = time * u[i];
        }
        if (u[0] != 0.0 || u[1] != 0.0 || u[2] != 0.0) NAMED(turned_axis)(turned, start, axes[limb]);
    }
}

/* P of the frozen shape about the base's centre, its lower half. */
VARIANT void NAMED(resistance)(const struct swimmer *s, LANE axes[2][3], LANE p[6][6]) {
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++) p[i][j] = NONE + (i == j ? s->drag[i] : 0.0);
    for (int limb = 0; limb < 2; limb++) {
        const struct limb *l = s->limbs + limb;
        const LANE *a = axes[limb];
        LANE c[3], moment[6];
        for (int i = 0; i < 3; i++) {
            c[i] = (l->side * l->half) * a[i];
            moment[i] = a[i];
        }
        c[0] += l->side * s->half;
        CROSS(moment + 3, c, a);
        for (int i = 0; i < 6; i++) { /* the drag along the axis is less */
            const LANE less = (-l->lateral * l->defect) * moment[i];
            for (int j = 0; j <= i; j++) p[i][j] += less * moment[j];
        }
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const LANE arm = l->lateral * c[i], more = (l->spin - l->turn) * a[i];
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
VARIANT void NAMED(factor)(LANE p[6][6]) {
    for (int j = 0; j < 6; j++) {
        LANE row[6];
        p[j][j] = 1.0 / p[j][j];
        for (int i = j + 1; i < 6; i++) row[i] = p[i][j];
        for (int i = j + 1; i < 6; i++) {
            p[i][j] = row[i] * p[j][j];
            for (int k = j + 1; k <= i; k++) p[i][k] -= p[i][j] * row[k];
        }
    }
}

VARIANT void NAMED(solve)(LANE p[6][6], LANE x[6]) {
    for (int j = 0; j < 5; j++)
        for (int i = j + 1; i < 6; i++) x[i] -= p[i][j] * x[j];
    for (int j = 0; j < 6; j++) x[j] *= p[j][j];
    for (int j = 4; j >= 0; j--)
        for (int i = j + 1; i < 6; i++) x[j] -= p[i][j] * x[i];
}

/* Force and torque about the joint that move a limb with its joint's velocity and a rate. */
VARIANT void NAMED(limb_wrench)(const struct limb *l, const LANE a[3], const LANE velocity[3], const LANE rate[3],
                        LANE wrench[6]) {
    LANE arm[3], at[3], lever[3];
    for (int i = 0; i < 3; i++) arm[i] = (l->side * l->half) * a[i];
    CROSS(at, rate, arm);
    for (int i = 0; i < 3; i++) at[i] += velocity[i];
    const LANE along = l->defect * DOT(a, at), spin = (l->spin - l->turn) * DOT(a, rate);
    for (int i = 0; i < 3; i++) wrench[i] = l->lateral * (at[i] - along * a[i]);
    CROSS(lever, arm, wrench);
    for (int i = 0; i < 3; i++) wrench[3 + i] = lever[i] + l->turn * rate[i] + spin * a[i];
}

/* A wrench about the base's centre from one about a joint. */
VARIANT void NAMED(to_base)(const struct swimmer *s, const struct limb *l, LANE wrench[6]) {
    const double arm = l->side * s->half;
    wrench[4] -= arm * wrench[2];
    wrench[5] += arm * wrench[1];
}

VARIANT void NAMED(unit)(int axis, LANE out[3]) {
    for (int i = 0; i < 3; i++) out[i] = NONE + (i == axis ? 1.0 : 0.0);
}

/* e_axis x v */
VARIANT void NAMED(unit_cross)(int axis, const LANE v[3], LANE out[3]) {
    const int j = (axis + 1) % 3, k = (axis + 2) % 3;
    out[axis] = NONE;
    out[j] = -v[k];
    out[k] = v[j];
}

VARIANT void NAMED(alone)(const struct swimmer *s, LANE axes[2][3], LANE rates[2][3], LANE xi[6], LANE change[6][6],
                  LANE per_rate[6][6], LANE *power) {
    const LANE zero = NONE, rest[3] = {zero, zero, zero};
    LANE p[6][6], wrench[2][6];
    NAMED(resistance)(s, axes, p);
    NAMED(factor)(p);
    for (int limb = 0; limb < 2; limb++) {
        NAMED(limb_wrench)(s->limbs + limb, axes[limb], rest, rates[limb], wrench[limb]);
        NAMED(to_base)(s, s->limbs + limb, wrench[limb]);
    }
    for (int i = 0; i < 6; i++) xi[i] = -(wrench[0][i] + wrench[1][i]);
    NAMED(solve)(p, xi);
    if (power) *power = zero;
    if (!change && !power && !per_rate) return;
    for (int limb = 0; limb < 2; limb++) {
        const struct limb *l = s->limbs + limb;
        const double arm = l->side * s->half;
        const LANE joint[3] = {xi[0], xi[1] + arm * xi[5], xi[2] - arm * xi[4]};
        const LANE spun[3] = {xi[3] + rates[limb][0], xi[4] + rates[limb][1], xi[5] + rates[limb][2]};
        LANE whole[6];
        NAMED(limb_wrench)(l, axes[limb], joint, spun, whole);
        if (power) *power += DOT(whole + 3, rates[limb]);
        /* Turning axis and rate of a limb turns its wrench and the motion it sees; only the base's motion stays.
         * That gives the derivative without differentiating P. */
        for (int axis = 0; change && axis < 3; axis++) {
            LANE velocity[3], rate[3], force[3], torque[3], *out = change[3 * limb + axis];
            NAMED(unit_cross)(axis, joint, velocity);
            NAMED(unit_cross)(axis, xi + 3, rate);
            NAMED(limb_wrench)(l, axes[limb], velocity, rate, out);
            NAMED(unit_cross)(axis, whole, force);
            NAMED(unit_cross)(axis, whole + 3, torque);
            for (int i = 0; i < 3; i++) {
                out[i] -= force[i];
                out[3 + i] -= torque[i];
            }
            NAMED(to_base)(s, l, out);
            NAMED(solve)(p, out);
        }
        for (int axis = 0; per_rate && axis < 3; axis++) {
            LANE rate[3], *out = per_rate[3 * limb + axis];
            NAMED(unit)(axis, rate);
            NAMED(limb_wrench)(l, axes[limb], rest, rate, out);
            NAMED(to_base)(s, l, out);
            for (int i = 0; i < 6; i++) out[i] = -out[i];
            NAMED(solve)(p, out);
        }
    }
}

VARIANT void NAMED(at_nodes)(const struct swimmer *s, const struct step *step, int many, const double *times, int m,
                             const double *weights, double (*twists)[6], double (*changes)[6][6], double (*per_rates)[6][6]) {
    for (int k = 0; k < many; k += SIDE_BY_SIDE) {
        LANE time = NONE, axes[2][3], rates[2][3], xi[6], change[6][6], per_rate[6][6];
        for (int l = 0; l < SIDE_BY_SIDE; l++) time[l] = times[k + l < many ? k + l : many - 1];
        NAMED(node_states)(step, time, axes, rates);
        NAMED(alone)(s, axes, rates, xi, changes ? change : 0, per_rates ? per_rate : 0, 0);
        for (int l = 0; l < SIDE_BY_SIDE && k + l < many; l++) {
            for (int i = 0; i < 6; i++) twists[k + l][i] = xi[i][l];
            if (k + l >= m) continue;
            for (int i = 0; changes && i < 36; i++) changes[k + l][i / 6][i % 6] = weights[k + l] * change[i / 6][i % 6][l];
            for (int i = 0; per_rates && i < 36; i++)
                per_rates[k + l][i / 6][i % 6] = weights[k + l] * per_rate[i / 6][i % 6][l];
        }
    }
}
