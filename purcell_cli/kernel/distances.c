/* How far segments are from balls and boxes, and how deep they are inside cones with round ends. */
#include <math.h>

#include "kernel.h"
#include "small.h"

static double within(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }

/* The distance of each of n segments from the surface of the nearest of m balls, and which that is; m is 1 or more.
 * Shapes (n, 3), (n, 3), (m, 3) and (m,) to (n,) each. */
API void purcell_from_balls(SIZE n, const double *first, const double *last, SIZE m, const double *centres,
                            const double *radii, double *out, SIZE *which) {
    for (SIZE k = 0; k < n; k++, first += 3, last += 3) {
        const double way[3] = {last[0] - first[0], last[1] - first[1], last[2] - first[2]};
        const double square = DOT(way, way), whole = square > 0.0 ? square : 1.0;
        for (SIZE i = 0; i < m; i++) {
            const double *centre = centres + 3 * i;
            double gap[3] = {centre[0] - first[0], centre[1] - first[1], centre[2] - first[2]};
            const double part = within(DOT(gap, way) / whole);
            for (int j = 0; j < 3; j++) gap[j] -= part * way[j];
            const double found = sqrt(DOT(gap, gap)) - radii[i];
            if (i && !(found < out[k])) continue;
            out[k] = found;
            which[k] = i;
        }
    }
}

/* How far a point is out of a box, coordinate by coordinate. */
static void beyond(const double at[3], const double half[3], double out[3]) {
    for (int j = 0; j < 3; j++) out[j] = at[j] < -half[j] ? at[j] + half[j] : at[j] > half[j] ? at[j] - half[j] : 0.0;
}

/* How deep a point is in a box, negative inside: by the nearest face. */
static double by_face(const double at[3], const double half[3], int *face) {
    double best = fabs(at[0]) - half[0];
    *face = 0;
    for (int j = 1; j < 3; j++) {
        const double here = fabs(at[j]) - half[j];
        if (!(here > best)) continue;
        best = here;
        *face = j;
    }
    return best;
}

/* The least signed distance from a box along a segment that meets it: a convex function, its least value by halving. */
static double deepest(const double begin[3], const double way[3], const double half[3], SIZE rounds) {
    double low = 0.0, high = 1.0, at[3];
    int face;
    for (SIZE k = 0; k < rounds; k++) {
        const double middle = 0.5 * (low + high);
        for (int j = 0; j < 3; j++) at[j] = begin[j] + middle * way[j];
        by_face(at, half, &face);
        const double slope = at[face] < 0.0 ? -way[face] : way[face];
        if (slope < 0.0) low = middle;
        else high = middle;
    }
    for (int j = 0; j < 3; j++) at[j] = begin[j] + low * way[j];
    const double one = by_face(at, half, &face);
    for (int j = 0; j < 3; j++) at[j] = begin[j] + high * way[j];
    const double two = by_face(at, half, &face);
    return one < two ? one : two;
}

/* The signed distance of a segment from a box: exact outside, to 2^-rounds of its length inside. The square of the
 * distance is convex along a segment, and a parabola between the six points at which a coordinate passes a face: its
 * slope, which only rises, tells between which two the least is. */
static double from_box(const double first[3], const double last[3], const double *centre, const double *turned,
                       const double *half, SIZE rounds) {
    double begin[3], way[3], at[3], off[3], edge[8];
    for (int j = 0; j < 3; j++) {
        begin[j] = way[j] = 0.0;
        for (int i = 0; i < 3; i++) {
            begin[j] += (first[i] - centre[i]) * turned[3 * i + j];
            way[j] += (last[i] - first[i]) * turned[3 * i + j];
        }
    }
    int count = 1;
    edge[0] = 0.0;
    for (int j = 0; j < 6; j++) {
        const int axis = j >> 1;
        const double pass = ((j & 1 ? half[axis] : -half[axis]) - begin[axis]) / way[axis];
        if (!(pass > 0.0 && pass < 1.0)) continue;
        int i = count++;
        for (; i > 1 && edge[i - 1] > pass; i--) edge[i] = edge[i - 1];
        edge[i] = pass;
    }
    edge[count] = 1.0;
    double low = 0.0, rising = 0.0, where = 1.0;
    for (int i = 0; i <= count; i++) {
        for (int j = 0; j < 3; j++) at[j] = begin[j] + edge[i] * way[j];
        beyond(at, half, off);
        const double slope = DOT(off, way);
        if (slope >= 0.0) {
            where = i && slope > rising ? low + within(-rising / (slope - rising)) * (edge[i] - low) : edge[i];
            break;
        }
        low = edge[i];
        rising = slope;
    }
    for (int j = 0; j < 3; j++) at[j] = begin[j] + where * way[j];
    beyond(at, half, off);
    const double square = DOT(off, off);
    return square > 0.0 ? sqrt(square) : deepest(begin, way, half, rounds);
}

/* The signed distance of each of n segments from the nearest of m boxes, and which that is; m is 1 or more. A box whose
 * ball is not nearer than the best is left out. Shapes (n, 3), (n, 3), (m, 3), (m, 3, 3) and (m, 3) to (n,) each. */
API void purcell_from_boxes(SIZE n, const double *first, const double *last, SIZE m, const double *centres,
                            const double *turned, const double *halves, SIZE rounds, double *out, SIZE *which) {
    for (SIZE k = 0; k < n; k++, first += 3, last += 3) {
        const double way[3] = {last[0] - first[0], last[1] - first[1], last[2] - first[2]};
        const double reach = 0.5 * sqrt(DOT(way, way));
        for (SIZE i = 0; i < m; i++) {
            const double *centre = centres + 3 * i, *half = halves + 3 * i;
            double gap[3];
            for (int j = 0; j < 3; j++) gap[j] = first[j] + 0.5 * way[j] - centre[j];
            if (i && sqrt(DOT(gap, gap)) - reach - sqrt(DOT(half, half)) >= out[k]) continue;
            const double found = from_box(first, last, centre, turned + 9 * i, half, rounds);
            if (i && !(found < out[k])) continue;
            out[k] = found;
            which[k] = i;
        }
    }
}

/* How deep a point is in a cone with round ends; negative outside. The nearest ball of a cone stands aside of the foot
 * of the perpendicular, by the slope of its side; the ball at the thick end of a steep one holds all others. */
static double depth(const double point[3], const double *first, const double *way, double radius, double change,
                    double size, double lean) {
    const double gap[3] = {point[0] - first[0], point[1] - first[1], point[2] - first[2]};
    const double foot = DOT(gap, way) / size;
    double across = DOT(gap, gap) - foot * foot;
    if (across < 0.0) across = 0.0;
    const double part = fabs(change) >= size ? (change > 0.0 ? 1.0 : 0.0) : within((foot + sqrt(across) * lean) / size);
    const double away = foot - part * size;
    return radius + part * change - sqrt(across + away * away);
}

/* How far inside the union of m cones n segments are at the least, and in which cone they are there. Each is cut into
 * cells, and a cell is as deep inside as the best of the cones has its shallower end; m is 1 or more, room takes 3 m
 * numbers. Shapes (n, 3), (m, 3), (m,) to (n,) each. */
API void purcell_inside_cones(SIZE n, const double *first, const double *last, SIZE cells, SIZE m, const double *begin,
                              const double *way, const double *radius, const double *change, double *room,
                              double *out, SIZE *which) {
    double *size = room, *lean = room + m, *before = room + 2 * m;
    for (SIZE i = 0; i < m; i++) {
        size[i] = sqrt(DOT(way + 3 * i, way + 3 * i));
        const double slope = change[i] / size[i];
        lean[i] = fabs(slope) >= 1.0 ? 0.0 : slope / sqrt(1.0 - slope * slope);
    }
    for (SIZE k = 0; k < n; k++, first += 3, last += 3) {
        double least = 0.0;
        SIZE owner = 0;
        const int place = first[0] == last[0] && first[1] == last[1] && first[2] == last[2];
        const SIZE count = place ? 1 : cells; /* a point needs no more than one */
        for (SIZE c = 0; c <= count; c++) {
            const double part = (double)c / (double)count;
            double point[3], best = 0.0;
            for (int j = 0; j < 3; j++) point[j] = first[j] + part * (last[j] - first[j]);
            for (SIZE i = 0; i < m; i++) {
                const double here =
                    depth(point, begin + 3 * i, way + 3 * i, radius[i], change[i], size[i], lean[i]);
                const double cell = c && !(here < before[i]) ? before[i] : here;
                before[i] = here;
                if (i && !(cell > best)) continue;
                best = cell;
                owner = i;
            }
            if (!c || (c > 1 && !(best < least))) continue;
            least = best;
            which[k] = owner;
        }
        out[k] = least;
    }
}
