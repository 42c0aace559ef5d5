/* How near the limbs come on the primitives of a motion. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define RIGHT_ANGLE 1.5707963267948966

static double bend_of(const double *limb) {
    const double c = limb[0] < -1.0 ? -1.0 : limb[0] > 1.0 ? 1.0 : limb[0];
    return 2.0 * purcell_arctan2_of(sqrt(1.0 - c), sqrt(1.0 + c));
}

/* Whether no limb bends by more than a right angle on a primitive: between two bends at most by half of the sum of both
 * and of the angle that it turns by. */
static int never_folds(const double before[2], const double after[2], double angle) {
    for (int i = 0; i < 2; i++)
        if (!(0.5 * (before[i] + after[i] + fabs(angle)) < RIGHT_ANGLE)) return 0;
    return 1;
}

/* The distance between the limbs' surfaces at a shape. */
static double distance_at(const double *numbers, const double *shape) {
    const double gap[3] = {2.0 * numbers[0], 0.0, 0.0};
    double link[2][3], place[3];
    for (int j = 0; j < 3; j++) {
        link[0][j] = numbers[1] * shape[3 * j];
        link[1][j] = -numbers[2] * shape[9 + 3 * j];
    }
    purcell_nearest(gap, link[0], link[1], place);
    return place[2] - numbers[3];
}

/* The rates of both limbs, in their own frames, on a primitive. */
static void rates_of(SIZE control, double angle, const double *shape, double out[6]) {
    const double sign = angle < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 6; i++) out[i] = 0.0;
    if (control < BASE_YAW)
        out[control] = sign;
    else
        for (int i = 0; i < 3; i++) out[3 * LIMB_OF(control) + i] = sign * shape[9 * LIMB_OF(control) + 6 + i];
}

/* What the least distance on a primitive exceeds the least that is allowed by: of the primitives on which that is small.
 *
 * control, angle, least: (n,); a primitive of which the least distance is -infinity does not matter. shapes: (n + 1, 2,
 * 3, 3). numbers: see `clearance.c`, (5,). straight: the distance of straight limbs; if that is far enough, limbs matter
 * only where one folds. near: what is small. cut: to work in, CLEARANCE_ROOM numbers.
 * room, of, stop, torque: see `purcell_bend_rooms`. Returns m, n at most. */
API SIZE purcell_clearance_rooms(SIZE n, const SIZE *control, const double *angle, const double *shapes,
                                 const double *least, const double *numbers, double straight, double near, double *cut,
                                 double *room, SIZE *of, SIZE *stop, double *torque) {
    double most = -INFINITY, bends[2][2], distances[2] = {0.0, 0.0};
    SIZE m = 0, known = -1, measured = -1; /* before which primitive the limbs' bends are known, and their distance */
    for (SIZE k = 0; k < n; k++) most = least[k] > most ? least[k] : most;
    for (SIZE k = 0; k < n && most > -INFINITY; k++) {
        const double *shape = shapes + 18 * k, lasts = fabs(angle[k]), enough = most + near;
        double *const before = bends[k % 2], *const after = bends[1 - k % 2];
        if (!(least[k] > -INFINITY)) continue;
        for (int i = 0; i < 2; i++) {
            if (known != k) before[i] = bend_of(shape + 9 * i);
            after[i] = shape[18 + 9 * i] == shape[9 * i] ? before[i] : bend_of(shape + 18 + 9 * i);
        }
        known = k + 1;
        if (straight - most >= near && never_folds(before, after, lasts)) continue;
        /* The distance changes no faster than the tip of the limb moves. */
        if (measured != k) distances[k % 2] = distance_at(numbers, shape);
        distances[1 - k % 2] = lasts == 0.0 ? distances[k % 2] : distance_at(numbers, shape + 18);
        measured = k + 1;
        if (0.5 * (distances[0] + distances[1] - numbers[1 + LIMB_OF(control[k])] * lasts) > enough + CLEARLY) continue;
        double rates[6], centre[6], cosine[6], sine[6], turn[2], best = INFINITY, when = 0.0, error;
        SIZE where = 0, count, from = 0;
        rates_of(control[k], angle[k], shape, rates);
        purcell_circles(1, shape, rates, centre, cosine, sine, turn);
        count = purcell_clearance_begun(1, numbers, centre, cosine, sine, turn, &lasts, 1, enough, &best, &when, &where, cut);
        for (; count > 0; from = 1 - from)
            count = purcell_clearance_cut(count, numbers, centre, cosine, sine, turn, &lasts, 1, enough, &best, &when,
                                          &where, cut + 5 * MOST_CUT * from, MOST_CUT / 4, cut + 5 * MOST_CUT * (1 - from),
                                          &error);
        if (!(best - least[k] < near)) continue;
        const double gap[3] = {2.0 * numbers[0], 0.0, 0.0};
        double axes[2][3], link[2][3], place[3], along[3];
        for (int i = 0; i < 2; i++) {
            double s, c;
            purcell_sin_cos_of(turn[i] * when, &s, &c);
            for (int j = 0; j < 3; j++) {
                axes[i][j] = centre[3 * i + j] + c * cosine[3 * i + j] + s * sine[3 * i + j];
                link[i][j] = (i ? -numbers[2] : numbers[1]) * axes[i][j];
            }
        }
        purcell_nearest(gap, link[0], link[1], place);
        for (int j = 0; j < 3; j++)
            along[j] = (gap[j] + place[0] * link[0][j] - place[1] * link[1][j]) / (place[2] > 0.0 ? place[2] : 1.0);
        for (int i = 0; i < 2; i++) {
            const double arm = numbers[1 + i] * place[i];
            const double pull[3] = {arm * along[0], arm * along[1], arm * along[2]};
            CROSS(torque + 6 * m + 3 * i, axes[i], pull);
        }
        of[m] = k;
        stop[m] = k + (when >= lasts);
        room[m++] = best - least[k];
    }
    return m;
}
