/* evaluate.c: f, the Jacobian and the assertions of a model at the present state. */
#include "bgc_internal.h"

#include <math.h>

/* f at the present state, unless it is known. */
void bgc_evaluate_f(const bgc_model *m, bgc_data *d) {
    if (!d->core.f_valid) {
        m->rhs(d->h, d->core.t, d->x, d->u, d->f, d->work);
        d->core.counts.rhs++;
        d->core.f_valid = 1;
    }
}

/* df/dx and df/dt at the present state, unless they are known. */
void bgc_evaluate_jacobian(const bgc_model *m, bgc_data *d) {
    if (!d->core.jac_valid) {
        m->jacobian(d->h, d->core.t, d->x, d->u, d->jac, d->dfdt, d->work);
        d->core.counts.jacobians++;
        d->core.jac_valid = 1;
    }
}

/* BGC_ASSERTION, naming the first that fails, where one does at (t, x). */
bgc_status bgc_check_asserts(const bgc_model *m, bgc_data *d, double t, const double *x) {
    if (m->n_assert == 0) {
        return BGC_OK;
    }
    m->asserts(d->h, t, x, d->u, d->check, d->work);
    for (int k = 0; k < m->n_assert; k++) {
        if (!(fabs(d->check[k]) > 0.0)) { /* nor does one that is undefined hold */
            d->core.failed_assertion = k;
            return BGC_ASSERTION;
        }
    }
    return BGC_OK;
}
