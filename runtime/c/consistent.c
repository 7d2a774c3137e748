/* consistent.c: states without a derivative put on their equations.
 *
 * Where a row and a column of M are empty, the row is an algebraic equation and the state is free
 * to satisfy it. Newton's method solves these rows for these states, the others held: with a large
 * c, W = c M - J holds them by itself. A step of a linearly implicit method is one such iteration,
 * and where nothing controls its error, what it leaves of these rows is looked at after it.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

enum { MAX_ITERATIONS = 30, MAX_HALVINGS = 10 };
static const double left_alone = 1e-3; /* correction after a fixed step, over scale plus size */

/* Euclidean norm of the algebraic rows of f at (t, x); f goes to d->right. */
static double residual_at(const bgc_model *m, bgc_data *d, double t, const double *x) {
    double sum = 0.0;

    m->rhs(d->h, t, x, d->u, d->right, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] *= d->algebraic[i];
        sum += d->right[i] * d->right[i];
    }
    return sqrt(sum);
}

/* d->right := the Newton correction from the residual in it; at (t, x). */
static bgc_status correct(const bgc_model *m, bgc_data *d, double t, const double *x) {
    double largest = 1.0;
    bgc_status status;

    m->jacobian(d->h, t, x, d->u, d->jac, d->dfdt, d->work);
    d->core.counts.jacobians++;
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

/* Puts x on its algebraic equations at t. BGC_SINGULAR if they do not determine the states, and
 * BGC_INCONSISTENT where no solution is found from here: x is spoilt then. */
static bgc_status solve_algebraic(const bgc_model *m, bgc_data *d, double t, double *x) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);
    double size_of_residual = residual_at(m, d, t, x);

    d->core.held = d->core.jac_valid = 0;
    for (int k = 0; k < MAX_ITERATIONS && isfinite(size_of_residual); k++) {
        const bgc_status status = correct(m, d, t, x);
        double part = 1.0, reached, length;
        if (status != BGC_OK) {
            return status;
        }
        memcpy(d->error, d->right, size);
        length = bgc_norm(m, d, d->error, x, x);
        for (int halving = 0;; halving++) {
            for (int i = 0; i < n; i++) {
                d->point[i] = x[i] + part * d->error[i];
            }
            reached = residual_at(m, d, t, d->point);
            if (reached < size_of_residual || length < 1e-3 || halving == MAX_HALVINGS) {
                break;
            }
            part *= 0.5;
        }
        memcpy(x, d->point, size);
        size_of_residual = reached;
        if (length < 1e-3 && isfinite(reached)) {
            return BGC_OK;
        }
    }
    return BGC_INCONSISTENT;
}

/* Puts d->x on its algebraic equations at the present t and u. Where no solution is found from
 * here, x is as it was: BGC_SINGULAR if the equations do not determine the states, otherwise
 * BGC_INCONSISTENT. */
bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof(double);
    bgc_status status;

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    d->core.f_valid = 0;
    memcpy(d->next, d->x, size);
    status = solve_algebraic(m, d, d->core.t, d->next);
    if (status == BGC_OK) {
        memcpy(d->x, d->next, size);
    }
    return status;
}

/* After a fixed step to d->next: the algebraic rows there, by the correction that the step's own
 * factorisation gives. A small one is the method's error and is left to the next step, which takes
 * it up; otherwise the step was too coarse for one iteration, or the solution is lost, and d->next
 * is corrected or refused. */
bgc_status bgc_keep_consistent(const bgc_model *m, bgc_data *d, double t) {
    double worst = 0.0;
    int at_fault = -1;
    bgc_status status;

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    m->rhs(d->h, t, d->next, d->u, d->error, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] = d->algebraic[i] != 0.0 ? d->error[i] : 0.0;
    }
    d->core.failed_state = bgc_first_bad(m->n_state, d->right);
    if (d->core.failed_state >= 0) {
        return BGC_NOT_FINITE;
    }
    status = bgc_solve(m, d, d->right);
    if (status != BGC_OK) {
        return status;
    }
    for (int i = 0; i < m->n_state; i++) {
        const double part = fabs(d->right[i]) / (d->scale[i] + fabs(d->next[i]));
        if (d->algebraic[i] != 0.0 && (part > worst || isnan(part))) { /* a NaN stays */
            worst = part;
            at_fault = i;
        }
    }
    if (worst <= left_alone) {
        d->core.f_ahead = 1;
        return BGC_OK;
    }
    status = solve_algebraic(m, d, t, d->next);
    if (status != BGC_OK) {
        d->core.failed_state = at_fault;
    }
    return status;
}
