/* Chains of screw motions that make a displacement: how often each is played, not whole, by Newton's method. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define MOST 16        /* screws of a chain */
#define ROUNDS 16      /* Newton steps: nineteen in twenty of the good chains that 40 find are found by so many */
#define EXACT 1e-8     /* a chain that misses by less needs no more steps [L, rad] */
#define DAMPING 1e-6   /* of the Gram matrix, as a part of its trace */
#define STEP 1.5       /* the largest motion by one part of a chain in a step [L, rad] */

/* What a chain's last displacement misses, of the components that count, and its change with the numbers of cycles,
 * (rows, length). */
static void shot(SIZE length, const SIZE *screw, const double *twists, const double *cycles, const double inverse[16],
                 SIZE rows, const SIZE *row, double *columns, double residual[6]) {
    double after[16], missing[16], all[6];
    identity(after, 4);
    for (SIZE k = length - 1; k >= 0; k--) {
        const double *twist = twists + 6 * screw[k], *v = twist, *w = twist + 3;
        double played[6], move[16], next[16], pw[3], seen[6];
        for (int i = 0; i < 6; i++) played[i] = cycles[k] * twist[i];
        purcell_exp(1, played, move);
        product(move, after, next, 4, 4, 4);
        for (int i = 0; i < 16; i++) after[i] = next[i];
        /* Ad of the inverse of what is played from here on. */
        const double p[3] = {after[3], after[7], after[11]};
        CROSS(pw, p, w);
        for (int i = 0; i < 3; i++) pw[i] = v[i] - pw[i];
        for (int i = 0; i < 3; i++) {
            seen[i] = after[i] * pw[0] + after[4 + i] * pw[1] + after[8 + i] * pw[2];
            seen[3 + i] = after[i] * w[0] + after[4 + i] * w[1] + after[8 + i] * w[2];
        }
        for (SIZE i = 0; i < rows; i++) columns[i * length + k] = seen[row[i]];
    }
    purcell_orthonormalise(1, 4, after);
    product(inverse, after, missing, 4, 4, 4);
    purcell_log(1, missing, all);
    for (SIZE i = 0; i < rows; i++) residual[i] = all[row[i]];
}

/* Changes the numbers of cycles by the step of least weighted size that closes the chain, as far as is linear. */
static void improve(SIZE length, const SIZE *screw, const double *twists, const double *travel, SIZE rows,
                    double *columns, const double residual[6], double *cycles) {
    double gram[36], multiplier[6], step[MOST], weight[MOST], longest = 0.0, trace = 0.0;
    for (SIZE k = 0; k < length; k++) weight[k] = 1.0 / travel[screw[k]];
    for (SIZE i = 0; i < rows; i++) {
        multiplier[i] = -residual[i];
        for (SIZE k = 0; k < length; k++) columns[i * length + k] *= weight[k];
    }
    for (SIZE i = 0; i < rows; i++) {
        for (SIZE j = 0; j <= i; j++)
            gram[i * rows + j] = gram[j * rows + i] = inner_product(length, columns + i * length, columns + j * length);
        trace += gram[i * rows + i];
    }
    for (SIZE i = 0; i < rows; i++) gram[i * rows + i] += DAMPING * trace + 1e-300;
    purcell_solve(1, rows, 1, gram, multiplier);
    for (SIZE k = 0; k < length; k++) {
        const double *twist = twists + 6 * screw[k];
        double sum = 0.0, square = 0.0;
        for (SIZE i = 0; i < rows; i++) sum += columns[i * length + k] * multiplier[i];
        for (int i = 0; i < 6; i++) square += twist[i] * twist[i];
        step[k] = weight[k] * sum;
        if (!isfinite(step[k])) step[k] = 0.0;
        const double size = fabs(step[k]) * sqrt(square);
        longest = size > longest ? size : longest;
    }
    const double part = STEP < longest ? STEP / longest : 1.0;
    for (SIZE k = 0; k < length; k++) cycles[k] += part * step[k];
}

/* Brings n chains to a displacement.
 *
 * screws: which screw each part is, (n, length), length at most MOST. twists, travel: of the screws, (m, 6) and (m,).
 * inverse: of the displacement, (4, 4). row: which components of what is missing count, (rows,). cycles: how often each
 * part is played, (n, length), which become the nearest that were found; missing: what those miss by, (n,). */
API void purcell_screw_chains(SIZE n, SIZE length, const SIZE *screws, const double *twists, const double *travel,
                              const double *inverse, SIZE rows, const SIZE *row, double *cycles, double *missing) {
    double columns[6 * MOST], residual[6], here[MOST];
    for (SIZE c = 0; c < n; c++, screws += length, cycles += length) {
        missing[c] = INFINITY;
        for (SIZE k = 0; k < length; k++) here[k] = cycles[k];
        for (int round = 0; round < ROUNDS; round++) {
            shot(length, screws, twists, here, inverse, rows, row, columns, residual);
            double off = 0.0;
            for (SIZE i = 0; i < rows; i++)
                off = isfinite(residual[i]) ? (fabs(residual[i]) > off ? fabs(residual[i]) : off) : INFINITY;
            if (!isfinite(off)) break;
            if (off < missing[c]) {
                missing[c] = off;
                for (SIZE k = 0; k < length; k++) cycles[k] = here[k];
            }
            if (off < EXACT) break;
            improve(length, screws, twists, travel, rows, columns, residual, here);
        }
    }
}
