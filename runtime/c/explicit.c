/* explicit.c: one step of an explicit Runge-Kutta method, driven by its tableau. */
#include "bgc_internal.h"

#include <string.h>

/* From x at t to d->next, with f(t, x) in d->f; the error estimate of an embedded method goes to
 * d->error. M must be diagonal and regular. */
bgc_status bgc_runge_kutta(const bgc_model *m, bgc_data *d, const bgc_tableau *method, double h) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);

    for (int i = 0; i < n; i++) {
        if (d->inverse_mass[i] == 0.0) {
            d->core.failed_state = i;
            return BGC_NOT_EXPLICIT;
        }
    }
    for (int s = 0; s < method->stages; s++) {
        double *stage = d->stages + (size_t)s * bgc_padded(n);
        const double *f = d->f;
        if (s > 0) {
            memcpy(d->point, d->x, size);
            bgc_combine(n, s, method->a[s], d->stages, d->point);
            m->rhs(d->h, d->core.t + method->alpha[s] * h, d->point, d->u, stage, d->work);
            d->core.counts.rhs++;
            f = stage;
        }
        for (int i = 0; i < n; i++) {
            stage[i] = h * d->inverse_mass[i] * f[i];
        }
    }
    memcpy(d->next, d->x, size);
    bgc_combine(n, method->stages, method->m, d->stages, d->next);
    if (method->embedded > 0) {
        memset(d->error, 0, size);
        bgc_combine(n, method->stages, method->e, d->stages, d->error);
    }
    return BGC_OK;
}
