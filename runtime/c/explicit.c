/* explicit.c: one step of an explicit Runge-Kutta method, by its tableau. */
#include "bgc_internal.h"

#include <string.h>

/* Copies the states without a rate. */
static void copy_algebraic(const bgc_ivp *d, const number *from, number *to) {
    for (int k = 0; k < d->n_block; k++) {
        to[d->block[k]] = from[d->block[k]];
    }
}

/* M must be diagonal (bgc_coupled_rate). Where it has empty rows, these are solved at every stage
 * for the states without a rate, so that the others see an ordinary differential equation: E.
 * Hairer, C. Lubich, M. Roche, The Numerical Solution of Differential-Algebraic Systems by
 * Runge-Kutta Methods, 1989, the indirect approach. In d->next they keep their values of the last
 * stage. */
bgc_status bgc_runge_kutta(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(number);

    memcpy(d->next, d->x, size);
    for (int s = 0; s < tableau->stages; s++) {
        number *stage = d->stages + (size_t)s * bgc_chunked(n);
        const number *f = d->f;
        if (s > 0) {
            const double t = d->core.t + tableau->alpha[s] * h;
            bgc_status status;

            /* The point of the stage, consistent, and f there. */
            bgc_combine(n, s, tableau->a[s], d->stages, d->x, d->point);
            copy_algebraic(d, d->next, d->point);
            status = bgc_satisfy_rows(m, d, t, d->point);
            if (status != BGC_OK) {
                return status;
            }
            copy_algebraic(d, d->point, d->next);
            bgc_functions(m, d)->rhs(d->h, number_of(t), d->point, d->u, stage, d->work);
            d->core.counts.rhs++;
            f = stage;
            if (s == tableau->stages - 1) {
                memcpy(d->f_last, stage, size);
            }
        }
        for (int i = 0; i < n; i++) {
            stage[i] = h * d->inverse_mass[i] * f[i];
        }
    }
    copy_algebraic(d, d->next, d->point);
    bgc_sum_stages(m, d, method);
    copy_algebraic(d, d->point, d->next);
    if (bgc_ends_at_last_stage(m, tableau) && d->n_block == 0) {
        d->core.f_last_at = d->core.t + h;
    }
    return BGC_OK;
}
