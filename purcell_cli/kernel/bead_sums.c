/* The sums over a table of links that feel each other, where nearly all of its time goes: over rows of numbers side by side,
 * each the same sum in the same order. */
#include "kernel.h"
#include "wide.h"

BODY table_rows_body(const double *rows, SIZE stride, int count, int entries, const double *weight, const double *slope,
                     double *sum, double *sloped) {
    for (int e = 0; e < entries; e += BLOCK) {
        double value[BLOCK] = {0.0}, other[BLOCK] = {0.0};
        if (sloped)
            for (int a = 0; a < count; a++)
                for (int i = 0; i < BLOCK; i++) {
                    value[i] += weight[a] * rows[a * stride + e + i];
                    other[i] += slope[a] * rows[a * stride + e + i];
                }
        else
            for (int a = 0; a < count; a++)
                for (int i = 0; i < BLOCK; i++) value[i] += weight[a] * rows[a * stride + e + i];
        for (int i = 0; i < BLOCK; i++) sum[e + i] = value[i];
        for (int i = 0; sloped && i < BLOCK; i++) sloped[e + i] = other[i];
    }
}
EITHER(table_rows,
       (const double *rows, SIZE stride, int count, int entries, const double *weight, const double *slope, double *sum,
        double *sloped),
       (rows, stride, count, entries, weight, slope, sum, sloped))

BODY contract_body(const struct known *known, int entries, const double *weight, const double *slope,
                   struct contracted *out) {
    for (int c = 0; c < known->used; c++)
        for (int e = 0; e < entries; e += BLOCK) {
            double value[BLOCK] = {0.0}, other[BLOCK] = {0.0}, sloped[BLOCK] = {0.0};
            if (known->slopes)
                for (int b = 0; b < known->many[c]; b++) {
                    const double *from = known->sums[0][c][b] + e, *steep = known->sums[1][c][b] + e;
                    for (int i = 0; i < BLOCK; i++) {
                        value[i] += weight[b] * from[i];
                        other[i] += slope[b] * from[i];
                        sloped[i] += weight[b] * steep[i];
                    }
                }
            else
                for (int b = 0; b < known->many[c]; b++) {
                    const double *from = known->sums[0][c][b] + e;
                    for (int i = 0; i < BLOCK; i++) value[i] += weight[b] * from[i];
                }
            for (int i = 0; i < BLOCK; i++) out->value[c][e + i] = value[i];
            for (int i = 0; known->slopes && i < BLOCK; i++) out->other[c][e + i] = other[i];
            for (int i = 0; known->slopes && i < BLOCK; i++) out->known[c][e + i] = sloped[i];
        }
}
EITHER(contract,
       (const struct known *known, int entries, const double *weight, const double *slope, struct contracted *out),
       (known, entries, weight, slope, out))

BODY angle_series_body(double (*of)[WIDTH], int used, int plains, int entries, const double *plain, const double *mixed,
                       struct series *out) {
    for (int kind = 0; kind < 2; kind++) {
        const double *factor = kind ? mixed : plain;
        for (int e = kind ? plains : 0; e < (kind ? entries : plains); e += BLOCK) {
            double even[BLOCK] = {0.0}, odd[BLOCK] = {0.0};
            for (int c = 0; c < used; c += 2)
                for (int i = 0; i < BLOCK; i++) even[i] += factor[c] * of[c][e + i];
            for (int c = 1; c < used; c += 2)
                for (int i = 0; i < BLOCK; i++) odd[i] += factor[c] * of[c][e + i];
            for (int i = 0; i < BLOCK; i++) out->even[e + i] = even[i];
            for (int i = 0; i < BLOCK; i++) out->odd[e + i] = odd[i];
        }
    }
}
EITHER(angle_series,
       (double (*of)[WIDTH], int used, int plains, int entries, const double *plain, const double *mixed,
        struct series *out),
       (of, used, plains, entries, plain, mixed, out))

BODY interpolated_body(const struct field *f, double (*weight)[LANES], int first, int last, lane *out) {
    for (int e = first; e < last; e += BLOCK) {
        double one[BLOCK] = {0.0}, two[BLOCK] = {0.0};
        for (int k = 0; k < f->count; k++)
            for (int i = 0; i < BLOCK; i++) {
                one[i] += weight[k][0] * f->values[k][e + i];
                two[i] += weight[k][1] * f->values[k][e + i];
            }
        for (int i = 0; i < BLOCK; i++) out[e + i] = (lane){one[i], two[i]};
    }
}
EITHER(interpolated, (const struct field *f, double (*weight)[LANES], int first, int last, lane *out),
       (f, weight, first, last, out))
