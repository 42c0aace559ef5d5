/* The trust region of every objective: a step is taken, and the next may be longer or must be shorter, by what it gains of
 * what it promised (Fletcher and de la Maza, Math. Program. 43, 1989). */
#include "kernel.h"

#define TAKEN 0.02       /* a step that gains more than this part of what it promised is taken */
#define GOOD 0.6         /* after one that gains more than this part the next may be twice as long */
#define POOR 0.2         /* after one that gains less than this part the next is shorter */
#define SHORTER 0.35     /* by this factor */

/* Whether a step is taken. reach: the radius it was made within, and then the next one's, `largest` at the most. */
API SIZE purcell_step_taken(double promised, double gained, double largest, double *reach) {
    const double kept = promised > 0.0 ? gained / promised : 0.0;
    if (kept > GOOD)
        *reach = 2.0 * *reach < largest ? 2.0 * *reach : largest;
    else if (kept < POOR)
        *reach *= SHORTER;
    return kept > TAKEN;
}
