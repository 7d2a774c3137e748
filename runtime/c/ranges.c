/* ranges.c: the operands of kernels on ranges, and what they have found ahead. */
#include "bgc_internal.h"
#include "bgc_ranges.h"

/* Ranges of h and u: modes are left open, so that operations are evaluated. Derivatives that a model does not
 * give are unknown. */
static void load_ranges(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_hoist; k++) {
        d->h_range[k] = bgc_range_of(d->h[k]);
    }
    for (int k = 0; k < m->n_input; k++) {
        d->u_range[k] = bgc_range_of(d->u[k]);
    }
    for (int k = 0; k < m->n_switch; k++) {
        d->u_range[m->n_input + k] = bgc_range_of((double)NAN);
    }
    for (int k = 0; k < m->n_timed && m->timed_ranges != NULL; k++) {
        d->timed_range[2 * k + 1] = bgc_range_unknown();
    }
}

/* At the start of a run, and where inputs change: nothing is known ahead. */
void bgc_reset_time_windows(const bgc_model *m, bgc_data *d) {
    if (bgc_has_ranges(m)) {
        load_ranges(m, d);
    }
    d->core.resolved_to = -INFINITY;
    bgc_forget_quiet(d);
}
