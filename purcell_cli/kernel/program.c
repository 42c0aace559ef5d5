/* Linear programs with an exact penalty: the least sum of c_j |x_j| and of the price of what equations and inequalities
 * miss, between bounds.
 *
 * Primal simplex on convex costs of two straight pieces (Fourer 1985, Math. Program. 33, 204): a variable out of the
 * basis rests on a bend of its cost, and a step goes on past bends of the others until the cost rises. Rows miss what
 * they may at a price, so any point is a beginning. What begins at zero is left out as long as it would not gain. */
#include <math.h>

#include "kernel.h"

#define TINY 1e-11       /* a pivot, or a gain per unit, below this is none, in units of the largest */
#define NO_BOUND 1e300
/* An inequality joins that misses more than this at the beginning, and later on, in units of what one variable changes it
 * by at the most. */
#define NEAR -1.0
#define BROKEN 1e-11
#define ROUNDS_A_COLUMN 40
/* Columns that join together: so many at the most, which gain more than this part of what the best does. */
#define JOINING 32
#define AS_GOOD 0.3

/* A cost: `slope[0]` from `edge[0]` to `edge[1]`, and `slope[1]` on to `edge[2]`. */
struct cost {
    double slope[2], edge[3], scale;
};

struct program {
    SIZE all, rows, columns; /* how many variables there are beside the rows', and the rows and columns that have joined */
    const double *matrix;
    double *table;          /* how the basis changes with the rest: (rows, columns), rows being `all` numbers apart */
    struct cost *costs;     /* of the columns' variables, then of the rows' */
    double *value;          /* of all variables, in that order */
    double *gains, *pivot;  /* of the columns, and of the last exchange: (columns,) */
    double *up, *down, *scale; /* what a unit up costs of each column, what a unit down saves, its cost's scale */
    double *idle;           /* a row of none: (columns,) */
    double *speed;          /* of the rows as a column moves: (rows,) */
    double *reduced, *worth; /* of all columns: the gains, and what those gain that have not joined */
    int64_t *piece, *basic, *resting, *out; /* out: whether a column has not joined */
};

/* The piece that a resting variable enters when it goes up (1) or down (-1): 0 or 1; or -1 or 2, a wall. */
static int piece_towards(const struct cost *c, double value, int direction) {
    if (direction > 0) return value >= c->edge[2] ? 2 : value >= c->edge[1] ? 1 : 0;
    return value <= c->edge[0] ? -1 : value <= c->edge[1] ? 0 : 1;
}

/* How far a variable in a piece may go before the piece ends. */
static double way_left(const struct cost *c, double value, int64_t piece, double speed) {
    const double end = speed > 0.0 ? c->edge[piece + 1] : c->edge[piece], way = (end - value) / speed;
    return way > 0.0 ? way : 0.0;
}

/* What moving a column's variable changes of its own cost; a wall is never worth it. */
static void tell(struct program *p, SIZE column) {
    const SIZE variable = p->resting[column];
    const struct cost *c = p->costs + variable;
    const int up = piece_towards(c, p->value[variable], 1), down = piece_towards(c, p->value[variable], -1);
    p->up[column] = up > 1 ? INFINITY : c->slope[up];
    p->down[column] = down < 0 ? -INFINITY : c->slope[down];
    p->scale[column] = c->scale;
}

/* Renews the gains of the columns; exchanges the variables of a row and a column first, if it is told a row. */
static void renew(struct program *p, SIZE row, SIZE column) {
    const SIZE n = p->columns;
    double *const pivot = p->pivot;
    if (row >= 0) {
        double *const from = p->table + row * p->all, by = 1.0 / from[column];
        for (SIZE j = 0; j < n; j++) pivot[j] = from[j] *= -by;
        pivot[column] = from[column] = by;
        const SIZE variable = p->basic[row];
        p->basic[row] = p->resting[column];
        p->resting[column] = variable;
    }
    for (SIZE j = 0; j < n; j++) p->gains[j] = 0.0;
    double *some[TOGETHER], factor[TOGETHER] = {0.0}, slope[TOGETHER] = {0.0};
    int many = 0, changed = 0;
    for (SIZE i = 0; i < p->rows; i++) {
        const SIZE variable = p->basic[i];
        double *const here = p->table + i * p->all;
        slope[many] = p->costs[variable].slope[p->piece[variable]];
        factor[many] = row >= 0 && i != row ? here[column] : 0.0;
        if (slope[many] == 0.0 && factor[many] == 0.0) continue;
        if (factor[many] != 0.0) {
            here[column] = 0.0;
            changed = 1;
        }
        some[many++] = here;
        if (many < TOGETHER) continue;
        purcell_renewed(n, changed, some, factor, slope, pivot, p->gains);
        many = changed = 0;
    }
    if (!many) return;
    for (int k = many; k < TOGETHER; k++) {
        some[k] = p->idle;
        slope[k] = factor[k] = 0.0;
    }
    purcell_renewed(n, changed, some, factor, slope, pivot, p->gains);
}

/* The best column to move, how it moves and at what gain per unit; -1 where none gains. */
static SIZE chosen(const struct program *p, double least, int *direction, double *gain) {
    SIZE best = -1;
    double most = 0.0;
    for (SIZE j = 0; j < p->columns; j++) {
        const double rising = -(p->up[j] + p->gains[j]), falling = p->down[j] + p->gains[j];
        const double found = rising > falling ? rising : falling;
        if (!(found > least && found * p->scale[j] > most)) continue;
        most = found * p->scale[j];
        best = j;
        *direction = rising > falling ? 1 : -1;
        *gain = found;
    }
    return best;
}

/* Moves a column's variable as far as the cost falls, and exchanges it with what stops it, if that is another. */
static void move(struct program *p, SIZE column, int direction, double gain) {
    const SIZE mover = p->resting[column];
    double way = 0.0;
    SIZE stopped = -1;
    p->piece[mover] = piece_towards(p->costs + mover, p->value[mover], direction);
    for (SIZE i = 0; i < p->rows; i++) p->speed[i] = direction * p->table[i * p->all + column];
    for (;;) {
        double least = way_left(p->costs + mover, p->value[mover], p->piece[mover], direction);
        SIZE first = -1;
        for (SIZE i = 0; i < p->rows; i++) {
            const double speed = p->speed[i];
            const SIZE variable = p->basic[i];
            if (!(fabs(speed) * p->costs[mover].scale > TINY * p->costs[variable].scale)) continue;
            const double found = way_left(p->costs + variable, p->value[variable], p->piece[variable], speed);
            if (found < least) {
                least = found;
                first = i;
            }
        }
        way = least > way ? least : way;
        const SIZE variable = first < 0 ? mover : p->basic[first];
        const double speed = first < 0 ? direction : p->speed[first];
        const int64_t next = p->piece[variable] + (speed > 0.0 ? 1 : -1);
        stopped = first;
        if (next < 0 || next > 1) break; /* a wall */
        gain -= fabs(speed) * (p->costs[variable].slope[1] - p->costs[variable].slope[0]);
        if (!(gain > 0.0)) break;
        p->piece[variable] = next;
    }
    for (SIZE i = 0; i < p->rows; i++) p->value[p->basic[i]] += p->speed[i] * way;
    p->value[mover] += direction * way;
    const SIZE variable = stopped < 0 ? mover : p->basic[stopped];
    const double speed = stopped < 0 ? direction : p->speed[stopped];
    p->value[variable] = p->costs[variable].edge[p->piece[variable] + (speed > 0.0 ? 1 : 0)];
    renew(p, stopped, column);
    tell(p, column);
}

/* A row as it changes with the resting variables, which joins the rest of the table. */
static void join(struct program *p, SIZE row) {
    const double *from = p->matrix + row * p->all;
    double *const to = p->table + p->rows * p->all;
    for (SIZE j = 0; j < p->columns; j++) to[j] = p->resting[j] < p->all ? from[p->resting[j]] : 0.0;
    for (SIZE i = 0; i < p->rows; i++) {
        const double factor = p->basic[i] < p->all ? from[p->basic[i]] : 0.0, *other = p->table + i * p->all;
        if (factor == 0.0) continue;
        for (SIZE j = 0; j < p->columns; j++) to[j] += factor * other[j];
    }
    p->basic[p->rows++] = p->all + row;
}

/* Columns that join the rest of the table, those that gain most; returns whether any does. What the others cost rises with
 * a column by its inner product with the rows' duals. With a column that rises, rows that rest stay: what it adds to them
 * is taken away again by the basis. */
static int enter(struct program *p, double least) {
    const SIZE n = p->all;
    double best = 0.0, few[JOINING];
    SIZE first = p->columns, joining[JOINING], many = 0;
    for (SIZE j = 0; j < n; j++) p->reduced[j] = 0.0;
    for (SIZE c = 0; c < p->columns + p->rows; c++) {
        const SIZE i = c - p->columns, variable = i < 0 ? p->resting[c] : p->basic[i];
        if (variable < n) continue;
        const double dual = i < 0 ? -p->gains[c] : p->costs[variable].slope[p->piece[variable]];
        const double *row = p->matrix + (variable - n) * n;
        for (SIZE j = 0; dual != 0.0 && j < n; j++) p->reduced[j] += dual * row[j];
    }
    for (SIZE j = 0; j < n; j++) {
        if (!p->out[j]) continue;
        const struct cost *c = p->costs + j; /* it rests at its bend */
        const double rising = -(c->slope[1] + p->reduced[j]), falling = c->slope[0] + p->reduced[j];
        const double gain = rising > falling ? rising : falling;
        p->worth[j] = gain > least ? gain * c->scale : 0.0;
        best = p->worth[j] > best ? p->worth[j] : best;
    }
    for (SIZE j = 0; j < n && many < JOINING && best > 0.0; j++) {
        if (!p->out[j] || !(p->worth[j] >= AS_GOOD * best)) continue;
        joining[many++] = j;
        p->out[j] = 0;
        p->gains[p->columns] = p->reduced[j];
        p->resting[p->columns] = j;
        tell(p, p->columns++);
    }
    for (SIZE i = 0; i < p->rows; i++) {
        double *const to = p->table + i * n + first;
        const double *row = p->matrix + (p->basic[i] - n) * n;
        for (SIZE q = 0; q < many; q++) to[q] = p->basic[i] < n ? 0.0 : row[joining[q]];
    }
    for (SIZE c = 0; c < first && many; c++) {
        if (p->resting[c] < n) continue;
        const double *row = p->matrix + (p->resting[c] - n) * n;
        for (SIZE q = 0; q < many; q++) few[q] = row[joining[q]];
        for (SIZE i = 0; i < p->rows; i++) {
            double *const here = p->table + i * n, factor = here[c];
            for (SIZE q = 0; factor != 0.0 && q < many; q++) here[first + q] -= factor * few[q];
        }
    }
    return many > 0;
}

/* The x between bounds of the least sum of cost |x| + price (|m_1| + ... + max(m_(equal + 1), 0) + ...), m being what
 * matrix x - wanted misses: equations first, then inequalities. Of these those join the table that are nearly broken, if
 * they are of the first `awaited` rows, and what is broken then, until nothing is.
 *
 * matrix: (rows, columns). x: where to begin, becomes the solution, (columns,). table: (rows, columns), room: 8 rows +
 * 15 columns and whole: 3 rows + 3 columns numbers to work in. Returns how many steps were taken, or -1 if too many. */
API SIZE purcell_program(SIZE rows, SIZE columns, SIZE equal, SIZE awaited, double price, const double *matrix,
                         const double *wanted, const double *cost, const double *low, const double *high, double *x,
                         double *table, double *room, int64_t *whole) {
    const SIZE all = rows + columns;
    struct program p = {.all = columns, .matrix = matrix, .table = table, .costs = (struct cost *)room};
    double largest = price;
    p.value = room + 6 * all;
    p.gains = p.value + all;
    p.pivot = p.gains + columns;
    p.idle = p.pivot + columns;
    p.reduced = p.idle + columns;
    p.worth = p.reduced + columns;
    p.up = p.worth + columns;
    p.down = p.up + columns;
    p.scale = p.down + columns;
    p.speed = p.scale + columns;
    p.piece = whole;
    p.basic = whole + all;
    p.resting = p.basic + rows;
    p.out = p.resting + columns;
    int64_t *const joined = p.out + columns;
    for (SIZE j = 0; j < columns; j++) {
        const double bend = low[j] > 0.0 ? low[j] : high[j] < 0.0 ? high[j] : 0.0;
        p.costs[j] = (struct cost){{-cost[j], cost[j]}, {low[j], bend, high[j]}, high[j] - low[j]};
        p.value[j] = x[j] < low[j] ? low[j] : x[j] > high[j] ? high[j] : x[j];
        p.out[j] = p.value[j] == bend && low[j] < bend && bend < high[j];
        if (!p.out[j]) {
            p.resting[p.columns] = j;
            tell(&p, p.columns++);
        }
        p.idle[j] = 0.0;
        largest = cost[j] > largest ? cost[j] : largest;
    }
    for (SIZE i = 0; i < rows; i++) {
        double scale = 1e-300;
        for (SIZE j = 0; j < columns; j++) {
            const double reach = fabs(matrix[i * columns + j]) * p.costs[j].scale;
            scale = reach > scale ? reach : scale;
        }
        p.costs[columns + i] = (struct cost){{i < equal ? -price : 0.0, price}, {-NO_BOUND, 0.0, NO_BOUND}, scale};
        joined[i] = 0;
    }
    SIZE steps = 0, column = 0;
    for (int again = 0;; again = 1) {
        const SIZE known = p.rows;
        for (SIZE i = 0; i < rows; i++) {
            if (joined[i]) continue;
            double missing = -wanted[i];
            for (SIZE j = 0; j < columns; j++) missing += matrix[i * columns + j] * p.value[j];
            const double from = again || i >= awaited ? BROKEN : NEAR;
            if (i >= equal && !(missing > from * p.costs[columns + i].scale)) continue;
            p.value[columns + i] = missing;
            p.piece[columns + i] = missing < 0.0 ? 0 : 1;
            join(&p, i);
            joined[i] = 1;
        }
        if (again && p.rows == known) break;
        renew(&p, -1, 0);
        do {
            for (; steps < ROUNDS_A_COLUMN * all; steps++) {
                int direction = 0;
                double gain = 0.0;
                column = chosen(&p, TINY * largest, &direction, &gain);
                if (column < 0) break;
                move(&p, column, direction, gain);
            }
        } while (column < 0 && enter(&p, TINY * largest));
        if (column >= 0 || p.rows == rows) break;
    }
    for (SIZE j = 0; j < columns; j++) x[j] = p.value[j] < low[j] ? low[j] : p.value[j] > high[j] ? high[j] : p.value[j];
    return column < 0 || all == 0 ? steps : -1;
}
