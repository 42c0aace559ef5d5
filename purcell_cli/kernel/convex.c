/* Convex programs of many small blocks that few rows tie: a linear or quadratic cost, inequalities within each block,
 * and equations and inequalities across blocks that may be missed at a price, so that every program has a solution.
 *
 * A primal-dual interior point method with a predictor and a corrector (Mehrotra 1992, SIAM J. Optim. 2, 575): blocks
 * are eliminated one by one, and what is left is a positive definite system of as many equations as there are rows. */
#include <math.h>

#include "kernel.h"

#define MOST_ROUNDS 60
#define NEARLY 0.995  /* the part of the way to the nearest wall that a step goes */
#define TO_BEGIN 0.1  /* the products of slacks and multipliers at the start, in units of the largest cost times the way */
#define STALLED 1e-9  /* a step that goes a smaller part of its way is the last */

struct block {
    SIZE size, linked, walls;          /* its variables, those in rows across blocks, which are the last, and its walls */
    const double *cost, *curve, *entry; /* (size,), (size, size) or null, and what the walls are, where not zero */
    const int64_t *start, *column;      /* where each wall's entries begin, (walls + 1,), and their variables */
    const double *across;              /* (linked, rows) */
    SIZE part[2][2];                   /* from which row to which, in two parts: it is in no others */
    double *y, *step, *force;          /* (size,) */
    double *factor, *carried;          /* (size, size), (linked, rows) */
    double *slack, *press, *dslack, *dpress, *target; /* (walls,) */
};

/* All rows that a block is in: moves are in no bends before them. */
#define ROWS_OF(b, r) \
    for (int part_ = 0; part_ < 2; part_++) \
        for (SIZE r = (b)->part[part_][0]; r < (b)->part[part_][1]; r++)

/* Those of them up to one of them. */
#define UNTIL(b, r, c) \
    for (int low_ = 0; low_ <= part_; low_++) \
        for (SIZE c = (b)->part[low_][0], end_ = low_ < part_ ? (b)->part[low_][1] : r + 1; c < end_; c++)

/* The Cholesky factor of a matrix (n, n), in its lower triangle; `column`: to work in, (n,). */
static void factorise(double *a, SIZE n, double *column) {
    double largest = 0.0;
    for (SIZE i = 0; i < n; i++) largest = a[i * n + i] > largest ? a[i * n + i] : largest;
    for (SIZE k = 0; k < n; k++) {
        const double left = a[k * n + k], pivot = sqrt(left > 1e-15 * largest ? left : 1e-15 * largest + 1e-300);
        a[k * n + k] = pivot;
        for (SIZE i = k + 1; i < n; i++) {
            double *row = a + i * n;
            const double by = column[i] = row[k] = row[k] / pivot;
            if (by != 0.0)
                for (SIZE j = k + 1; j <= i; j++) row[j] -= by * column[j];
        }
    }
}

/* x becomes L^-1 x, for the rows from `first` on, where all before are zero. */
static void forward(const double *factor, SIZE n, SIZE first, double *x) {
    for (SIZE i = first; i < n; i++) {
        double sum = x[i];
        for (SIZE j = first; j < i; j++) sum -= factor[i * n + j] * x[j];
        x[i] = sum / factor[i * n + i];
    }
}

/* x becomes L^-T x. */
static void backward(const double *factor, SIZE n, double *x) {
    for (SIZE i = n - 1; i >= 0; i--) {
        x[i] /= factor[i * n + i];
        for (SIZE j = 0; j < i; j++) x[j] -= factor[i * n + j] * x[i];
    }
}

/* A wall's value at some y, and its normal, times a number, added to `out`. */
static double along(const struct block *b, SIZE wall, const double *y) {
    double sum = 0.0;
    for (SIZE i = b->start[wall]; i < b->start[wall + 1]; i++) sum += b->entry[i] * y[b->column[i]];
    return sum;
}

static void push(const struct block *b, SIZE wall, double by, double *out) {
    for (SIZE i = b->start[wall]; i < b->start[wall + 1]; i++) out[b->column[i]] += by * b->entry[i];
}

/* Factorises curve + sum wall^T (press / slack) wall, and adds what the block means for the rows to `schur`. */
static void eliminate(struct block *b, double *schur, SIZE rows) {
    const SIZE n = b->size, first = n - b->linked;
    for (SIZE i = 0; i < n * n; i++) b->factor[i] = b->curve ? b->curve[i] : 0.0;
    for (SIZE k = 0; k < b->walls; k++) {
        const double weight = b->press[k] / b->slack[k];
        for (SIZE i = b->start[k]; i < b->start[k + 1]; i++) {
            double *row = b->factor + b->column[i] * n;
            const double scaled = weight * b->entry[i];
            for (SIZE j = b->start[k]; j <= i; j++) row[b->column[j]] += scaled * b->entry[j];
        }
    }
    factorise(b->factor, n, b->step);
    for (SIZE i = 0; i < b->linked; i++) {
        double *row = b->carried + i * rows;
        const double *lower = b->factor + (first + i) * n + first;
        ROWS_OF(b, c) row[c] = b->across[i * rows + c];
        for (SIZE j = 0; j < i; j++) {
            const double *other = b->carried + j * rows, by = lower[j];
            if (by != 0.0)
                ROWS_OF(b, c) row[c] -= by * other[c];
        }
        const double by = 1.0 / lower[i];
        ROWS_OF(b, c) row[c] *= by;
    }
    SIZE i = 0;
    for (; i + 2 < b->linked; i += 3) { /* three at a time: `schur` is read and written less often */
        const double *u = b->carried + i * rows, *v = u + rows, *w = v + rows;
        ROWS_OF(b, r) {
            const double p = u[r], q = v[r], s = w[r];
            double *out = schur + r * rows;
            if (p != 0.0 || q != 0.0 || s != 0.0)
                UNTIL(b, r, c) out[c] += p * u[c] + q * v[c] + s * w[c];
        }
    }
    for (; i < b->linked; i++) {
        const double *u = b->carried + i * rows;
        ROWS_OF(b, r) {
            const double p = u[r];
            double *out = schur + r * rows;
            UNTIL(b, r, c) out[c] += p * u[c];
        }
    }
}

#define WORDS 24 /* doubles that a block's record may take */
_Static_assert(sizeof(struct block) <= WORDS * sizeof(double), "a block's record has room");

struct program {
    SIZE blocks, rows, walls;
    struct block *block;
    const double *wanted;
    double *schur, *multiplier, *change;        /* (rows, rows), (rows,), (rows,) */
    double *over, *under, *dover, *dunder;      /* what is above and below what is wanted, (rows,) */
    double *pover, *punder;                     /* their multipliers, (rows,) */
    double *tover, *tunder, *missing;           /* (rows,) */
};

/* The direction for the products that slack and multiplier are to have (targets), in the blocks and rows. */
static void direction(struct program *p) {
    const SIZE m = p->rows;
    for (SIZE r = 0; r < m; r++)
        p->change[r] = p->missing[r] + p->tunder[r] / p->punder[r] - p->tover[r] / p->pover[r];
    for (SIZE i = 0; i < p->blocks; i++) {
        struct block *b = p->block + i;
        const SIZE n = b->size, first = n - b->linked;
        for (SIZE j = 0; j < n; j++) b->step[j] = -b->force[j];
        for (SIZE k = 0; k < b->walls; k++) push(b, k, -b->target[k] / b->slack[k], b->step);
        forward(b->factor, n, 0, b->step);
        for (SIZE j = 0; j < b->linked; j++) {
            const double by = b->step[first + j], *row = b->carried + j * m;
            ROWS_OF(b, r) p->change[r] += by * row[r];
        }
    }
    forward(p->schur, m, 0, p->change);
    backward(p->schur, m, p->change);
    for (SIZE i = 0; i < p->blocks; i++) {
        struct block *b = p->block + i;
        const SIZE n = b->size, first = n - b->linked;
        for (SIZE j = 0; j < b->linked; j++) {
            const double *row = b->carried + j * m;
            double sum = 0.0;
            ROWS_OF(b, r) sum += row[r] * p->change[r];
            b->step[first + j] -= sum;
        }
        backward(b->factor, n, b->step);
        for (SIZE k = 0; k < b->walls; k++) {
            const double sum = along(b, k, b->step);
            b->dslack[k] = -sum;
            b->dpress[k] = (b->target[k] + b->press[k] * sum) / b->slack[k];
        }
    }
    for (SIZE r = 0; r < m; r++) {
        p->dunder[r] = (p->tunder[r] - p->under[r] * p->change[r]) / p->punder[r];
        p->dover[r] = (p->tover[r] + p->over[r] * p->change[r]) / p->pover[r];
    }
}

/* How far a positive number may go along a change before it is zero, at the most. */
static double reach(double most, double value, double change) {
    return change < 0.0 && value < -most * change ? value / -change : most;
}

/* How far steps of slacks and of multipliers may go before one is zero, one for both where costs curve. */
static void ways(const struct program *p, int together, double most, double out[2]) {
    double a = most, z = most;
    for (SIZE i = 0; i < p->blocks; i++) {
        const struct block *b = p->block + i;
        for (SIZE k = 0; k < b->walls; k++) {
            a = reach(a, b->slack[k], b->dslack[k]);
            z = reach(z, b->press[k], b->dpress[k]);
        }
    }
    for (SIZE r = 0; r < p->rows; r++) {
        a = reach(reach(a, p->under[r], p->dunder[r]), p->over[r], p->dover[r]);
        z = reach(reach(z, p->punder[r], p->change[r]), p->pover[r], -p->change[r]);
    }
    out[0] = together && z < a ? z : a;
    out[1] = together ? out[0] : z;
}

/* The sum of products of slacks and multipliers, some way along the direction. */
static double gap(const struct program *p, double a, double z) {
    double sum = 0.0;
    for (SIZE i = 0; i < p->blocks; i++) {
        const struct block *b = p->block + i;
        for (SIZE k = 0; k < b->walls; k++)
            sum += (b->slack[k] + a * b->dslack[k]) * (b->press[k] + z * b->dpress[k]);
    }
    for (SIZE r = 0; r < p->rows; r++)
        sum += (p->under[r] + a * p->dunder[r]) * (p->punder[r] + z * p->change[r]) +
               (p->over[r] + a * p->dover[r]) * (p->pover[r] - z * p->change[r]);
    return sum;
}

/* What the equations still miss: the force on each variable, and the rows; returns the largest of both. */
static double misses(struct program *p) {
    const SIZE m = p->rows;
    double most = 0.0;
    for (SIZE r = 0; r < m; r++) p->missing[r] = p->under[r] - p->over[r] - p->wanted[r];
    for (SIZE i = 0; i < p->blocks; i++) {
        struct block *b = p->block + i;
        const SIZE n = b->size, first = n - b->linked;
        for (SIZE j = 0; j < n; j++) {
            b->force[j] = b->cost[j];
            if (b->curve)
                for (SIZE k = 0; k < n; k++) b->force[j] += b->curve[j * n + k] * b->y[k];
        }
        for (SIZE k = 0; k < b->walls; k++) push(b, k, b->press[k], b->force);
        for (SIZE j = 0; j < b->linked; j++) {
            const double *row = b->across + j * m, y = b->y[first + j];
            double sum = 0.0;
            ROWS_OF(b, r) {
                sum += row[r] * p->multiplier[r];
                p->missing[r] += y * row[r];
            }
            b->force[first + j] += sum;
        }
        for (SIZE j = 0; j < n; j++) most = fabs(b->force[j]) > most ? fabs(b->force[j]) : most;
    }
    for (SIZE r = 0; r < m; r++) most = fabs(p->missing[r]) > most ? fabs(p->missing[r]) : most;
    return most;
}

/* The y of the least cost . y + y . curve y / 2 + price (|m_1| + ... + max(m_(equal + 1), 0) + ...), for wall y <= bound
 * within each block, m being what the rows across miss: sum across^T y - wanted, equations first.
 *
 * sizes: (blocks, 3): a block's variables, how many of them (its last) the rows are about, and its walls. cost, y:
 * (all variables,), y strictly within the walls, becomes the solution. curve: (size, size) for each block, or null.
 * start, column, entry: the walls' entries that are not zero, all blocks' walls one after the other: where each wall's
 * begin, (all walls + 1,), their variables in the block, ascending, and they. bound: (all walls,). across: (linked, rows) for each block. room: numbers to work
 * in: rows (rows + 11), and for each block WORDS + size (size + 2) + linked rows + 5 walls. Ends where products of slacks and multipliers add up to less than `enough`.
 * Returns how many rounds that took, or -1 if it does not end so. */
API SIZE purcell_convex(SIZE blocks, SIZE rows, SIZE equal, double price, double enough, const int64_t *sizes,
                        const double *cost, const double *curve, const int64_t *start, const int64_t *column,
                        const double *entry, const double *bound, const double *across, const double *wanted, double *y, double *room) {
    struct block *const block = (struct block *)room;
    struct program p = {.blocks = blocks, .rows = rows, .block = block, .wanted = wanted};
    double **const of_rows[] = {&p.multiplier, &p.change, &p.over,  &p.under,  &p.dover,  &p.dunder,
                                &p.pover,      &p.punder, &p.tover, &p.tunder, &p.missing};
    room += WORDS * blocks;
    p.schur = room;
    room += rows * rows;
    for (int i = 0; i < 11; i++, room += rows) *of_rows[i] = room;
    double largest = 0.0, way = 1e-300;
    for (SIZE i = 0; i < blocks; i++) {
        const SIZE n = sizes[3 * i], linked = sizes[3 * i + 1], walls = sizes[3 * i + 2];
        struct block *b = block + i;
        *b = (struct block){.size = n, .linked = linked, .walls = walls, .cost = cost, .curve = curve, .entry = entry,
                            .start = start, .column = column, .across = across, .y = y, .step = room, .force = room + n};
        room += 2 * n;
        b->factor = room;
        b->carried = room + n * n;
        room += n * n + linked * rows;
        double **const of_walls[] = {&b->slack, &b->press, &b->dslack, &b->dpress, &b->target};
        for (int k = 0; k < 5; k++, room += walls) *of_walls[k] = room;
        for (SIZE j = 0; j < n; j++) largest = fabs(cost[j]) > largest ? fabs(cost[j]) : largest;
        for (SIZE k = 0; k < walls; k++) {
            b->slack[k] = bound[k] - along(b, k, y);
            if (!(b->slack[k] > 0.0)) return -1;
            way = b->slack[k] > way ? b->slack[k] : way;
        }
        p.walls += walls;
        SIZE begin = equal, none = 1;
        for (; begin < rows && none; begin += none)
            for (SIZE j = 0; j < linked && none; j++) none = across[j * rows + begin] == 0.0;
        const SIZE part[2][2] = {{0, equal}, {begin, rows}};
        for (int k = 0; k < 4; k++) b->part[k / 2][k % 2] = part[k / 2][k % 2];
        cost += n, y += n, start += walls, bound += walls, across += linked * rows;
        if (curve) curve += n * n;
    }
    const double begun = TO_BEGIN * (largest > 0.0 ? largest : 1.0) * way;
    for (SIZE i = 0; i < blocks; i++)
        for (SIZE k = 0; k < block[i].walls; k++) block[i].press[k] = begun / block[i].slack[k];
    for (SIZE r = 0; r < rows; r++) p.multiplier[r] = p.over[r] = p.under[r] = 0.0;
    misses(&p);
    for (SIZE r = 0; r < rows; r++) {
        const double off = p.missing[r], least = begun / price;
        p.over[r] = (off > 0.0 ? off : 0.0) + least;
        p.under[r] = (off < 0.0 ? -off : 0.0) + least;
        if (r >= equal) {
            const double press = begun / p.under[r];
            p.multiplier[r] = press < 0.5 * price ? press : 0.5 * price;
        }
        p.pover[r] = price - p.multiplier[r];
        p.punder[r] = (r < equal ? price : 0.0) + p.multiplier[r];
    }
    const double many = (double)(p.walls + 2 * rows);
    SIZE round = 0;
    for (; round < MOST_ROUNDS; round++) {
        const double off = misses(&p);
        for (SIZE i = 0; i < blocks; i++)
            for (SIZE k = 0; k < block[i].walls; k++) block[i].dslack[k] = block[i].dpress[k] = 0.0;
        for (SIZE r = 0; r < rows; r++) p.change[r] = p.dover[r] = p.dunder[r] = 0.0;
        const double now = gap(&p, 0.0, 0.0);
        if (!(now < 1e300)) return -1;
        if (now < enough && off < 1e-6 * (1.0 + largest)) return round;
        for (SIZE i = 0; i < rows * rows; i++) p.schur[i] = 0.0;
        for (SIZE i = 0; i < blocks; i++) eliminate(block + i, p.schur, rows);
        for (SIZE r = 0; r < rows; r++)
            p.schur[r * rows + r] += p.under[r] / p.punder[r] + p.over[r] / p.pover[r];
        factorise(p.schur, rows, p.change);
        for (SIZE i = 0; i < blocks; i++)
            for (SIZE k = 0; k < block[i].walls; k++) block[i].target[k] = -block[i].slack[k] * block[i].press[k];
        for (SIZE r = 0; r < rows; r++) {
            p.tunder[r] = -p.under[r] * p.punder[r];
            p.tover[r] = -p.over[r] * p.pover[r];
        }
        direction(&p);
        double far[2];
        ways(&p, curve != 0, 1.0, far);
        const double left = gap(&p, far[0], far[1]) / now, centre = left * left * left * now / many;
        for (SIZE i = 0; i < blocks; i++)
            for (SIZE k = 0; k < block[i].walls; k++) block[i].target[k] += centre - block[i].dslack[k] * block[i].dpress[k];
        for (SIZE r = 0; r < rows; r++) {
            p.tunder[r] += centre - p.dunder[r] * p.change[r];
            p.tover[r] += centre + p.dover[r] * p.change[r];
        }
        direction(&p);
        ways(&p, curve != 0, 1.0 / NEARLY, far);
        const double a = NEARLY * far[0], z = NEARLY * far[1];
        if (!(a > STALLED)) return now < 1e3 * enough ? round : -1;
        for (SIZE i = 0; i < blocks; i++) {
            struct block *b = block + i;
            for (SIZE j = 0; j < b->size; j++) b->y[j] += a * b->step[j];
            for (SIZE k = 0; k < b->walls; k++) {
                b->slack[k] += a * b->dslack[k];
                b->press[k] += z * b->dpress[k];
            }
        }
        for (SIZE r = 0; r < rows; r++) {
            p.under[r] += a * p.dunder[r];
            p.over[r] += a * p.dover[r];
            p.multiplier[r] += z * p.change[r];
            p.punder[r] += z * p.change[r];
            p.pover[r] -= z * p.change[r];
        }
    }
    return -1;
}
