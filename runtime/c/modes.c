/* modes.c: the modes of piecewise laws, at a start and between steps.
 *
 * Invariant: between steps each mode is the result of its operation at the present time and state; a
 * NaN where that is undefined, or where the switch is left to error control.
 */
#include "switches.h"
#include "tolerance.h"

#include <math.h>
#include <string.h>

enum { MOST_ROUNDS = 10 };

/* --- modes --------------------------------------------------------------------------------- */

/* Kernels take the modes for the results of the operations. */
void bgc_hold_modes(const bgc_model *m, bgc_data *d) {
    if (m->n_switch > 0) {
        memcpy(d->u + m->n_input, d->mode, (size_t)m->n_switch * sizeof *d->mode);
    }
}

/* Kernels evaluate the operations. */
void bgc_release_modes(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_switch; k++) {
        d->u[m->n_input + k] = (double)NAN;
    }
}

/* Whether switch k keeps the mode before a jump that turned its argument back: the argument, located
 * within rounding of its edge, is still beyond it. */
static int has_turned(const bgc_model *m, bgc_data *d, int k, double mode) {
    if (m->n_jump == 0 || d->turned[k] == 0.0) {
        return 0;
    }
    if (mode == d->mode[k]) {
        d->turned[k] = 0.0;
    }
    return d->turned[k] != 0.0;
}

/* Sets the modes by the arguments at the present; returns 1 where one of them changes. */
static int update_modes(const bgc_model *m, bgc_data *d) {
    int changed = 0;

    m->switches(d->h, d->core.t, d->x, d->u, d->argument, d->work);
    for (int k = 0; k < m->n_switch; k++) {
        const double mode = bgc_value_of(m->switch_info[k].operation, d->argument[k]);
        d->extent[k] = fmax(d->extent[k], fabs(d->argument[k]));
        if (!bgc_is_given_up(d, k) && !has_turned(m, d, k, mode)) {
            changed |= d->mode[k] != mode && !(isnan(d->mode[k]) && isnan(mode));
            d->mode[k] = mode;
        }
    }
    return changed;
}

/* Finds the modes at the present, and leaves them released. Arguments that contain operations differ
 * by rounding between released and held modes. Steps see held ones, so the modes are iterated on
 * them. */
void bgc_find_modes(const bgc_model *m, bgc_data *d) {
    if (m->n_switch == 0) {
        return;
    }
    bgc_forget_quiet(d);
    d->core.skipped = 0;
    bgc_release_modes(m, d);
    update_modes(m, d);
    for (int round = 0; round < MOST_ROUNDS; round++) {
        bgc_hold_modes(m, d);
        if (!update_modes(m, d)) {
            break;
        }
    }
    bgc_release_modes(m, d);
}

/* At the start of a run: no modes yet, and no switch left to error control. */
void bgc_reset_modes(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_switch; k++) {
        d->mode[k] = 0.0;
        d->extent[k] = d->returns[k] = d->change_of_mode[k] = 0.0;
        if (m->n_jump > 0) {
            d->turned[k] = 0.0;
        }
    }
    bgc_release_modes(m, d);
    d->core.unresolved = 0;
    bgc_check_within(d);
    d->core.event_window = 16.0;
    d->core.skipped_tries = d->core.skipped = d->core.undecided = d->core.undecided_left = 0;
    bgc_forget_quiet(d);
    d->core.event_at = (double)NAN;
}

/* moved = x with every state perturbed by about its tolerance. Sizes and signs follow low-discrepancy
 * sequences, so that perturbations do not cancel in differences of states. */
void bgc_perturb_by_tolerances(const bgc_model *m, const bgc_data *d, const double *x, double *moved) {
    const double size_stride = 0.6180339887498949, sign_stride = 0.7548776662466927;
    const bgc_core *core = &d->core;
    double size = 0.0, sign = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        const double tolerance = bgc_step_tolerance(fabs(x[i]), d->scale[i],
                                                    core->counts.scale_reached, core->rtol,
                                                    core->atol);
        const double off = (0.5 + 0.5 * size) * tolerance;
        moved[i] = x[i] + (sign < 0.5 ? off : -off);
        size = fmod(size + size_stride, 1.0);
        sign = fmod(sign + sign_stride, 1.0);
    }
}

/* Iterates modes and algebraic equations until they agree: a jump of the states without a rate may
 * change other modes. Modes are held in the equations, which are smooth then. Where that does not
 * converge, the equations are solved with released modes. Leaves the modes released. */
bgc_status bgc_settle(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_switch * sizeof *d->mode;
    bgc_status status;

    if (m->n_switch == 0) {
        return bgc_make_consistent(m, d);
    }
    bgc_find_modes(m, d);
    for (int round = 0; round < MOST_ROUNDS && d->core.algebraic > 0; round++) {
        bgc_hold_modes(m, d);
        memcpy(d->after, d->mode, size);
        status = bgc_make_consistent(m, d);
        bgc_find_modes(m, d);
        if (status == BGC_OK && memcmp(d->after, d->mode, size) == 0) {
            return BGC_OK;
        }
    }
    status = bgc_make_consistent(m, d);
    bgc_find_modes(m, d);
    return status;
}
