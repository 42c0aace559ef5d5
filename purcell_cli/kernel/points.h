/* A motion whose angles are sought, and what is known of it at a point: the equations of its arrival and its limits. */
#ifndef PURCELL_POINTS_H
#define PURCELL_POINTS_H

#include <math.h>

#include "kernel.h"

/* Adds inequalities at the angles that were told it; returns how many, or -1 to stop. */
typedef SIZE watcher(void);

struct motion {
    const double *swimmer;
    struct rule rule;
    SIZE n, free, equations; /* primitives, free angles, equations */
    SIZE most, added;        /* inequalities at most, and those of them that the watcher adds */
    const SIZE *control, *index, *fixed;
    SIZE k, t;
    const SIZE *repeats, *stops;
    const double *start, *given, *sign, *wanted, *ends, *least, *weight;
    const double *apart, *links; /* see `purcell_clearance_rooms`: `least`, or null, and `numbers` */
    double near, straight, near_apart, price;
    watcher *watch;
    double *told, *more_room, *more_slope; /* the angles for the watcher, and what it adds */
    double *flow, *columns, *axes, *cut;   /* to work in */
    int plain;                             /* whether every primitive has a free angle of its own */
};

/* What an inequality is of: a primitive that turns, or one at angle zero. Its limbs are where they were before, so that
 * matters only where it may turn, and before others at angle zero only with those. */
enum { TURNING, IDLE, PASSING };

struct point {
    double *angle, *all, *shapes, *residual, *derivative, *room, *torque, *slope; /* slope: of what the watcher added */
    SIZE *of, *stop, *kind, rooms, turning, known; /* torques tell the slope of the first `known` rooms */
    double size, violation, merit;
    int sloped; /* whether the equations' derivative is known */
};

/* Memory to work in, one part after the other. */
static inline double *taken(double **room, SIZE count) {
    double *const out = *room;
    *room += count;
    return out;
}

static inline SIZE *whole_taken(SIZE **room, SIZE count) {
    SIZE *const out = *room;
    *room += count;
    return out;
}

static inline double largest(SIZE n, const double *x) {
    double out = 0.0;
    for (SIZE i = 0; i < n; i++) {
        const double size = fabs(x[i]);
        if (size != size) return size;
        out = size > out ? size : out;
    }
    return out;
}

/* How many numbers a point is, and a point in memory to work in. */
SIZE purcell_point_room(SIZE n, SIZE free, SIZE equations, SIZE most, SIZE added);
void purcell_point_of(const struct motion *m, double **room, SIZE **whole, struct point *p);
/* The equations at a point's angles, with their derivative or, in half of the time, without. Returns 0, or the number of
 * a piece that is too long, counted from 1. */
SIZE purcell_point_equations(const struct motion *m, struct point *p, int sloped);
/* The room below the limits there. Returns 0, or -1 to stop. */
SIZE purcell_point_limits(const struct motion *m, struct point *p);
/* How the rooms of the first kinds change with the free angles, kind after kind: (j, free). room: those, (j,). Returns j. */
SIZE purcell_point_slopes(const struct motion *m, const struct point *p, SIZE last_kind, double *room, double *slope);
/* All of a point but the equations' derivative. Returns 0, -1 to stop, or the number of a piece that is too long. */
SIZE purcell_point_evaluated(const struct motion *m, struct point *p);

#endif
