/* corrections.c: detection of fixed steps that are far too long for their equations.
 *
 * The change that the last stages of a method make to the result of the earlier ones costs next to
 * nothing to compute. Where steps resolve the motion it is small relative to the range of a state.
 * It is large beyond a pole of the equations, through a stiff stop, and outside the stability region
 * of an explicit method.
 */
#include "bgc_internal.h"
#include "corrections.h"

#include <math.h>
#include <string.h>

/* At the start of a run. */
void bgc_reset_corrections(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;

    memset(d->correction, 0, size);
    memset(d->corrected_at, 0, size);
    memset(d->range, 0, size);
}

/* A loop of fixed length without aliases, which compilers vectorise. Keeps the largest correction of
 * each state, its time, and the range of the state. */
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

/* After a fixed step from t to d->next, before that becomes the present. */
void bgc_record_correction(const bgc_model *m, bgc_data *d, const bgc_method *method, double t) {
    const int n = m->n_state;
    double *change = d->right;

    memset(change, 0, (size_t)n * sizeof *change);
    method->family->correction(m, d, method, change);
    for (size_t i = 0; i < bgc_padded(n); i += BGC_LANES) {
        keep_largest(t, change + i, d->next + i, d->corrected_at + i, d->correction + i,
                     d->range + i);
    }
}

/* Reports in the counts the largest correction that shows too long a step. States without a rate may
 * jump, and do not count. */
void bgc_report_correction(const bgc_model *m, bgc_data *d) {
    bgc_counts *counts = &d->core.counts;

    counts->largest_correction = 0.0;
    for (int i = 0; i < m->n_state; i++) {
        const double part = d->correction[i] / fmax(d->scale[i], d->range[i]);
        if (d->algebraic[i] == 0.0 && part > fmax(bgc_unresolved_part, counts->largest_correction)) {
            counts->largest_correction = part;
            counts->correction_time = d->corrected_at[i];
            counts->correction_state = i;
        }
    }
}
