/* lockstep.c: attempts at a step that all lanes take, as step.c does for one instance.
 *
 * Under error control the step is the one that the lane with the largest error needs, so every lane
 * is within its tolerance. A lane that asks for a step below the resolution of time leaves.
 */
#include "control.h"
#include "lanes/batch.h"

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
        const lane stored = lane_fabs(balance->stored - b->stored0);
        b->imbalance = residual_after(b, balance);
        b->supplied_old = b->supplied;
        b->dissipated_old = b->dissipated;
        b->supplied += balance->supplied;
        b->dissipated += balance->dissipated;
        b->largest_account =
            lane_max(lane_max(b->largest_account, stored),
                     lane_max(lane_fabs(b->supplied), lane_fabs(b->dissipated)));
        b->exchanged =
            lane_max(b->exchanged, lane_max(b->largest_account, lane_fabs(balance->stored)));
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

/* Tells how near to its scale any state has come: look_for_life of step.c. */
static void look_for_life(bgc_batch *b) {
    lane most = lane_max(b->liveliest, lane_of(bgc_least_lively));

    for (int i = 0; i < b->m->n_state; i++) {
        most = lane_max(most, lane_fabs(b->x[i]) / b->scale[i]);
    }
    b->liveliest = lane_min(most, lane_of(1.0));
}

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

/* The first step, the shortest that a lane needs: first_step of step.c. */
static double first_step(bgc_batch *b) {
    const int n = b->m->n_state;
    const double order = b->method->error_order, most = b->option->max_step;
    lane d0, d1, d2, h0, h1, slope;

    for (int i = 0; i < n; i++) {
        b->point[i] = b->f[i] * b->inverse_mass[i];
    }
    d0 = bgc_batch_norm(b, b->x, b->x, b->x);
    d1 = bgc_batch_norm(b, b->point, b->x, b->x);
    h0 = lane_select((d0 < lane_of(1e-5)) | (d1 < lane_of(1e-5)), lane_of(1e-6), 0.01 * d0 / d1);
    if (most > 0.0) {
        h0 = lane_min(h0, lane_of(most));
    }
    for (int i = 0; i < n; i++) {
        b->next[i] = b->x[i] + h0 * b->point[i];
    }
    b->kernel->rhs(b->h, b->t + h0, b->next, b->u, b->error, b->work);
    b->counts.rhs++;
    for (int i = 0; i < n; i++) {
        b->error[i] = b->error[i] * b->inverse_mass[i] - b->point[i];
    }
    d2 = bgc_batch_norm(b, b->error, b->x, b->x) / h0;
    slope = lane_max(d1, d2);
    h1 = lane_select(slope <= lane_of(1e-15), lane_max(lane_of(1e-6), 1e-3 * h0),
                     lane_pow(0.01 / slope, lane_of(1.0 / (order + 1.0))));
    h1 = lane_min(100.0 * h0, h1);
    h1 = lane_select(d2 - d2 == lane_of(0.0), h1, 1e-3 * h0);
    return -largest(b, -h1);
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
    const unsigned bad = bgc_lanes_where(b, lane_not(bgc_is_finite(errors)));

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

/* The error of the energies of the step just made over their tolerance: account_error of step.c. */
static lane account_error(const bgc_batch *b, const bgc_lane_balance *balance) {
    const double rounding = 1e-12;
    const lane tolerance = rounding * b->energy_scale +
                           b->option->rtol * lane_max(b->largest_account, balance->moved);
    const lane_mask counts = bgc_is_finite(balance->error) & (balance->error > lane_of(0.0));

    return lane_select(counts, balance->error / tolerance, lane_of(0.0));
}

/* How much the balance asks for a shorter next step: drift_error of step.c. */
static double drift_error(const bgc_batch *b, const bgc_lane_balance *balance, double q,
                          double error) {
    const double rtol = b->option->rtol;
    const lane residual = residual_after(b, balance), added = residual - b->imbalance;
    const lane energy =
        lane_max(b->exchanged, lane_max(lane_fabs(balance->stored), balance->moved));
    const lane share = lane_max(balance->moved, energy / (double)(b->counts.steps + 1));
    const lane drift =
        bgc_drift_weight * residual / (rtol * energy) * (added / (rtol * share));
    const lane counted = lane_select(bgc_is_finite(drift), drift, lane_of(0.0));

    return fmin(largest(b, counted), error * pow(2.0, q));
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
    look_for_life(b);
    if (b->h_next <= 0.0) {
        b->h_next = b->option->step > 0.0 ? b->option->step : first_step(b);
    }
    h = b->option->max_step > 0.0 ? fmin(b->h_next, b->option->max_step) : b->h_next;
    h = bgc_limit_step(b->t, h, due, &t_new);
    if (b->rejected && h < fmax(16.0 * DBL_EPSILON * fabs(b->t), 1e-30)) {
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
            is_refused(b, account_error(b, &balance), h, &error)) {
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
