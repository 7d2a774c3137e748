/* fmi_co_simulation.c: Co-Simulation: the solver of the scene between communication points.
 *
 * Steps do not end at communication points: values there come from the dense output of the step that
 * passes the point, as rows of a run do. The result is therefore independent of the communication steps,
 * bit for bit, as long as inputs are constant. Before a step that may pass the point the instance is saved.
 * Where an input then changes, the instance is restored and the step is repeated up to the point.
 */
#include "control.h"
#include "fmi.h"

/* Saves the instance, if the next step may pass t and inputs may change there. */
static void save_before(bgc_fmi *i, double t) {
    const bgc_core *core = &i->d->core;
    const double next = fmax(core->h_next, core->step);

    if (i->m->n_param + i->info->n_input > 0 && (next <= 0.0 || core->t + 4.0 * next >= t)) {
        bgc_save(i->m, i->d, i->snapshot);
        i->core.has_snapshot = 1;
    } else {
        i->core.has_snapshot = 0;
    }
}

/* One attempt at a step, which ends at `end` at the latest. */
static bgc_status attempt_to(bgc_fmi *i, double end) {
    bgc_core *core = &i->d->core;
    bgc_status status;

    core->due = fmin(core->due, end);
    status = bgc_attempt(i->m, i->d);
    bgc_schedule(core);
    return status;
}

/* Integrates until the present is at or beyond t; exactly to it where `cut` is nonzero. *t becomes earlier
 * where the importer wants to return early. */
static bgc_status integrate_to(bgc_fmi *i, double *t, int cut) {
    bgc_data *d = i->d;
    bgc_core *core = &d->core;

    for (long attempts = 0;; attempts++) {
        const double slack = bgc_time_slack(core->t, core->t_old);
        bgc_status status = core->t > *t + slack ? BGC_OK : bgc_sample(i->m, d);

        if (status != BGC_OK || core->t >= *t - slack) {
            return status;
        }
        if (attempts >= core->max_steps) {
            return BGC_TOO_MANY_STEPS;
        }
        if (!cut) {
            save_before(i, *t);
        }
        status = attempt_to(i, cut ? *t : (double)INFINITY);
        if (status != BGC_OK) {
            return status;
        }
        if (!cut && i->hooks.stepped != NULL && core->t < *t - slack && core->t > core->t_old) {
            double stop = *t;
            i->core.t = core->t;
            i->core.viewed = i->core.has_row = 0;
            if (i->hooks.stepped(i, core->t, &stop)) {
                *t = fmax(core->t, fmin(*t, stop));
            }
            bgc_hold_modes(i->m, d);
        }
    }
}

/* The same with modes held, and with new inputs applied first. */
static bgc_status advance_to_point(bgc_fmi *i, double *t, int cut) {
    bgc_data *d = i->d;
    bgc_status status;

    d->core.f_valid = d->core.jac_valid = 0;
    bgc_find_modes(i->m, d);
    bgc_hold_modes(i->m, d);
    status = bgc_apply_inputs(i->m, d);
    if (status == BGC_OK) {
        status = bgc_check_asserts(i->m, d, d->core.t, d->x);
    }
    if (status == BGC_OK) {
        status = integrate_to(i, t, cut);
    }
    bgc_release_modes(i->m, d);
    return status;
}

/* Puts the present at the communication point, if a step has passed it. */
bgc_status bgc_fmi_return_to_point(bgc_fmi *i) {
    bgc_data *d = i->d;
    double t = i->core.t;

    if (d->core.t <= t + bgc_time_slack(d->core.t, d->core.t_old)) {
        return BGC_OK;
    }
    if (!i->core.has_snapshot || bgc_restore(i->m, d, i->snapshot) != BGC_OK) {
        return BGC_BAD_ARGUMENT;
    }
    i->core.has_snapshot = 0;
    return advance_to_point(i, &t, 1);
}

/* Sets the view to the state and the inputs at the communication point. */
static void view_point(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    const double t = i->core.t, slack = bgc_time_slack(d->core.t, d->core.t_old);
    const size_t inputs = ((size_t)m->n_input + (size_t)m->n_switch) * sizeof(double);

    if (t < d->core.t - slack) {
        bgc_interpolate(m, d, t, d->point);
        memcpy(i->view_u, d->u_step, inputs);
    } else {
        bgc_hold_modes(m, d);
        memcpy(d->point, d->x, (size_t)m->n_state * sizeof(double));
        if (d->core.algebraic > 0) {
            bgc_satisfy(m, d, t, d->point);
        }
        memcpy(i->view_u, d->u, inputs);
        bgc_release_modes(m, d);
    }
    memcpy(i->view_x, d->point, (size_t)m->n_state * sizeof(double));
    i->core.viewed = 1;
    i->core.has_row = 0;
}

/* One communication step. */
bgc_fmi_status bgc_fmi_step(bgc_fmi *i, double t, double step, double *reached) {
    const size_t size = (size_t)i->info->n_input * sizeof(double);
    bgc_status status = BGC_OK;
    double end = t + step;

    *reached = i->core.t;
    if (i->core.phase != BGC_FMI_STEPS || !isfinite(end) || !(step >= 0.0)) {
        return bgc_fmi_report(i, BGC_FMI_ERROR, "a step is made after initialisation, forwards in time");
    }
    if (fabs(t - i->core.t) > 1e-9 * fmax(step, fabs(t))) {
        return bgc_fmi_report(i, BGC_FMI_ERROR,
                              "a step begins where the last one ended, or at a restored FMU state");
    }
    if (memcmp(i->d->u, i->given, size) != 0) {
        status = bgc_fmi_return_to_point(i);
        memcpy(i->d->u, i->given, size);
    }
    if (status == BGC_OK) {
        status = advance_to_point(i, &end, 0);
    }
    if (status != BGC_OK) {
        return bgc_fmi_explain(i, BGC_FMI_ERROR, status);
    }
    i->core.t = *reached = end;
    view_point(i);
    return BGC_FMI_OK;
}
