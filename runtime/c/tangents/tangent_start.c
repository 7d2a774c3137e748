/* tangent_start.c: derivatives of the states at the start of a run. */
#include "tangents/sensitivities.h"

#include <math.h>
#include <string.h>

/* The changes of the unknowns of the start, by the implicit function: J ds = -dr. */
static bgc_status differentiate_start(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                      bgc_sensitivity_block *b) {
    const int n = m->n_start;
    lane *change = s->change + m->n_state + 1, *at = s->result;

    m->start(d->h, d->core.t, d->u, d->start_at, d->start_change, d->start_jac, d->work);
    memcpy(d->start_lu, d->start_jac, (size_t)n * (size_t)n * sizeof *d->start_lu);
    if (bgc_factorise_dense(n, d->start_lu, d->start_pivot, d->start_magnitude) >= 0) {
        return BGC_SINGULAR;
    }
    memset(s->change, 0, (size_t)(m->n_state + 1 + n) * sizeof *s->change);
    bgc_spread(n, d->start_at, at);
    s->kernel->start(s->h, lane_of(d->core.t), s->u, at, s->change, b->q, s->right, s->work);
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        for (int i = 0; i < n; i++) {
            d->start_change[i] = -lane_get(s->right[i], l);
        }
        bgc_solve_dense(n, d->start_lu, d->start_pivot, d->start_change);
        for (int i = 0; i < n; i++) {
            lane_set(&change[i], l, d->start_change[i]);
        }
    }
    s->kernel->started(s->h, lane_of(d->core.t), s->u, at, s->change, b->q, b->now, s->work);
    return BGC_OK;
}

bgc_status bgc_start_sensitivities(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                   const double *parameter, const double *state) {
    const size_t n = (size_t)m->n_state;
    const bgc_moment now = {d->core.t, d->x, d->u};
    bgc_status status = BGC_OK;

    memcpy(s->parameter, parameter, (size_t)s->count * (size_t)m->n_param * sizeof *parameter);
    bgc_prepare_sensitivities(m, d, s);
    bgc_spread(m->n_input + m->n_switch, d->u, s->u);
    s->jacobians = -1;
    s->event_at = -INFINITY;
    for (int k = 0; k < s->blocks && status == BGC_OK; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        if (m->n_held > 0) {
            s->kernel->held_start(s->h, lane_of(d->core.t), s->u, b->q, b->q + m->n_hoist, s->work);
        }
        if (m->n_mass > 0) {
            s->kernel->mass(s->h, b->q, b->mass, s->work);
        }
        if (m->n_start > 0) {
            status = differentiate_start(m, d, s, b);
        } else {
            s->kernel->initial(s->h, lane_of(d->core.t), s->u, b->q, b->now, s->work);
        }
        for (int l = 0; l < BGC_LANE_WIDTH && k * BGC_LANE_WIDTH + l < s->count; l++) {
            const double *own = state + (size_t)(k * BGC_LANE_WIDTH + l) * n;
            for (size_t i = 0; i < n; i++) {
                lane_set(&b->now[i], l, lane_get(b->now[i], l) + own[i]);
            }
        }
        m->initial(d->h, d->core.t, d->u, s->rate, d->work);
        if (m->n_start > 0) {
            m->started(d->h, d->core.t, d->u, d->start_at, s->rate, d->work);
        }
        bgc_project_sensitivity(m, s, b, now.t, d->x, b->now);
        if (status == BGC_OK) {
            status = bgc_close_sensitivity(m, d, s, b, &now, s->rate, lane_of(0.0), b->now);
        }
        if (status == BGC_OK) {
            status = bgc_satisfy_sensitivity(m, d, s, b, &now, s->rate, lane_of(0.0), b->now);
        }
        b->has_dense = 0;
    }
    return status;
}
