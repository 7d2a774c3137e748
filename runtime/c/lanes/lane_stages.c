/* lane_stages.c: sets of lanes, and linear systems of a batch. Solutions are checked as often as in
 * linear.c. A lane whose solution is not acceptable leaves the batch: refinement and pivoting are
 * left to bgc_run.
 */
#include "lanes/batch.h"
#include "bgc_internal.h"
#include "solutions.h"

#include <string.h>

/* The active lanes with an entry that is not finite. */
unsigned bgc_bad_lanes(const bgc_batch *b, int n, const lane *v) {
    lane sum = lane_of(0.0);

    for (int i = 0; i < n; i++) {
        sum += v[i] - v[i];
    }
    return bgc_lanes_where(b, sum != lane_of(0.0));
}

/* The largest number in a set of lanes. */
double bgc_largest_in(unsigned lanes, lane v) {
    double found = -INFINITY;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if ((lanes >> l & 1u) != 0) {
            found = fmax(found, lane_get(v, l));
        }
    }
    return found;
}

/* Factorises W = c M - J, and decides how solutions are checked. */
bgc_status bgc_factorise(const bgc_model *m, bgc_batch *b, double c) {
    lane growth;

    (void)m;
    b->kernel->factor(b->mass, b->jac, lane_of(c), b->lu, &growth);
    b->core.counts.factorisations++;
    b->core.c = c;
    b->active &= bgc_lanes_where(b, growth < lane_of(INFINITY));
    b->core.pivoting = bgc_choose_checks(b->core.counts.factorisations,
                                         bgc_largest_in(b->active, growth), &b->core.watched);
    return BGC_OK;
}

/* v := W^-1 v. Lanes whose right-hand side is not finite are not checked. */
bgc_status bgc_solve(const bgc_model *m, bgc_batch *b, lane *v) {
    const int n = m->n_state;
    unsigned finite;
    lane error;

    b->core.counts.solves++;
    if (b->core.pivoting == BGC_STATIC) {
        b->kernel->solve(b->lu, v, b->work);
        return BGC_OK;
    }

    /* The right-hand side, and the solution with its inner unknowns. */
    finite = b->active & ~bgc_bad_lanes(b, n, v);
    memcpy(b->b, v, (size_t)n * sizeof *v);
    b->kernel->solve(b->lu, v, b->work);
    memcpy(b->wide, v, (size_t)n * sizeof *v);
    memcpy(b->wide + n, b->work, (size_t)m->n_inner * sizeof *v);

    error = bgc_backward_error(m, b, b->b, b->wide);
    b->active &= ~(finite & ~bgc_lanes_where(b, error <= lane_of(bgc_acceptable)));
    if (b->core.pivoting == BGC_CHECKED_ONCE) {
        b->core.pivoting = BGC_STATIC;
    }
    return BGC_OK;
}
