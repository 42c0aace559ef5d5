/* The flow on a step by Gauss collocation, from the twists at its nodes: of steps side by side, as many as a LANE has
 * numbers, each as it would be alone. `collocation.c` includes this for one step, `connection.c` for each kind of register. */

/* v turned by an almost unit quaternion q = (scalar, vector). */
VARIANT void NAMED(turned)(const LANE q[4], const LANE v[3], LANE out[3]) {
    LANE across[3], twice[3];
    CROSS(across, q + 1, v);
    for (int i = 0; i < 3; i++) across[i] *= 2.0;
    CROSS(twice, q + 1, across);
    for (int i = 0; i < 3; i++) out[i] = v[i] + q[0] * across[i] + twice[i];
}

VARIANT void NAMED(matrix)(const LANE q[4], LANE out[9]) {
    const LANE b = 2.0 * q[0], *w = q + 1;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[4 * i] = 1.0 - 2.0 * (w[j] * w[j] + w[k] * w[k]);
        out[3 * i + j] = 2.0 * (w[i] * w[j]) - b * w[k];
        out[3 * i + k] = 2.0 * (w[i] * w[k]) + b * w[j];
    }
}

/* The quaternions at the nodes, by Picard iteration: the error falls faster than any power, by |omega / 2|^k / k!. A step
 * that has settled stays as it is. */
VARIANT inline __attribute__((always_inline)) void NAMED(oriented)(const int m, const struct rule *rule, LANE half[][3],
                                                                   LANE q[][4]) {
    const double *to_node = rule->to_node;
    LANE slope[MOST_STAGES][4], before[MOST_STAGES][4], change[MOST_STAGES][3];
    int settled[SIDE_BY_SIDE] = {0}, open = SIDE_BY_SIDE;
    for (int k = 0; k < m; k++) {
        q[k][0] = NONE + 1.0;
        for (int i = 0; i < 3; i++) {
            LANE sum = to_node[k * m] * half[0][i];
            for (int j = 1; j < m; j++) sum += to_node[k * m + j] * half[j][i];
            q[k][1 + i] = sum;
        }
    }
    for (int round = 0; open && round < MOST_ITERATIONS; round++) {
        for (int k = 0; k < m; k++) {
            for (int i = 0; i < 4; i++) before[k][i] = q[k][i];
            slope[k][0] = DOT(q[k] + 1, half[k]);
        }
        for (int k = 0; k < m; k++) {
            LANE sum = to_node[k * m] * slope[0][0];
            for (int j = 1; j < m; j++) sum += to_node[k * m + j] * slope[j][0];
            q[k][0] = 1.0 - sum;
        }
        for (int k = 0; k < m; k++) {
            CROSS(slope[k] + 1, q[k] + 1, half[k]);
            for (int i = 0; i < 3; i++) slope[k][1 + i] += q[k][0] * half[k][i];
        }
        for (int k = 0; k < m; k++)
            for (int i = 0; i < 3; i++) {
                LANE sum = to_node[k * m] * slope[0][1 + i];
                for (int j = 1; j < m; j++) sum += to_node[k * m + j] * slope[j][1 + i];
                change[k][i] = sum - q[k][1 + i];
                q[k][1 + i] = sum;
            }
        open = 0;
        for (int l = 0; l < SIDE_BY_SIDE; l++) {
            double changed = 0.0;
            for (int k = 0; settled[l] && k < m; k++)
                for (int i = 0; i < 4; i++) OF(q[k][i], l) = OF(before[k][i], l);
            for (int k = 0; !settled[l] && k < m; k++)
                for (int i = 0; i < 3; i++) {
                    const double by = fabs(OF(change[k][i], l));
                    changed = by > changed ? by : changed;
                }
            settled[l] = settled[l] || changed < rule->settled;
            open += !settled[l];
        }
    }
}

/* The displacement: where the step ends, an orientation and a position.
 *
 * velocity, half: the twists' linear parts and half their angular parts at the nodes, times the duration; the velocities
 * become what is seen from the step's beginning. q: the orientations at the nodes. */
VARIANT inline __attribute__((always_inline)) void NAMED(displaced)(const int m, const struct rule *rule,
                                                                    LANE velocity[][3], LANE half[][3], LANE q[][4],
                                                                    LANE rotation[9], LANE position[3]) {
    LANE end[4] = {NONE + 1.0, NONE, NONE, NONE};
    NAMED(oriented)(m, rule, half, q);
    for (int i = 0; i < 3; i++) position[i] = NONE;
    for (int k = 0; k < m; k++) {
        LANE across[3], moved[3];
        const double weight = rule->weights[k];
        CROSS(across, q[k] + 1, half[k]);
        end[0] -= weight * DOT(q[k] + 1, half[k]);
        NAMED(turned)(q[k], velocity[k], moved);
        for (int i = 0; i < 3; i++) {
            end[1 + i] += weight * (q[k][0] * half[k][i] + across[i]);
            position[i] += weight * moved[i];
            velocity[k][i] = moved[i];
        }
    }
    LANE size = end[0] * end[0] + end[1] * end[1] + end[2] * end[2] + end[3] * end[3];
    for (int l = 0; l < SIDE_BY_SIDE; l++) OF(size, l) = sqrt(OF(size, l));
    for (int i = 0; i < 4; i++) end[i] /= size;
    NAMED(matrix)(end, rotation);
}

/* The pose at node k, from what `displaced` leaves. */
VARIANT inline __attribute__((always_inline)) void NAMED(at_node)(const int m, const struct rule *rule, int k,
                                                                  LANE velocity[][3], LANE q[][4], LANE rotation[9],
                                                                  LANE position[3]) {
    NAMED(matrix)(q[k], rotation);
    for (int i = 0; i < 3; i++) {
        LANE sum = rule->to_node[k * m] * velocity[0][i];
        for (int j = 1; j < m; j++) sum += rule->to_node[k * m + j] * velocity[j][i];
        position[i] = sum;
    }
}

/* To a sum changes of the twist at a node are added, seen from the step's beginning: column c is of change[c]. */
VARIANT inline void NAMED(add_carried)(const LANE rotation[9], const LANE position[3], LANE change[6][6],
                                       LANE *restrict sum) {
    for (int c = 0; c < 6; c++) {
        const LANE *x = change[c];
        LANE v[3], w[3], arm[3];
        for (int i = 0; i < 3; i++) {
            v[i] = DOT(rotation + 3 * i, x);
            w[i] = DOT(rotation + 3 * i, x + 3);
        }
        CROSS(arm, position, w);
        for (int i = 0; i < 3; i++) {
            sum[6 * i + c] += v[i] + arm[i];
            sum[6 * (3 + i) + c] += w[i];
        }
    }
}
