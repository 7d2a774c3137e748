/* attempt.c: one attempt at a step whose length error control chooses, of one instance or of a
 * batch.
 *
 * Errors are relative to the tolerances. A batch takes the step that its least accurate instance
 * permits; what an instance or a lane does about an attempt that fails is in attempt_parts.c and in
 * lanes/lane_attempt.c.
 */
#include "bgc_internal.h"
#include "accounts.h"
#include "control.h"
#include "tolerance.h"

#include <math.h>

/* The wanted step, at most to the next sample, instant or stop. */
static double limit_step(const bgc_core *core, double *t_new) {
    const double most = core->given.max_step;
    const double h = most > 0.0 ? fmin(core->h_next, most) : core->h_next;

    return bgc_limit_step(core->t, h, fmin(core->due, core->stop), t_new);
}

/* The energies of the step and their error. Returns whether the step goes on. A power that grows
 * from nothing has nothing to be relative to at first: then some rejections are enough. */
static int balances(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h,
                    double t_new, double *error, bgc_balance *balance) {
    bgc_core *core = &d->core;
    const bgc_accounts *a = bgc_accounts_of(d);
    number errors;

    bgc_balance_step(m, d, method, t_new, balance);
    errors = bgc_account_error(balance->error, balance->moved, a->largest_account, a->energy_scale,
                               core->rtol);
    if (core->account_rejections < BGC_MOST_ACCOUNT_REJECTIONS &&
        bgc_rejects(m, d, method, errors, NULL, h, error)) {
        core->account_rejections++;
        return 0;
    }
    core->account_rejections = 0;
    *error = fmax(*error, bgc_largest(d, errors));
    *error = fmax(*error, bgc_drift_error(d, balance, method->error_order + 1, *error));
    return 1;
}

/* From the present to the end of a step of the length that step control chooses, or a rejection,
 * which sets a shorter length for the next attempt. A status other than BGC_OK ends the run. */
bgc_status bgc_attempt_adaptive(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    bgc_core *core = &d->core;
    const double q = method->error_order + 1;
    double h, t_new, error = 0.0;
    bgc_balance balance;
    bgc_status status;
    number errors;
    int sampled;

    bgc_evaluate_f(m, d);
    status = bgc_begin_attempt(m, d);
    if (status != BGC_OK) {
        return status;
    }

    /* The length of the step: at most to the next stop, or to an event or motion of time alone. */
    bgc_raise_reached(m, d);
    core->h_next = bgc_wanted_step(m, d, method);
    h = limit_step(core, &t_new);
    if (core->rejected &&
        (bgc_is_too_short(core->t, h) || core->h_next < core->given.min_step)) {
        return bgc_give_up(d);
    }
    h = bgc_shorten(m, d, h, &t_new);

    /* The step, and its error estimate. */
    sampled = bgc_samples_rounding(m, d, method) && bgc_try_perturbed(m, d, method, h);
    if (!bgc_advances(m, d, method, h)) {
        return BGC_OK;
    }
    errors = bgc_norm(m, d, d->error, d->x, d->next);
    if (sampled) {
        bgc_judge_rounding(m, d, errors);
    }
    if (bgc_rejects(m, d, method, errors, d->error, h, &error)) {
        return BGC_OK;
    }

    /* Its end: algebraic equations and events; then the dense output, and the energy accounts. */
    if (!bgc_completes(m, d, method, h, &t_new) ||
        bgc_rejects(m, d, method, bgc_dense_error(m, d, method), d->right, h, &error)) {
        return BGC_OK;
    }
    if (core->accounts && !balances(m, d, method, h, t_new, &error, &balance)) {
        return BGC_OK;
    }
    if (!bgc_passes(m, d, t_new, &status)) {
        return status;
    }

    /* Accept. After an event the step does not grow. */
    bgc_follow_subtolerance(m, d, t_new);
    core->counts.controlled_steps += (double)powf((float)fmin(error, 1.0), (float)(1.0 / q));
    error = fmax(error, bgc_least_error);
    core->h_next = bgc_next_step(h, core->h_next, error, core->error_old, q,
                                 !core->rejected && !core->event);
    core->error_old = bgc_remembered(error);
    core->rejected = core->hidden = 0;
    core->failed_state = -1;
    bgc_limit_next(d, h);
    bgc_choose_method(m, d, t_new, h);
    return bgc_finish_step(m, d, method, &balance, t_new);
}
