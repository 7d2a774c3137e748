/* lockstep.c: attempts at a step that all lanes take, as step.c does for one instance.
 *
 * Under error control the step is the one that the lane with the largest error needs, so every lane
 * is within its tolerance. A lane that asks for a step below the resolution of time leaves.
 */
#include "lanes/batch.h"
#include "accounts.h"
#include "tolerance.h"

#include <string.h>

/* Makes `next` the present at t_new; what was is kept, for the dense output. */
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

/* Takes that back. */
static void move_back(bgc_batch *b) {
    lane *scratch = b->next;

    b->next = b->x;
    b->x = b->y0;
    b->y0 = scratch;
    b->t = b->t_old;
    b->dense = b->f_valid = 0;
}

/* The residual of the accounts at the end of the step just made. */
static lane residual_after(const bgc_batch *b, const bgc_lane_balance *balance) {
    return balance->stored - b->stored0 - (b->supplied + balance->supplied) +
           (b->dissipated + balance->dissipated);
}

/* Accepts the step just made, as far as lanes do not take it alone: enters it into the counts and the
 * accounts. Lanes in which an assertion fails leave. */
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

/* Lanes without a result leave; but a law may be undefined beyond its switch. */
static void send_away(bgc_batch *b, unsigned bad) {
    if (b->m->n_switch > 0) {
        b->astray |= bad;
    } else {
        b->live &= ~bad;
    }
}

static void attempt_fixed(bgc_batch *b) {
    const double step = b->option->step;
    bgc_lane_balance balance;

    bgc_batch_evaluate_f(b);
    bgc_batch_advance(b, step);
    b->held = (b->held == 0 ? b->option->keep : b->held) - 1;
    send_away(b, bgc_batch_bad(b, b->m->n_state, b->next));
    move(b, b->option->origin + (double)(b->ticks + 1) * step);
    bgc_batch_watch_switches(b);
    if (b->option->accounts) {
        bgc_batch_balance(b, &balance);
    }
    accept(b, &balance);
    b->ticks++;
}

/* --- error control ------------------------------------------------------------------------- */

/* The largest number in a live lane. */
static double largest(const bgc_batch *b, lane v) {
    double found = -INFINITY;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if ((b->live >> l & 1u) != 0) {
            found = fmax(found, lane_get(v, l));
        }
    }
    return found;
}

/* The first step, the shortest that an instance alone would take. The instances are at their initial
 * states. */
static double first_step(bgc_batch *b) {
    const bgc_model *m = b->m;
    double least = INFINITY;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if ((b->live >> l & 1u) != 0) {
            bgc_data *d = b->instance[l];
            double h;
            d->core.counts.liveliest = lane_get(b->liveliest, l);
            d->core.f_valid = 0;
            bgc_hold_modes(m, d);
            bgc_evaluate_f(m, d);
            h = b->option->step > 0.0 ? b->option->step
                                      : bgc_first_step(m, d, b->method->error_order);
            if (b->method->family->jacobian) {
                h = bgc_trust_first_step(m, d, h);
            }
            bgc_release_modes(m, d);
            least = fmin(least, h);
        }
    }
    return least;
}

/* The next attempt is shorter, because of some lanes. */
static void reject(bgc_batch *b, unsigned at_fault, double h) {
    b->counts.rejected++;
    b->rejected = 1;
    b->at_fault = at_fault;
    b->h_next = h;
}

/* Whether the errors of a step of length h refuse it; `error` becomes the largest if it is larger. One
 * that is undefined does, unless its lane may go alone. */
static int is_refused(bgc_batch *b, lane errors, double h, double *error) {
    const double q = b->method->error_order + 1;
    const unsigned bad = bgc_lanes_where(b, lane_not(number_is_finite(errors)));

    if (bad != 0 && (b->m->n_switch == 0 || bad == b->live)) {
        reject(b, bad, 0.25 * h);
        return 1;
    }
    b->astray |= bad;
    *error = fmax(*error, largest(b, errors));
    if (*error > 1.0) {
        reject(b, bgc_lanes_where(b, errors > lane_of(1.0)), bgc_shorter_step(h, *error, q));
    }
    return *error > 1.0;
}

/* What the drift of the accounts adds to the error: at most so much that the step is halved. */
static double drift_error(const bgc_batch *b, const bgc_lane_balance *balance, double q,
                          double error) {
    const lane residual = residual_after(b, balance);
    const lane drift =
        bgc_drift_error(residual, residual - b->imbalance, b->exchanged, balance->stored,
                        balance->moved, (double)(b->counts.steps + 1), b->option->rtol);

    return fmin(largest(b, drift), error * pow(2.0, q));
}

static void attempt_adaptive(bgc_batch *b) {
    const double q = b->method->error_order + 1;
    const double due = b->option->period > 0.0
                           ? b->option->origin + (double)b->sample * b->option->period
                           : INFINITY;
    double h, t_new, error = bgc_least_error;
    bgc_lane_balance balance;

    bgc_batch_evaluate_f(b);
    b->live &= ~bgc_batch_bad(b, b->m->n_state, b->f);
    if (b->live == 0) {
        return;
    }
    b->liveliest = bgc_scale_reached(b->m->n_state, b->x, b->scale, b->liveliest);
    if (b->h_next <= 0.0) {
        b->h_next = first_step(b);
    }
    h = b->option->max_step > 0.0 ? fmin(b->h_next, b->option->max_step) : b->h_next;
    h = bgc_limit_step(b->t, h, due, &t_new);
    if (b->rejected && bgc_is_too_short(b->t, h)) {
        b->live &= ~b->at_fault;
        b->rejected = 0;
        return;
    }
    bgc_batch_advance(b, h);
    if (is_refused(b, bgc_batch_norm(b, b->error, b->x, b->next), h, &error)) {
        return;
    }
    move(b, t_new);
    if (is_refused(b, bgc_batch_dense_error(b), h, &error)) {
        move_back(b);
        return;
    }
    if (b->option->accounts) {
        bgc_batch_balance(b, &balance);
        if (b->account_rejections < BGC_MOST_ACCOUNT_REJECTIONS &&
            is_refused(b,
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
    b->h_next = bgc_next_step(h, b->h_next, error, b->error_old, q, !b->rejected);
    b->error_old = bgc_remembered(error);
    b->rejected = 0;
    bgc_batch_watch_switches(b);
    accept(b, &balance);
}

/* One attempt at a step of all lanes. */
void bgc_batch_attempt(bgc_batch *b) {
    b->astray = b->written = 0;
    if (bgc_is_adaptive(b->method)) {
        attempt_adaptive(b);
    } else {
        attempt_fixed(b);
    }
}
