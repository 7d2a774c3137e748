/* evaluate.c: f and the Jacobian of a model at the present state. */
#include "bgc_internal.h"

/* d->f at the present, unless it is valid. */
void bgc_evaluate_f(const bgc_model *m, bgc_ivp *d) {
    if (!d->core.f_valid) {
        bgc_functions(m, d)->rhs(d->h, number_of(d->core.t), d->x, d->u, d->f, d->work);
        d->core.counts.rhs++;
        d->core.f_valid = 1;
    }
}

/* d->jac and d->dfdt at the present, unless they are valid. */
void bgc_evaluate_jacobian(const bgc_model *m, bgc_ivp *d) {
    if (!d->core.jac_valid) {
        bgc_functions(m, d)->jacobian(d->h, number_of(d->core.t), d->x, d->u, d->jac, d->dfdt,
                                      d->work);
        d->core.counts.jacobians++;
        d->core.jac_valid = 1;
    }
}
