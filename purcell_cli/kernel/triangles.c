/* How far segments are from triangles, which stand in a tree of boxes. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define DEEPEST 64     /* levels of a tree at most: as many as the bits of a box's number */
#define ROUNDING 1e-12 /* by how much of all lengths that take part a computed distance may be off, and more */
#define THIN 1e-16     /* the square of the sine below which rounding hides which way a triangle faces */

struct segment {
    const double *first, *last;
    double way[3], low[3], high[3], middle[3];
};

static double larger(double a, double b) { return a > b ? a : b; }

/* What a segment is from all behind a plane, at least. The plane is across `off`, whose length is `size`; `height` is the
 * product of `off` and a way from the plane to the segment's middle. */
static double from_plane(const struct segment *s, const double off[3], double size, double height) {
    return size > 0.0 ? (height - 0.5 * fabs(DOT(off, s->way))) / size : 0.0;
}

/* What a segment is from all in a box, at least: what its own box is from that one, or what it is from the plane that
 * touches the box where that is nearest to the segment's middle. `off` is the way from there to the middle, `size` long. */
static double from_box(const struct segment *s, const double least[3], const double most[3], double off[3],
                       double *size) {
    double gap[3];
    for (int j = 0; j < 3; j++) {
        gap[j] = larger(larger(least[j] - s->high[j], s->low[j] - most[j]), 0.0);
        off[j] = larger(s->middle[j] - most[j], 0.0) - larger(least[j] - s->middle[j], 0.0);
    }
    const double square = DOT(off, off);
    *size = sqrt(square);
    return larger(sqrt(DOT(gap, gap)), from_plane(s, off, *size, square));
}

/* The same for a box of the tree. */
static double bound(const struct segment *s, const double *box) {
    double off[3], size;
    return from_box(s, box, box + 3, off, &size);
}

/* The same for a triangle: by its box, or by the plane that touches itself and lies as the one that touches its box. */
static double bound_of_triangle(const struct segment *s, const double *corners) {
    double least[3], most[3], off[3], size, height[3];
    for (int j = 0; j < 3; j++) {
        const double a = corners[j], b = corners[3 + j], c = corners[6 + j];
        most[j] = larger(larger(a, b), c);
        least[j] = -larger(larger(-a, -b), -c);
    }
    const double found = from_box(s, least, most, off, &size);
    for (int i = 0; i < 3; i++) {
        double way[3];
        for (int j = 0; j < 3; j++) way[j] = s->middle[j] - corners[3 * i + j];
        height[i] = -DOT(way, off);
    }
    return larger(found, from_plane(s, off, size, -larger(larger(height[0], height[1]), height[2])));
}

/* Whether a point is over the triangle of sides u and v, from their common corner. */
static int over(const double off[3], const double u[3], const double v[3]) {
    const double uu = DOT(u, u), uv = DOT(u, v), vv = DOT(v, v), pu = DOT(off, u), pv = DOT(off, v);
    const double a = vv * pu - uv * pv, b = uu * pv - uv * pu;
    return a >= 0.0 && b >= 0.0 && a + b <= uu * vv - uv * uv;
}

/* 0 where the segment crosses the triangle; else the least of its distances from the sides and of its ends' heights over
 * the triangle. One that is too thin to face anywhere has sides alone. */
static double from_triangle(const struct segment *s, const double *corners) {
    double side[3][3], v[3], normal[3], off[3], height[2], found = INFINITY;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) side[i][j] = corners[3 * ((i + 1) % 3) + j] - corners[3 * i + j];
    for (int j = 0; j < 3; j++) v[j] = -side[2][j];
    CROSS(normal, side[0], v);
    const double square = DOT(normal, normal);
    if (square > THIN * (DOT(side[0], side[0]) * DOT(v, v))) {
        const double size = sqrt(square);
        for (int j = 0; j < 3; j++) normal[j] /= size;
        for (int i = 0; i < 2; i++) {
            const double *end = i ? s->last : s->first;
            for (int j = 0; j < 3; j++) off[j] = end[j] - corners[j];
            height[i] = DOT(off, normal);
            if (fabs(height[i]) < found && over(off, side[0], v)) found = fabs(height[i]);
        }
        const double drop = height[0] - height[1];
        if (height[0] * height[1] <= 0.0 && drop != 0.0) {
            const double part = height[0] / drop;
            for (int j = 0; j < 3; j++) off[j] = s->first[j] + part * s->way[j] - corners[j];
            if (over(off, side[0], v)) return 0.0;
        }
    }
    for (int i = 0; i < 3; i++) {
        double gap[3], near[3];
        for (int j = 0; j < 3; j++) gap[j] = s->first[j] - corners[3 * i + j];
        purcell_nearest(gap, s->way, side[i], near);
        if (near[2] < found) found = near[2];
    }
    return found;
}

/* The least of `most` and the distances from the triangles of a leaf. */
static double from_leaf(const struct segment *s, SIZE width, const double *corners, double slack, double most) {
    for (SIZE i = 0; i < width; i++, corners += 9) {
        if (!(bound_of_triangle(s, corners) <= most + slack)) continue;
        const double found = from_triangle(s, corners);
        if (found < most) most = found;
    }
    return most;
}

/* The distance of each of n segments from the nearest triangle, or `most` where that is less: what comparing with all
 * triangles would find, for what is left out is farther by more than rounding. Of a tree with a power of 2 of leaves box k
 * has the boxes 2 k + 1 and 2 k + 2 below it, and the last ones are the leaves'; of two the nearer is looked at first.
 * Shapes (n, 3), (n, 3), (n,), (2 leaves - 1, 2, 3) and (leaves, width, 3, 3) to (n,). */
API void purcell_from_triangles(SIZE n, const double *first, const double *last, const double *most, SIZE leaves,
                                SIZE width, const double *boxes, const double *corners, double *out) {
    double across[3];
    for (int j = 0; j < 3; j++) across[j] = boxes[3 + j] - boxes[j];
    const double diagonal = sqrt(DOT(across, across));
    for (SIZE k = 0; k < n; k++, first += 3, last += 3) {
        struct segment s = {.first = first, .last = last};
        for (int j = 0; j < 3; j++) {
            s.way[j] = last[j] - first[j];
            s.high[j] = larger(first[j], last[j]);
            s.low[j] = -larger(-first[j], -last[j]);
            s.middle[j] = 0.5 * (first[j] + last[j]);
        }
        const double lengths = sqrt(DOT(s.way, s.way)) + sqrt(DOT(s.middle, s.middle)) + diagonal;
        SIZE box[DEEPEST], count = 1;
        double away[DEEPEST], best = most[k];
        box[0] = 0;
        away[0] = bound(&s, boxes);
        while (count && best > 0.0) {
            const SIZE here = box[--count];
            const double slack = ROUNDING * (best + lengths);
            if (!(away[count] <= best + slack)) continue;
            if (here >= leaves - 1) {
                best = from_leaf(&s, width, corners + 9 * width * (here - (leaves - 1)), slack, best);
                continue;
            }
            const SIZE one = 2 * here + 1, two = one + 1;
            const double from_one = bound(&s, boxes + 6 * one), from_two = bound(&s, boxes + 6 * two);
            const int nearer = from_two < from_one;
            box[count] = nearer ? one : two; /* the last is taken next */
            away[count++] = nearer ? from_one : from_two;
            box[count] = nearer ? two : one;
            away[count++] = nearer ? from_two : from_one;
        }
        out[k] = best;
    }
}
