/* Sums of many numbers, four side by side (NUMBERS); `wide_sums.c` includes this for each kind of register. */

VARIANT void NAMED(table_rows)(const double *rows, int count, int entries, const double *weight, const double *slope,
                               double *sum, double *sloped) {
    for (int e = 0; e < entries; e += 2 * QUAD) {
        NUMBERS value[2] = {NOTHING, NOTHING}, other[2] = {NOTHING, NOTHING};
        const double *row = rows + e;
        for (int a = 0; a < count; a++, row += WIDTH) {
            const NUMBERS one = AT(row), two = AT(row + QUAD);
            ADD(value[0], weight[a], one);
            ADD(value[1], weight[a], two);
            if (!sloped) continue;
            ADD(other[0], slope[a], one);
            ADD(other[1], slope[a], two);
        }
        for (int i = 0; i < 2; i++) {
            PUT(sum + e + i * QUAD, value[i]);
            if (sloped) PUT(sloped + e + i * QUAD, other[i]);
        }
    }
}

VARIANT void NAMED(contract)(const struct known *known, const double *weight, const double *slope,
                             struct contracted *out) {
    const int entries = known->entries, row = known->slopes ? 2 * entries : entries;
    const double *from = known->sums;
    for (int c = 0; c < known->used; from += known->many[c] * row, c++)
        for (int e = 0; e < entries; e += 2 * QUAD) {
            NUMBERS value[2] = {NOTHING, NOTHING}, other[2] = {NOTHING, NOTHING}, sloped[2] = {NOTHING, NOTHING};
            const double *sum = from + e;
            for (int b = 0; b < known->many[c]; b++, sum += row) {
                const NUMBERS one = AT(sum), two = AT(sum + QUAD);
                ADD(value[0], weight[b], one);
                ADD(value[1], weight[b], two);
                if (!known->slopes) continue;
                ADD(other[0], slope[b], one);
                ADD(other[1], slope[b], two);
                ADD(sloped[0], weight[b], AT(sum + entries));
                ADD(sloped[1], weight[b], AT(sum + entries + QUAD));
            }
            for (int i = 0; i < 2; i++) {
                PUT(out->value[c] + e + i * QUAD, value[i]);
                if (!known->slopes) continue;
                PUT(out->other[c] + e + i * QUAD, other[i]);
                PUT(out->known[c] + e + i * QUAD, sloped[i]);
            }
        }
}

VARIANT void NAMED(angle_series)(double (*of)[WIDTH], int used, int entries, const double *plain, const double *mixed,
                                 struct series *out) {
    for (int e = 0; e < entries; e += QUAD) {
        NUMBERS sums[2][2] = {{NOTHING, NOTHING}, {NOTHING, NOTHING}}; /* of kind and parity */
        const int first = purcell_mirrored[e], last = purcell_mirrored[e + QUAD - 1];
        for (int c = 0; c < used; c++) {
            const NUMBERS here = AT(of[c] + e);
            ADD(sums[first][c % 2], (first ? mixed : plain)[c], here);
            if (last != first) ADD(sums[last][c % 2], (last ? mixed : plain)[c], here);
        }
        for (int i = 0; i < QUAD; i++) {
            out->even[e + i] = PART(sums[purcell_mirrored[e + i]][0], i);
            out->odd[e + i] = PART(sums[purcell_mirrored[e + i]][1], i);
        }
    }
}

VARIANT void NAMED(interpolated)(const struct field *f, double (*weight)[LANES], int first, int last, lane *out) {
    for (int e = first; e < last; e += 2 * QUAD) {
        NUMBERS one[2] = {NOTHING, NOTHING}, two[2] = {NOTHING, NOTHING};
        for (int k = 0; k < f->count; k++)
            for (int i = 0; i < 2; i++) {
                const NUMBERS here = AT(f->values[k] + e + i * QUAD);
                ADD(one[i], weight[k][0], here);
                ADD(two[i], weight[k][1], here);
            }
        for (int i = 0; i < 2 * QUAD; i++) out[e + i] = (lane){PART(one[i / QUAD], i % QUAD), PART(two[i / QUAD], i % QUAD)};
    }
}

/* Rows of L with M = L L^T, in place of M's lower half, or 0 in `positive`: a bead's rows and four columns at once, whose sums
 * are each of four parts. */
VARIANT void NAMED(cholesky)(SIZE n, double *m, int *positive) {
    for (SIZE i = 0; i < n; i += TILE) {
        double *const row = m + i * n;
        for (SIZE j = 0; j < i + TILE; j += QUAD) {
            const int many = i + TILE - j < QUAD ? (int)(i + TILE - j) : QUAD;
            const double *other[QUAD];
            NUMBERS sums[TILE][QUAD];
            for (int c = 0; c < QUAD; c++) other[c] = m + (c < many ? j + c : j) * n;
            for (int r = 0; r < TILE; r++)
                for (int c = 0; c < QUAD; c++) sums[r][c] = ZERO;
            for (SIZE k = 0; k < j; k += QUAD) { /* columns of L; j is a multiple of four */
                const NUMBERS mine[TILE] = {AT(row + k), AT(row + n + k), AT(row + 2 * n + k)};
                for (int c = 0; c < QUAD; c++) {
                    const NUMBERS here = AT(other[c] + k);
                    for (int r = 0; r < TILE; r++) ADD_EACH(sums[r][c], mine[r], here);
                }
            }
            for (int r = 0; r < TILE; r++)
                for (int c = 0; c < many && j + c <= i + r; c++) {
                    double *const at = row + r * n + j;
                    const NUMBERS sum = sums[r][c];
                    double left = at[c] - ((PART(sum, 0) + PART(sum, 1)) + (PART(sum, 2) + PART(sum, 3)));
                    for (int k = 0; k < c; k++) left -= at[k] * other[c][j + k];
                    if (j + c < i + r) {
                        at[c] = left / other[c][j + c];
                    } else {
                        if (!(left > 0.0)) {
                            *positive = 0;
                            return;
                        }
                        at[c] = sqrt(left);
                    }
                }
        }
    }
    *positive = 1;
}

VARIANT void NAMED(renewed)(SIZE n, int changed, double *const *row, const double *factor, const double *slope,
                            const double *pivot, double *gains) {
    SIZE j = 0;
    for (; j + QUAD <= n; j += QUAD) {
        NUMBERS gain = AT(gains + j);
        for (int k = 0; k < TOGETHER; k++) {
            NUMBERS here = AT(row[k] + j);
            if (changed) {
                ADD(here, factor[k], AT(pivot + j));
                PUT(row[k] + j, here);
            }
            ADD(gain, slope[k], here);
        }
        PUT(gains + j, gain);
    }
    for (; j < n; j++)
        for (int k = 0; k < TOGETHER; k++) {
            if (changed) row[k][j] += factor[k] * pivot[j];
            gains[j] += slope[k] * row[k][j];
        }
}

VARIANT void NAMED(inner_products)(SIZE n, SIZE count, const double *rows, const double *other, double *out) {
    for (SIZE i = 0; i < count; i += QUAD) {
        const SIZE many = count - i < QUAD ? count - i : QUAD;
        const double *row[QUAD];
        NUMBERS sums[QUAD];
        SIZE k = 0;
        for (int r = 0; r < QUAD; r++) {
            row[r] = rows + (r < many ? i + r : i) * n;
            sums[r] = ZERO;
        }
        for (; k + QUAD <= n; k += QUAD) {
            const NUMBERS there = AT(other + k);
            for (int r = 0; r < QUAD; r++) ADD_EACH(sums[r], AT(row[r] + k), there);
        }
        for (int r = 0; r < many; r++) {
            double s[QUAD];
            PUT(s, sums[r]);
            for (int l = 0; k + l < n; l++) s[l] += row[r][k + l] * other[k + l];
            out[i + r] = (s[0] + s[1]) + (s[2] + s[3]);
        }
    }
}
