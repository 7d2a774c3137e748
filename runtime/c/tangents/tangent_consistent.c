/* tangent_consistent.c: derivatives of states that are projected, and of those that algebraic equations
 * determine.
 *
 * At (t, x) the block of consistent.c satisfies f_a(t, x) = 0 and M (x - from) = 0 beside the states that are
 * held. By the implicit function its derivatives change by the solution of
 *
 *   -f_x dx' = f' in algebraic rows,   M dx' = -M' (x - from) in the others,
 *
 * where f' is the derivative of f along the derivatives at hand. */
#include "tangents/sensitivities.h"

#include <string.h>

/* Projects derivatives of the states, which are x, where states are projected. */
void bgc_project_sensitivity(const bgc_model *m, bgc_sensitivities *s, const bgc_sensitivity_block *b,
                             double t, const double *x, lane *v) {
    const size_t size = (size_t)m->n_state * sizeof *v;

    if (m->project != NULL) {
        bgc_spread(m->n_state, x, s->x);
        memcpy(s->change, v, size);
        s->change[m->n_state] = lane_of(0.0);
        s->kernel->project(s->h, lane_of(t), s->x, s->change, b->q, v, s->work);
    }
}

/* The factors of the block's matrix there. */
static bgc_status refresh_block_at(const bgc_model *m, bgc_data *d, const bgc_moment *at) {
    double *present = d->u;
    bgc_status status;

    d->u = at->u;
    status = bgc_refresh_block(m, d, at->t, at->x);
    d->u = present;
    return status;
}

/* The residuals of lane l, in the order of the block. */
static void gather_block(const bgc_model *m, const bgc_data *d, const bgc_sensitivities *s,
                         const bgc_sensitivity_block *b, const double *x, const double *from, int l,
                         double *column) {
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        column[k] = d->algebraic[i] != 0.0 ? lane_get(s->right[i], l) : 0.0;
    }
    for (int k = 0; k < m->n_mass && from != NULL; k++) {
        const int i = d->place[m->mass_row[k]], j = m->mass_col[k];
        if (i >= 0) {
            column[i] -= lane_get(b->mass[k], l) * (x[j] - from[j]);
        }
    }
}

bgc_status bgc_satisfy_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                   bgc_sensitivity_block *b, const bgc_moment *at, const double *from,
                                   lane delay, lane *v) {
    bgc_status status = BGC_OK;

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    status = refresh_block_at(m, d, at);
    if (status != BGC_OK) {
        return status;
    }
    bgc_slope_sensitivity(m, s, b, at, v, delay);
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        gather_block(m, d, s, b, at->x, from, l, s->column);
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, s->column);
        for (int k = 0; k < d->n_block; k++) {
            lane *own = &v[d->block[k]];
            lane_set(own, l, lane_get(*own, l) + s->column[k]);
        }
    }
    return BGC_OK;
}
