/* inner.c: df/dx of a model whose Jacobian has inner unknowns, and the sizes of these.
 *
 * The rates are f = g(x, z), where z solves 0 = r(x, z). jacobian() fills the entries of
 * [g_x g_z; r_x r_z], in which steps eliminate z together with the states. What needs df/dx itself
 * (the caller of bgc_jacobian, algebraic equations, bounds of the stiffness) has z eliminated here.
 */
#include "bgc_internal.h"
#include "inner.h"

#include <math.h>

/* Fills d->inner by bgc_eliminate_inner; returns its width, 0 where the memory does not suffice. */
static size_t eliminate(const bgc_model *m, bgc_data *d, const double *local) {
    if (!bgc_make_room(&d->inner, &d->inner_room, (size_t)bgc_unknowns(m))) {
        return 0;
    }
    return bgc_eliminate_inner(m, local, d->inner);
}

/* The entries of df/dx from those of [g_x g_z; r_x r_z]; NaN where the memory does not suffice. */
static void find_slopes(const bgc_model *m, bgc_data *d, const double *local, double *jac) {
    const size_t width = eliminate(m, d, local);

    if (width > 0) {
        bgc_gather_slopes(m, d->inner, width, jac);
        return;
    }
    for (int k = 0; k < m->n_jac; k++) {
        jac[k] = (double)NAN;
    }
}

/* The entries of df/dx at jac_row, jac_col, and df/dt at (t, x). */
void bgc_differentiate(const bgc_model *m, bgc_data *d, double t, const double *x, double *jac,
                       double *dfdt) {
    if (m->n_inner == 0) {
        m->jacobian(d->h, t, x, d->u, jac, dfdt, d->work);
        return;
    }
    m->jacobian(d->h, t, x, d->u, d->local, dfdt, d->work);
    find_slopes(m, d, d->local, jac);
}

/* The entries of df/dx of the Jacobian in d->jac. */
const double *bgc_slopes(const bgc_model *m, bgc_data *d) {
    if (m->n_inner == 0) {
        return d->jac;
    }
    find_slopes(m, d, d->jac, d->slopes);
    return d->slopes;
}

/* Bounds of the inner unknowns while the states are as large as their scales, after those in d->scale:
 * a component that is zero but for rounding counts in the check of a solution (linear.c). */
void bgc_scale_inner(const bgc_model *m, bgc_data *d) {
    const size_t n = (size_t)bgc_unknowns(m);
    size_t width;

    if (m->n_inner == 0) {
        return;
    }
    m->jacobian(d->h, d->core.t, d->x, d->u, d->local, d->residual, d->work);
    width = eliminate(m, d, d->local);
    for (size_t i = (size_t)m->n_state; i < n; i++) {
        const double *row = d->inner + i * width;
        const size_t before = i < width ? i : width;
        double sum = 0.0;
        for (size_t j = 0; j < before; j++) {
            sum += fabs(row[j]) * d->scale[j];
        }
        d->scale[i] = i < width ? sum / fabs(row[i]) : sum;
        d->scale[i] = isfinite(d->scale[i]) ? d->scale[i] : 0.0;
    }
}
