/* solutions.h: when solutions of linear systems with static pivots are checked, and which are accepted:
 * of real and of complex systems, of one instance and of a batch.
 */
#ifndef BGC_SOLUTIONS_H
#define BGC_SOLUTIONS_H

#include <float.h>

static const double bgc_growth_limit = 1e5; /* of static pivots; above, solutions are checked */
static const double bgc_acceptable = 1e-11; /* componentwise backward error of a solution */
/* A component counts in the check with at least this part of the largest, each over the scale of its
 * state: a component that is zero but for rounding leaves rows whose terms are rounding, too, and
 * would fail every check. After Arioli, Demmel and Duff, Solving sparse linear systems with sparse
 * backward error, SIAM J. Matrix Anal. Appl. 10 (1989), 165-190. */
static const double bgc_least_part = 1e-3;
static const double bgc_underflow = DBL_MIN / DBL_EPSILON; /* smaller terms lose digits */

/* Refinements of a solution; factorisations from one check to the next; factorisations that are
 * checked after a failed check or a large growth. */
enum { BGC_MAX_REFINEMENTS = 5, BGC_CHECK_EVERY = 16, BGC_WATCH_FOR = 100 };

#endif
