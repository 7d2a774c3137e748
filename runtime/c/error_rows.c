/* error_rows.c: the errors of the outputs, from those of the states: the largest since the last row.
 *
 * They are the difference of the outputs at the computed and at the corrected state, at rows, at the steps whose
 * local error is measured (local_error.c), and at events.
 */
#include "global_error.h"

#include <math.h>

static const double held_row = 0.25; /* part of a step for which the error of a row stands */

/* Enters the errors of the outputs at t, where x is off by e, into the largest since the last row. Each is at most
 * the size that its output has had: a fast change that comes late is off by no more. `y`: the outputs, or NULL. */
void bgc_note_errors(const bgc_model *m, bgc_data *d, double t, const double *x, const double *u,
                     const double *e, const double *y) {
    double *true_state = d->right;

    for (int i = 0; i < m->n_state; i++) {
        true_state[i] = x[i] + e[i];
    }
    if (y == NULL) {
        m->outputs(d->h, t, x, u, d->output, d->work);
        y = d->output;
    }
    m->outputs(d->h, t, true_state, u, d->off_output, d->work);
    for (int k = 0; k < m->n_output; k++) {
        const double error = fabs(d->off_output[k] - y[k]);
        const double lowest = y[k] < d->lowest[k] ? y[k] : d->lowest[k];
        const double highest = y[k] > d->highest[k] ? y[k] : d->highest[k];
        const double size = (highest > 0.0 ? highest : 0.0) - (lowest < 0.0 ? lowest : 0.0);
        d->lowest[k] = lowest;
        d->highest[k] = highest;
        d->last_off[k] = error > size ? size : error;
        if (!(d->last_off[k] <= d->largest_off[k])) { /* also a NaN */
            d->largest_off[k] = d->last_off[k];
        }
    }
    d->core.off_noted = t;
}

/* The largest errors of the outputs since the row before, up to the row y at t that bgc_evaluate_row has just
 * written, which leaves the state of a row inside the last step in d->point. Rows close together inside a step share
 * one estimate. */
void bgc_write_errors(const bgc_model *m, bgc_data *d, double t, int inside, const double *y, double *errors) {
    const bgc_core *core = &d->core;
    const double *x = inside || core->algebraic > 0 ? d->point : d->x;
    const double h = core->t - core->t_old, at = inside ? t : core->t;
    double *e = bgc_error_vector(m, d, 10);

    if (!inside ? core->off_noted != at : !(fabs(at - core->off_noted) < held_row * h)) {
        const double q = inside ? (t - core->t_old) / h : 1.0;
        double part[INSIDE_NODES];
        for (int k = 0; k < INSIDE_NODES; k++) {
            part[k] = core->off_scale * bgc_inside_part(q, k);
        }
        for (int i = 0; i < m->n_state; i++) {
            e[i] = inside ? d->off_before[i] + q * (d->off_at_end[i] - d->off_before[i]) : d->off[i];
        }
        for (int k = 0; k < INSIDE_NODES && inside; k++) {
            const double *error = bgc_error_inside(m, d, k);
            for (int i = 0; i < m->n_state; i++) {
                e[i] += part[k] * error[i];
            }
        }
        bgc_note_errors(m, d, at, x, inside ? d->u_step : d->u, e, y);
    }
    for (int k = 0; k < m->n_output; k++) {
        errors[k] = d->largest_off[k] > d->last_off[k] ? d->largest_off[k] : d->last_off[k];
        d->largest_off[k] = 0.0;
    }
}
