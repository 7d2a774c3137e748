/* consistent.c: states without a derivative put on their equations.
 *
 * Where a row and a column of M are empty, the row is an algebraic equation and the state is free
 * to satisfy it. Newton's method solves these rows for these states, the others held: with a large
 * c, W = c M - J holds them by itself.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

enum { MAX_ITERATIONS = 30, MAX_HALVINGS = 10 };

/* Euclidean norm of the algebraic rows of f at x; f goes to d->right. */
static double residual_at(const bgc_model *m, bgc_data *d, const double *x) {
    double sum = 0.0;

    m->rhs(d->h, d->core.t, x, d->u, d->right, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] *= d->algebraic[i];
        sum += d->right[i] * d->right[i];
    }
    return sqrt(sum);
}

/* d->right := the Newton correction from the residual in it; at the present x. */
static bgc_status correct(const bgc_model *m, bgc_data *d) {
    double largest = 1.0;
    bgc_status status;

    d->core.jac_valid = 0;
    bgc_evaluate_jacobian(m, d);
    for (int k = 0; k < m->n_jac; k++) {
        largest = fmax(largest, fabs(d->jac[k]));
    }
    status = bgc_factorise(m, d, 1e8 * largest);
    if (status == BGC_OK) {
        status = bgc_solve(m, d, d->right);
    }
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] *= d->algebraic[i];
    }
    return status;
}

/* Puts d->x on its algebraic equations at the present t and u. Where no solution is found from
 * here, x is as it was: BGC_SINGULAR if the equations do not determine the states, otherwise
 * BGC_INCONSISTENT. */
bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);
    double size_of_residual;
    bgc_status status = BGC_INCONSISTENT;

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    d->core.held = 0;
    d->core.f_valid = 0;
    memcpy(d->next, d->x, size);
    size_of_residual = residual_at(m, d, d->x);
    for (int k = 0; k < MAX_ITERATIONS && isfinite(size_of_residual); k++) {
        double part = 1.0, reached, length;
        status = correct(m, d);
        if (status != BGC_OK) {
            break;
        }
        status = BGC_INCONSISTENT;
        memcpy(d->error, d->right, size);
        length = bgc_norm(m, d, d->error, d->x, d->x);
        for (int halving = 0;; halving++) {
            for (int i = 0; i < n; i++) {
                d->point[i] = d->x[i] + part * d->error[i];
            }
            reached = residual_at(m, d, d->point);
            if (reached < size_of_residual || length < 1e-3 || halving == MAX_HALVINGS) {
                break;
            }
            part *= 0.5;
        }
        memcpy(d->x, d->point, size);
        size_of_residual = reached;
        d->core.jac_valid = 0;
        if (length < 1e-3 && isfinite(reached)) {
            return BGC_OK;
        }
    }
    memcpy(d->x, d->next, size);
    d->core.jac_valid = 0;
    return status;
}
