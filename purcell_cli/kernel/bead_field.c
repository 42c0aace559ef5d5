/* What a motion needs of the resistance of links that feel each other, along a part of a path: polynomials in time. */
#include "kernel.h"
#include "small.h"

#define PI 3.14159265358979323846

void purcell_fill_field(const struct swimmer *s, double begun[2][3], double rates[2][3], double start, double length,
                        int nodes, struct known *known, struct field *out) {
    double axes[PANEL_NODES][2][3];
    const int still = DOT(rates[0], rates[0]) == 0.0 ? 0 : DOT(rates[1], rates[1]) == 0.0 ? 1 : -1;
    known->window = known->power ? WITH_POWER : known->couplings || still < 0 ? BOTH : MOTION;
    if (out->count != nodes)
        for (int k = 0; k < nodes; k++) purcell_sin_cos_of(PI * (k + 0.5) / nodes, out->sines + k, out->nodes + k);
    out->count = nodes;
    out->changes = known->slopes;
    out->couplings = known->couplings;
    out->start = start;
    out->length = length;
    for (int k = 0; k < nodes; k++)
        for (int limb = 0; limb < 2; limb++) {
            const double time = start + 0.5 * length * (1.0 + out->nodes[k]);
            double turned[3];
            for (int i = 0; i < 3; i++) turned[i] = rates[limb][i] * time;
            purcell_rotate(turned, begun[limb], axes[k][limb]);
        }
    known->table = purcell_table_for(s, nodes, axes);
    if (still >= 0) purcell_fix(still, begun[still], known);
    for (int k = 0; k < nodes; k++) {
        if (still < 0) purcell_fix(0, axes[k][0], known);
        purcell_look_up(axes[k], rates, known, out->values[k]);
    }
}

/* The barycentric formula with Chebyshev's nodes of the first kind (Berrut and Trefethen 2004, SIAM Review 46). */
void purcell_of_field(const struct field *f, lane time, int changes, lane out[GIVEN]) {
    const lane part = 2.0 * (time - f->start) / f->length - 1.0;
    double weight[PANEL_NODES][LANES];
    for (int l = 0; l < LANES; l++) {
        double total = 0.0;
        int exact = -1;
        for (int k = 0; k < f->count; k++) {
            const double gap = part[l] - f->nodes[k];
            if (gap == 0.0) exact = k;
            weight[k][l] = (k % 2 ? -f->sines[k] : f->sines[k]) / (gap == 0.0 ? 1.0 : gap);
            total += weight[k][l];
        }
        for (int k = 0; k < f->count; k++)
            weight[k][l] = exact >= 0 ? (k == exact ? 1.0 : 0.0) : weight[k][l] / total;
    }
    purcell_interpolated(f, weight, 0, changes ? CHANGES : PULL, out);
    if (f->couplings) purcell_interpolated(f, weight, COUPLINGS, GIVEN, out);
}

void purcell_at_shape(const struct swimmer *s, double axes[2][3], double rates[2][3], int changes, int couplings,
                      double out[GIVEN]) {
    struct known known;
    known.limb = -1;
    known.exact = 1;
    known.slopes = changes;
    known.couplings = couplings;
    known.window = couplings ? WITH_POWER : BOTH;
    known.table = purcell_table_for(s, 1, (double(*)[2][3])axes);
    purcell_fix(0, axes[0], &known);
    purcell_look_up(axes, rates, &known, out);
}

/* The table's resistances at n shapes. (n, 2, 3) to (n, 78). */
API void purcell_looked_up(const double *numbers, SIZE n, const double *axes, double *out) {
    for (SIZE k = 0; k < n; k++) {
        double a[2][3], rates[2][3] = {{0.0}}, found[GIVEN];
        for (int i = 0; i < 6; i++) a[i / 3][i % 3] = axes[6 * k + i];
        purcell_at_shape((const struct swimmer *)numbers, a, rates, 0, 1, found);
        for (int e = 0; e < 21; e++) out[RESISTANCE * k + e] = found[e];
        for (int e = 21; e < RESISTANCE; e++) out[RESISTANCE * k + e] = found[COUPLINGS + e - 21];
    }
}
