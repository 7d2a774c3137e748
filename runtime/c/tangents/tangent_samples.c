/* tangent_samples.c: derivatives of what sampled parts hold, and of the states where inputs change.
 *
 * What devices give counts as constant. The values held from an instant on change with the states, time and
 * held values before it. An instant that the parameters move, by t' = offset' + i period', is an event whose
 * time has that derivative. */
#include "tangents/sensitivities.h"

#include <float.h>
#include <string.h>

/* Before devices or sampled parts change the inputs. */
void bgc_keep_before_inputs(const bgc_model *m, bgc_data *d, void *of) {
    bgc_sensitivities *s = of;

    s->jumps = 0;
    memcpy(s->before_inputs, d->x, (size_t)m->n_state * sizeof *d->x);
    memcpy(s->inputs_before, d->u, (size_t)(m->n_input + m->n_switch) * sizeof *d->u);
    memcpy(s->instants_before, d->instants, (size_t)m->n_rate * sizeof *d->instants);
}

static int is_taken(const bgc_data *d, const bgc_sensitivities *s, int rate) {
    return d->instants[rate] != s->instants_before[rate];
}

/* The derivatives of the time of the instant. BGC_SIMULTANEOUS where they differ between rates. */
static bgc_status differentiate_instant(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                        const bgc_sensitivity_block *b, lane *delay) {
    int found = 0;

    *delay = lane_of(0.0);
    if (m->n_rate > 0) {
        s->kernel->sampling(s->h, b->q, s->result, s->work);
    }
    for (int r = 0; r < m->n_rate; r++) {
        const lane own = s->result[2 * r + 1] + s->instants_before[r] * s->result[2 * r];
        if (!is_taken(d, s, r)) {
            continue;
        }
        if (found && lane_bits(own != *delay) != 0) {
            d->core.failed_switch = -1;
            return BGC_SIMULTANEOUS;
        }
        *delay = own;
        found = 1;
    }
    return BGC_OK;
}

/* The derivatives of the new values, along v (with time in its last element) before the instant. */
static void differentiate_held(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s,
                               bgc_sensitivity_block *b, const bgc_moment *ahead, const lane *v) {
    const double behind = ahead->t + 4.0 * DBL_EPSILON * fabs(ahead->t);
    lane *held = b->q + m->n_hoist;

    if (m->n_held == 0) {
        return;
    }
    bgc_spread(m->n_state, ahead->x, s->x);
    bgc_spread(m->n_input + m->n_switch, ahead->u, s->u);
    s->kernel->held(s->h, lane_of(behind), s->x, s->u, v, b->q, s->result, s->work);
    for (int k = 0; k < m->n_held; k++) {
        if (is_taken(d, s, m->held_rate[k])) {
            held[k] = s->result[k];
        }
    }
}

/* After other inputs and what has followed from them. */
bgc_status bgc_differentiate_inputs(const bgc_model *m, bgc_data *d, void *of) {
    bgc_sensitivities *s = of;
    const int n = m->n_state;
    const bgc_moment ahead = {d->core.t, s->before_inputs, s->inputs_before};
    const bgc_moment behind = {d->core.t, d->x, d->u};
    bgc_status status = BGC_OK;

    bgc_follow_chosen_rows(m, d, s);
    memset(s->rate, 0, 2 * (size_t)n * sizeof *s->rate);
    for (int k = 0; k < s->blocks && status == BGC_OK; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        lane delay, *v = s->along;
        status = differentiate_instant(m, d, s, b, &delay);
        if (status == BGC_OK && lane_bits(delay != lane_of(0.0)) != 0) {
            status = bgc_find_rate(m, d, s, &ahead, s->rate);
            status = status == BGC_OK ? bgc_find_rate(m, d, s, &behind, s->rate_after) : status;
        }
        for (int i = 0; i < n; i++) {
            v[i] = b->now[i] + s->rate[i] * delay;
        }
        v[n] = delay;
        if (status == BGC_OK) {
            differentiate_held(m, d, s, b, &ahead, v);
            status = bgc_carry_sensitivity(m, d, s, b, ahead.x, &behind, v);
        }
    }
    return status;
}

/* The values that they would hold after an instant at the present, with the states held, along direction k. */
void bgc_held_slopes(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, int k, double *slope) {
    const bgc_sensitivity_block *b = &s->block[k / BGC_LANE_WIDTH];

    if (m->n_held == 0) {
        return;
    }
    bgc_spread(m->n_state, d->x, s->x);
    bgc_spread(m->n_input + m->n_switch, d->u, s->u);
    s->kernel->held(s->h, lane_of(d->core.t), s->x, s->u, s->no_change, b->q, s->result, s->work);
    for (int i = 0; i < m->n_held; i++) {
        slope[i] = lane_get(s->result[i], k % BGC_LANE_WIDTH);
    }
}
