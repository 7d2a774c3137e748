/* consistent_steps.c: the algebraic equations at the end of a step.
 *
 * A linearly implicit step satisfies them nearly: the defect is measured, and corrected where it is
 * more than a part of the step's own error.
 */
#include "bgc_internal.h"

#include <math.h>

/* Corrections after a step that need no action, and those that reject it. */
static const double fixed_allowance = 1e-3;       /* fixed step: relative to scale plus state */
static const double adaptive_allowance = 0.1;     /* adaptive step: over the tolerance */
static const double rejection_limit = 100.0;      /* adaptive step: over the allowance */
static const double negligible_correction = 1e-5; /* relative to scale plus state */
static const double nonlinearity_limit = 0.03;    /* fixed step: relative to the change in the step */
static const double near_root = 1e-3;             /* a step off a root: relative to scale plus state */

/* The defect of d->next in the algebraic rows: the correction that the factors of the step give. */
typedef struct {
    double excess;       /* the largest correction over its allowance */
    double nonlinearity; /* the largest one that is not negligible, over the change in the step */
    int at_fault;        /* the state with the largest excess */
} algebraic_defect;

/* Raises the defect, which begins with zeros and no state, to that of d->next, f at which is in d->error. */
static bgc_status measure_defect(const bgc_model *m, bgc_data *d, int fixed,
                                 algebraic_defect *found) {
    bgc_status status;

    for (int i = 0; i < m->n_state; i++) {
        d->right[i] = d->algebraic[i] != 0.0 ? d->error[i] : 0.0;
    }
    d->core.failed_state = bgc_first_bad(m->n_state, d->right);
    if (d->core.failed_state >= 0) {
        return BGC_NOT_FINITE;
    }
    status = bgc_solve(m, d, d->right);
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        const double size = fabs(d->next[i]), change = fabs(d->right[i]);
        const double allowed =
            fixed ? fixed_allowance * (d->scale[i] + size)
                  : adaptive_allowance * bgc_tolerance(d, i, size);
        if (change > found->excess * allowed || isnan(change)) { /* a NaN stays */
            found->excess = change / allowed;
            found->at_fault = i;
        }
        if (change > negligible_correction * (d->scale[i] + size)) {
            found->nonlinearity = fmax(found->nonlinearity, change / fabs(d->next[i] - d->x[i]));
        }
    }
    return status;
}

/* After a step to d->next: the algebraic equations there. A linearly implicit method satisfies them
 * nearly. A small defect is part of its error and left to the next step. A large one, or one that is
 * large compared with the change in the step, makes the step too coarse. In between, and where the
 * step cannot be shorter, d->next is corrected. Other methods leave these equations to this call. */
bgc_status bgc_keep_consistent(const bgc_model *m, bgc_data *d, const bgc_method *method,
                               double t) {
    const int fixed = !bgc_is_adaptive(method);
    algebraic_defect found = {0.0, 0.0, -1};

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    if (method->family->rows == BGC_ROWS_NEARLY) {
        bgc_status status;

        /* The defect, by f at the end of the step. */
        m->rhs(d->h, t, d->next, d->u, d->error, d->work);
        d->core.counts.rhs++;
        status = measure_defect(m, d, fixed, &found);
        if (status != BGC_OK) {
            return status;
        }
        if (fixed ? found.nonlinearity > nonlinearity_limit && d->core.halvings < BGC_MAX_HALVINGS
                  : found.excess > rejection_limit) {
            d->core.too_coarse = 1;
            return BGC_OK;
        }
        if (found.excess <= 1.0) {
            d->core.f_at_end = 1;
            return BGC_OK;
        }
    }
    if (bgc_satisfy(m, d, t, d->next) != BGC_OK) {
        d->core.failed_state = found.at_fault >= 0 ? found.at_fault : d->core.failed_state;
        return BGC_INCONSISTENT;
    }
    return BGC_OK;
}

/* A step of length h to d->next off a state at which a law has no finite slope, such as a throttle
 * without flow: there the linearisation misses the motion of the algebraic states in steps of any length.
 * Newton's method finds these from values beside the present ones, Euler's method moves the others; its
 * error goes to d->error. Returns 0 where a state has moved far, which another solution would be. */
int bgc_leave_root(const bgc_model *m, bgc_data *d, double h) {
    const int failed = d->core.failed_state;
    const double t = d->core.t + h;

    if (failed >= 0 && d->algebraic[failed] == 0.0) {
        return 0;
    }
    for (int i = 0; i < m->n_state; i++) {
        d->next[i] = d->x[i] + h * d->f[i] * d->inverse_mass[i];
        if (d->algebraic[i] == 0.0 && d->inverse_mass[i] == 0.0) {
            return 0;
        }
    }
    if (bgc_satisfy_beside(m, d, t, d->next) != BGC_OK) {
        return 0;
    }
    m->rhs(d->h, t, d->next, d->u, d->error, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        if (!(fabs(d->next[i] - d->x[i]) <= near_root * (d->scale[i] + fabs(d->x[i])))) {
            return 0;
        }
        d->error[i] = 0.5 * h * d->inverse_mass[i] * (d->error[i] - d->f[i]);
    }
    return bgc_norm(m, d, d->error, d->x, d->next) <= 1.0;
}
