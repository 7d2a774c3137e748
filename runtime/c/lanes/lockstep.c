/* lockstep.c: one attempt at a step that all lanes take, as in step.c.
 *
 * With error control the lane with the largest error determines the length, so that every lane is
 * within its tolerance. A lane that needs a step below the resolution of time leaves the batch.
 */
#include "lanes/batch.h"
#include "accounts.h"
#include "tolerance.h"

#include <string.h>

static const double near_factor = 2.0;       /* of a step with an argument near the edge of its mode, */
static const double unresolved_factor = 0.4; /* and of one that was too long for it */
enum { MOST_UNRESOLVED_STEPS = 8 };

/* Makes b->next the present at t_new. The state before is kept in b->y0 for the dense output. */
static void move(bgc_batch *b, double t_new) {
    lane *old = b->y0;

    if (b->m->project != NULL) {
        b->kernel->project(b->h, lane_of(t_new), b->next, b->work);
    }
    b->y0 = b->x;
    b->x = b->next;
    b->next = old;
    b->t_old = b->t;
    b->t = t_new;
    b->dense = b->f_valid = 0;
}

/* Undoes `move`. */
static void move_back(bgc_batch *b) {
    lane *scratch = b->next;

    b->next = b->x;
    b->x = b->y0;
    b->y0 = scratch;
    b->t = b->t_old;
    b->dense = 0;
    b->f_valid = !b->f_valid; /* unless it has been evaluated at the end, f is still that at the start */
}

/* The residual of the accounts at the end of the last step. */
static lane residual_after(const bgc_batch *b, const bgc_lane_balance *balance) {
    return balance->stored - b->stored0 - (b->supplied + balance->supplied) +
           (b->dissipated + balance->dissipated);
}

/* Accepts the last step: single lanes repeat it by themselves, for the others it enters counts and
 * accounts. Lanes in which an assertion fails leave the batch. */
static void accept(bgc_batch *b, const bgc_lane_balance *balance) {
    bgc_batch_step_alone(b);
    b->counts.steps++;
    b->counts.last_step = b->t - b->t_old;
    if (b->option->accounts) {
        b->imbalance = residual_after(b, balance);
        b->supplied_old = b->supplied;
        b->dissipated_old = b->dissipated;
        b->supplied += balance->supplied;
        b->dissipated += balance->dissipated;
        b->largest_account = bgc_largest_account(b->largest_account, balance->stored - b->stored0,
                                                 b->supplied, b->dissipated);
        b->exchanged = number_larger(number_larger(b->exchanged, b->largest_account),
                                     lane_fabs(balance->stored));
    }
    bgc_batch_rejoin(b);
    bgc_batch_check(b, b->t, b->x);
}

/* Removes lanes with a result that is not finite. Where laws switch, one may be undefined beyond its
 * switch, and shorter steps may avoid it: then these lanes take the step by themselves. */
static void release_lanes(bgc_batch *b, unsigned bad) {
    if (b->m->n_switch > 0 || b->option->substeps > 1) {
        b->single |= bad;
    } else {
        b->active &= ~bad;
    }
}

/* Lanes whose embedded error is above the tolerance subdivide the step by themselves. */
static void judge_lanes(bgc_batch *b) {
    const bgc_tableau *tableau = b->method->tableau;
    const int n = b->m->n_state;

    memset(b->error, 0, (size_t)n * sizeof *b->error);
    bgc_batch_combine(n, tableau->stages, tableau->embedded, b->stages, b->error);
    b->single |= bgc_lanes_where(
        b, lane_not(bgc_batch_norm_within(b, b->error, b->x, b->next, b->option->sub_rtol,
                                          b->option->sub_atol, lane_of(1.0)) <= lane_of(1.0)));
}

/* The lanes in which something that depends on time alone moves unseen in a step of length h take it by
 * themselves. */
static void release_moving(bgc_batch *b, double h) {
    for (int l = 0; l < BGC_LANE_WIDTH && b->m->n_term > 0; l++) {
        if ((b->active >> l & 1u) != 0 &&
            bgc_limit_for_time(b->m, b->instance[l], b->t, h) < h) {
            b->single |= 1u << l;
        }
    }
}

/* The length of a step, at most h, that resolves sources in time in every lane. */
static double resolved_by_all(const bgc_batch *b, double h) {
    for (int l = 0; l < BGC_LANE_WIDTH && b->m->n_term > 0; l++) {
        if ((b->active >> l & 1u) != 0) {
            h = fmin(h, bgc_limit_for_time(b->m, b->instance[l], b->t, h));
        }
    }
    return h;
}

/* One fixed step. */
static void attempt_fixed(bgc_batch *b) {
    const double step = b->option->step;
    bgc_lane_balance balance;
    unsigned bad;

    bgc_batch_evaluate_f(b);
    bgc_batch_advance(b, step);
    b->held = (b->held == 0 ? b->option->keep : b->held) - 1;
    bad = bgc_batch_bad(b, b->m->n_state, b->next);
    if (bgc_batch_rejects_explicit_step(b, bad)) {
        return;
    }
    release_lanes(b, bad);
    if (b->option->substeps > 1) {
        judge_lanes(b);
    }
    release_moving(b, step);
    move(b, bgc_tick(b->option, b->ticks + 1));
    bgc_batch_choose_fixed_method(b);
    bgc_batch_watch_switches(b);
    if (b->option->accounts) {
        bgc_batch_balance(b, &balance);
    }
    accept(b, &balance);
    bgc_batch_record_corrections(b);
    b->ticks++;
}

/* --- error control ------------------------------------------------------------------------- */

/* The first step: the shortest that bgc_run would take for an instance. The instances are at their
 * initial states. */
static double first_step(bgc_batch *b) {
    const bgc_model *m = b->m;
    double least = INFINITY;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if ((b->active >> l & 1u) != 0) {
            bgc_data *d = b->instance[l];
            double h;
            d->core.counts.scale_reached = lane_get(b->scale_reached, l);
            d->core.f_valid = 0;
            bgc_hold_modes(m, d);
            bgc_evaluate_f(m, d);
            h = b->option->step > 0.0 ? b->option->step
                                      : bgc_first_step(m, d, b->method->error_order);
            if (b->method->family->jacobian) {
                h = bgc_limit_first_step(m, d, h);
            }
            bgc_release_modes(m, d);
            least = fmin(least, h);
        }
    }
    return least;
}

/* Rejects the attempt because of the lanes at fault: the next one has the length h. */
static void reject(bgc_batch *b, unsigned at_fault, double h) {
    b->counts.rejected++;
    b->rejected++;
    b->at_fault = at_fault;
    b->h_next = h;
    bgc_batch_count_rejection(b);
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
    *error = fmax(*error, bgc_batch_largest(b->active, errors));
    if (*error > 1.0) {
        reject(b, bgc_lanes_where(b, errors > lane_of(1.0)), bgc_shorter_step(h, *error, q));
    }
    return *error > 1.0;
}

/* The error by which the drift of the accounts shortens the next step, at most to half. */
static double drift_error(const bgc_batch *b, const bgc_lane_balance *balance, double q,
                          double error) {
    const lane residual = residual_after(b, balance);
    const lane drift =
        bgc_drift_error(residual, residual - b->imbalance, b->exchanged, balance->stored,
                        balance->moved, (double)(b->counts.steps + 1), b->option->rtol);

    return fmin(bgc_batch_largest(b->active, drift), error * pow(2.0, q));
}

/* After a step of length h: the next one does not pass the edge of a mode unseen. Lanes in which an argument varies
 * too fast for a step take it by themselves, but in a much longer one the argument could seem to stand still. */
static void limit_by_switches(bgc_batch *b, double h) {
    if (b->unresolved > 0 && b->unresolved < MOST_UNRESOLVED_STEPS) {
        b->h_next = fmin(b->h_next, unresolved_factor * h);
    } else if (b->near_edge) {
        b->h_next = fmin(b->h_next, near_factor * h);
    }
}

/* A step of the length that step control chooses, or a rejection. */
static void attempt_adaptive(bgc_batch *b) {
    const double q = b->method->error_order + 1;
    const double due = b->option->period > 0.0
                           ? b->option->origin + (double)b->sample * b->option->period
                           : (double)INFINITY;
    double h, t_new, resolved, error = bgc_least_error;
    bgc_lane_balance balance;
    lane errors;
    int sampled;

    bgc_batch_evaluate_f(b);
    b->active &= ~bgc_batch_bad(b, b->m->n_state, b->f);
    if (b->active == 0) {
        return;
    }

    /* The length of the step. */
    b->scale_reached = bgc_scale_reached(b->m->n_state, b->x, b->scale, b->scale_reached);
    if (b->h_next <= 0.0) {
        b->h_next = first_step(b);
    }
    h = b->option->given.max_step > 0.0 ? fmin(b->h_next, b->option->given.max_step) : b->h_next;
    h = bgc_limit_step(b->t, h, due, &t_new);
    resolved = resolved_by_all(b, h);
    if (resolved < h) {
        h = resolved;
        t_new = b->t + h;
    }
    if (b->rejected &&
        (bgc_is_too_short(b->t, h) || b->h_next < b->option->given.min_step)) {
        b->active &= ~b->at_fault;
        b->rejected = 0;
        return;
    }

    /* The step, and its errors: of the solution, of the dense output, of the accounts. */
    sampled = bgc_batch_samples_rounding(b);
    if (sampled) {
        bgc_batch_try_perturbed(b, h);
    }
    bgc_batch_advance(b, h);
    errors = bgc_batch_norm(b, b->error, b->x, b->next);
    if (sampled) {
        bgc_batch_judge_rounding(b, errors);
    }
    if (rejects(b, errors, h, &error)) {
        return;
    }
    move(b, t_new);
    if (rejects(b, bgc_batch_dense_error(b), h, &error)) {
        move_back(b);
        return;
    }
    if (b->option->accounts) {
        bgc_batch_balance(b, &balance);
        if (b->account_rejections < BGC_MOST_ACCOUNT_REJECTIONS &&
            rejects(b,
                       bgc_account_error(balance.error, balance.moved, b->largest_account,
                                         b->energy_scale, b->option->rtol),
                       h, &error)) {
            b->account_rejections++;
            move_back(b);
            return;
        }
        b->account_rejections = 0;
        error = fmax(error, drift_error(b, &balance, q, error));
    }

    /* Accept. */
    b->h_next = bgc_next_step(h, b->h_next, error, b->error_old, q, !b->rejected);
    b->error_old = bgc_remembered(error);
    b->rejected = 0;
    bgc_batch_watch_switches(b);
    limit_by_switches(b, h);
    bgc_batch_watch_pulses(b);
    bgc_batch_choose_method(b, h);
    accept(b, &balance);
    bgc_batch_follow_subtolerance(b);
}

/* One attempt at a step of all lanes. */
void bgc_batch_attempt(bgc_batch *b) {
    b->single = b->written = 0;
    bgc_batch_take_method(b);
    if (bgc_is_adaptive(b->method)) {
        attempt_adaptive(b);
    } else {
        attempt_fixed(b);
    }
}
