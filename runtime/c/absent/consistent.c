/* consistent.c: replaces consistent.c in a model whose mass matrix is the identity. */
#include "bgc_internal.h"

void bgc_classify_states(const bgc_model *m, bgc_data *d) {
    for (int i = 0; i < m->n_state; i++) {
        d->inverse_mass[i] = 1.0;
        d->algebraic[i] = 0.0;
        d->place[i] = -1;
    }
    d->core.algebraic = d->n_block = 0;
}

bgc_status bgc_satisfy(const bgc_model *m, bgc_data *d, double t, double *x) {
    (void)m, (void)d, (void)t, (void)x;
    return BGC_OK;
}

bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

bgc_status bgc_refresh_block(const bgc_model *m, bgc_data *d, double t, const double *x) {
    (void)m, (void)d, (void)t, (void)x;
    return BGC_OK;
}

bgc_status bgc_keep_consistent(const bgc_model *m, bgc_data *d, const bgc_method *method,
                               double t) {
    (void)m, (void)d, (void)method, (void)t;
    return BGC_OK;
}

int bgc_leave_root(const bgc_model *m, bgc_data *d, double h) {
    (void)m, (void)d, (void)h;
    return 0;
}
