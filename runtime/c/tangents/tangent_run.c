/* tangent_run.c: a run with the derivatives of its rows. */
#include "tangents/sensitivities.h"

#include <string.h>

/* The derivatives of the outputs in the row at t. */
static bgc_status write_row(const bgc_model *m, bgc_data *d, void *of, double t, int inside) {
    bgc_sensitivities *s = of;
    const double *x = d->x, *u = inside ? d->u_step : d->u;
    bgc_status status = BGC_OK;

    if (inside) {
        bgc_interpolate(m, d, t, d->point);
        x = d->point;
    }
    t = inside ? t : d->core.t;
    bgc_follow_chosen_rows(m, d, s);
    for (int k = 0; k < s->blocks && status == BGC_OK; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        lane *v = s->along;
        if (inside) {
            status = bgc_interpolate_sensitivity(m, d, s, b, t, x, v);
        } else {
            memcpy(v, b->now, (size_t)m->n_state * sizeof *v);
        }
        v[m->n_state] = lane_of(0.0);
        bgc_spread(m->n_state, x, s->x);
        bgc_spread(m->n_input + m->n_switch, u, s->u);
        s->kernel->outputs(s->h, lane_of(t), s->x, s->u, v, b->q, s->result, s->work);
        for (int l = 0; l < BGC_LANE_WIDTH && k * BGC_LANE_WIDTH + l < s->count; l++) {
            for (int i = 0; i < m->n_output; i++) {
                *s->slopes++ = lane_get(s->result[i], l);
            }
        }
    }
    return status;
}

bgc_status bgc_run_sensitivities(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 const double *times, size_t n, double *rows, double *slopes,
                                 size_t *done) {
    const bgc_follower follower = {
        .of = s,
        .step = bgc_differentiate_step,
        .event = bgc_differentiate_event,
        .jump = bgc_note_jump,
        .before_inputs = bgc_keep_before_inputs,
        .inputs = bgc_differentiate_inputs,
        .row = write_row,
    };
    bgc_status status;

    s->slopes = slopes;
    d->follower = &follower;
    status = bgc_run(m, d, times, n, rows, done);
    d->follower = NULL;
    return status;
}

/* --- derivatives at the present ------------------------------------------------------------------ */

void bgc_get_sensitivity(const bgc_model *m, const bgc_sensitivities *s, int k, double *x) {
    const bgc_sensitivity_block *b = &s->block[k / BGC_LANE_WIDTH];

    for (int i = 0; i < m->n_state; i++) {
        x[i] = lane_get(b->now[i], k % BGC_LANE_WIDTH);
    }
    for (int i = 0; i < m->n_held; i++) {
        x[m->n_state + i] = lane_get(b->q[m->n_hoist + i], k % BGC_LANE_WIDTH);
    }
}

void bgc_set_sensitivity(const bgc_model *m, bgc_sensitivities *s, int k, const double *x) {
    const bgc_sensitivity_block *b = &s->block[k / BGC_LANE_WIDTH];

    for (int i = 0; i < m->n_state; i++) {
        lane_set(&b->now[i], k % BGC_LANE_WIDTH, x[i]);
    }
    for (int i = 0; i < m->n_held; i++) {
        lane_set(&b->q[m->n_hoist + i], k % BGC_LANE_WIDTH, x[m->n_state + i]);
    }
}

void bgc_slope_by_parameters(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, int k, double *f) {
    const bgc_sensitivity_block *b = &s->block[k / BGC_LANE_WIDTH];
    const bgc_moment now = {d->core.t, d->x, d->u};

    bgc_slope_sensitivity(m, s, b, &now, s->no_change, lane_of(0.0));
    for (int i = 0; i < m->n_state; i++) {
        f[i] = lane_get(s->right[i], k % BGC_LANE_WIDTH);
    }
    bgc_chain_slopes(m, d, s, k, f + m->n_state);
    bgc_held_slopes(m, d, s, k, f + m->n_state + bgc_chain_rows(m));
}
