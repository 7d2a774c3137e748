/* alone.c: actions of single instances of a batch. Each reads and writes its own devices. A step in
 * which a law of an instance may switch, and a fixed step that it subdivides, is taken by bgc_run
 * for that instance, from the start of the step of the batch to its end, so that events and
 * sub-steps need no second implementation. Such steps are few.
 */
#include "lanes/alone.h"
#include "control.h"
#include "modes.h"

#include <string.h>

/* Whether lane l is in the set. */
static int is_among(unsigned lanes, int l) { return (int)(lanes >> l & 1u); }

/* --- inputs and modes ---------------------------------------------------------------------- */

/* Copies inputs and modes of an instance to its lane. */
static void load_inputs(bgc_batch *b, int l, const bgc_data *d) {
    for (int k = 0; k < b->m->n_input; k++) {
        lane_set(b->u + k, l, d->u[k]);
    }
    for (int k = 0; k < b->m->n_switch; k++) {
        lane_set(b->u + b->m->n_input + k, l, d->mode[k]);
    }
}

/* The same for all instances, at the start of a run. Lanes beyond the last instance copy it. */
void bgc_load_inputs(bgc_batch *b, int count) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        bgc_data *d = b->instance[l < count ? l : count - 1];
        bgc_find_modes(b->m, d);
        load_inputs(b, l, d);
    }
}

/* Where a sample of a sampled batch is due, reads the devices of every instance and writes its
 * commands. */
void bgc_sample_all(bgc_batch *b) {
    const bgc_model *m = b->m;

    if (b->core.t < b->core.due - bgc_time_slack(b->core.t, b->core.t_old)) {
        return;
    }
    for (int l = 0; l < BGC_LANE_WIDTH && (m->n_input > 0 || m->n_device > 0); l++) {
        bgc_data *d = is_among(b->active, l) ? b->instance[l] : NULL;
        if (d == NULL || is_among(b->written, l)) { /* after a single step: sampled already */
            continue;
        }
        for (int i = 0; i < m->n_state; i++) {
            d->x[i] = lane_get(b->x[i], l);
        }
        d->core.t = b->core.t;
        d->core.t_old = b->core.t_old;
        d->core.sample = b->core.sample;
        bgc_schedule(&d->core);
        if (bgc_sample(m, d) != BGC_OK) {
            b->active &= ~(1u << l);
        }
        load_inputs(b, l, d);
        b->core.f_valid = b->core.jac_valid = 0;
    }
    b->core.sample++;
    bgc_schedule(&b->core);
}

/* --- steps in which a law may switch ------------------------------------------------------- */

/* The arguments of all switches at sample i of the last step, 0 at its start. */
static void evaluate_sample(bgc_batch *b, int i) {
    const bgc_model *m = b->m;
    const double part = i == 0 ? 0.0 : bgc_sample_at[i - 1];
    const double start = b->core.t_old, end = b->core.t_end;
    const double t = i == BGC_SAMPLES ? end : start + part * (end - start);
    const lane *x = i == 0 ? b->y0 : i == BGC_SAMPLES ? b->y1 : b->point;

    if (x == b->point && m->n_switch_state > 0) {
        bgc_interpolate_some(m, b, t, m->n_switch_state, m->switch_state, b->point);
    } else if (x == b->point) {
        bgc_interpolate(m, b, t, b->point);
    }
    b->kernel->switches(b->h, lane_of(t), x, b->u, b->argument + (size_t)(i * m->n_switch),
                        b->work);
}

/* Whether sample i is one of the first. */
static int is_first(int i) {
    int found = i == 0;

    for (int j = 0; j < BGC_FIRST_SAMPLES; j++) {
        found |= i == bgc_first_sample[j];
    }
    return found;
}

/* The same at the first samples, or at the others. */
static void evaluate_samples(bgc_batch *b, int first) {
    for (int i = 0; i <= BGC_SAMPLES; i++) {
        if (is_first(i) == first) {
            evaluate_sample(b, i);
        }
    }
}

/* The lanes in which ranges cannot tell what the switches of time alone do in the last step. Adds
 * to `single` those in which one leaves its mode. */
static unsigned look_at_timed(bgc_batch *b) {
    unsigned undecided = 0;

    for (int l = 0; l < BGC_LANE_WIDTH && b->m->n_timed > 0; l++) {
        double inside, outside;
        bgc_outlook outlook;
        if (is_among(b->active, l)) {
            outlook = bgc_find_time_event(b->m, b->instance[l], b->core.t_old, b->core.t_end,
                                          &inside, &outside);
            b->single |= outlook == BGC_LEAVES ? 1u << l : 0u;
            undecided |= outlook == BGC_UNDECIDED ? 1u << l : 0u;
        }
    }
    return undecided;
}

/* The lanes in which a law may switch in the last step, by all samples or the first ones: an
 * argument has left its mode or has none, or it is nearer to the edge of its mode than `distance`
 * times its variation. Of all samples, *unresolved has those in which an argument near the edge of
 * its mode varies too fast for them, as in bgc_is_unresolved. Switches of time alone are judged in
 * the lanes `timed`. */
static unsigned find_near(bgc_batch *b, unsigned timed, int all, double distance,
                          unsigned *unresolved) {
    const bgc_model *m = b->m;
    unsigned found = 0;

    *unresolved = 0;
    for (int k = timed != 0 ? 0 : m->n_timed; k < m->n_switch; k++) {
        const int operation = m->switch_info[k].operation;
        const unsigned judged = k < m->n_timed ? timed : ~0u;
        const lane mode = b->u[m->n_input + k];
        lane z[BGC_SAMPLES + 1], low = b->argument[k], high = low;
        lane nearest = bgc_depth(operation, mode, low), largest = b->extent[k];
        lane_mask left = mode != mode;
        for (int i = 0; i <= BGC_SAMPLES; i++) {
            z[i] = b->argument[i * m->n_switch + k];
            if (all || is_first(i)) {
                low = lane_min(low, z[i]);
                high = lane_max(high, z[i]);
                nearest = lane_min(nearest, bgc_depth(operation, mode, z[i]));
                largest = lane_max(largest, lane_fabs(z[i]));
            }
            if (i > 0 && (all || is_first(i))) {
                left |= (z[i] != z[i]) | (bgc_result(operation, z[i]) != mode);
            }
        }
        found |= bgc_lanes_where(b, left | (nearest < distance * (high - low))) & judged;
        if (all) {
            b->extent[k] = largest;
            *unresolved |= bgc_lanes_where(b, (bgc_excess_over_cubic(z) > lane_of(0.0)) &
                                                  (nearest < high - low) &
                                                  (high - low > lane_of(b->core.rtol) * largest)) &
                           judged;
        }
    }
    return found;
}

/* Adds to `single` the lanes in which a law may switch in the last step, and notes whether an
 * argument came near to its edge, and for how many steps in a row one has varied too fast. */
void bgc_watch_switches(bgc_batch *b) {
    const unsigned timed = look_at_timed(b);
    const int before = b->core.unresolved;
    unsigned unresolved;

    if (timed == 0 && b->m->n_timed == b->m->n_switch) {
        return;
    }
    b->core.unresolved = b->core.near_edge = 0;
    evaluate_samples(b, 1);
    if (find_near(b, timed, 0, bgc_far_from_edge, &unresolved) == 0) {
        return;
    }
    b->core.near_edge = 1;
    evaluate_samples(b, 0);
    b->single |= find_near(b, timed, 1, 1.0, &unresolved);
    b->core.unresolved = unresolved != 0 ? before + 1 : 0;
}

/* Adds to `single` the lanes in which a function of states may have a pulse that the last step
 * hides. */
void bgc_watch_pulses(bgc_batch *b) {
    const bgc_model *m = b->m;

    for (int i = 0; i <= BGC_SAMPLES && m->n_watch > 0; i++) {
        const double part = i == 0 ? 0.0 : bgc_sample_at[i - 1];
        const double t = b->core.t_old + part * (b->core.t_end - b->core.t_old);
        if (i > 0) {
            bgc_interpolate(m, b, t, b->point);
        }
        b->kernel->watched(b->h, lane_of(t), i == 0 ? b->y0 : b->point, b->u,
                           b->hiding + (size_t)(i * m->n_watch), b->work);
    }
    for (int k = 0; k < m->n_watch; k++) {
        for (int l = 0; l < BGC_LANE_WIDTH; l++) {
            double z[BGC_SAMPLES + 1];
            for (int i = 0; i <= BGC_SAMPLES; i++) {
                z[i] = lane_get(b->hiding[i * m->n_watch + k], l);
            }
            b->single |= isfinite(bgc_hidden_peak(m->watch[k], z)) ? (1u << l) & b->active : 0u;
        }
    }
}

/* --- single steps -------------------------------------------------------------------------- */

/* The lanes that take the last step together. */
lane_mask bgc_together(const bgc_batch *b) {
    lane single = lane_of(0.0);

    for (int l = 0; b->single != 0 && l < BGC_LANE_WIDTH; l++) {
        lane_set(&single, l, is_among(b->single, l) ? 1.0 : 0.0);
    }
    return single == lane_of(0.0);
}

/* Copies the multiples of the tolerances between which nothing happens to a state to lane l. */
static void load_subtolerance(bgc_batch *b, int l, const bgc_data *d) {
    for (int i = 0; i < b->m->n_state; i++) {
        lane_set(b->subtol_from + i, l, d->subtol_from[i]);
        lane_set(b->subtol_to + i, l, d->subtol_to[i]);
    }
}

/* Follows state i in the lanes in which it has changed. Those that take the step by themselves
 * follow it there. */
void bgc_follow_where(bgc_batch *b, int i, lane_mask changed, lane limit, double t) {
    const unsigned lanes = bgc_lanes_where(b, changed) & ~b->single;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if (is_among(lanes, l)) {
            bgc_follow_subtolerance_state(b->instance[l], i, lane_get(b->next[i], l),
                                          lane_get(limit, l), t);
            load_subtolerance(b, l, b->instance[l]);
        }
    }
}

/* A method of one stage compares it with that of the step before, where a second stage would be:
 * gives it to a lane that takes the last step by itself, */
static void give_stage(const bgc_batch *b, int l, bgc_data *d) {
    const int n = b->m->n_state;

    for (int i = 0; b->method->tableau->stages == 1 && i < n; i++) {
        d->stages[bgc_padded(n) + (size_t)i] = lane_get(b->stages[n + i], l);
    }
}

/* and takes the stage of its own last step. */
static void take_stage(const bgc_batch *b, int l, const bgc_data *d) {
    const int n = b->m->n_state;

    for (int i = 0; b->method->tableau->stages == 1 && i < n; i++) {
        lane_set(b->stages + n + i, l, d->stages[i]);
    }
}

/* Steps that an instance takes by itself, within one of the batch, before it makes a choice of its
 * own. */
enum { STEPS_WITHOUT_CHOICE = 32 };

/* Gives an instance, which takes the last step by itself, the method of that step. */
static void give_method(const bgc_batch *b, bgc_data *d) {
    const bgc_choice *choice = &b->core.choice;

    d->core.choice = (bgc_choice){.partner = choice->partner,
                                  .is_explicit = b->method != &bgc_methods[b->core.method],
                                  .usual = choice->usual,
                                  .wait = STEPS_WITHOUT_CHOICE,
                                  .look = STEPS_WITHOUT_CHOICE};
    d->core.spectrum.radius = b->core.spectrum.radius;
}

/* Sets an instance to the start of the last step. */
static void put_back(const bgc_batch *b, int l, bgc_data *d) {
    bgc_core *core = &d->core;

    for (int i = 0; i < b->m->n_state; i++) {
        d->x[i] = lane_get(b->y0[i], l);
    }
    core->t = core->t_old = core->t_end = b->core.t_old;
    core->ticks = b->core.ticks;
    core->sample = b->core.sample;
    bgc_schedule(core);
    core->step_cut = core->halvings = core->held = core->rejected = 0;
    core->dense = BGC_NO_DENSE;
    bgc_check_within(d);
    bgc_begin_sample(core);
    give_stage(b, l, d);
    give_method(b, d);
    core->h_next = b->core.t_end - b->core.t_old;
    core->error_old = 1.0;
    core->counts.scale_reached = lane_get(b->scale_reached, l);
    core->counts.steps = b->core.counts.steps;
    if (b->core.accounts) {
        core->supplied = lane_get(b->account.supplied, l);
        core->dissipated = lane_get(b->account.dissipated, l);
        core->imbalance = lane_get(b->account.imbalance, l);
        core->largest_account = lane_get(b->account.largest_account, l);
        core->counts.exchanged = lane_get(b->account.exchanged, l);
        core->energy_scale =
            bgc_is_adaptive(b->method) ? lane_get(b->account.energy_scale, l) : core->energy_scale;
    }
}

/* Runs an instance from there to the present, with the rows between. */
static bgc_status run_alone(const bgc_batch *b, int l, bgc_data *d) {
    const double end = b->core.t_end, slack = bgc_time_slack(end, b->core.t_old);
    size_t count = 0, done;
    bgc_status status;

    while (b->row + count < b->n_rows && b->times[b->row + count] <= end + slack) {
        count++;
    }
    d->core.stop = end;
    status = bgc_run(b->m, d, b->times + b->row, count,
                     b->rows[l] + b->row * bgc_row_width(b), &done);
    if (status == BGC_OK && d->core.t < end - slack) {
        status = bgc_run(b->m, d, &end, 1, b->spare_row, &done);
    }
    d->core.stop = INFINITY;
    return status;
}

/* After a step of the batch, before it enters the accounts: single lanes take it by themselves. An
 * instance that fails leaves the batch. */
void bgc_step_alone(bgc_batch *b) {
    for (int l = 0; b->single != 0 && l < BGC_LANE_WIDTH; l++) {
        if (is_among(b->single & b->active, l)) {
            bgc_data *d = b->instance[l];
            bgc_status status;
            put_back(b, l, d);
            status = run_alone(b, l, d);
            b->interrupted |= status == BGC_INTERRUPTED;
            b->active &= ~(status == BGC_OK ? 0u : 1u << l);
        }
    }
}

/* Copies their results to the lanes, which go on with the batch. */
void bgc_rejoin(bgc_batch *b) {
    b->written = b->single & b->active;
    if (b->written != 0) { /* the end of the step for the dense output of the others */
        memcpy(b->end, b->x, (size_t)b->m->n_state * sizeof *b->x);
        b->y1 = b->end;
    }
    for (int l = 0; b->written != 0 && l < BGC_LANE_WIDTH; l++) {
        if (is_among(b->written, l)) {
            const bgc_data *d = b->instance[l];
            const bgc_core *core = &d->core;
            for (int i = 0; i < b->m->n_state; i++) {
                lane_set(b->x + i, l, d->x[i]);
            }
            load_inputs(b, l, d);
            take_stage(b, l, d);
            load_subtolerance(b, l, d);
            lane_set(&b->account.supplied, l, core->supplied);
            lane_set(&b->account.dissipated, l, core->dissipated);
            lane_set(&b->account.imbalance, l, core->imbalance);
            lane_set(&b->account.largest_account, l, core->largest_account);
            lane_set(&b->account.exchanged, l, core->counts.exchanged);
            b->core.held = b->core.f_valid = 0;
        }
    }
}
