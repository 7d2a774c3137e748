/* followed_states.c: which states pass a multiple of their tolerance in a step: subtolerance.c. */
#include "bgc_internal.h"

/* Whether a state leaves the multiples of its tolerance between which nothing happens to it. */
static inline number_mask is_outside(number size, number limit, number from, number to) {
    return (size < from * limit) | (size > to * limit);
}

/* Counts the states to which something happens. */
static inline void count_changes(const number *restrict x, const number *restrict scale,
                                 const number *restrict from, const number *restrict to,
                                 double atol, number part, number *restrict count) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        const number_mask changed =
            is_outside(number_fabs(x[l]), atol + part * scale[l], from[l], to[l]);
        count[l] += number_select(changed, number_of(1.0), number_of(0.0));
    }
}

/* After a step under error control to d->next at t. */
void bgc_follow_subtolerance(const bgc_model *m, bgc_ivp *d, double t) {
    const double atol = d->core.atol;
    const number part = atol > 0.0 ? number_of(0.0) : d->core.rtol * bgc_reached(d);
    number count[BGC_CHUNK], all = number_of(0.0);

    /* In most steps nothing happens; padding is zero. */
    for (int l = 0; l < BGC_CHUNK; l++) {
        count[l] = number_of(0.0);
    }
    for (size_t i = 0; i < bgc_chunked(m->n_state); i += BGC_CHUNK) {
        count_changes(d->next + i, d->scale + i, d->subtol_from + i, d->subtol_to + i, atol, part,
                      count);
    }
    for (int l = 0; l < BGC_CHUNK; l++) {
        all += count[l];
    }
    if (!bgc_holds_in_any(d, all > number_of(0.0))) {
        return;
    }
    for (int i = 0; i < m->n_state; i++) {
        const number limit = atol + part * d->scale[i];
        const number_mask changed =
            is_outside(number_fabs(d->next[i]), limit, d->subtol_from[i], d->subtol_to[i]);
        if (bgc_holds_in_any(d, changed)) {
            bgc_follow_where(d, i, changed, limit, t);
        }
    }
}
