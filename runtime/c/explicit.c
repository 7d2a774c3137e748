/* explicit.c: the classical Runge-Kutta method, order 4 (W. Kutta, 1901). */
#include "bgc_internal.h"

/* From x at t to d->next, with f(t, x) in d->f. M must be diagonal and regular. */
bgc_status bgc_runge_kutta(const bgc_model *m, bgc_data *d, double h) {
    static const double node[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const int n = m->n_state;
    const double *k = d->f;

    for (int i = 0; i < n; i++) {
        if (d->inverse_mass[i] == 0.0) {
            d->core.failed_state = i;
            return BGC_NOT_EXPLICIT;
        }
        d->next[i] = d->x[i] + weight[0] * h * d->inverse_mass[i] * k[i];
    }
    for (int s = 1; s < 4; s++) {
        for (int i = 0; i < n; i++) {
            d->point[i] = d->x[i] + node[s] * h * d->inverse_mass[i] * k[i];
        }
        m->rhs(d->h, d->core.t + node[s] * h, d->point, d->u, d->stages, d->work);
        d->core.counts.rhs++;
        k = d->stages;
        for (int i = 0; i < n; i++) {
            d->next[i] += weight[s] * h * d->inverse_mass[i] * k[i];
        }
    }
    return BGC_OK;
}
