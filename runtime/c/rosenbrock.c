/* rosenbrock.c: one step of a Rosenbrock method, driven by its tableau. */
#include "bgc_internal.h"

#include <string.h>

/* right += M (sum of c_ij U_j) / h: the part of a stage's right-hand side that earlier stages
 * give. */
static void add_earlier_stages(const bgc_model *m, bgc_data *d, const double *c, int stage,
                               double h, double *right) {
    const int n = m->n_state;
    double weight[BGC_MAX_STAGES];

    for (int j = 0; j < stage; j++) {
        weight[j] = c[j] / h;
    }
    if (m->n_mass == 0) {
        bgc_combine(n, stage, weight, d->stages, right);
        return;
    }
    memset(d->point, 0, (size_t)n * sizeof *d->point);
    bgc_combine(n, stage, weight, d->stages, d->point);
    bgc_multiply_mass(m, d, d->point, d->error);
    for (int i = 0; i < n; i++) {
        right[i] += d->error[i];
    }
}

/* From x at t to d->next, with f(t, x) in d->f, the Jacobian in d->jac and d->dfdt, and W
 * factorised for h; the error estimate of an embedded method goes to d->error. */
bgc_status bgc_rosenbrock(const bgc_model *m, bgc_data *d, const bgc_tableau *method, double h) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);

    for (int s = 0; s < method->stages; s++) {
        double *stage = d->stages + (size_t)s * bgc_padded(n);
        const double slope = method->g[s] * h;
        bgc_status status;

        /* f at the stage's point, straight into the place of the solution. */
        if (s == 0) {
            memcpy(stage, d->f, size);
        } else {
            memcpy(d->point, d->x, size);
            bgc_combine(n, s, method->a[s], d->stages, d->point);
            m->rhs(d->h, d->core.t + method->alpha[s] * h, d->point, d->u, stage, d->work);
            d->core.counts.rhs++;
            add_earlier_stages(m, d, method->c[s], s, h, stage);
        }
        if (slope != 0.0) {
            for (int i = 0; i < n; i++) {
                stage[i] += slope * d->dfdt[i];
            }
        }
        status = bgc_solve(m, d, stage);
        if (status != BGC_OK) {
            return status;
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
