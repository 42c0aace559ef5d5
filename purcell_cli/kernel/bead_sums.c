/* The sums over a table of links that feel each other, where nearly all of its time goes: over rows of numbers side by side. */
#include "wide.h"

BODY table_rows_body(const double *rows, int count, int entries, const double *weight, const double *slope, double *sum,
                     double *sloped) {
    for (int e = 0; e < entries; e += 2 * QUAD) {
        quad value[2] = {nothing, nothing}, other[2] = {nothing, nothing};
        const double *row = rows + e;
        for (int a = 0; a < count; a++, row += WIDTH) {
            const quad one = AT(row), two = AT(row + QUAD);
            value[0] += weight[a] * one;
            value[1] += weight[a] * two;
            if (!sloped) continue;
            other[0] += slope[a] * one;
            other[1] += slope[a] * two;
        }
        for (int i = 0; i < 2; i++) {
            PUT(sum + e + i * QUAD, value[i]);
            if (sloped) PUT(sloped + e + i * QUAD, other[i]);
        }
    }
}
EITHER(table_rows,
       (const double *rows, int count, int entries, const double *weight, const double *slope, double *sum, double *sloped),
       (rows, count, entries, weight, slope, sum, sloped))

BODY contract_body(const struct known *known, const double *weight, const double *slope, struct contracted *out) {
    const int entries = known->entries, row = known->slopes ? 2 * entries : entries;
    const double *from = known->sums;
    for (int c = 0; c < known->used; from += known->many[c] * row, c++)
        for (int e = 0; e < entries; e += 2 * QUAD) {
            quad value[2] = {nothing, nothing}, other[2] = {nothing, nothing}, sloped[2] = {nothing, nothing};
            const double *sum = from + e;
            for (int b = 0; b < known->many[c]; b++, sum += row) {
                const quad one = AT(sum), two = AT(sum + QUAD);
                value[0] += weight[b] * one;
                value[1] += weight[b] * two;
                if (!known->slopes) continue;
                other[0] += slope[b] * one;
                other[1] += slope[b] * two;
                sloped[0] += weight[b] * AT(sum + entries);
                sloped[1] += weight[b] * AT(sum + entries + QUAD);
            }
            for (int i = 0; i < 2; i++) {
                PUT(out->value[c] + e + i * QUAD, value[i]);
                if (!known->slopes) continue;
                PUT(out->other[c] + e + i * QUAD, other[i]);
                PUT(out->known[c] + e + i * QUAD, sloped[i]);
            }
        }
}
EITHER(contract, (const struct known *known, const double *weight, const double *slope, struct contracted *out),
       (known, weight, slope, out))

BODY angle_series_body(double (*of)[WIDTH], int used, int entries, const double *plain, const double *mixed,
                       struct series *out) {
    for (int e = 0; e < entries; e += QUAD) {
        quad sums[2][2] = {{nothing, nothing}, {nothing, nothing}}; /* of kind and parity */
        const int first = purcell_mirrored[e], last = purcell_mirrored[e + QUAD - 1];
        for (int c = 0; c < used; c++) {
            const quad here = AT(of[c] + e);
            sums[first][c % 2] += (first ? mixed : plain)[c] * here;
            if (last != first) sums[last][c % 2] += (last ? mixed : plain)[c] * here;
        }
        for (int i = 0; i < QUAD; i++) {
            out->even[e + i] = sums[purcell_mirrored[e + i]][0][i];
            out->odd[e + i] = sums[purcell_mirrored[e + i]][1][i];
        }
    }
}
EITHER(angle_series,
       (double (*of)[WIDTH], int used, int entries, const double *plain, const double *mixed, struct series *out),
       (of, used, entries, plain, mixed, out))

BODY interpolated_body(const struct field *f, double (*weight)[LANES], int first, int last, lane *out) {
    for (int e = first; e < last; e += 2 * QUAD) {
        quad one[2] = {nothing, nothing}, two[2] = {nothing, nothing};
        for (int k = 0; k < f->count; k++)
            for (int i = 0; i < 2; i++) {
                const quad here = AT(f->values[k] + e + i * QUAD);
                one[i] += weight[k][0] * here;
                two[i] += weight[k][1] * here;
            }
        for (int i = 0; i < 2 * QUAD; i++) out[e + i] = (lane){one[i / QUAD][i % QUAD], two[i / QUAD][i % QUAD]};
    }
}
EITHER(interpolated, (const struct field *f, double (*weight)[LANES], int first, int last, lane *out),
       (f, weight, first, last, out))
