/* The limbs' orientations along a sequence of controls. */
#include "kernel.h"
#include "small.h"

/* One Newton step of the polar factor: it squares the defect. */
void purcell_orthonormalise_of(double r[9]) {
    double defect[9], made[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            defect[3 * i + j] = (i == j ? 1.5 : 0.0) - 0.5 * (r[i] * r[j] + r[3 + i] * r[3 + j] + r[6 + i] * r[6 + j]);
    product(r, defect, made, 3, 3, 3);
    for (int i = 0; i < 9; i++) r[i] = made[i];
}

static void turn_about_axis(double r[9], int axis, double angle) {
    const int j = (axis + 1) % 3, k = (axis + 2) % 3;
    double s, c;
    purcell_sin_cos_of(angle, &s, &c);
    for (int i = 0; i < 3; i++) {
        const double first = r[3 * i + j], second = r[3 * i + k];
        r[3 * i + j] = c * first + s * second;
        r[3 * i + k] = c * second - s * first;
    }
}

/* The limb turned about the base's z. */
static void turn_about_base(double r[9], double angle) {
    double s, c;
    purcell_sin_cos_of(angle, &s, &c);
    for (int j = 0; j < 3; j++) {
        const double first = r[j], second = r[3 + j];
        r[j] = c * first - s * second;
        r[3 + j] = s * first + c * second;
    }
}

/* A vector turned by a rotation vector: v + sin(t)/t w x v + (1 - cos t)/t^2 w x (w x v). */
void purcell_rotate(const double w[3], const double v[3], double out[3]) {
    double c[3], first[3], second[3];
    purcell_exp_of(DOT(w, w), c);
    CROSS(first, w, v);
    CROSS(second, w, first);
    for (int i = 0; i < 3; i++) out[i] = v[i] + c[0] * first[i] + c[1] * second[i];
}

/* rotation(w) = 1 + sin(t)/t hat(w) + (1 - cos t)/t^2 hat(w)^2 */
void purcell_rotation_of(const double w[3], double out[9]) {
    double c[3];
    purcell_exp_of(DOT(w, w), c);
    hat_series(w, c[0], c[1], out);
}

/* Shapes before, between and after n pieces. start: (2, 3, 3). control, amount: of primitives their controls and
 * angles, (n,) and (n,); of moves null and their rotation vectors, (n, 6). out: (n + 1, 2, 3, 3). */
API void purcell_shapes(SIZE n, const double *start, const SIZE *control, const double *amount, double *out) {
    for (int i = 0; i < 18; i++) out[i] = start[i];
    for (SIZE p = 0; p < n; p++, out += 18) {
        for (int i = 0; i < 18; i++) out[18 + i] = out[i];
        for (int limb = 0; limb < 2; limb++) {
            double *shape = out + 18 + 9 * limb, turn[9];
            const double *w = amount + 6 * p + 3 * limb;
            if (control && LIMB_OF(control[p]) != limb) continue;
            if (control && control[p] >= BASE_YAW) {
                turn_about_base(shape, amount[p]);
            } else if (control) {
                turn_about_axis(shape, (int)(control[p] % 3), amount[p]);
            } else if (w[0] != 0.0 || w[1] != 0.0 || w[2] != 0.0) {
                purcell_rotation_of(w, turn);
                product(out + 9 * limb, turn, shape, 3, 3, 3);
            } else {
                continue;
            }
            purcell_orthonormalise_of(shape);
        }
    }
}
