/* evaluate.c: f, the Jacobian and the assertions of a model at the present state. */
#include "bgc_internal.h"

#include <math.h>

/* d->f at the present, unless it is valid. */
void bgc_evaluate_f(const bgc_model *m, bgc_data *d) {
    if (!d->core.f_valid) {
        m->rhs(d->h, d->core.t, d->x, d->u, d->f, d->work);
        d->core.counts.rhs++;
        d->core.f_valid = 1;
    }
}

/* d->jac and d->dfdt at the present, unless they are valid. */
void bgc_evaluate_jacobian(const bgc_model *m, bgc_data *d) {
    if (!d->core.jac_valid) {
        m->jacobian(d->h, d->core.t, d->x, d->u, d->jac, d->dfdt, d->work);
        d->core.counts.jacobians++;
        d->core.jac_valid = 1;
    }
}

/* BGC_ASSERTION where an assertion fails at (t, x) or is undefined: core.failed_assertion. */
bgc_status bgc_check_asserts(const bgc_model *m, bgc_data *d, double t, const double *x) {
    if (m->n_assert == 0) {
        return BGC_OK;
    }
    m->asserts(d->h, t, x, d->u, d->check, d->work);
    for (int k = 0; k < m->n_assert; k++) {
        if (!(fabs(d->check[k]) > 0.0)) {
            d->core.failed_assertion = k;
            return BGC_ASSERTION;
        }
    }
    return BGC_OK;
}
