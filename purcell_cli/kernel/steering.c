/* Needle steering: three arcs, in planes of any roll, and a last roll, that make a displacement at little cost. */
#include <math.h>

#include "kernel.h"
#include "small.h"

#define ARCS 3
#define UNKNOWN (3 * ARCS + 1)
#define ROUNDS 10         /* of least squares, the settling ones included */
#define SETTLING 3        /* the last rounds, in which arcs only settle on the displacement and the weights stay */
#define SMALL_TURN 1e-3   /* below this a derivative is taken from its series, since its closed form cancels [rad] */
#define ROLL_PRICE 0.1    /* weight of the squared last roll beside those of the arcs */
#define LEAST 1e-2        /* the least cost of an arc in its weights, which an empty arc would make infinite [rad] */
#define LONGEST_TURN 0.5  /* the largest change of a turn or roll in one round [rad] */
/* The least advance and turn by which an arc is priced, as a part of what its cost could make of either, and at most
 * [L, rad]; without it an arc that only advances, or only turns, could never do the other. */
#define REVIVED 0.1
#define REVIVED_WAY 1.0
#define REVIVED_TURN 0.5
#define DAMPING 1e-12     /* of the equations' matrix, as a part of its trace */

/* Loops from the one that goes straight to the one that turns most: `count` bearings of turn against advance, both in
 * what a unit cost makes at most, ascending, and what goes that way. */
struct fan {
    double straight, tight;
    SIZE count;
    const double *bearing, *size;
};

/* What an arc costs when its loops repeat often; a tighter one than the tightest loop's is swum to and fro. */
static double cost_of(const struct fan *f, double advance, double turn) {
    const double a = fabs(advance) / f->straight, b = fabs(turn) / f->tight, at = purcell_arctan2_of(b, a);
    double size;
    SIZE k = 1;
    while (k + 1 < f->count && f->bearing[k] < at) k++;
    if (!(at > f->bearing[0]))
        size = f->size[0];
    else if (!(at < f->bearing[f->count - 1]))
        size = f->size[f->count - 1];
    else
        size = f->size[k - 1] + (f->size[k] - f->size[k - 1]) * ((at - f->bearing[k - 1]) / (f->bearing[k] - f->bearing[k - 1]));
    const double cost = sqrt(a * a + b * b) / size;
    return cost > b ? cost : b;
}

/* The inverse weights of quadratics that fall with the cost of an arc. */
static void looseness(const struct fan *f, const double arc[3], double out[3]) {
    double a = fabs(arc[0]), b = sqrt(arc[1] * arc[1] + arc[2] * arc[2]), here = cost_of(f, a, b);
    here = here > LEAST ? here : LEAST;
    double least_a = REVIVED * f->straight * here, least_b = REVIVED * f->tight * here;
    least_a = least_a < REVIVED_WAY ? least_a : REVIVED_WAY;
    least_b = least_b < REVIVED_TURN ? least_b : REVIVED_TURN;
    a = a > least_a ? a : least_a;
    b = b > least_b ? b : least_b;
    here = cost_of(f, a, b);
    const double more_a = 100.0 * (cost_of(f, 1.01 * a, b) / here - 1.0), more_b = 100.0 * (cost_of(f, a, 1.01 * b) / here - 1.0);
    out[0] = a * a / (here * (more_a > 0.05 ? more_a : 0.05));
    out[1] = out[2] = b * b / (here * (more_b > 0.05 ? more_b : 0.05));
}

/* The displacement exp(a, 0, 0; 0, p, q) of an arc, and the body twists of changes of a, p and q. The series have only
 * even powers of the turn, so their closed forms (Murray, Li and Sastry 1994, section 2.3) need no root. */
static void swum(const double arc[3], double rotation[9], double position[3], double twist[6][3]) {
    const double a = arc[0], p = arc[1], q = arc[2], tt = p * p + q * q;
    double c[3], slope[3][3];
    purcell_exp_of(tt, c);
    const double sine = c[0], cosine = c[1], rest = c[2], sine_slope = rest - cosine;
    const double cosine_slope = tt < SMALL_TURN * SMALL_TURN ? tt / 180.0 - 1.0 / 12.0 : (sine - 2.0 * cosine) / tt;
    const double r[9] = {1.0 - cosine * tt, -sine * q, sine * p, sine * q, 1.0 - cosine * q * q, cosine * p * q,
                         -sine * p, cosine * p * q, 1.0 - cosine * p * p};
    const double unit[3] = {sine, cosine * q, -cosine * p};
    const double by_p[3] = {sine_slope * p, cosine_slope * p * q, -cosine_slope * p * p - cosine};
    const double by_q[3] = {sine_slope * q, cosine_slope * q * q + cosine, -cosine_slope * q * p};
    for (int i = 0; i < 3; i++) {
        position[i] = a * unit[i];
        slope[i][0] = unit[i];
        slope[i][1] = a * by_p[i];
        slope[i][2] = a * by_q[i];
    }
    for (int i = 0; i < 9; i++) rotation[i] = r[i];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            twist[i][k] = r[i] * slope[0][k] + r[3 + i] * slope[1][k] + r[6 + i] * slope[2][k];
            twist[3 + i][0] = 0.0;
        }
    /* The right Jacobian 1 - (1 - cos t) / t^2 hat(w) + (t - sin t) / t^3 hat(w)^2 on the axes y and z. */
    twist[3][1] = cosine * q;
    twist[4][1] = 1.0 - rest * q * q;
    twist[5][1] = twist[4][2] = rest * p * q;
    twist[3][2] = -cosine * p;
    twist[5][2] = 1.0 - rest * p * p;
}

/* log(D^-1 exp .. exp exp(roll)) and its derivative; inverse: D^-1. */
static void equations(const double x[UNKNOWN], const double inverse[16], double residual[6], double jacobian[6][UNKNOWN]) {
    double g[16], off[16], s, c;
    purcell_sin_cos_of(x[UNKNOWN - 1], &s, &c);
    identity(g, 4);
    g[5] = g[10] = c;
    g[6] = -s;
    g[9] = s;
    for (int i = 0; i < 6; i++) jacobian[i][UNKNOWN - 1] = i == 3;
    for (int k = ARCS - 1; k >= 0; k--) {
        double move[16], rotation[9], position[3], twist[6][3], back[16], ad[36], made[16];
        swum(x + 3 * k, rotation, position, twist);
        inverse_pose(g, back);
        adjoint(back, ad);
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 3; j++) {
                double sum = ad[6 * i] * twist[0][j];
                for (int l = 1; l < 6; l++) sum += ad[6 * i + l] * twist[l][j];
                jacobian[i][3 * k + j] = sum;
            }
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) move[4 * i + j] = rotation[3 * i + j];
            move[4 * i + 3] = position[i];
            move[12 + i] = 0.0;
        }
        move[15] = 1.0;
        product(move, g, made, 4, 4, 4);
        for (int i = 0; i < 16; i++) g[i] = made[i];
    }
    product(inverse, g, off, 4, 4, 4);
    purcell_orthonormalise(1, 4, off);
    purcell_log(1, off, residual);
}

/* Brings n beginnings to displacements, each by least squares that are weighted anew in every round.
 *
 * bearing, size: of a fan, (count,). inverse: of the displacements, (n, 4, 4). x: advance and turns of three arcs and a
 * roll, (n, 10), changed. off: what they then miss, (n,). */
API void purcell_steer(SIZE n, double straight, double tight, SIZE count, const double *bearing, const double *size,
                       const double *inverse, double *x, double *off) {
    const struct fan f = {straight, tight, count, bearing, size};
    for (SIZE c = 0; c < n; c++, inverse += 16, x += UNKNOWN) {
        double residual[6], jacobian[6][UNKNOWN], loose[UNKNOWN];
        loose[UNKNOWN - 1] = 1.0 / ROLL_PRICE;
        for (int round = 0; round < ROUNDS; round++) {
            const int weighing = round < ROUNDS - SETTLING;
            double system[36], wanted[6], step[UNKNOWN], trace = 0.0, turning = 1e-300;
            equations(x, inverse, residual, jacobian);
            for (int k = 0; weighing && k < ARCS; k++) looseness(&f, x + 3 * k, loose + 3 * k);
            for (int i = 0; i < 6; i++) {
                wanted[i] = -residual[i];
                for (int j = 0; weighing && j < UNKNOWN; j++) wanted[i] += jacobian[i][j] * x[j];
                for (int l = 0; l < 6; l++) {
                    double sum = 0.0;
                    for (int j = 0; j < UNKNOWN; j++) sum += jacobian[i][j] * loose[j] * jacobian[l][j];
                    system[6 * i + l] = sum;
                }
                trace += system[7 * i];
            }
            for (int i = 0; i < 6; i++) system[7 * i] += DAMPING * trace;
            purcell_solve(1, 6, 1, system, wanted);
            for (int j = 0; j < UNKNOWN; j++) {
                double sum = 0.0;
                for (int i = 0; i < 6; i++) sum += jacobian[i][j] * wanted[i];
                step[j] = loose[j] * sum - (weighing ? x[j] : 0.0);
                if ((j == UNKNOWN - 1 || j % 3) && fabs(step[j]) > turning) turning = fabs(step[j]);
            }
            const double part = LONGEST_TURN / turning < 1.0 ? LONGEST_TURN / turning : 1.0;
            for (int j = 0; j < UNKNOWN; j++) x[j] += step[j] * part;
        }
        equations(x, inverse, residual, jacobian);
        off[c] = 0.0;
        for (int i = 0; i < 6; i++) off[c] = fabs(residual[i]) <= off[c] ? off[c] : fabs(residual[i]);
    }
}
