/* What the compiled kernel offers, and what its files share.
 *
 * The same bits on every machine and with every compiler: all numbers are IEEE doubles, all sums and products stand in
 * one order, nothing is contracted (-ffp-contract=off), and of the C library only sqrt and fabs are called, which IEEE
 * rounds correctly. The certificate alone has a function in extended precision too, whose digits are the machine's.
 * Sizes and shapes are checked by the Python side, which owns all memory; matrices are row by row.
 */
#ifndef PURCELL_KERNEL_H
#define PURCELL_KERNEL_H

#include <float.h>
#include <stdint.h>

#if FLT_EVAL_METHOD != 0
#error "doubles must be computed as doubles: build for SSE2 (-mfpmath=sse -msse2)"
#endif
#ifdef __FAST_MATH__
#error "the kernel must be built without -ffast-math"
#endif

#ifdef _WIN32
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

#define SIZE int64_t

/* A number for each of two nodes: the processor works on both at once, each as it would work on one. */
typedef double lane __attribute__((vector_size(16)));
#define LANES 2

/* wide_sums.c: whether the processor and its system have registers of 256 bits, for four numbers, and a multiplication
 * that keeps all digits for an addition; a build with PURCELL_NARROW never uses them. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(PURCELL_NARROW)
#define WIDE
int purcell_is_wide(void);
#endif

/* elementary.c: a sine and cosine, an arc tangent, and sin(t)/t, (1 - cos t)/t^2, (t - sin t)/t^3 of t^2. */
#define SERIES_TERMS 12
#define SERIES_BELOW 2.25
extern const double purcell_series[SERIES_TERMS][3];
void purcell_sin_cos_of(double angle, double *sine, double *cosine);
double purcell_arctan2_of(double y, double x);
void purcell_exp_of(double angle_squared, double out[3]);

/* shapes.c: a vector turned by a rotation vector, the rotation of one, and one Newton step of the polar factor. */
void purcell_rotate(const double w[3], const double v[3], double out[3]);
void purcell_rotation_of(const double vector[3], double out[9]);
void purcell_orthonormalise_of(double rotation[9]);

/* segments.c: where two segments are nearest to each other. */
void purcell_nearest(const double gap[3], const double first[3], const double second[3], double out[3]);

/* Controls 0 to 5 turn a limb about its own x, y, z; 6 and 7 turn limb 1 and limb 2 about the base's z. */
#define BASE_YAW 6
#define LIMB_OF(control) ((int)((control) < BASE_YAW ? (control) / 3 : (control) - BASE_YAW))

/* trust_region.c, linear.c, poses.c, shapes.c, derivatives.c: see there. */
API SIZE purcell_step_taken(double promised, double gained, double largest, double *reach);
API void purcell_solve(SIZE count, SIZE k, SIZE m, double *a, double *x);
API SIZE purcell_orthogonal_rows(SIZE k, SIZE n, double *rows, double weakest, double *basis, double *made);
API void purcell_quaternions(SIZE n, const double *rotations, double *out);
API void purcell_exp(SIZE n, const double *twists, double *out);
API void purcell_log(SIZE n, const double *poses, double *out);
API void purcell_orthonormalise(SIZE n, SIZE d, double *matrices);
API void purcell_least_steps(SIZE n, SIZE k, const double *columns, const double *wanted, const double *begun,
                             const double *loose, const double *low, const double *high, double *room, double *out);
API void purcell_shapes(SIZE n, const double *start, const SIZE *control, const double *amount, double *out);
API SIZE purcell_flow_and_derivatives(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                                      const double *to_node, double step, double settled, SIZE n, const double *shapes,
                                      const SIZE *control, const double *amount, SIZE k, const SIZE *repeats,
                                      double *room, double *pose, double *derivative);

/* The swimmer's numbers, scaled to a length of 1 and a lateral drag per length of 1. */
struct limb {
    double side;     /* 1 where it hangs at the base's +x end, -1 at the other */
    double half;     /* half its length */
    double lateral;  /* drag across the axis */
    double defect;   /* by what part the drag along the axis is less */
    double turn;     /* torque of turning across the axis */
    double spin;     /* torque of spinning about it */
};

struct swimmer {
    double half;             /* half the base's length */
    double drag[6];          /* the base's drag, its matrix being diagonal */
    double sharpness;        /* distance from the collinear shape below which spin drag resists roll [rad] */
    double straight_spread;  /* what a bend of one limb adds to the spread of the links */
    double steepness;        /* how fast the distance can change with the angle of a limb */
    struct limb limbs[2];
    double tables;           /* how many `struct bead_table` follow: 0 for links that do not feel each other */
    double numbers[];
};

/* The resistance of links that feel each other over the limbs' bends, up to one; those of a swimmer follow one another, the
 * one that reaches furthest last. */
struct bead_table {
    double reach, least;      /* up to which bend it reaches [rad], and that bend's cosine */
    double bends, multiples;  /* Chebyshev polynomials of each limb's bend, and multiples of the angle between their planes */
    /* (2, 2, multiples, bends) numbers of coefficients that count, roughly and exactly, for the sums over limb 1's bend at
     * a multiple and one of limb 2's polynomials, and for those over limb 2's; then for each of these sums (multiples,
     * bends, bends, WIDTH) coefficients: the last bend is the one that is summed over. */
    double numbers[];
};

/* shooting.c, program.c: see there. */
API SIZE purcell_equations(const double *swimmer, SIZE stages, const double *nodes, const double *weights,
                           const double *to_node, double step, double settled, SIZE n, const double *start,
                           const SIZE *control, const double *angle, SIZE k, const SIZE *repeats, const double *wanted,
                           SIZE t, const SIZE *stops, const double *ends, double *room, double *shapes,
                           double *residual, double *derivative);
void purcell_turning_axis(SIZE control, const double *shape, double out[3]);
void purcell_turns_about_base(SIZE n, const SIZE *control, int out[2]);
void purcell_gap_between(const double *found, const double *wanted, double out[6]);
API SIZE purcell_bend_rooms(SIZE n, const SIZE *control, const double *angle, const double *shapes, const double *least,
                            const SIZE *fixed, double near, double *room, SIZE *of, SIZE *stop, double *torque);
void purcell_turning_axes(SIZE n, const SIZE *control, const double *shapes, double *axes);
void purcell_room_slope(SIZE stop, const double *torque, SIZE n, const SIZE *control, const double *shapes,
                        const double *axes, double *slope);
API SIZE purcell_step_room(SIZE r, SIZE n);
API void purcell_bounded_step(SIZE m, SIZE k, SIZE n, const double *arrival, const double *missing, const double *room,
                              const double *slope, double reach, SIZE fine, double *work, double *out);
API SIZE purcell_program(SIZE rows, SIZE columns, SIZE equal, SIZE awaited, double price, const double *matrix,
                         const double *wanted, const double *cost, const double *low, const double *high, double *x,
                         double *table, double *room, int64_t *whole);

/* clearance.c, clearance_rooms.c: see there. */
#define MOST_CUT 1024 /* stretches of one primitive that are looked at at once */
#define CLEARANCE_ROOM (2 * MOST_CUT * 5)
API SIZE purcell_clearance_rooms(SIZE n, const SIZE *control, const double *angle, const double *shapes,
                                 const double *least, const double *numbers, double straight, double near, double *cut,
                                 double *room, SIZE *of, SIZE *stop, double *torque);
API void purcell_circles(SIZE n, const double *shapes, const double *rates, double *centre, double *cosine, double *sine,
                         double *turn);
API SIZE purcell_clearance_begun(SIZE n, const double *numbers, const double *centre, const double *cosine,
                                 const double *sine, const double *turn, const double *duration, SIZE apart, double enough,
                                 double *best, double *when, SIZE *where, double *stretches);
API SIZE purcell_clearance_cut(SIZE n, const double *numbers, const double *centre, const double *cosine,
                               const double *sine, const double *turn, const double *duration, SIZE apart, double enough,
                               double *best, double *when, SIZE *where, double *stretches, SIZE most, double *cut,
                               double *error);

/* beads.c, bead_table.c: the resistance of links that feel each other's flow, from their beads and from a table of it.
 *
 * It is the lower half of a symmetric matrix on (v, omega, u_1, u_2): first P's 21 numbers, then the 36 couplings Q^T, then
 * the 21 that only the power needs; each part row by row. */
#define COLUMNS 12
#define RESISTANCE 78
#define WITHOUT_POWER 57
/* Where entry (i, j) stands, i >= j. */
static inline int entry(int i, int j) {
    if (i < 6) return i * (i + 1) / 2 + j;
    return j < 6 ? 21 + 6 * (i - 6) + j : 57 + (i - 6) * (i - 5) / 2 + j - 6;
}
/* What a motion with constant rates needs of it: P and the wrench Q^T u on the base, then how these 27 numbers change when
 * limb i, with its rate, is turned about axis j of the base, at 27 (1 + 3 i + j); then the couplings and the rest. There is
 * room for whole blocks of numbers. */
#define PULL 27
#define CHANGES (7 * PULL)
#define COUPLINGS (CHANGES + 3)
#define POWERS (COUPLINGS + 36)
#define GIVEN (POWERS + 28)
#define MOST_BENDS 16
#define MOST_MULTIPLES 16
#define WIDTH 80 /* numbers of a resistance side by side, in whole blocks */
#define PANEL_NODES 16
#define PANEL_RAD 2.0
/* What is wanted of a resistance: what a motion of the limb that is not summed over needs, of both limbs, the power too. */
enum window { MOTION, BOTH, WITH_POWER };
/* What is left of a table when one limb's bend is known: its sums with the polynomials, and with their slopes. */
struct known {
    const struct bead_table *table, *of; /* which is wanted, and which was summed */
    int limb;                     /* the limb, -1 at first */
    enum window window, fixed;    /* which entries of a resistance are wanted, and which were summed */
    int slopes, couplings, power; /* what is wanted: changes, the couplings themselves, what the power needs */
    int exact;                    /* whether every coefficient that counts is summed, or only those that do for a search */
    int used, many[MOST_MULTIPLES]; /* of how many multiples, and of how many of the other limb's polynomials by the multiple */
    int entries;                    /* how many entries of a resistance were summed */
    double bend;
    double sums[MOST_MULTIPLES * MOST_BENDS * 2 * WIDTH]; /* by the multiple and the other's polynomial: sums, then slopes */
};
/* Along a part of a path what a motion needs of the resistance is a polynomial in time. */
struct field {
    double start, length;
    double nodes[PANEL_NODES], sines[PANEL_NODES]; /* Chebyshev's, from -1 to 1, and the sines of their angles */
    double values[PANEL_NODES][GIVEN];
    int count, changes, couplings; /* nodes, 0 before the first part, and what values there are */
};
/* What remains of the table at a multiple: its sum over the other limb's bend, and the slopes by both bends. */
struct contracted {
    double value[MOST_MULTIPLES][WIDTH], other[MOST_MULTIPLES][WIDTH], known[MOST_MULTIPLES][WIDTH];
};
/* The series in the angle between the planes: of even multiples, and of odd ones. */
struct series {
    double even[WIDTH], odd[WIDTH];
};
/* wide_sums.c. A sum of rows of a table with weights, and with others where slopes are wanted. */
void purcell_table_rows(const double *rows, int count, int entries, const double *weight, const double *slope, double *sum,
                        double *sloped);
void purcell_contract(const struct known *known, const double *weight, const double *slope, struct contracted *out);
extern const int purcell_mirrored[WIDTH]; /* whether the mirror of limb 1's plane changes an entry's sign */
/* The entries that the mirror leaves alone with some factors of the multiples, the others with others. */
void purcell_angle_series(double (*of)[WIDTH], int used, int entries, const double *plain, const double *mixed,
                          struct series *out);
/* Rows of L with M = L L^T, in place of M's lower half, n being a multiple of three; or 0 in `positive`. */
void purcell_cholesky(SIZE n, double *m, int *positive);
#define TILE 3 /* rows of Cholesky's factor at once: those of a bead */
#define TOGETHER 4 /* rows of a linear program that are renewed at once */
/* To rows, so many times a pivot row, and to the gains so many times what the rows then are, one after the other. */
void purcell_renewed(SIZE n, int changed, double *const *row, const double *factor, const double *slope,
                     const double *pivot, double *gains);
/* Inner products of rows (count, n) with another vector, each in four sums side by side as `inner_product`. */
void purcell_inner_products(SIZE n, SIZE count, const double *rows, const double *other, double *out);
/* Of two times, sums over a field's nodes. */
void purcell_interpolated(const struct field *f, double (*weight)[LANES], int first, int last, lane *out);

/* bead_table.c. The table of the least reach that has both bends at some shapes, pairs of axes. */
const struct bead_table *purcell_table_for(const struct swimmer *s, int shapes, double (*axes)[2][3]);
/* A part of the table's sum over one limb's bend, for all the rest: with the polynomials, and with their slopes. */
void purcell_fix(int limb, const double axis[3], struct known *known);
/* What is needed at a shape; where slopes are wanted, how it changes when a limb is turned too. */
void purcell_look_up(double axes[2][3], double rates[2][3], const struct known *known, double out[GIVEN]);

/* bead_field.c */
void purcell_fill_field(const struct swimmer *s, double begun[2][3], double rates[2][3], double start, double length,
                        int nodes, struct known *known, struct field *out);
void purcell_of_field(const struct field *f, lane time, int changes, lane out[GIVEN]);
/* The same at one shape. */
void purcell_at_shape(const struct swimmer *s, double axes[2][3], double rates[2][3], int changes, int couplings,
                      double out[GIVEN]);

/* connection.c: the local connection of two shapes at once, the one place that knows the drag.
 *
 * axes, rates: of both limbs in base coordinates.
 * xi: the base's body twist (v, omega).
 * change: its derivatives when limb i, with its rate, is turned about axis j of the base, at [3 i + j]; or null.
 * per_rate: the twist for a unit rate of limb i about axis j of the base, at [3 i + j]; or null.
 * power: that of both joints' torques; or null.
 * given: what a motion needs of the resistance of links that feel each other (`PULL`); null for links that do not.
 */
void purcell_connection(const struct swimmer *s, lane axes[2][3], lane rates[2][3], const lane *given,
                        lane xi[6], lane change[6][6], lane per_rate[6][6], lane *power);
/* The limbs' axes and rates at two nodes of a step. */
struct step;
void purcell_node_states(const struct step *step, lane time, lane axes[2][3], lane rates[2][3]);
/* The connection at so many times of a step, of links that do not feel each other: the twists, and of the first m times
 * their weights the other two, or null. */
void purcell_at_nodes(const struct swimmer *s, const struct step *step, int many, const double *times, int m,
                      const double *weights, double (*twists)[6], double (*changes)[6][6], double (*per_rates)[6][6]);
/* How far a shape is from a straight line, as a bend of one limb [rad]; farther than enough may be told as 1. */
double purcell_distance(const struct swimmer *s, double axes[2][3], double enough);

/* extended.c: displacements with twice the digits, as sums of two doubles. */
typedef struct {
    double high, low;
} twofold;
typedef struct {
    twofold m[3][4];
} wide_pose;
void purcell_wide_identity(wide_pose *g);
void purcell_wide_times(wide_pose *g, const double move[16]);
void purcell_wide_product(const wide_pose *a, const wide_pose *b, wide_pose *out);
void purcell_wide_normalise(wide_pose *g);
void purcell_wide_power(const wide_pose *g, SIZE exponent, wide_pose *out);
void purcell_wide_round(const wide_pose *g, double out[16]);
void purcell_wide_load(const double *high_low, wide_pose *g);
void purcell_wide_store(const wide_pose *g, double *high_low);

/* collocation.c: the flow on a step, by Gauss collocation on a mesh graded by the distance from a straight line. */
#define MOST_STAGES 16
#define MOST_ITERATIONS 100
#define ROUGH_STAGES 5 /* rules of so few stages err by 1e-7, and so may the resistance and sums of poses */
struct rule {
    SIZE stages;
    const double *nodes, *weights, *to_node;
    double step, settled;
};

struct step {
    double axes[2][3];   /* the limbs' axes where it begins */
    double rates[2][3];  /* in base coordinates */
    double start, duration;
    const struct field *field; /* null for links that do not feel each other */
};

struct solved {
    double pose[16];                        /* the displacement */
    double rotation[MOST_STAGES][9];        /* at the nodes, from here on only where derivatives are wanted */
    double position[MOST_STAGES][3];
    double change[MOST_STAGES][6][6];       /* derivatives of the twist at the nodes, times the nodes' weights */
    double per_rate[MOST_STAGES][6][6];
    double ending[6];                       /* the twist where the step ends, of links that do not feel each other */
};
/* What a step does: the displacement, and where derivatives are wanted what turning the limbs by their axes changes of it,
 * column by column, (6, 6), and the twist where it ends. */
struct travelled {
    double pose[16], seen[36], ending[6];
};
enum wanted { POWER, DISPLACEMENT, CHANGE, PER_RATE };
void purcell_solve_step(const struct swimmer *s, const struct rule *rule, const struct step *step, enum wanted wanted,
                        struct solved *out);
/* The sum over a step's nodes of changes of the twist, seen from the step's beginning: column c is of changes[.][c]. */
void purcell_carried(const struct solved *solved, SIZE stages, double changes[][6][6], double out[36]);
double purcell_step_power(const struct swimmer *s, const struct rule *rule, const struct step *step, int root);

/* Calls visit for every step of the mesh of a piece, in order, prepared for what is wanted of it; `known` is kept from
 * piece to piece. Returns how many there are, or -1 for too many. */
typedef void visitor(const struct step *step, void *state);
SIZE purcell_mesh(const struct swimmer *s, const struct rule *rule, const double shape[18], const double rate[6],
                  double duration, enum wanted wanted, struct known *known, visitor *visit, void *state);

/* Steps that are solved together, and the pieces that they are of. Where there is no more room `full` is called, which
 * puts on what is stored; if that is null, pieces are stored whole. */
#define QUEUE 32
struct queue {
    SIZE stored, piece; /* how many, and the piece at hand */
    SIZE of[QUEUE];
    struct step steps[QUEUE];
    struct travelled travelled[QUEUE];
    void (*full)(void *state);
    void *state;
};
/* Stores the steps of a piece of links that do not feel each other. Returns 0 where there are too many, or no room for all:
 * then none of them is stored. */
int purcell_queued(struct queue *q, const struct swimmer *s, const struct rule *rule, SIZE piece, const double shape[18],
                   const double rate[6], double duration, struct known *known);

/* connection.c. Steps of links that do not feel each other, side by side. */
void purcell_solve_steps(const struct swimmer *s, const struct rule *rule, SIZE many, const struct step *steps, int slopes,
                         struct travelled *out);

#endif
