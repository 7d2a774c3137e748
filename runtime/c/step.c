/* step.c: one attempt at a step: a fixed one, or one under error control (attempt.c). The order of
 * calls is in bgc_internal.h. */
#include "bgc_internal.h"
#include "control.h"

#include <math.h>

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

/* The end of a fixed step that would pass the next instant of a sampled part: that instant, or the
 * planned end if they differ by rounding alone. */
static double before_instant(const bgc_core *core, double planned) {
    const double slack = bgc_time_slack(planned, planned - core->step);

    return core->due < planned - slack ? core->due : planned;
}

/* From one multiple of the step to the next, or to the next event before it; in sub-steps where
 * there is a budget for them, and in halves, quarters and so on where the step is too coarse for
 * the algebraic equations. */
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
    status = bgc_advance_held(m, d, method, whole ? core->step : stop - core->t);
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
        status = bgc_complete(m, d, method, &t_new);
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
    return bgc_finish_step(m, d, method, &balance, t_new);
}

/* One attempt at a step. BGC_OK: the state has advanced, or the next attempt is shorter. Otherwise
 * the run fails, and the state is unchanged. */
bgc_status bgc_attempt(const bgc_model *m, bgc_data *d) {
    const bgc_method *method = bgc_present_method(&d->core);
    bgc_status status;

    d->core.f_at_end = d->core.too_coarse = d->core.passes_singular = d->core.left = 0;
    d->core.f_last_at = INFINITY;
    status = bgc_is_adaptive(method) ? bgc_attempt_adaptive(m, d, method)
                                     : attempt_fixed(m, d, method);
    bgc_hold_modes(m, d);
    status = bgc_status_near_chains(m, d, status);
    return status == BGC_OK || status == BGC_SINGULAR_CHAIN ? status
                                                            : bgc_blame_divisor(m, d, status);
}
