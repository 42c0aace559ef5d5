/* Steps of a flow side by side, as many as a LANE has numbers, each as `solve_step` in `collocation.c` solves it;
 * `connection.c` includes this for each kind of register. */

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

/* The quaternions at the nodes, by Picard iteration. A step that has settled stays as it is. */
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
                for (int i = 0; i < 4; i++) q[k][i][l] = before[k][i][l];
            for (int k = 0; !settled[l] && k < m; k++)
                for (int i = 0; i < 3; i++) {
                    const double by = fabs(change[k][i][l]);
                    changed = by > changed ? by : changed;
                }
            settled[l] = settled[l] || changed < rule->settled;
            open += !settled[l];
        }
    }
}

VARIANT inline __attribute__((always_inline)) void NAMED(some_steps)(const int m, const struct swimmer *s,
                                                                     const struct rule *rule, SIZE many,
                                                                     const struct step *steps, int slopes,
                                                                     struct travelled *out) {
    LANE duration = NONE, start[2][3], rates[2][3], xi[6], velocity[MOST_STAGES][3], half[MOST_STAGES][3], q[MOST_STAGES][4];
    LANE change[MOST_STAGES][6][6], ending[6], seen[36], rotation[9];
    for (int i = 0; i < 6; i++) start[i / 3][i % 3] = rates[i / 3][i % 3] = NONE;
    for (int l = 0; l < SIDE_BY_SIDE; l++) {
        const struct step *step = steps + (l < many ? l : many - 1);
        duration[l] = step->duration;
        for (int i = 0; i < 6; i++) {
            start[i / 3][i % 3][l] = step->axes[i / 3][i % 3];
            rates[i / 3][i % 3][l] = step->rates[i / 3][i % 3];
        }
    }
    for (int k = 0; k < m + (slopes != 0); k++) {
        const LANE time = (k < m ? rule->nodes[k] : 1.0) * duration, weight = (k < m ? rule->weights[k] : 0.0) * duration;
        LANE axes[2][3], turned[3];
        for (int limb = 0; limb < 2; limb++) {
            for (int i = 0; i < 3; i++) turned[i] = time * rates[limb][i];
            NAMED(turned_axis)(turned, start[limb], axes[limb]);
        }
        NAMED(alone)(s, axes, rates, xi, slopes && k < m ? change[k] : 0, 0, 0);
        for (int i = 0; k == m && i < 6; i++) ending[i] = xi[i];
        for (int i = 0; k < m && i < 3; i++) {
            velocity[k][i] = xi[i] * duration;
            half[k][i] = 0.5 * (xi[3 + i] * duration);
        }
        for (int i = 0; slopes && k < m && i < 36; i++) change[k][i / 6][i % 6] *= weight;
    }
    NAMED(oriented)(m, rule, half, q);
    LANE end[4] = {NONE + 1.0, NONE, NONE, NONE}, position[3] = {NONE, NONE, NONE};
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
    for (int l = 0; l < SIDE_BY_SIDE; l++) size[l] = sqrt(size[l]);
    for (int i = 0; i < 4; i++) end[i] /= size;
    NAMED(matrix)(end, rotation);
    for (int l = 0; l < many; l++) {
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) out[l].pose[4 * i + j] = rotation[3 * i + j][l];
            out[l].pose[4 * i + 3] = position[i][l];
            out[l].pose[12 + i] = 0.0;
        }
        out[l].pose[15] = 1.0;
    }
    if (!slopes) return;
    /* The sum over the nodes of changes of the twist, seen from the steps' beginning: column c is of change[.][c]. */
    for (int i = 0; i < 36; i++) seen[i] = NONE;
    for (int k = 0; k < m; k++) {
        LANE at[3];
        NAMED(matrix)(q[k], rotation);
        for (int i = 0; i < 3; i++) {
            at[i] = rule->to_node[k * m] * velocity[0][i];
            for (int j = 1; j < m; j++) at[i] += rule->to_node[k * m + j] * velocity[j][i];
        }
        for (int c = 0; c < 6; c++) {
            const LANE *x = change[k][c];
            LANE v[3], w[3], arm[3];
            for (int i = 0; i < 3; i++) {
                v[i] = DOT(rotation + 3 * i, x);
                w[i] = DOT(rotation + 3 * i, x + 3);
            }
            CROSS(arm, at, w);
            for (int i = 0; i < 3; i++) {
                seen[6 * i + c] += v[i] + arm[i];
                seen[6 * (3 + i) + c] += w[i];
            }
        }
    }
    for (int l = 0; l < many; l++) {
        for (int i = 0; i < 36; i++) out[l].seen[i] = seen[i][l];
        for (int i = 0; i < 6; i++) out[l].ending[i] = ending[i][l];
    }
}

/* Written for any number m of stages, and compiled for each that is used. */
VARIANT void NAMED(solve_steps)(const struct swimmer *s, const struct rule *rule, SIZE many, const struct step *steps,
                                int slopes, struct travelled *out) {
    for (SIZE k = 0; k < many; k += SIDE_BY_SIDE) {
        const SIZE some = many - k < SIDE_BY_SIDE ? many - k : SIDE_BY_SIDE;
        if (rule->stages == 3)
            NAMED(some_steps)(3, s, rule, some, steps + k, slopes, out + k);
        else if (rule->stages == 5)
            NAMED(some_steps)(5, s, rule, some, steps + k, slopes, out + k);
        else if (rule->stages == 8)
            NAMED(some_steps)(8, s, rule, some, steps + k, slopes, out + k);
        else
            NAMED(some_steps)((int)rule->stages, s, rule, some, steps + k, slopes, out + k);
    }
}
