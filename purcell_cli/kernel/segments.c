/* Where two segments are nearest to each other. */
#include <math.h>

#include "kernel.h"
#include "small.h"

static double share(double part, double whole) { return whole > 0.0 ? part / whole : part; }

static double within(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }

/* Of segments p + s first and q + t second, s and t from 0 to 1, the s, the t and the distance where they are nearest,
 * from the gap p - q. The squared distance is a convex parabola in (s, t): its least value in the square is on one of the
 * four sides, or inside where the lines pass each other; of parallel segments on a side. */
void purcell_nearest(const double gap[3], const double first[3], const double second[3], double out[3]) {
    const double uu = DOT(first, first), vv = DOT(second, second), uv = DOT(first, second);
    const double ru = DOT(gap, first), rv = DOT(gap, second);
    double normal[3], one[3], two[3];
    CROSS(normal, first, second);
    /* The lines' parameters from cross products: 1 - cos^2 would lose all digits of nearly parallel segments. */
    CROSS(one, gap, second);
    CROSS(two, gap, first);
    const double nn = DOT(normal, normal);
    const double places[5][2] = {
        {within(-share(ru, uu)), 0.0},
        {within(share(uv - ru, uu)), 1.0},
        {0.0, within(share(rv, vv))},
        {1.0, within(share(rv + uv, vv))},
        {within(-share(DOT(one, normal), nn)), within(-share(DOT(two, normal), nn))},
    };
    for (int i = 0; i < 5; i++) {
        double d[3];
        for (int j = 0; j < 3; j++) d[j] = gap[j] + places[i][0] * first[j] - places[i][1] * second[j];
        const double square = DOT(d, d);
        if (i && !(square < out[2])) continue;
        out[0] = places[i][0];
        out[1] = places[i][1];
        out[2] = square;
    }
    out[2] = sqrt(out[2]);
}

/* The same of n pairs of segments. Shapes (n, 3) to (n, 3). */
API void purcell_segments(SIZE n, const double *gap, const double *first, const double *second, double *out) {
    for (SIZE k = 0; k < 3 * n; k += 3) purcell_nearest(gap + k, first + k, second + k, out + k);
}
