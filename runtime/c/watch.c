/* watch.c: fixed steps that are far too long for what they step over are noticed.
 *
 * What the later stages of a method correct in the earlier ones costs next to nothing to look at. It
 * is above the error of the step by a power of its length, and small beside the range of a state
 * wherever steps resolve the motion at all. It is not past a pole of the equations, through a wall,
 * or outside the stability of an explicit method.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

/* Of the range of a state. A spring at 0.9 radians a step comes to as much; steps that are fair to
 * what they integrate stay below 0.1, most of them far below. */
static const double unresolved_part = 0.15;

/* As at the start of a run. */
void bgc_reset_watch(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;

    memset(d->correction, 0, size);
    memset(d->corrected_at, 0, size);
    memset(d->range, 0, size);
}

/* A fixed short loop, which compilers vectorise without asking what it overlaps. */
static inline void keep_largest(double t, const double *restrict change,
                                const double *restrict next, double *restrict at,
                                double *restrict correction, double *restrict range) {
    for (int l = 0; l < BGC_LANES; l++) {
        const double size = fabs(change[l]), now = fabs(next[l]);
        const double largest = correction[l], before = at[l], most = range[l];
        at[l] = size > largest ? t : before;
        correction[l] = size > largest ? size : largest;
        range[l] = now > most ? now : most;
    }
}

/* After a fixed step from t to d->next, not yet made the present. */
void bgc_watch_step(const bgc_model *m, bgc_data *d, const bgc_method *method, double t) {
    const int n = m->n_state;
    double *change = d->right;

    memset(change, 0, (size_t)n * sizeof *change);
    method->family->correction(m, d, method, change);
    for (size_t i = 0; i < bgc_padded(n); i += BGC_LANES) {
        keep_largest(t, change + i, d->next + i, d->corrected_at + i, d->correction + i,
                     d->range + i);
    }
}

/* Enters into the counts the largest correction so far, if it tells of a step that is too long.
 * States without a rate may jump. */
void bgc_judge_steps(const bgc_model *m, bgc_data *d) {
    bgc_counts *counts = &d->core.counts;

    counts->coarsest = 0.0;
    for (int i = 0; i < m->n_state; i++) {
        const double part = d->correction[i] / fmax(d->scale[i], d->range[i]);
        if (d->algebraic[i] == 0.0 && part > fmax(unresolved_part, counts->coarsest)) {
            counts->coarsest = part;
            counts->coarsest_at = d->corrected_at[i];
            counts->coarsest_state = i;
        }
    }
}
