/* tangent_chains.c: derivatives of the projection onto closed chains of closures.c.
 *
 * Positions move by A' l, A = dg/dx, until g = 0: their derivatives change by A' l', A A' l' = -g', which leaves
 * out the change of A times the distance that they move. Momenta move by D l, S l = w, S = -G D, G = dw/dx:
 *
 *   x'  +=  D l' + D' l,   S l' = w' + G' (D l) + G (D' l),
 *
 * with w', G' and D' along the derivatives before. */
#include "closures.h"
#include "tangents/sensitivities.h"

#include <string.h>

static const double regularisation = 1e-13; /* of the normal equations, as in closures.c */

size_t bgc_closing_tangents(const bgc_model *m) {
    const bgc_closure_info *c = m->closure_info;

    return c == NULL ? 0
                     : (size_t)(c->n_all_rows + c->n_all_conditions) +
                           2 * (size_t)c->n_row * (size_t)c->n_impulse;
}

int bgc_closing_parameter(const bgc_model *m, int k) {
    const bgc_closure_info *c = m->closure_info;

    return c != NULL && k >= 0 && k < c->n_start ? c->start[k] : -1;
}

/* Derivatives along v of the flows, the conditions, G and D at x, in this order, to s->closing. */
static void differentiate_rows(const bgc_model *m, bgc_sensitivities *s, const bgc_sensitivity_block *b,
                               const bgc_moment *at, const double *x, const lane *v, lane delay) {
    bgc_spread(m->n_state, x, s->x);
    bgc_spread(m->n_input + m->n_switch, at->u, s->u);
    memcpy(s->change, v, (size_t)m->n_state * sizeof *v);
    s->change[m->n_state] = delay;
    s->kernel->closures(s->h, lane_of(at->t), s->x, s->u, s->change, b->q, s->closing, s->work);
}

/* The positions' part of the projection, with the derivatives of the conditions in s->closing. */
static bgc_status close_positions(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, bgc_chain_parts *p,
                                  lane *v) {
    const bgc_closure_info *c = m->closure_info;
    const int n = bgc_list_conditions(m, d);

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        for (int i = 0; i < c->n_condition; i++) {
            p->condition[i] = lane_get(s->closing[c->n_all_rows + i], l);
        }
        if (!bgc_least_chain_change(d, n, p->by_place, c->n_moved, regularisation, p)) {
            return BGC_SINGULAR_CHAIN;
        }
        for (int k = 0; k < c->n_moved; k++) {
            lane *own = &v[c->moved[k]];
            lane_set(own, l, lane_get(*own, l) + p->change[k]);
        }
    }
    return BGC_OK;
}

/* l and D l, with the factors of S of the n rows listed: D l to s->column, behind l. */
static bgc_status find_impulses(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, bgc_chain_parts *p,
                                int n) {
    const bgc_closure_info *c = m->closure_info;
    const int *row = d->closing_list;
    double *multiplier = s->multiplier, *impulse = s->multiplier + c->n_row;

    bgc_chain_response(c, p->by_impulse, p->response, n, row, p->matrix);
    for (int i = 0; i < n; i++) {
        multiplier[i] = p->flow[row[i]];
    }
    if (bgc_factorise_dense(n, p->matrix, d->closing_pivot, p->other) >= 0) {
        return BGC_SINGULAR_CHAIN;
    }
    bgc_solve_dense(n, p->matrix, d->closing_pivot, multiplier);
    for (int k = 0; k < c->n_impulse; k++) {
        impulse[k] = 0.0;
        for (int j = 0; j < n; j++) {
            impulse[k] += p->response[k * c->n_row + row[j]] * multiplier[j];
        }
    }
    return BGC_OK;
}

/* The momenta's part of the projection, with the derivatives of all in s->closing. */
static bgc_status close_flows(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, bgc_chain_parts *p,
                              lane *v) {
    const bgc_closure_info *c = m->closure_info;
    const int *row = d->closing_list;
    const int n = bgc_list_chosen(d->chosen, 0, c->n_row, d->closing_list);
    const lane *by_impulse = s->closing + c->n_all_rows + c->n_all_conditions;
    const lane *response = by_impulse + c->n_row * c->n_impulse;
    const double *multiplier = s->multiplier, *impulse = s->multiplier + c->n_row;
    bgc_status status = n > 0 ? find_impulses(m, d, s, p, n) : BGC_OK;

    if (n == 0 || status != BGC_OK) {
        return status;
    }

    /* D' l, and the right-hand side of S l'. */
    for (int k = 0; k < c->n_impulse; k++) {
        s->result[k] = lane_of(0.0);
        for (int j = 0; j < n; j++) {
            s->result[k] += multiplier[j] * response[k * c->n_row + row[j]];
        }
    }
    for (int i = 0; i < n; i++) {
        s->right[i] = s->closing[row[i]];
        for (int k = 0; k < c->n_impulse; k++) {
            const int entry = row[i] * c->n_impulse + k;
            s->right[i] += impulse[k] * by_impulse[entry] + p->by_impulse[entry] * s->result[k];
        }
    }
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        for (int i = 0; i < n; i++) {
            p->change[i] = lane_get(s->right[i], l);
        }
        bgc_solve_dense(n, p->matrix, d->closing_pivot, p->change);
        for (int i = 0; i < n; i++) {
            lane_set(&s->right[i], l, p->change[i]);
        }
    }
    for (int k = 0; k < c->n_impulse; k++) {
        lane sum = s->result[k];
        for (int j = 0; j < n; j++) {
            sum += p->response[k * c->n_row + row[j]] * s->right[j];
        }
        v[c->impulse[k]] += sum;
    }
    return BGC_OK;
}

bgc_status bgc_close_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 const bgc_sensitivity_block *b, const bgc_moment *at, const double *from,
                                 lane delay, lane *v) {
    const bgc_closure_info *c = m->closure_info;
    double *present = d->u, *x = s->before_flows;
    int finite;
    bgc_status status = BGC_OK;
    bgc_chain_parts p;

    if (c == NULL) {
        return BGC_OK;
    }

    /* The kernel at the projected positions and the momenta before. */
    memcpy(x, from, (size_t)m->n_state * sizeof *x);
    for (int k = 0; k < c->n_moved; k++) {
        x[c->moved[k]] = at->x[c->moved[k]];
    }
    d->u = at->u;
    finite = bgc_evaluate_chains(m, d, at->t, x, &p);
    d->u = present;
    if (!finite) {
        return BGC_NOT_FINITE;
    }
    if (c->n_condition > 0) {
        differentiate_rows(m, s, b, at, x, v, delay);
        status = close_positions(m, d, s, &p, v);
    }
    if (status != BGC_OK) {
        return status;
    }
    differentiate_rows(m, s, b, at, x, v, delay);
    return close_flows(m, d, s, &p, v);
}

void bgc_chain_slopes(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, int k, double *slope) {
    const bgc_closure_info *c = m->closure_info;
    const bgc_moment now = {d->core.t, d->x, d->u};
    int n, conditions;

    if (bgc_chain_rows(m) == 0) {
        return;
    }
    differentiate_rows(m, s, &s->block[k / BGC_LANE_WIDTH], &now, d->x, s->no_change, lane_of(0.0));
    n = bgc_list_chosen(d->chosen, 0, c->n_row, d->closing_list);
    for (int i = 0; i < n; i++) {
        slope[i] = lane_get(s->closing[d->closing_list[i]], k % BGC_LANE_WIDTH);
    }
    conditions = bgc_list_conditions(m, d);
    for (int i = 0; i < conditions; i++) {
        slope[n + i] = lane_get(s->closing[c->n_all_rows + d->closing_list[i]], k % BGC_LANE_WIDTH);
    }
}
