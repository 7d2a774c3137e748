/* at_events.c: the end of a step at an event: new modes, jumps, and modes that return endlessly. */
#include "switches.h"
#include "tolerance.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double immediate_return = 1e-3; /* part of a step between an event and the next */
enum { MOST_RETURNS = 50 };

/* Whether f jumps with the mode of switch k, from `before`, by more than the tolerances of the states
 * change it. */
static int jumps_here(const bgc_model *m, bgc_data *d, int k, double before) {
    double *mode = d->u + m->n_input + k;
    int jumps = 0;

    bgc_hold_modes(m, d);
    m->rhs(d->h, d->core.t, d->x, d->u, d->right, d->work);
    bgc_perturb_by_tolerances(m, d, d->x, d->point);
    m->rhs(d->h, d->core.t, d->point, d->u, d->magnitude, d->work);
    *mode = before;
    m->rhs(d->h, d->core.t, d->x, d->u, d->point, d->work);
    d->core.counts.rhs += 3;
    bgc_release_modes(m, d);
    for (int i = 0; i < m->n_state && !jumps; i++) {
        const double off = fabs(d->magnitude[i] - d->right[i]);
        const double rounding = 16.0 * DBL_EPSILON * fabs(d->right[i]);
        jumps = !(fabs(d->point[i] - d->right[i]) <= bgc_noise_factor * off + rounding);
    }
    return jumps;
}

/* Counts the consecutive immediate returns of each switch. Where one returns endlessly, its law
 * drives the state to the edge from both sides: BGC_CHATTERING if f jumps there; if f is continuous,
 * the switch is left to error control. */
static bgc_status count_returns(const bgc_model *m, bgc_data *d, const double *before,
                                int in_a_row) {
    bgc_status status = BGC_OK;

    for (int k = 0; k < m->n_switch; k++) {
        const double change = d->mode[k] - before[k];
        if (bgc_is_given_up(d, k)) {
            continue;
        }
        d->returns[k] = in_a_row ? d->returns[k] : 0.0;
        if (change == 0.0 || isnan(change)) {
            continue;
        }
        d->returns[k] += change * d->change_of_mode[k] < 0.0;
        d->change_of_mode[k] = change;
        if (d->returns[k] < MOST_RETURNS) {
            continue;
        }
        if (m->switch_info[k].jumps > 1 ||
            (m->switch_info[k].jumps && jumps_here(m, d, k, before[k]))) {
            d->core.failed_switch = k;
            status = BGC_CHATTERING;
        } else {
            d->mode[k] = (double)NAN;
            d->returns[k] = (double)INFINITY;
        }
    }
    return status;
}

/* Sets the modes of switches whose arguments are no longer undefined, and of those whose change was
 * negligible. */
static void find_missing_modes(const bgc_model *m, bgc_data *d) {
    int changed = 0;

    for (int k = 0; k < m->n_switch; k++) {
        if (isnan(d->mode[k]) && !bgc_is_given_up(d, k)) {
            d->mode[k] = bgc_value_of(m->switch_info[k].operation, d->argument[k]);
        }
        changed |= d->ignored[k] != 0.0 && bgc_is_outside(m, d, k, d->argument[k]);
    }
    if (changed) {
        bgc_find_modes(m, d);
        d->core.f_valid = d->core.jac_valid = 0;
    }
}

/* After an accepted step. Where it ended at an event: the new modes, and the states that jump with
 * them. `whole` is the length of the attempted step. */
bgc_status bgc_handle_event(const bgc_model *m, bgc_data *d, double whole) {
    bgc_core *core = &d->core;
    const int in_a_row =
        core->event_at == core->t_old && core->t - core->t_old <= immediate_return * whole;
    bgc_status status;

    core->unresolved = 0;
    if (!core->event && core->algebraic == 0) {
        const double *last = d->samples + (BGC_SAMPLES - 1) * bgc_padded(m->n_switch);
        memcpy(d->argument, last, (size_t)m->n_switch * sizeof *d->argument);
        if (core->near_edge) {
            find_missing_modes(m, d);
        }
        return BGC_OK;
    }
    if (!core->event) {
        m->switches(d->h, core->t, d->x, d->u, d->argument, d->work);
        find_missing_modes(m, d);
        return BGC_OK;
    }

    /* New modes and consistent states; f and the factors of W are those of the old modes. */
    bgc_check_within(d);
    core->event = 0;
    core->after_event = core->event_at == core->t_old;
    core->event_at = core->t;
    core->counts.events++;
    core->f_valid = core->jac_valid = core->held = 0;
    memcpy(d->probe, d->mode, (size_t)m->n_switch * sizeof *d->mode);
    status = m->n_jump > 0 ? bgc_meet_edges(m, d) : BGC_OK;
    if (status == BGC_OK) {
        status = bgc_settle(m, d);
    }
    if (status == BGC_OK) {
        status = count_returns(m, d, d->probe, in_a_row);
    }
    if (status == BGC_OK && m->n_jump > 0) {
        status = bgc_jump(m, d, d->probe, whole);
    }
    bgc_hold_modes(m, d);
    return status;
}
