/* Steps of a flow side by side, as many as a LANE has numbers, each as `solve_step` in `collocation.c` solves it: there
 * the nodes of one step stand side by side, for what needs them or a field along it. `connection.c` includes this for each
 * kind of register. */

VARIANT inline __attribute__((always_inline)) void NAMED(some_steps)(const int m, const struct swimmer *s,
                                                                     const struct rule *rule, SIZE many,
                                                                     const struct step *steps, int slopes,
                                                                     struct travelled *out) {
    LANE duration = NONE, start[2][3], rates[2][3], xi[6], velocity[MOST_STAGES][3], half[MOST_STAGES][3], q[MOST_STAGES][4];
    LANE change[MOST_STAGES][6][6], ending[6], seen[36], rotation[9], position[3];
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
    NAMED(displaced)(m, rule, velocity, half, q, rotation, position);
    for (int l = 0; l < many; l++) {
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) out[l].pose[4 * i + j] = rotation[3 * i + j][l];
            out[l].pose[4 * i + 3] = position[i][l];
            out[l].pose[12 + i] = 0.0;
        }
        out[l].pose[15] = 1.0;
    }
    if (!slopes) return;
    for (int i = 0; i < 36; i++) seen[i] = NONE;
    for (int k = 0; k < m; k++) {
        NAMED(at_node)(m, rule, k, velocity, q, rotation, position);
        NAMED(add_carried)(rotation, position, change[k], seen);
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
