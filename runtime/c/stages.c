/* stages.c: the result of a step of a Rosenbrock or explicit method from its stages, by the
 * formulas of methods.h: solution, error estimates and dense output. */
#include "bgc_internal.h"

#include <string.h>

/* d->next = x + sum m_i U_i; the error estimate, where the method has one, to d->error. */
void bgc_sum_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state;

    bgc_combine(n, tableau->stages, tableau->m, d->stages, d->x, d->next);
    if (bgc_is_adaptive(method)) {
        bgc_combine(n, tableau->stages, tableau->e, d->stages, NULL, d->error);
    }
}

/* The error of the step to d->next by which fixed steps are subdivided, over its tolerances, root mean
 * square; d->error is overwritten. */
number bgc_embedded_error(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;

    bgc_combine(m->n_state, tableau->stages, tableau->embedded, d->stages, NULL, d->error);
    return bgc_norm_within(m, d, d->error, d->x, d->next, d->core.sub_rtol, d->core.sub_atol,
                           number_of(1.0));
}

/* The method's own dense output to d->k, where it has one. */
int bgc_interpolate_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const size_t width = bgc_chunked(m->n_state);

    if (tableau->dense == 0) {
        return 0;
    }
    for (int l = 0; l < BGC_MAX_DENSE; l++) {
        bgc_combine(m->n_state, tableau->stages, tableau->h[l], d->stages, NULL,
                    d->k + (size_t)l * width);
    }
    return 1;
}
