/* step.c: one attempt at a step, and its acceptance or rejection. The order of calls is in
 * bgc_internal.h. */
#include "bgc_internal.h"
#include "accounts.h"
#include "control.h"
#include "tolerance.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { REJECTIONS_AT_ROOT = 5 }; /* in a row, before a step by Euler's method is tried */
static const double short_of_pole = 1e-3; /* relative: time before a divisor vanishes */
static const double still_part = 0.1; /* of the expected change of a state */

/* Whether the step under way may meet an edge of a switch. */
static inline int may_meet_event(const bgc_model *m, const bgc_core *core) {
    return m->n_switch > (core->skipped ? m->n_timed : 0);
}

/* Completes a step to d->next at *t_new: normalises quaternions, satisfies the algebraic equations,
 * stores the dense output and cuts the step at its first event, whose time and state go to *t_new and
 * d->next. Returns early where the step is too coarse for the algebraic equations. */
static bgc_status complete(const bgc_model *m, bgc_data *d, const bgc_method *method,
                           double *t_new) {
    const double end = *t_new;

    if (m->project != NULL) {
        m->project(d->h, end, d->next, d->work);
    }
    if (m->closure_info != NULL) {
        bgc_status status;

        memcpy(d->magnitude, d->next, (size_t)m->n_state * sizeof *d->next);
        status = bgc_close_chains(m, d, end, d->next);
        d->core.too_coarse = status == BGC_OK && d->core.halvings < BGC_MAX_HALVINGS &&
                             bgc_chains_were_left(m, d, d->next);
        if (status != BGC_OK || d->core.too_coarse) {
            return status;
        }
    }
    if (method->family->rows != BGC_ROWS_SOLVED) {
        const bgc_status status = bgc_keep_consistent(m, d, method, end);
        if (status != BGC_OK || d->core.too_coarse) {
            return status;
        }
    }
    bgc_store_dense(m, d, method, end);
    if (may_meet_event(m, &d->core)) {
        const bgc_status status = bgc_find_event(m, d, end, bgc_is_adaptive(method), t_new);
        if (status != BGC_OK) {
            return status;
        }
    }
    if (m->closure_info != NULL) {
        const bgc_status status = bgc_watch_chains(m, d, *t_new, d->next);
        if (status != BGC_OK || d->core.too_coarse) {
            return status;
        }
    }
    return bgc_check_asserts(m, d, *t_new, d->next);
}

/* Makes d->next the present state at t_new, and handles the event at the end of the step, if any. */
static bgc_status accept_step(const bgc_model *m, bgc_data *d, const bgc_balance *balance,
                              double t_new) {
    bgc_core *core = &d->core;

    if (bgc_present_method(core)->family->jacobian) {
        bgc_watch_stiffness(m, d, t_new - core->t);
    }
    bgc_accept(m, d, balance, t_new);
    bgc_enter_chains(m, d);
    return may_meet_event(m, core) ? bgc_handle_event(m, d, core->t_end - core->t_old) : BGC_OK;
}

/* A step of the method to a finite d->next. */
static bgc_status advance(const bgc_model *m, bgc_data *d, const bgc_method *method, double h) {
    const int coupled = method->family->jacobian ? -1 : bgc_coupled_rate(m, d);
    bgc_status status;
    int bad;

    if (coupled >= 0) {
        d->core.failed_state = coupled;
        return BGC_NOT_EXPLICIT;
    }
    status = method->family->advance(m, d, method, h);
    bad = status == BGC_OK ? bgc_first_bad(m->n_state, d->next) : -1;
    if (bad >= 0) {
        d->core.failed_state = bad;
        return BGC_NOT_FINITE;
    }
    return status;
}

/* The same in held modes. A law may be undefined beyond its switch (a root of a negative number): then
 * comparisons are made at every stage instead. */
static bgc_status advance_held(const bgc_model *m, bgc_data *d, const bgc_method *method,
                               double h) {
    const bgc_status status = advance(m, d, method, h);

    if (m->n_switch == 0 || status == BGC_OK) {
        return status;
    }
    bgc_release_modes(m, d);
    return advance(m, d, method, h);
}

/* --- fixed steps ------------------------------------------------------------------------- */

/* Whether a shorter step may succeed where this one did not. */
static int is_too_long(const bgc_core *core, bgc_status status) {
    return core->too_coarse || status == BGC_NOT_FINITE || status == BGC_INCONSISTENT ||
           status == BGC_SINGULAR || status == BGC_NOT_CONVERGED;
}

/* Whether to try half the length: algebraic equations are strongly nonlinear within the step, or it
 * passes a singular position of a closed chain. */
static int may_halve(const bgc_model *m, const bgc_core *core, bgc_status status) {
    return (core->algebraic > 0 || m->closure_info != NULL) && core->halvings < BGC_MAX_HALVINGS &&
           is_too_long(core, status);
}

/* The end of a fixed step that would pass the next instant of a sampled part: that instant, or the planned
 * end if they differ by rounding alone. */
static double before_instant(const bgc_core *core, double planned) {
    const double slack = bgc_time_slack(planned, planned - core->step);

    return core->due < planned - slack ? core->due : planned;
}

/* From one multiple of the step to the next, or to the next event before it; in sub-steps where there is
 * a budget for them, and in halves, quarters and so on where the step is too coarse for the algebraic
 * equations. */
static bgc_status attempt_fixed(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    bgc_core *core = &d->core;
    const double grid = bgc_tick(core, core->ticks + 1);
    bgc_balance balance = {0};
    const double part = core->t + ldexp(core->step, -core->halvings);
    const int halved = core->halvings > 0 && part < grid - 1e-3 * core->step;
    const int judged = core->substeps > 1 && core->halvings == 0;
    const double planned = halved ? part : judged ? bgc_plan_substep(core, grid) : grid;
    const double end = core->due < planned ? before_instant(core, planned) : planned;
    const double resolved = bgc_limit_for_time(m, d, core->t, end - core->t);
    const double stop =
        bgc_stop_for_switch(m, d, resolved < end - core->t ? core->t + resolved : end);
    const int whole = !core->step_cut && stop == grid;
    double t_new = stop;
    bgc_status status;

    /* A shorter step needs factors of its own. */
    if (!whole) {
        core->held = 0;
    }
    bgc_evaluate_f(m, d);
    status = advance_held(m, d, method, whole ? core->step : stop - core->t);
    if (core->held == 0) {
        core->held = core->keep;
    }
    if (status == BGC_OK && bgc_rejects_explicit_step(m, d)) {
        return BGC_OK;
    }
    if (status == BGC_OK) {
        if (judged && !bgc_accept_substep(m, d, method, status, stop - core->t)) {
            core->held = 0;
            return BGC_OK;
        }
        status = complete(m, d, method, &t_new);
    }
    if (judged && is_too_long(core, status) &&
        !bgc_accept_substep(m, d, method, status, stop - core->t)) {
        core->held = 0;
        return BGC_OK;
    }

    if (status == BGC_OK && m->n_divisor > 0) {
        status = bgc_check_divisors(m, d, t_new);
    }

    /* Try it by the implicit method, halve it, or fail. */
    if (is_too_long(core, status) && bgc_return_from_partner(d)) {
        return BGC_OK;
    }
    if (may_halve(m, core, status)) {
        core->held = 0;
        core->halvings++;
        return BGC_OK;
    }
    if (status == BGC_OK && core->passes_singular) {
        status = BGC_SINGULAR_CHAIN;
    }
    if (status != BGC_OK) {
        core->held = 0;
        return status;
    }

    /* Accept: towards longer steps again, and the factors for one step less. */
    if (!(core->substeps > 1)) {
        bgc_record_correction(m, d, method, core->t);
    }
    core->halvings -= core->halvings > 0;
    core->step_cut = t_new < grid;
    if (t_new >= grid) {
        core->ticks++;
        bgc_begin_sample(core);
    } else {
        core->attempts -= judged && t_new < planned;
    }
    core->held = whole && !core->step_cut && core->held > 0 ? core->held - 1 : 0;
    if (core->accounts) {
        bgc_settle_energy_scale(m, d);
        bgc_balance_step(m, d, method, t_new, &balance);
    }
    bgc_choose_fixed_method(m, d);
    return accept_step(m, d, &balance, t_new);
}

/* --- steps with error control -------------------------------------------------------------- */

/* The next step that is tried, which ends at the next sample or instant at the latest. */
static double limit_step(const bgc_core *core, double *t_new) {
    const double most = core->given.max_step;
    const double h = most > 0.0 ? fmin(core->h_next, most) : core->h_next;

    return bgc_limit_step(core->t, h, fmin(core->due, core->stop), t_new);
}

/* Rejects the attempt: the next one has the length h. */
static bgc_status reject(bgc_data *d, bgc_status reason, double h) {
    d->core.counts.rejected++;
    d->core.rejected++;
    d->core.reason = reason;
    d->core.h_next = h;
    bgc_count_rejection(d);
    return BGC_OK;
}

/* The first state whose error is not finite, or that with the largest over its tolerance. */
static int worst_state(const bgc_model *m, const bgc_data *d, const double *errors) {
    const bgc_core *core = &d->core;
    const double reached = core->counts.scale_reached;
    double worst = -1.0;
    int k = bgc_first_bad(m->n_state, errors);

    if (k >= 0) {
        return k;
    }
    for (int i = 0; i < m->n_state; i++) {
        const double size = fmax(fabs(d->x[i]), fabs(d->next[i]));
        const double error = fabs(errors[i]) / bgc_step_tolerance(size, d->scale[i], reached,
                                                                  core->rtol, core->atol);
        if (error > worst) {
            worst = error;
            k = i;
        }
    }
    return k;
}

/* A step in held modes. Where many attempts in a row have failed, it leaves a state at which a law has
 * no finite slope. */
static bgc_status advance_or_leave(const bgc_model *m, bgc_data *d, const bgc_method *method,
                                   double h) {
    d->core.left = d->core.rejected >= REJECTIONS_AT_ROOT && d->core.algebraic > 0 &&
                   bgc_leave_root(m, d, h);
    return d->core.left ? BGC_OK : advance_held(m, d, method, h);
}

/* Whether a state stood still in the last step, although f at the present says that it moves. */
static int stands_still(const bgc_model *m, const bgc_data *d) {
    const bgc_core *core = &d->core;

    for (int i = 0; i < m->n_state; i++) {
        const double change = fabs(d->x[i] - d->y0[i]);
        const double expected = core->counts.last_step * fabs(d->f[i] * d->inverse_mass[i]);
        const double tolerance = bgc_step_tolerance(fabs(d->x[i]), d->scale[i], core->counts.scale_reached,
                                                    core->rtol, core->atol);
        if (expected > tolerance && change < still_part * expected) {
            return 1;
        }
    }
    return 0;
}

/* Whether the present may be a point at which J is infinite: the start, an event there, or one of events that
 * follow each other step by step while a state stands still, as beside the root of a law whose piece ends
 * there. */
static int may_be_singular(const bgc_model *m, const bgc_data *d) {
    const bgc_core *core = &d->core;
    const bgc_counts *counts = &core->counts;

    return (counts->steps == counts->events && counts->events < 2) ||
           (core->after_event && core->event_at == core->t && stands_still(m, d));
}

/* From the present to the end of a step of the length that step control chooses, or a rejection. */
static bgc_status attempt_adaptive(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    bgc_core *core = &d->core;
    const double q = method->error_order + 1;
    double h, t_new, resolved, stop, shorter, error;
    bgc_balance balance = {0};
    bgc_status status;
    int bad, sampled;

    bgc_evaluate_f(m, d);
    bad = bgc_first_bad(m->n_state, d->f);
    if (bad >= 0) {
        core->failed_state = bad;
        return BGC_NOT_FINITE;
    }

    bgc_judge_terms(m, d, core->counts.last_step);

    /* The length of the step: at most to the next stop, or to an event or motion of time alone. */
    if (core->counts.scale_reached < 1.0) {
        core->counts.scale_reached =
            bgc_scale_reached(m->n_state, d->x, d->scale, core->counts.scale_reached);
    }
    if (core->h_next <= 0.0) {
        core->h_next =
            core->step > 0.0 ? core->step : bgc_first_step(m, d, method->error_order);
    }
    if (method->family->jacobian && !core->rejected && may_be_singular(m, d)) {
        core->h_next = bgc_limit_first_step(m, d, core->h_next);
    }
    h = limit_step(core, &t_new);
    if (core->rejected &&
        (bgc_is_too_short(core->t, h) || core->h_next < core->given.min_step)) {
        return core->reason;
    }
    resolved = bgc_limit_for_time(m, d, core->t, h);
    if (resolved < h) {
        h = resolved;
        t_new = core->t + h;
    }
    stop = bgc_stop_for_switch(m, d, t_new);
    if (stop != t_new) {
        t_new = stop;
        h = stop - core->t;
    }

    /* The step, and its error estimate. */
    sampled = bgc_samples_rounding(m, d, method) && bgc_try_perturbed(m, d, method, h);
    status = advance_or_leave(m, d, method, h);
    if (status != BGC_OK) {
        return reject(d, status, 0.25 * h);
    }
    error = bgc_norm(m, d, d->error, d->x, d->next);
    if (!isfinite(error)) {
        core->failed_state = bgc_first_bad(m->n_state, d->error);
        return reject(d, BGC_NOT_FINITE, 0.25 * h);
    }
    if (sampled) {
        bgc_judge_rounding(m, d, error);
    }
    if (error > 1.0) {
        core->failed_state = worst_state(m, d, d->error);
        return reject(d, BGC_STEP_TOO_SMALL, bgc_shorter_step(h, error, q));
    }

    /* Its end: algebraic equations and events; then the dense output. */
    status = complete(m, d, method, &t_new);
    if (core->too_coarse) {
        return reject(d, core->passes_singular ? BGC_SINGULAR_CHAIN : BGC_STEP_TOO_SMALL, 0.5 * h);
    }
    if (status != BGC_OK) {
        return reject(d, status, core->unresolved > 0 ? 0.4 * h : 0.1 * h);
    }
    if (m->n_watch > 0) {
        shorter = bgc_before_hidden(m, d, t_new);
        if (shorter < h) {
            core->hidden++;
            return reject(d, BGC_STEP_TOO_SMALL, shorter);
        }
    }
    error = fmax(error, bgc_dense_error(m, d, method));
    if (error > 1.0) {
        core->failed_state = worst_state(m, d, d->right);
        return reject(d, BGC_STEP_TOO_SMALL, bgc_shorter_step(h, error, q));
    }

    /* The error of the energy accounts. */
    if (core->accounts) {
        bgc_settle_energy_scale(m, d);
        bgc_balance_step(m, d, method, t_new, &balance);
        error = fmax(error, bgc_account_error(balance.error, balance.moved, core->largest_account,
                                              core->energy_scale, core->rtol));
        if (error > 1.0 && core->account_rejections < BGC_MOST_ACCOUNT_REJECTIONS) {
            core->account_rejections++;
            return reject(d, BGC_STEP_TOO_SMALL, bgc_shorter_step(h, error, q));
        }
        core->account_rejections = 0;
        error = fmax(error, bgc_drift_error(d, &balance, q, error));
    }

    /* Divisors that vanish: the run ends shortly before. */
    status = m->n_divisor > 0 ? bgc_check_divisors(m, d, t_new) : BGC_OK;
    if (status != BGC_OK) {
        const double rest = core->failed_time - core->t;
        return rest > short_of_pole * fmax(fabs(core->t), core->failed_time - core->origin)
                   ? reject(d, status, 0.98 * rest)
                   : status;
    }

    /* Accept. After an event the step does not grow. */
    if (core->limited_by >= 0) {
        memcpy(d->f_before, d->f, (size_t)m->n_state * sizeof *d->f);
    }
    bgc_follow_subtolerance(m, d, t_new);
    core->counts.controlled_steps += (double)powf((float)fmin(error, 1.0), (float)(1.0 / q));
    error = fmax(error, bgc_least_error);
    core->h_next = bgc_next_step(h, core->h_next, error, core->error_old, q,
                                 !core->rejected && !core->event);
    core->error_old = bgc_remembered(error);
    core->rejected = core->hidden = 0;
    core->failed_state = -1;
    bgc_choose_method(m, d, t_new, h);
    return accept_step(m, d, &balance, t_new);
}

/* One attempt at a step. BGC_OK: the state has advanced, or the next attempt is shorter. Otherwise the
 * run fails, and the state is unchanged. */
bgc_status bgc_attempt(const bgc_model *m, bgc_data *d) {
    const bgc_method *method = bgc_present_method(&d->core);
    bgc_status status;

    d->core.f_at_end = d->core.too_coarse = d->core.passes_singular = d->core.left = 0;
    d->core.f_last_at = INFINITY;
    status = bgc_is_adaptive(method) ? attempt_adaptive(m, d, method)
                                     : attempt_fixed(m, d, method);
    bgc_hold_modes(m, d);
    status = bgc_status_near_chains(m, d, status);
    return status == BGC_OK || status == BGC_SINGULAR_CHAIN ? status
                                                            : bgc_blame_divisor(m, d, status);
}
