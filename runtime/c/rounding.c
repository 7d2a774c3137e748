/* rounding.c: detection of runs whose steps are limited by the rounding of f.
 *
 * Where f is a small difference of large terms, as in a fine mesh, its rounding errors enter the
 * error estimate. They do not fall with the step as the error does, and error control takes steps
 * that are far too short. At some steps the attempt is made twice, once from a hundredth of the
 * last step before its end, perturbed by a millionth of the tolerance and some units of the last
 * digit. The true error hardly changes, and the rounding errors are independent: the difference of
 * both estimates is their size. The digits alone would not do: beside a large term they may round
 * away.
 */
#include "bgc_internal.h"
#include "tolerance.h"

#include <float.h>
#include <string.h>

enum { ROUNDING_INTERVAL = 256 }; /* steps between two samples */

static const double shift_of_step = 1e-2;
static const double shift_of_tolerance = 1e-6;
static const double shift_of_state = 8.0 * DBL_EPSILON;
static const double negligible_rounding = 0.05; /* rounding, over the tolerance */
static const double dominant_rounding = 0.5;    /* rounding, over the error estimate */

/* Shifts the present by a part of the tolerance of each state; sizes and signs follow a
 * low-discrepancy sequence. */
static void shift_state(const bgc_model *m, bgc_ivp *d) {
    double size = 0.25;

    for (int i = 0; i < m->n_state; i++) {
        const number value = d->x[i], now = number_fabs(value);
        const number tolerance =
            bgc_step_tolerance(now, d->scale[i], bgc_reached(d), d->core.rtol, d->core.atol);
        d->x[i] = value + (2.0 * size - 1.0) *
                              (shift_of_tolerance * tolerance + shift_of_state * now);
        size += 0.6180339887498949;
        size -= size >= 1.0 ? 1.0 : 0.0;
    }
}

/* Whether rounding makes up the error estimate of a step. */
static number_mask rounding_dominates(number noise, number error) {
    return (noise > number_of(negligible_rounding)) & (noise > dominant_rounding * error);
}

/* Whether the next attempt is a sample. Runs with inputs have to keep their time, and take none.
 * Nor do methods that solve algebraic equations after a step: their factors would be those of the
 * perturbed state. */
int bgc_samples_rounding(const bgc_model *m, const bgc_ivp *d, const bgc_method *method) {
    const bgc_counts *counts = &d->core.counts;

    return counts->steps > 0 && counts->steps % ROUNDING_INTERVAL == 0 && !d->core.rejected &&
           method->tableau != NULL && m->n_input == 0 &&
           (d->core.algebraic == 0 || method->family->rows != BGC_ROWS_LEFT);
}

/* Whether the last step ended at the present, and its dense output is at hand where the method
 * needs it here: with stiff equations, a tangent leaves the solution. */
static int follows_step(const bgc_model *m, const bgc_ivp *d, const bgc_method *method) {
    const bgc_core *core = &d->core;

    return core->t == core->t_end && core->t > core->t_old &&
           memcmp(d->x, d->y1, (size_t)m->n_state * sizeof *d->x) == 0 &&
           (!method->family->jacobian || core->dense == BGC_DENSE_READY);
}

/* Moves the state and the time back by a part of the last step. */
static void move_back(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    bgc_core *core = &d->core;
    const double shift = shift_of_step * (core->t_end - core->t_old);

    if (method->family->jacobian) {
        bgc_interpolate_all(m, d, core->t_end - shift, d->point);
        memcpy(d->x, d->point, (size_t)m->n_state * sizeof *d->x);
    } else {
        for (int i = 0; i < m->n_state; i++) {
            d->x[i] -= shift * d->inverse_mass[i] * d->f[i];
        }
    }
    core->t -= shift;
}

/* Makes the attempt of length h from a perturbed state, and keeps its error estimate in d->noise.
 * Nothing else of the instance changes but scratch. Returns whether it succeeded. */
int bgc_try_perturbed(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;
    const bgc_core before = d->core;
    const int follows = follows_step(m, d, method);
    const unsigned lanes = bgc_active(d);
    bgc_status status;

    memcpy(d->trial, d->x, size);
    memcpy(d->change, d->f, size);
    if (follows) {
        move_back(m, d, method);
    }
    d->core.jac_valid = 0;
    if (method->family->jacobian) { /* before the rounding errors change */
        bgc_evaluate_jacobian(m, d);
    }
    shift_state(m, d);
    d->core.f_valid = 0;
    bgc_evaluate_f(m, d);
    status = bgc_advance_by(m, d, method, h);
    memcpy(d->noise, d->error, size);
    memcpy(d->x, d->trial, size);
    memcpy(d->f, d->change, size);
    d->core = before;
    bgc_set_active(d, lanes);
    d->core.jac_valid = 0;
    return status == BGC_OK;
}

/* After the same attempt from the state itself, with this error over the tolerances. */
void bgc_judge_rounding(const bgc_model *m, bgc_ivp *d, number error) {
    number noise;

    for (int i = 0; i < m->n_state; i++) {
        d->noise[i] -= d->error[i];
    }
    noise = bgc_norm(m, d, d->noise, d->x, d->next);
    bgc_enter_rounding(d, rounding_dominates(noise, error), noise);
}
