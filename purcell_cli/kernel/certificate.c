/* The certificate's integrator, for doubles and in extended precision: it shares no formula with the planner's connection
 * and collocation.
 *
 * g' = g hat(xi) on pieces by the modified midpoint rule with several numbers of steps, extrapolated to no step. The
 * twist is -P^-1 q of the plain equation, set up link by link; of doubles two pieces at once, each as it would be alone.
 * What is extended has the digits that the machine's `long double` has. */
#include "kernel.h"
#include "small.h"

#define MOST_ROWS 8
#define MOST_TIMES 64

struct link {
    double half;    /* half its length */
    double drag[6]; /* along and across its axis, and torques about them */
};

#define NUMBER double
#define MANY lane
#define AT_ONCE LANES
#define TOGETHER(first, second) ((lane){first, second})
#define ONE_OF(many, k) ((many)[k])
#define NAMED(name) name
#include "extrapolated.h"

#define NUMBER long double
#define MANY long double
#define AT_ONCE 1
#define TOGETHER(first, second) ((long double)(first))
#define ONE_OF(many, k) (many)
#define NAMED(name) name##_extended
#include "extrapolated.h"

/* How many bytes a `long double` has. */
API SIZE purcell_extended_size(void) { return sizeof(long double); }
