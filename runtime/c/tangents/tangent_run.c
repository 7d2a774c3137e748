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
