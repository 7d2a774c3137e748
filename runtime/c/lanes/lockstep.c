/* lockstep.c: one attempt at a step that all lanes take: a fixed one, or one under error control
 * (attempt.c).
 *
 * With error control the lane with the largest error determines the length, so that every lane is
 * within its tolerance. A lane that needs a step below the resolution of time leaves the batch.
 */
#include "lanes/alone.h"

/* Removes lanes with a result that is not finite. Where laws switch, one may be undefined beyond
 * its switch, and shorter steps may avoid it: then these lanes take the step by themselves. */
static void release_lanes(bgc_batch *b, unsigned bad) {
    if (b->m->n_switch > 0 || b->core.substeps > 1) {
        b->single |= bad;
    } else {
        b->active &= ~bad;
    }
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
    bad = bgc_bad_lanes(b, m->n_state, b->next);
    if (bad != 0 ? bgc_return_from_partner(b) : bgc_rejects_explicit_step(m, b)) {
        return;
    }

    /* Lanes that take it by themselves: among them those whose error makes them subdivide it. */
    release_lanes(b, bad);
    if (core->substeps > 1) {
        const lane error = bgc_embedded_error(m, b, b->method);
        b->single |= bgc_lanes_where(b, lane_not(error <= lane_of(1.0)));
    }
    bgc_resolved_by_all(b, core->step, &b->single);
    bgc_complete_together(b, bgc_tick(core, core->ticks + 1));
    bgc_watch_switches(b);

    /* Accept. */
    if (core->accounts) {
        bgc_balance_step(m, b, b->method, core->t_end, &balance);
    }
    bgc_choose_fixed_method(m, b);
    bgc_finish_step(m, b, b->method, &balance, core->t_end);
    core->ticks++;
}

/* One attempt at a step of all lanes, by the method that has been chosen. */
void bgc_attempt_together(bgc_batch *b) {
    b->single = b->written = 0;
    b->method = bgc_present_method(&b->core);
    b->core.f_at_end = 0;
    b->core.f_last_at = (double)INFINITY;
    if (bgc_is_adaptive(b->method)) {
        bgc_attempt_adaptive(b->m, b, b->method);
    } else {
        attempt_fixed(b);
    }
}
