/* attempt_parts.c: parts of an attempt at a step of one instance: what attempt.c and step.c take it
 * from. Those that return 0 have rejected it.
 */
#include "bgc_internal.h"
#include "control.h"
#include "tolerance.h"

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
 * stores the dense output and cuts the step at its first event, whose time and state go to *t_new
 * and d->next. Returns early where the step is too coarse for the algebraic equations. */
bgc_status bgc_complete(const bgc_model *m, bgc_data *d, const bgc_method *method,
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

/* Makes d->next, to which a step of the method leads, the present state at t_new, and handles the
 * event at the end of the step, if any. Another method may have been chosen for the next step. */
bgc_status bgc_finish_step(const bgc_model *m, bgc_data *d, const bgc_method *method,
                           const bgc_balance *balance, double t_new) {
    bgc_core *core = &d->core;
    const int at_event = core->event;
    bgc_status status = BGC_OK;

    if (d->follower != NULL) {
        status = d->follower->step(m, d, d->follower->of, method, t_new);
    }
    if (status != BGC_OK) {
        return status;
    }
    if (method->family->jacobian) {
        bgc_watch_stiffness(m, d, t_new - core->t);
    }
    if (core->errors) {
        bgc_follow_error(m, d, method, t_new);
    }
    bgc_accept(m, d, balance, t_new);
    bgc_enter_chains(m, d);
    status = may_meet_event(m, core) ? bgc_handle_event(m, d, core->t_end - core->t_old) : BGC_OK;
    if (core->errors && at_event && status == BGC_OK) {
        bgc_carry_error_through(m, d, method);
    }
    if (d->follower != NULL && at_event && status == BGC_OK) {
        status = d->follower->event(m, d, d->follower->of);
    }
    return status;
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

/* The same in held modes. A law may be undefined beyond its switch (a root of a negative number):
 * then comparisons are made at every stage instead. */
bgc_status bgc_advance_held(const bgc_model *m, bgc_data *d, const bgc_method *method,
                               double h) {
    const bgc_status status = advance(m, d, method, h);

    if (m->n_switch == 0 || status == BGC_OK) {
        return status;
    }
    bgc_release_modes(m, d);
    return advance(m, d, method, h);
}

/* --- error control --------------------------------------------------------------------------- */

/* Rejects the attempt: the next one has the length h. */
static void reject(bgc_data *d, bgc_status reason, double h) {
    d->core.counts.rejected++;
    d->core.rejected++;
    d->core.reason = reason;
    d->core.h_next = h;
    bgc_count_rejection(d);
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

/* Rejects an attempt of length h whose error is not finite or above 1; returns whether it does.
 * `error` is raised to it. The state at fault is that of `vector`, where there is one. */
int bgc_rejects(const bgc_model *m, bgc_data *d, const bgc_method *method, double errors,
                const double *vector, double h, double *error) {
    const double q = method->error_order + 1;

    if (!isfinite(errors)) {
        d->core.failed_state = vector != NULL ? bgc_first_bad(m->n_state, vector) : -1;
        reject(d, BGC_NOT_FINITE, 0.25 * h);
        return 1;
    }
    *error = fmax(*error, errors);
    if (*error > 1.0) {
        d->core.failed_state = vector != NULL ? worst_state(m, d, vector) : d->core.failed_state;
        reject(d, BGC_STEP_TOO_SMALL, bgc_shorter_step(h, *error, q));
    }
    return *error > 1.0;
}

/* Before an attempt, with f at the present. */
bgc_status bgc_begin_attempt(const bgc_model *m, bgc_data *d) {
    const int bad = bgc_first_bad(m->n_state, d->f);

    if (bad >= 0) {
        d->core.failed_state = bad;
        return BGC_NOT_FINITE;
    }
    bgc_judge_terms(m, d, d->core.counts.last_step);
    if (d->core.accounts) {
        bgc_settle_energy_scale(m, d);
    }
    return BGC_OK;
}

/* A step in held modes to d->next, or a rejection. Where many attempts in a row have failed, it
 * leaves a state at which a law has no finite slope. */
int bgc_advances(const bgc_model *m, bgc_data *d, const bgc_method *method, double h) {
    bgc_status status;

    d->core.left = d->core.rejected >= REJECTIONS_AT_ROOT && d->core.algebraic > 0 &&
                   bgc_leave_root(m, d, h);
    status = d->core.left ? BGC_OK : bgc_advance_held(m, d, method, h);
    if (status != BGC_OK) {
        reject(d, status, 0.25 * h);
    }
    return status == BGC_OK;
}

/* Whether a state stood still in the last step, although f at the present says that it moves. */
static int stands_still(const bgc_model *m, const bgc_data *d) {
    const bgc_core *core = &d->core;

    for (int i = 0; i < m->n_state; i++) {
        const double change = fabs(d->x[i] - d->y0[i]);
        const double expected = core->counts.last_step * fabs(d->f[i] * d->inverse_mass[i]);
        const double tolerance = bgc_step_tolerance(
            fabs(d->x[i]), d->scale[i], core->counts.scale_reached, core->rtol, core->atol);
        if (expected > tolerance && change < still_part * expected) {
            return 1;
        }
    }
    return 0;
}

/* Whether the present may be a point at which J is infinite: the start, an event there, or one of
 * events that follow each other step by step while a state stands still, as beside the root of a
 * law whose piece ends there. */
static int may_be_singular(const bgc_model *m, const bgc_data *d) {
    const bgc_core *core = &d->core;
    const bgc_counts *counts = &core->counts;

    return (counts->steps == counts->events && counts->events < 2) ||
           (core->after_event && core->event_at == core->t && stands_still(m, d));
}

/* The length that step control wants, before an attempt. */
double bgc_wanted_step(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    bgc_core *core = &d->core;

    if (core->h_next <= 0.0) {
        core->h_next =
            core->step > 0.0 ? core->step : bgc_first_step(m, d, method->error_order);
    }
    return method->family->jacobian && !core->rejected && may_be_singular(m, d)
               ? bgc_limit_first_step(m, d, core->h_next)
               : core->h_next;
}

/* The step, cut before an event or a motion of time alone. Sets t_new. */
double bgc_shorten(const bgc_model *m, bgc_data *d, double h, double *t_new) {
    const double resolved = bgc_limit_for_time(m, d, d->core.t, h);
    double stop;

    if (resolved < h) {
        h = resolved;
        *t_new = d->core.t + h;
    }
    stop = bgc_stop_for_switch(m, d, *t_new);
    if (stop != *t_new) {
        *t_new = stop;
        h = stop - d->core.t;
    }
    return h;
}

/* Completes a step of length h, or rejects it: too coarse for the algebraic equations, an event
 * that is not found, a function of states that hides a pulse. */
int bgc_completes(const bgc_model *m, bgc_data *d, const bgc_method *method, double h,
                  double *t_new) {
    bgc_core *core = &d->core;
    const bgc_status status = bgc_complete(m, d, method, t_new);
    double shorter;

    if (core->too_coarse) {
        reject(d, core->passes_singular ? BGC_SINGULAR_CHAIN : BGC_STEP_TOO_SMALL, 0.5 * h);
        return 0;
    }
    if (status != BGC_OK) {
        reject(d, status, core->unresolved > 0 ? 0.4 * h : 0.1 * h);
        return 0;
    }
    shorter = m->n_watch > 0 ? bgc_before_hidden(m, d, *t_new) : h;
    if (shorter < h) {
        core->hidden++;
        reject(d, BGC_STEP_TOO_SMALL, shorter);
    }
    return !(shorter < h);
}

/* Whether no divisor vanishes in a step to t_new: the run ends shortly before, with that status. */
int bgc_passes(const bgc_model *m, bgc_data *d, double t_new, bgc_status *status) {
    bgc_core *core = &d->core;

    *status = m->n_divisor > 0 ? bgc_check_divisors(m, d, t_new) : BGC_OK;
    if (*status != BGC_OK) {
        const double rest = core->failed_time - core->t;
        if (rest > short_of_pole * fmax(fabs(core->t), core->failed_time - core->origin)) {
            reject(d, *status, 0.98 * rest);
            *status = BGC_OK;
        }
        return 0;
    }
    if (core->limited_by >= 0) {
        memcpy(d->f_before, d->f, (size_t)m->n_state * sizeof *d->f);
    }
    return 1;
}
