/* stages.c: the result of a step of a Rosenbrock or explicit method from its stages, by the formulas of
 * methods.h: solution, error estimate, dense output and correction. */
#include "bgc_internal.h"

#include <string.h>

/* d->next = x + sum m_i U_i; the error estimate, where the method has one, to d->error. */
void bgc_sum_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(number);

    memcpy(d->next, d->x, size);
    bgc_combine(n, tableau->stages, tableau->m, d->stages, d->next);
    if (bgc_is_adaptive(method)) {
        memset(d->error, 0, size);
        bgc_combine(n, tableau->stages, tableau->e, d->stages, d->error);
    }
}

/* The method's own dense output to d->k, where it has one. */
int bgc_interpolate_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const size_t width = bgc_chunked(m->n_state);

    if (tableau->dense == 0) {
        return 0;
    }
    memset(d->k, 0, BGC_MAX_DENSE * width * sizeof *d->k);
    for (int l = 0; l < tableau->dense; l++) {
        number *k = d->k + (size_t)l * width;
        bgc_combine(m->n_state, tableau->stages, tableau->h[l], d->stages, k);
    }
    return 1;
}

/* A method of one stage is compared with the step before, whose stage is kept where a second stage
 * would be. */
static void keep_stage(int n, bgc_ivp *d) {
    memcpy(d->stages + bgc_chunked(n), d->stages, (size_t)n * sizeof *d->stages);
}

/* change += sum e_i U_i, or the same by the weights of sub-steps where they differ and give more: the stability
 * polynomial of each vanishes somewhere beyond the stability limit of an explicit method, not both at one place. */
void bgc_correction_of_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                              number *change) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state, count = tableau->stages > 1 ? tableau->stages : 2;
    number *other = d->magnitude;

    if (tableau->stages == 1 && d->core.ticks == 0) {
        keep_stage(n, d);
    }
    bgc_combine(n, count, tableau->e, d->stages, change);
    if (!method->family->jacobian &&
        memcmp(tableau->e, tableau->embedded, (size_t)count * sizeof *tableau->e) != 0) {
        memset(other, 0, (size_t)n * sizeof *other);
        bgc_combine(n, count, tableau->embedded, d->stages, other);
        for (int i = 0; i < n; i++) {
            change[i] = number_larger(number_fabs(change[i]), number_fabs(other[i]));
        }
    }
    if (tableau->stages == 1) {
        keep_stage(n, d);
    }
}
