/* fmi_model_exchange.c: Model Exchange: the importer integrates, the model handles its events.
 *
 * The continuous states are the states of the model, without those that follow from its algebraic
 * equations; these are solved for at each evaluation. Where the mass matrix couples such states to others,
 * all are continuous states, with the rates of the differentiated equations. The energy accounts of the
 * scene add two more.
 *
 * Modes of switches are held between events, so rates are smooth there. The event indicator of a switch is
 * the distance of its argument from the edge of its mode, plus a hysteresis within rounding. Instants of
 * sampled parts are time events, and so are switches that depend on time alone, in a model without inputs.
 * Quaternions and closed
 * chains drift off their constraints: where the drift is more than a part of the tolerance, a completed step
 * asks for an event, at which the states are projected.
 */
#include "fmi.h"
#include "switches.h"

enum { LOOKS_AHEAD = 64 }; /* for a switch of time alone */

/* --- states ------------------------------------------------------------------------------------ */

bgc_fmi_status bgc_fmi_set_time(bgc_fmi *i, double t) {
    if (t != i->core.t) {
        i->core.t = i->d->core.t = t;
        i->core.satisfied = 0;
    }
    return BGC_FMI_OK;
}

static bgc_fmi_status check_length(bgc_fmi *i, size_t n, int wanted) {
    return n == (size_t)wanted ? BGC_FMI_OK
                               : bgc_fmi_report(i, BGC_FMI_ERROR, "the number of values is wrong");
}

bgc_fmi_status bgc_fmi_set_states(bgc_fmi *i, const double *x, size_t n) {
    const bgc_fmi_info *info = i->info;

    if (check_length(i, n, info->n_continuous) != BGC_FMI_OK) {
        return BGC_FMI_ERROR;
    }
    for (int k = 0; k < info->n_free; k++) {
        i->d->x[info->free_state[k]] = x[k];
    }
    if (info->n_continuous > info->n_free) {
        i->d->core.supplied = x[info->n_free];
        i->d->core.dissipated = x[info->n_free + 1];
    }
    i->core.satisfied = 0;
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_get_states(bgc_fmi *i, double *x, size_t n) {
    const bgc_fmi_info *info = i->info;

    if (check_length(i, n, info->n_continuous) != BGC_FMI_OK || bgc_fmi_start(i) != BGC_FMI_OK) {
        return BGC_FMI_ERROR;
    }
    for (int k = 0; k < info->n_free; k++) {
        x[k] = i->d->x[info->free_state[k]];
    }
    if (info->n_continuous > info->n_free) {
        x[info->n_free] = i->d->core.supplied;
        x[info->n_free + 1] = i->d->core.dissipated;
    }
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_get_rates(bgc_fmi *i, double *rate, size_t n) {
    const bgc_fmi_info *info = i->info;
    bgc_fmi_status status = check_length(i, n, info->n_continuous);

    if (status == BGC_FMI_OK) {
        status = bgc_fmi_view(i);
    }
    if (status == BGC_FMI_OK) {
        status = bgc_fmi_rates(i, i->rate);
    }
    if (status != BGC_FMI_OK) {
        return status;
    }
    for (int k = 0; k < info->n_free; k++) {
        rate[k] = i->rate[info->free_state[k]];
    }
    if (info->n_continuous > info->n_free) {
        double energy[3];
        i->m->energy(i->d->h, i->core.t, i->view_x, i->view_u, energy, i->d->work);
        rate[info->n_free] = energy[1];
        rate[info->n_free + 1] = energy[2];
    }
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_get_nominals(bgc_fmi *i, double *nominal, size_t n) {
    const bgc_fmi_info *info = i->info;

    if (check_length(i, n, info->n_continuous) != BGC_FMI_OK || bgc_fmi_start(i) != BGC_FMI_OK) {
        return BGC_FMI_ERROR;
    }
    for (int k = 0; k < info->n_continuous; k++) {
        nominal[k] = k < info->n_free ? i->d->scale[info->free_state[k]] : 1.0;
    }
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_get_indicators(bgc_fmi *i, double *z, size_t n) {
    const bgc_fmi_status status = check_length(i, n, i->m->n_switch);

    return status == BGC_FMI_OK ? bgc_fmi_indicators(i, z) : status;
}

/* --- events ------------------------------------------------------------------------------------ */

/* Projects the present state on its constraints; returns the largest change over the tolerances. */
static bgc_status project(bgc_fmi *i, double *drift) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    bgc_status status = BGC_OK;

    memcpy(d->error, d->x, (size_t)m->n_state * sizeof *d->x);
    if (m->project != NULL) {
        m->project(d->h, d->core.t, d->x, d->work);
    }
    if (m->closure_info != NULL) {
        status = bgc_close_chains(m, d, d->core.t, d->x);
    }
    *drift = 0.0;
    for (int k = 0; k < m->n_state; k++) {
        *drift = fmax(*drift, fabs(d->x[k] - d->error[k]) / bgc_tolerance(d, k, fabs(d->x[k])));
    }
    return status;
}

bgc_fmi_status bgc_fmi_completed_step(bgc_fmi *i, int *wants_event) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    bgc_status status = BGC_OK;

    *wants_event = 0;
    if (bgc_fmi_satisfy(i) != BGC_FMI_OK) {
        return BGC_FMI_ERROR;
    }
    i->core.last_step = d->core.t - d->core.t_old;
    d->core.t_old = d->core.t_end = d->core.t;
    d->core.counts.steps++;
    if (m->n_switch > 0) {
        m->switches(d->h, d->core.t, d->x, d->u, d->argument, d->work);
        for (int k = 0; k < m->n_switch; k++) {
            d->extent[k] = fmax(d->extent[k], fabs(d->argument[k]));
        }
        if (m->n_jump > 0) {
            bgc_ignore_turned(m, d);
        }
    }
    if (m->project != NULL || m->closure_info != NULL) {
        double drift;
        status = project(i, &drift);
        memcpy(d->x, d->error, (size_t)m->n_state * sizeof *d->x);
        *wants_event = drift > bgc_fmi_allowed_drift;
    }
    if (status == BGC_OK) {
        status = bgc_choose_chain_rows(m, d);
    }
    if (status == BGC_OK) {
        status = bgc_check_asserts(m, d, d->core.t, d->x);
    }
    return status == BGC_OK ? BGC_FMI_OK : bgc_fmi_explain(i, BGC_FMI_ERROR, status);
}

/* The next time at which a switch of time alone changes, or at which to look again: it is searched for in
 * the part of the run that is ahead. */
static double next_of_time(bgc_fmi *i) {
    const bgc_model *m = i->m;
    const double t = i->d->core.t;
    const double ahead = m->duration > 0.0 ? m->duration / 10.0 : 1.0;

    if (m->n_timed == 0 || i->info->n_input > 0) {
        return (double)INFINITY;
    }
    for (int k = 1; k <= LOOKS_AHEAD; k++) {
        const double end = t + ahead * k / LOOKS_AHEAD, stop = bgc_stop_for_switch(m, i->d, end);
        if (stop != end) { /* an event at an instant may be a few bits behind it */
            return stop;
        }
    }
    return t + ahead;
}

/* Where a time event is due but for the rounding of times, the present is the time of the event. */
static void reach_time_event(bgc_fmi *i) {
    bgc_core *core = &i->d->core;
    const double next = next_of_time(i);

    if (next - core->t <= 64.0 * DBL_EPSILON * fabs(core->t)) {
        core->t = next;
    }
}

/* Handles what happens at the present: sampled parts, changed inputs, new modes, jumps, and projections.
 * *next is the time of the next time event, or INFINITY. */
bgc_fmi_status bgc_fmi_handle_events(bgc_fmi *i, int *states_changed, double *next) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    bgc_core *core = &d->core;
    const double supplied = core->supplied, dissipated = core->dissipated;
    const size_t size = (size_t)m->n_state * sizeof *d->x;
    double drift = 0.0;
    bgc_status status = BGC_OK;

    /* The constraints, at the time of the event. */
    memcpy(i->seed, d->x, size);
    reach_time_event(i);
    if (m->project != NULL || m->closure_info != NULL) {
        status = project(i, &drift);
    }

    /* Sampled parts whose instant has come, and inputs that have changed. */
    core->f_valid = core->jac_valid = 0;
    if (status == BGC_OK && m->n_rate > 0) {
        const double slack = 1e-9 * fmax(fabs(core->t), i->core.last_step);
        if (core->t >= core->instant - fmin(slack, 1e-6 * d->sampling[0])) {
            for (int k = 0; k < m->n_timed; k++) { /* switches of time alone at the instant come first */
                d->u[m->n_input + k] = (double)NAN;
            }
            status = bgc_take_sampled(m, d, slack);
            bgc_hold_modes(m, d);
        }
    }
    if (status == BGC_OK && m->n_input > 0 &&
        memcmp(d->u, d->u_seen, (size_t)m->n_input * sizeof *d->u) != 0) {
        memcpy(d->u_seen, d->u, (size_t)m->n_input * sizeof *d->u);
        bgc_reset_time_windows(m, d);
    }

    /* New modes with the jumps that follow, and consistent values. */
    if (status == BGC_OK && m->n_switch > 0) {
        core->event = 1;
        core->t_old = isnan(core->event_at) ? core->t_old : core->event_at;
        status = bgc_handle_event(m, d, i->core.last_step);
    } else if (status == BGC_OK) {
        status = bgc_settle(m, d);
    }
    if (status != BGC_OK) {
        return bgc_fmi_explain(i, BGC_FMI_ERROR, status);
    }

    /* The next step begins here. */
    core->t_old = core->t_end = core->t;
    core->dense = BGC_NO_DENSE;
    bgc_hold_modes(m, d);
    i->core.satisfied = 1;
    i->core.has_row = 0;
    *states_changed = memcmp(i->seed, d->x, size) != 0 || supplied != core->supplied ||
                      dissipated != core->dissipated;
    *next = fmin(m->n_rate > 0 ? core->instant : (double)INFINITY, next_of_time(i));
    return BGC_FMI_OK;
}
