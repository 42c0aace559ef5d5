/* The equations of an exact arrival of moves, and the bend limit as inequalities on their rotation vectors. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define FULL_TURN 6.283185307179586

/* How a rotation by w, after which more rotations follow, turns as w changes: 1 + b hat(w) + c hat(w)^2, times r. */
static void turning(const double w[3], const double r[9], double out[9]) {
    double c[3], left[9];
    purcell_exp_of(DOT(w, w), c);
    hat_series(w, c[1], c[2], left);
    product(left, r, out, 3, 3, 3);
}

/* What is missing of a displacement and of shapes where phases end, and its derivative by the rotation vectors of n moves.
 *
 * Arguments as of `purcell_equations`. turn: (n, 6). room: to work in, (n, 94) and (k, 36). turned: each limb's turn in
 * base coordinates, and how its later path turns as its rotation vector changes, (n, 2, 3) and (n, 2, 3, 3). derivative:
 * (6 + 6 t, 6 n). Returns 0, or the number of a piece that is too long, counted from 1. */
API SIZE purcell_move_equations(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                                const double *to_node, double step, double settled, SIZE n, const double *start,
                                const double *turn, SIZE k, const SIZE *repeats, const double *wanted, SIZE t,
                                const SIZE *stops, const double *ends, double *room, double *turned, double *shapes,
                                double *residual, double *derivative) {
    double pose[16], off[16], *path = turned + 6 * n;
    purcell_shapes(n, start, 0, turn, shapes);
    const SIZE long_piece = purcell_flow_and_derivatives(swimmer, stages, nodes, weights, to_node, step, settled, n,
                                                         shapes, 0, turn, k, repeats, room, pose, derivative);
    if (long_piece) return long_piece;
    product(wanted, pose, off, 4, 4, 4);
    purcell_orthonormalise(1, 4, off);
    purcell_log(1, off, residual);
    for (SIZE i = 0; i < 2 * n; i++) {
        product(shapes + 9 * i, turn + 3 * i, turned + 3 * i, 3, 3, 1);
        turning(turned + 3 * i, shapes + 9 * i, path + 9 * i);
    }
    for (SIZE e = 0; e < t; e++, ends += 18) {
        double *rows = derivative + 36 * (e + 1) * n;
        purcell_gap_between(shapes + 18 * stops[e], ends, residual + 6 * (e + 1));
        for (SIZE i = 0; i < 36 * n; i++) rows[i] = 0.0;
        for (SIZE p = 0; p < stops[e]; p++)
            for (int i = 0; i < 6; i++)
                for (int j = 0; j < 3; j++)
                    rows[6 * n * i + 6 * p + 3 * (i / 3) + j] = path[18 * p + 3 * i + j];
    }
    return 0;
}

/* The room left below the bend limit where each limb is most bent on each move, and its derivative.
 *
 * On a move a limb's axis goes round a circle, on which its bend is largest at the end or where the circle is furthest
 * from the base's axis. shapes, turned: see `purcell_move_equations`. least: the least cosine of each limb's bend on each
 * move, (n, 2). near: more room than this does not matter. room, slope: (m,) and (m, 6 n). Returns m, 2 n at most. */
API SIZE purcell_move_bends(SIZE n, const double *shapes, const double *turned, const double *least, double near,
                            double *room, double *slope) {
    const double *path = turned + 6 * n;
    SIZE m = 0;
    for (SIZE i = 0; i < 2 * n; i++) {
        const double *shape = shapes + 9 * i, *turn = turned + 3 * i;
        const double angle = sqrt(DOT(turn, turn)), by = angle > 0.0 ? 1.0 / angle : 0.0;
        const double about[3] = {by * turn[0], by * turn[1], by * turn[2]}, axis[3] = {shape[0], shape[3], shape[6]};
        const double along = DOT(about, axis), cosine = axis[0] - along * about[0];
        const double sine = about[1] * axis[2] - about[2] * axis[1];
        double far = purcell_arctan2_of(-sine, -cosine), own[9], rotation[9], place[3], part[3];
        if (far < 0.0) far += FULL_TURN;
        const double share = far > 0.0 && far < angle ? far / angle : 1.0;
        for (int j = 0; j < 3; j++) part[j] = share * turn[j];
        purcell_rotation_of(part, rotation);
        product(rotation, axis, place, 3, 3, 1);
        const double left = place[0] - least[i];
        if (!(left < near)) continue;
        room[m] = left;
        double *row = slope + 6 * n * m++;
        for (SIZE q = 0; q < 6 * n; q++) row[q] = 0.0;
        const SIZE limb = i % 2;
        for (SIZE q = 0; q < i / 2; q++)
            for (int j = 0; j < 3; j++)
                row[6 * q + 3 * limb + j] =
                    place[2] * path[9 * (2 * q + limb) + 3 + j] - place[1] * path[9 * (2 * q + limb) + 6 + j];
        turning(part, shape, own);
        for (int j = 0; j < 3; j++) row[3 * i + j] = share * (place[2] * own[3 + j] - place[1] * own[6 + j]);
    }
    return m;
}
