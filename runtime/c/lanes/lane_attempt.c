/* lane_attempt.c: parts of an attempt at a step of a batch, as in attempt_parts.c. A lane that
 * fails leaves the batch, or takes the step by itself.
 */
#include "lanes/alone.h"
#include "control.h"

static const double near_factor = 2.0;       /* of a step with an argument near the edge of its mode, */
static const double unresolved_factor = 0.4; /* and of one that was too long for it */
enum { MOST_UNRESOLVED_STEPS = 8 };

/* Completes a step to b->next at t_new: normalises quaternions and stores the dense output. */
void bgc_complete_together(bgc_batch *b, double t_new) {
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

/* Lanes that have taken the step by themselves do not move in that of the batch, which may be far
 * off for them. */
static void leave_in_place(bgc_batch *b) {
    for (int l = 0; b->single != 0 && l < BGC_LANE_WIDTH; l++) {
        for (int i = 0; (b->single >> l & 1u) != 0 && i < b->m->n_state; i++) {
            lane_set(b->next + i, l, lane_get(b->x[i], l));
        }
    }
}

/* Accepts a step: single lanes repeat it by themselves, for the others it enters counts and
 * accounts. */
bgc_status bgc_finish_step(const bgc_model *m, bgc_batch *b, const bgc_method *method,
                           const bgc_balance *balance, double t_new) {
    bgc_step_alone(b);
    leave_in_place(b);
    if (!bgc_is_adaptive(method) && b->core.substeps <= 1) {
        bgc_record_correction(m, b, method, b->core.t);
    }
    bgc_accept(m, b, balance, t_new);
    bgc_rejoin(b);
    bgc_check_lanes(b);
    return BGC_OK;
}

/* The length of a step, at most h, that resolves sources in time in every lane. Adds to `hidden`
 * the lanes in which it is shorter than h. */
double bgc_resolved_by_all(const bgc_batch *b, double h, unsigned *hidden) {
    double shortest = h;

    for (int l = 0; l < BGC_LANE_WIDTH && b->m->n_term > 0; l++) {
        if ((b->active >> l & 1u) != 0) {
            const double length = bgc_limit_for_time(b->m, b->instance[l], b->core.t, h);
            *hidden |= length < h ? 1u << l : 0u;
            shortest = length < shortest ? length : shortest;
        }
    }
    return shortest;
}

/* Before an attempt: lanes whose f is not finite leave the batch. */
bgc_status bgc_begin_attempt(const bgc_model *m, bgc_batch *b) {
    b->active &= ~bgc_bad_lanes(b, m->n_state, b->f);
    return b->active == 0 ? BGC_NOT_FINITE : BGC_OK;
}

/* The length that step control wants; at first the shortest that bgc_run would take for an
 * instance. The instances are at their initial states. */
double bgc_wanted_step(const bgc_model *m, bgc_batch *b, const bgc_method *method) {
    double least = b->core.h_next > 0.0 ? b->core.h_next : (double)INFINITY;

    (void)method;
    for (int l = 0; b->core.h_next <= 0.0 && l < BGC_LANE_WIDTH; l++) {
        if ((b->active >> l & 1u) != 0) {
            bgc_data *d = b->instance[l];
            d->core.counts.scale_reached = lane_get(b->scale_reached, l);
            least = fmin(least, bgc_first_step_alone(m, d));
        }
    }
    return least;
}

/* Lanes for which even the shortest step is rejected leave the batch. */
bgc_status bgc_give_up(bgc_batch *b) {
    b->active &= ~b->at_fault;
    b->core.rejected = 0;
    return BGC_OK;
}

/* The step, cut to what resolves sources in time in every lane. Sets t_new. */
double bgc_shorten(const bgc_model *m, bgc_batch *b, double h, double *t_new) {
    unsigned hidden = 0;
    const double resolved = bgc_resolved_by_all(b, h, &hidden);

    (void)m;
    *t_new = resolved < h ? b->core.t + resolved : *t_new;
    return resolved;
}

int bgc_advances(const bgc_model *m, bgc_batch *b, const bgc_method *method, double h) {
    bgc_advance_by(m, b, method, h);
    return 1;
}

/* Rejects the attempt because of the lanes at fault: the next one has the length h. */
static void reject_for(bgc_batch *b, unsigned at_fault, double h) {
    b->core.counts.rejected++;
    b->core.rejected++;
    b->at_fault = at_fault;
    b->core.h_next = h;
    bgc_count_rejection(b);
}

/* Rejects a step of length h whose errors are above 1; returns whether it does. `error` is raised
 * to the largest one. An undefined error rejects the step too, unless its lane can take it by
 * itself. */
int bgc_rejects(const bgc_model *m, bgc_batch *b, const bgc_method *method, lane errors,
                const lane *vector, double h, double *error) {
    const double q = method->error_order + 1;
    const unsigned bad = bgc_lanes_where(b, lane_not(number_is_finite(errors)));

    (void)vector;
    if (bad != 0 && (m->n_switch == 0 || bad == b->active)) {
        reject_for(b, bad, 0.25 * h);
        return 1;
    }
    b->single |= bad;
    *error = fmax(*error, bgc_largest_in(b->active & ~bad, errors));
    if (*error > 1.0) {
        reject_for(b, bgc_lanes_where(b, errors > lane_of(1.0)), bgc_shorter_step(h, *error, q));
    }
    return *error > 1.0;
}

int bgc_completes(const bgc_model *m, bgc_batch *b, const bgc_method *method, double h,
                  double *t_new) {
    (void)m, (void)method, (void)h;
    bgc_complete_together(b, *t_new);
    return 1;
}

/* Lanes in which a law may switch, or a function of states hides a pulse, take the step by
 * themselves. */
int bgc_passes(const bgc_model *m, bgc_batch *b, double t_new, bgc_status *status) {
    (void)m, (void)t_new;
    bgc_watch_switches(b);
    bgc_watch_pulses(b);
    *status = BGC_OK;
    return 1;
}

/* After a step of length h: the next one does not pass the edge of a mode unseen. Lanes in which an
 * argument varies too fast for a step take it by themselves, but in a much longer one the argument
 * could seem to stand still. */
void bgc_limit_next(bgc_batch *b, double h) {
    bgc_core *core = &b->core;

    if (core->unresolved > 0 && core->unresolved < MOST_UNRESOLVED_STEPS) {
        core->h_next = fmin(core->h_next, unresolved_factor * h);
    } else if (core->near_edge) {
        core->h_next = fmin(core->h_next, near_factor * h);
    }
}
