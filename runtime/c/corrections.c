/* corrections.c: detection of fixed steps that are far too long for their equations.
 *
 * The change that the last stages of a method make to the result of the earlier ones costs next to
 * nothing to compute. Where steps resolve the motion it is small relative to the range of a state.
 * It is large beyond a pole of the equations, through a stiff stop, and outside the stability region
 * of an explicit method.
 */
#include "bgc_internal.h"

#include <string.h>

/* At the start of a run. */
void bgc_reset_corrections(const bgc_model *m, bgc_ivp *d) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;

    memset(d->correction, 0, size);
    memset(d->corrected_at, 0, size);
    memset(d->range, 0, size);
}

/* Keeps the largest correction of each state, its time, and the range of the state. */
static inline void keep_largest(number_mask together, double t, const number *restrict change,
                                const number *restrict next, number *restrict at,
                                number *restrict correction, number *restrict range) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        const number size = number_fabs(change[l]), now = number_fabs(next[l]);
        const number largest = correction[l], before = at[l], most = range[l];
        const number_mask larger = (size > largest) & together, wider = (now > most) & together;
        at[l] = number_select(larger, number_of(t), before);
        correction[l] = number_select(larger, size, largest);
        range[l] = number_select(wider, now, most);
    }
}

/* After a fixed step from t to d->next, before that becomes the present. */
void bgc_record_correction(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double t) {
    const int n = m->n_state;
    const number_mask together = bgc_together(d);
    number *change = d->right;

    memset(change, 0, (size_t)n * sizeof *change);
    bgc_correct_by(m, d, method, change);
    for (size_t i = 0; i < bgc_chunked(n); i += BGC_CHUNK) {
        keep_largest(together, t, change + i, d->next + i, d->corrected_at + i,
                     d->correction + i, d->range + i);
    }
}
