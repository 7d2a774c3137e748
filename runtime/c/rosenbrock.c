/* rosenbrock.c: one step of a Rosenbrock method, by its tableau, in the variables of methods.h:
 * E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.7. */
#include "bgc_internal.h"

#include <string.h>

/* right += M (sum of c_ij U_j) / h. */
static void add_earlier_stages(const bgc_model *m, bgc_ivp *d, const double *c, int stage,
                               double h, number *right) {
    const int n = m->n_state;
    double weight[BGC_MAX_STAGES];

    for (int j = 0; j < stage; j++) {
        weight[j] = c[j] / h;
    }
    if (m->n_mass == 0) {
        bgc_combine(n, stage, weight, d->stages, right, right);
        return;
    }
    bgc_combine(n, stage, weight, d->stages, NULL, d->point);
    bgc_multiply_mass(m, d, d->point, d->error);
    for (int i = 0; i < n; i++) {
        right[i] += d->error[i];
    }
}

/* The Jacobian and the factors of W = M / (h gamma) - J at the present, unless they are held. */
static bgc_status factorise_for_stages(const bgc_model *m, bgc_ivp *d, const bgc_tableau *tableau,
                                       double h) {
    if (d->core.held > 0) {
        return BGC_OK;
    }
    bgc_evaluate_jacobian(m, d);
    return bgc_factorise(m, d, 1.0 / (h * tableau->gamma));
}

/* Each stage is made in the place of its solution: right-hand side, then one solution with W. */
bgc_status bgc_rosenbrock(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(number);
    bgc_status status = factorise_for_stages(m, d, tableau, h);

    for (int s = 0; s < tableau->stages && status == BGC_OK; s++) {
        number *stage = d->stages + (size_t)s * bgc_chunked(n);
        const double slope = tableau->g[s] * h;

        /* f at the point of the stage, and the earlier stages. */
        if (s == 0) {
            memcpy(stage, d->f, size);
        } else {
            bgc_combine(n, s, tableau->a[s], d->stages, d->x, d->point);
            bgc_functions(m, d)->rhs(d->h, number_of(d->core.t + tableau->alpha[s] * h), d->point, d->u, stage,
                                    d->work);
            d->core.counts.rhs++;
            add_earlier_stages(m, d, tableau->c[s], s, h, stage);
        }

        /* df/dt, and the solution. */
        if (slope != 0.0) {
            for (int i = 0; i < n; i++) {
                stage[i] += slope * d->dfdt[i];
            }
        }
        status = bgc_solve(m, d, stage);
    }
    if (status == BGC_OK) {
        bgc_sum_stages(m, d, method);
    }
    return status;
}
