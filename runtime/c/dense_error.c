/* dense_error.c: the error of the dense output within a step. */
#include "bgc_internal.h"
#include "interpolation.h"

#include <math.h>
#include <string.h>

/* The error of the dense output in the middle of a step to d->next, over the tolerances, of methods
 * whose error estimate ignores stiff components: L-stability damps these by the end of the step,
 * not within it. The estimate of a method whose stages satisfy the algebraic equations ignores
 * states without a rate too: a step to other roots of the equations has a large defect here. 0 for
 * other methods. */
number bgc_dense_error(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const double middle = 0.5 * (d->core.t_old + d->core.t_end);
    const double h = d->core.t_end - d->core.t_old;
    number error;

    if (!method->check_dense || d->core.left || d->core.dense != BGC_DENSE_READY) {
        return number_of(0.0);
    }

    /* f in the middle, */
    if (method->family->rows == BGC_ROWS_SOLVED) {
        bgc_interpolate_all(m, d, middle, d->point);
    } else {
        bgc_interpolate(m, d, middle, d->point);
    }
    bgc_functions(m, d)->rhs(d->h, number_of(middle), d->point, d->u_step, d->right, d->work);
    d->core.counts.rhs++;

    /* the defect f - M y', */
    bgc_dense_slope(m, d, d->point);
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, d->point, d->magnitude);
        memcpy(d->point, d->magnitude, (size_t)m->n_state * sizeof *d->point);
    }
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] -= d->point[i];
    }

    /* and one simplified Newton iteration. */
    if (bgc_solve(m, d, d->right) != BGC_OK) {
        return number_of(HUGE_VAL);
    }
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] = bgc_defect(d->right[i], d->y0[i], d->y1[i], middle, h);
    }
    error = bgc_norm(m, d, d->right, d->x, d->next);
    return number_select(number_is_finite(error), error, number_of(HUGE_VAL));
}
