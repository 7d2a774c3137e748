/* faint.c: states that fall below their tolerance and grow again by orders of magnitude.
 *
 * Below its tolerance error control does not see a state: a decay over many decades may end anywhere,
 * also with the wrong sign. Where the state then grows by an instability of its own, the run depends
 * on that remainder. Whether it does is left to the caller, who has the times to compare runs:
 * a state may as well be driven by others.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

static const double well_above = 10.0; /* times the tolerance: a state that has been resolved */
static const double regrown = 1e3;     /* times the tolerance, */
static const double of_size = 0.1;     /* or this part of the scale, if that is less */
static const double linear = 50.0;     /* a state that passes through zero at constant rate takes 500
                                        * times as long to grow as it was below its tolerance */

enum { NEVER_ABOVE, ABOVE, BELOW_ONCE, BELOW, GROWING };

/* Forgets all states that fell. */
void bgc_reset_faint(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof(double);

    memset(d->faint_phase, 0, size);
    memset(d->faint_low, 0, size);
    for (int i = 0; i < m->n_state; i++) {
        d->faint[i].grown = -INFINITY;
        d->faint[i].low = INFINITY;
    }
}

/* Follows state i, which has been above its tolerance, at its size at t. One step below it may be a
 * passage through zero; two are not. */
static void follow(bgc_data *d, int i, double size, double limit, double t) {
    double *phase = d->faint_phase + i, *low = d->faint_low + i;
    bgc_faint_state *found = d->faint + i;

    if (size < limit) {
        if (*phase == ABOVE) {
            *low = INFINITY;
            d->faint_entered[i] = t;
        }
        if (size < *low) {
            *low = size;
            d->faint_at[i] = t;
        }
        *phase = *phase == ABOVE ? BELOW_ONCE : BELOW;
    } else if (*phase == BELOW_ONCE) {
        *phase = ABOVE;
    } else if (*phase == BELOW) {
        *phase = GROWING;
        d->faint_left[i] = t;
    }
    if (*phase == GROWING &&
        size >= fmax(well_above, fmin(regrown, of_size / d->core.rtol)) * limit) {
        const double below = d->faint_left[i] - d->faint_entered[i];
        *phase = ABOVE;
        if (t - d->faint_left[i] <= linear * below && *low < found->low) {
            *found = (bgc_faint_state){limit, *low, d->faint_at[i], t, d->next[i]};
        }
    }
}

/* A loop of fixed length, which compilers vectorise: adds 1 for each state that is above its tolerance
 * and was not, or the reverse, and more for those that are followed. */
static inline void count_changes(const double *restrict x, const double *restrict scale,
                                 const double *restrict phase, double atol, double part,
                                 double *restrict count) {
    for (int l = 0; l < BGC_LANES; l++) {
        const double above = fabs(x[l]) > atol + part * scale[l] ? 1.0 : 0.0;
        count[l] += fabs(above - phase[l]);
    }
}

/* After a step under error control to d->next at t. */
void bgc_follow_faint(const bgc_model *m, bgc_data *d, double t) {
    const double atol = d->core.atol;
    const double part = atol > 0.0 ? 0.0 : d->core.rtol * d->core.counts.scale_reached;
    double count[BGC_LANES] = {0.0}, all = 0.0;

    /* In most steps no state changes; padding is zero. */
    for (size_t i = 0; i < bgc_padded(m->n_state); i += BGC_LANES) {
        count_changes(d->next + i, d->scale + i, d->faint_phase + i, atol, part, count);
    }
    for (int l = 0; l < BGC_LANES; l++) {
        all += count[l];
    }
    if (all == 0.0) {
        return;
    }
    for (int i = 0; i < m->n_state; i++) {
        const double size = fabs(d->next[i]), limit = atol + part * d->scale[i];
        if (size >= limit && d->faint_phase[i] <= ABOVE) {
            if (d->faint_phase[i] == NEVER_ABOVE && size >= well_above * limit) {
                d->faint_phase[i] = ABOVE;
            }
        } else if (d->faint_phase[i] != NEVER_ABOVE) {
            follow(d, i, size, limit, t);
        }
    }
}

int bgc_get_faint(const bgc_model *m, const bgc_data *d, int k, bgc_faint_state *state) {
    if (k < 0 || k >= m->n_state || d->faint[k].grown == -(double)INFINITY) {
        return 0;
    }
    *state = d->faint[k];
    return 1;
}
