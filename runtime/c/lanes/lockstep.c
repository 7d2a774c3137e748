/* lockstep.c: one attempt at a step that all lanes take, as in step.c.
 *
 * With error control the lane with the largest error determines the length, so that every lane is
 * within its tolerance. A lane that needs a step below the resolution of time leaves the batch.
 */
#include "lanes/alone.h"
#include "accounts.h"
#include "control.h"
#include "tolerance.h"

#include <string.h>

static const double near_factor = 2.0;       /* of a step with an argument near the edge of its mode, */
static const double unresolved_factor = 0.4; /* and of one that was too long for it */
enum { MOST_UNRESOLVED_STEPS = 8 };

/* Completes a step to b->next at t_new: normalises quaternions and stores the dense output. */
static void complete(bgc_batch *b, double t_new) {
    if (b->m->project != NULL) {
        b->kernel->project(b->h, lane_of(t_new), b->next, b->work);
    }
    bgc_store_dense(b->m, b, b->method, t_new);
}

/* Lanes in which an assertion fails at the present leave the batch. */
void bgc_check_lanes(bgc_batch *b) {
    if (b->m->n_assert == 0) {
        return;
    }
    b->kernel->asserts(b->h, lane_of(b->core.t), b->x, b->u, b->check, b->work);
    for (int k = 0; k < b->m->n_assert; k++) {
        b->active &= ~bgc_lanes_where(b, lane_not(lane_is(b->check[k])));
    }
}

/* Accepts the last step, which single lanes have repeated by themselves: for the others it enters counts and
 * accounts. */
static void accept_together(bgc_batch *b, const bgc_balance *balance) {
    bgc_accept(b->m, b, balance, b->core.t_end);
    bgc_rejoin(b);
    bgc_check_lanes(b);
}

/* Removes lanes with a result that is not finite. Where laws switch, one may be undefined beyond its
 * switch, and shorter steps may avoid it: then these lanes take the step by themselves. */
static void release_lanes(bgc_batch *b, unsigned bad) {
    if (b->m->n_switch > 0 || b->core.substeps > 1) {
        b->single |= bad;
    } else {
        b->active &= ~bad;
    }
}

/* Lanes whose embedded error is above the tolerance subdivide the step by themselves. */
static void judge_lanes(bgc_batch *b) {
    const bgc_tableau *tableau = b->method->tableau;
    lane error;

    bgc_combine(b->m->n_state, tableau->stages, tableau->embedded, b->stages, NULL, b->error);
    error = bgc_norm_within(b->m, b, b->error, b->x, b->next, b->core.sub_rtol, b->core.sub_atol,
                            lane_of(1.0));
    b->single |= bgc_lanes_where(b, lane_not(error <= lane_of(1.0)));
}

/* The length of a step, at most h, that resolves sources in time in every lane. Adds to `hidden` the lanes in
 * which it is shorter than h. */
static double resolved_by_all(const bgc_batch *b, double h, unsigned *hidden) {
    double shortest = h;

    for (int l = 0; l < BGC_LANE_WIDTH && b->m->n_term > 0; l++) {
        if ((b->active >> l & 1u) != 0) {
            const double length = bgc_limit_for_time(b->m, b->instance[l], b->core.t, h);
            *hidden |= length < h ? 1u << l : 0u;
            shortest = fmin(shortest, length);
        }
    }
    return shortest;
}

/* One fixed step. */
static void attempt_fixed(bgc_batch *b) {
    const bgc_model *m = b->m;
    bgc_core *core = &b->core;
    bgc_balance balance;
    unsigned bad;

    bgc_evaluate_f(m, b);
    bgc_advance_by(m, b, b->method, core->step);
    core->held = (core->held == 0 ? core->keep : core->held) - 1;
    bad = bgc_batch_bad(b, m->n_state, b->next);
    if (bad != 0 ? bgc_return_from_partner(b) : bgc_rejects_explicit_step(m, b)) {
        return;
    }

    /* Lanes that take it by themselves. */
    release_lanes(b, bad);
    if (core->substeps > 1) {
        judge_lanes(b);
    }
    resolved_by_all(b, core->step, &b->single);
    complete(b, bgc_tick(core, core->ticks + 1));
    bgc_watch_switches(b);

    /* Accept. */
    if (core->accounts) {
        bgc_balance_step(m, b, b->method, core->t_end, &balance);
    }
    bgc_choose_fixed_method(m, b);
    bgc_step_alone(b);
    if (core->substeps <= 1) {
        bgc_record_correction(m, b, b->method, core->t);
    }
    accept_together(b, &balance);
    core->ticks++;
}

/* --- error control ------------------------------------------------------------------------- */

/* The first step: the shortest that bgc_run would take for an instance. The instances are at their
 * initial states. */
static double first_step(const bgc_batch *b) {
    double least = INFINITY;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if ((b->active >> l & 1u) != 0) {
            bgc_data *d = b->instance[l];
            d->core.counts.scale_reached = lane_get(b->scale_reached, l);
            least = fmin(least, bgc_first_step_alone(b->m, d));
        }
    }
    return least;
}

/* Rejects the attempt because of the lanes at fault: the next one has the length h. */
static void reject(bgc_batch *b, unsigned at_fault, double h) {
    b->core.counts.rejected++;
    b->core.rejected++;
    b->at_fault = at_fault;
    b->core.h_next = h;
    bgc_count_rejection(b);
}

/* Rejects a step of length h whose errors are above 1; returns whether it does. `error` is raised to the
 * largest one. An undefined error rejects the step too, unless its lane can take it by itself. */
static int rejects(bgc_batch *b, lane errors, double h, double *error) {
    const double q = b->method->error_order + 1;
    const unsigned bad = bgc_lanes_where(b, lane_not(number_is_finite(errors)));

    if (bad != 0 && (b->m->n_switch == 0 || bad == b->active)) {
        reject(b, bad, 0.25 * h);
        return 1;
    }
    b->single |= bad;
    *error = fmax(*error, bgc_largest_in(b->active & ~bad, errors));
    if (*error > 1.0) {
        reject(b, bgc_lanes_where(b, errors > lane_of(1.0)), bgc_shorter_step(h, *error, q));
    }
    return *error > 1.0;
}

/* After a step of length h: the next one does not pass the edge of a mode unseen. Lanes in which an argument varies
 * too fast for a step take it by themselves, but in a much longer one the argument could seem to stand still. */
static void limit_by_switches(bgc_core *core, double h) {
    if (core->unresolved > 0 && core->unresolved < MOST_UNRESOLVED_STEPS) {
        core->h_next = fmin(core->h_next, unresolved_factor * h);
    } else if (core->near_edge) {
        core->h_next = fmin(core->h_next, near_factor * h);
    }
}

/* A step of the length that step control chooses, or a rejection. */
static void attempt_adaptive(bgc_batch *b) {
    const bgc_model *m = b->m;
    bgc_core *core = &b->core;
    const double q = b->method->error_order + 1;
    const double due = core->period > 0.0 ? core->origin + (double)core->sample * core->period
                                          : (double)INFINITY;
    double h, t_new, resolved, error = bgc_least_error;
    bgc_balance balance;
    unsigned hidden = 0;
    lane errors;
    int sampled;

    bgc_evaluate_f(m, b);
    b->active &= ~bgc_batch_bad(b, m->n_state, b->f);
    if (b->active == 0) {
        return;
    }

    /* The length of the step. */
    b->scale_reached = bgc_scale_reached(m->n_state, b->x, b->scale, b->scale_reached);
    if (core->h_next <= 0.0) {
        core->h_next = first_step(b);
    }
    h = core->given.max_step > 0.0 ? fmin(core->h_next, core->given.max_step) : core->h_next;
    h = bgc_limit_step(core->t, h, due, &t_new);
    resolved = resolved_by_all(b, h, &hidden);
    if (resolved < h) {
        h = resolved;
        t_new = core->t + h;
    }
    if (core->rejected && (bgc_is_too_short(core->t, h) || core->h_next < core->given.min_step)) {
        b->active &= ~b->at_fault;
        core->rejected = 0;
        return;
    }

    /* The step, and its errors: of the solution, of the dense output, of the accounts. */
    sampled = bgc_samples_rounding(m, b, b->method);
    if (sampled) {
        const unsigned active = b->active;
        bgc_try_perturbed(m, b, b->method, h);
        b->active = active;
    }
    bgc_advance_by(m, b, b->method, h);
    errors = bgc_norm(m, b, b->error, b->x, b->next);
    if (sampled) {
        bgc_judge_rounding(m, b, errors);
    }
    if (rejects(b, errors, h, &error)) {
        return;
    }
    complete(b, t_new);
    if (rejects(b, bgc_dense_error(m, b, b->method), h, &error)) {
        return;
    }
    if (core->accounts) {
        bgc_balance_step(m, b, b->method, t_new, &balance);
        if (core->account_rejections < BGC_MOST_ACCOUNT_REJECTIONS &&
            rejects(b,
                    bgc_account_error(balance.error, balance.moved, b->account.largest_account,
                                      b->account.energy_scale, core->rtol),
                    h, &error)) {
            core->account_rejections++;
            return;
        }
        core->account_rejections = 0;
        error = fmax(error, bgc_drift_error(b, &balance, q, error));
    }

    /* Accept. */
    core->h_next = bgc_next_step(h, core->h_next, error, core->error_old, q, !core->rejected);
    core->error_old = bgc_remembered(error);
    core->rejected = 0;
    bgc_watch_switches(b);
    limit_by_switches(core, h);
    bgc_watch_pulses(b);
    bgc_follow_subtolerance(m, b, t_new);
    bgc_choose_method(m, b, t_new, h);
    bgc_step_alone(b);
    accept_together(b, &balance);
}

/* One attempt at a step of all lanes, by the method that has been chosen. */
void bgc_attempt_together(bgc_batch *b) {
    b->single = b->written = 0;
    b->method = bgc_present_method(&b->core);
    b->core.f_at_end = 0;
    b->core.f_last_at = (double)INFINITY;
    if (bgc_is_adaptive(b->method)) {
        attempt_adaptive(b);
    } else {
        attempt_fixed(b);
    }
}
