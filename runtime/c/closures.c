/* closures.c: closed chains of rigid connections, kept closed by projection.
 *
 * The rows that close a chain, w(x) = G u = 0, hold by multipliers that f contains already: they
 * follow from w' = 0. Integration keeps w, and the conditions g(x) = 0 on the positions, only within
 * its tolerance, so that each completed step is projected:
 *
 *   positions   x += (dg/dx)' l, (dg/dx)(dg/dx)' l = -g, repeated: the least change of the states
 *   momenta     x += D l, S l = w, S = -(dw/dx) D: the least kinetic energy of the change
 *
 * where D is the action of the multipliers on the momenta. E. Hairer, C. Lubich, G. Wanner, Geometric
 * Numerical Integration, IV.4; E. Eich, SIAM J. Numer. Anal. 30 (1993) 1467.
 *
 * chain_kernel.c holds the results of their kernel, closed_start.c closes the start, chosen_rows.c chooses
 * among rows that follow from each other, and singular_chains.c watches for singular positions.
 */
#include "closures.h"

#include <math.h>
#include <string.h>

enum { MAX_PROJECTIONS = 12 };
static const double projected = 1e-12;       /* last change, relative to scale plus state */
static const double least_gap = 1e-13;       /* of a condition in a run: m, rad */
static const double regularisation = 1e-13;         /* of the normal equations, to their trace */

/* --- positions -------------------------------------------------------------------------------- */

int bgc_least_chain_change(bgc_data *d, int n, const double *slopes, int width, double damping,
                           bgc_chain_parts *p) {
    const int *list = d->closing_list;
    double *multiplier = p->change + width;
    double trace = 0.0;

    /* The normal equations. */
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int k = 0; k < width; k++) {
                sum += slopes[list[i] * width + k] * slopes[list[j] * width + k];
            }
            p->matrix[i * n + j] = sum;
        }
        trace += p->matrix[i * n + i];
        multiplier[i] = -p->condition[list[i]];
    }
    for (int i = 0; i < n; i++) {
        p->matrix[i * n + i] += damping * trace;
    }
    if (trace == 0.0 || bgc_factorise_dense(n, p->matrix, d->closing_pivot, p->other) >= 0) {
        return 0;
    }
    bgc_solve_dense(n, p->matrix, d->closing_pivot, multiplier);

    /* Their combination of the slopes. */
    for (int k = 0; k < width; k++) {
        double sum = 0.0;
        for (int i = 0; i < n; i++) {
            sum += slopes[list[i] * width + k] * multiplier[i];
        }
        p->change[k] = sum;
    }
    return bgc_first_bad(width, p->change) < 0;
}

double bgc_chain_gap(const bgc_chain_parts *p, int n, const int *list, int *worst) {
    double gap = 0.0;

    for (int i = 0; i < n; i++) {
        const int k = list == NULL ? i : list[i];
        if (!(fabs(p->condition[k]) <= gap)) {
            gap = fabs(p->condition[k]);
            *worst = k;
        }
    }
    return gap;
}

/* Moves the positions in x until the conditions hold; the results of the kernel are those there. */
static bgc_status close_positions(const bgc_model *m, bgc_data *d, double t, double *x, bgc_chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;
    const int n = bgc_list_conditions(m, d);

    for (int i = 0; i < MAX_PROJECTIONS; i++) {
        double size = 0.0;
        int worst;
        if (!bgc_evaluate_chains(m, d, t, x, p)) {
            return BGC_NOT_FINITE;
        }
        if (bgc_chain_gap(p, n, d->closing_list, &worst) <= least_gap) {
            return BGC_OK;
        }
        if (!bgc_least_chain_change(d, n, p->by_place, c->n_moved, regularisation, p)) {
            return BGC_SINGULAR_CHAIN;
        }
        for (int k = 0; k < c->n_moved; k++) {
            const int state = c->moved[k];
            size = fmax(size, fabs(p->change[k]) / (d->scale[state] + fabs(x[state])));
            x[state] += p->change[k];
        }
        if (size <= projected) {
            return BGC_OK;
        }
    }
    return BGC_NOT_CONVERGED;
}

/* --- flows -------------------------------------------------------------------------------------- */

/* Moves the momenta in x until the closing rows hold. */
static bgc_status close_flows(const bgc_model *m, bgc_data *d, double *x, bgc_chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;
    const int *row = d->closing_list;
    const int n = bgc_list_chosen(d->chosen, 0, c->n_row, d->closing_list);
    int bad;

    if (n == 0) {
        return BGC_OK;
    }
    bgc_chain_response(c, p->by_impulse, p->response, n, row, p->matrix);
    for (int i = 0; i < n; i++) {
        p->change[i] = p->flow[row[i]];
    }
    bad = bgc_factorise_dense(n, p->matrix, d->closing_pivot, p->other);
    if (bad >= 0) {
        d->core.failed_chain = c->chain_of[row[bad]];
        return BGC_SINGULAR_CHAIN;
    }
    bgc_solve_dense(n, p->matrix, d->closing_pivot, p->change);
    if (bgc_first_bad(n, p->change) >= 0) {
        return BGC_NOT_FINITE;
    }
    for (int k = 0; k < c->n_impulse; k++) {
        for (int j = 0; j < n; j++) {
            x[c->impulse[k]] += p->response[k * c->n_row + row[j]] * p->change[j];
        }
    }
    return BGC_OK;
}

/* Projects x at time t onto the closed chains. */
bgc_status bgc_close_chains(const bgc_model *m, bgc_data *d, double t, double *x) {
    bgc_status status;
    bgc_chain_parts p;

    if (m->closure_info == NULL) {
        return BGC_OK;
    }
    status = close_positions(m, d, t, x, &p);
    return status == BGC_OK ? close_flows(m, d, x, &p) : status;
}

/* --- for a start at rest ------------------------------------------------------------------------ */

int bgc_chain_rows(const bgc_model *m) {
    const bgc_closure_info *c = m->closure_info;
    int count = c == NULL ? 0 : c->condition_rank;

    for (int k = 0; c != NULL && k < c->n_row; k++) {
        count += bgc_is_first_choice(c, k);
    }
    return count;
}

bgc_status bgc_evaluate_chain_rows(const bgc_model *m, bgc_data *d, double *value, double *slope) {
    const bgc_closure_info *c = m->closure_info;
    const int n = m->n_state;
    int count;
    bgc_chain_parts p;

    if (bgc_chain_rows(m) == 0) {
        return BGC_OK;
    }
    if (!bgc_evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    memset(slope, 0, (size_t)bgc_chain_rows(m) * (size_t)n * sizeof *slope);

    /* Flows by momenta, then conditions by positions. */
    count = bgc_list_chosen(d->chosen, 0, c->n_row, d->closing_list);
    for (int i = 0; i < count; i++) {
        const int row = d->closing_list[i];
        value[i] = p.flow[row];
        for (int k = 0; k < c->n_impulse; k++) {
            slope[i * n + c->impulse[k]] = p.by_impulse[row * c->n_impulse + k];
        }
    }
    value += count, slope += count * n;
    count = bgc_list_conditions(m, d);
    for (int i = 0; i < count; i++) {
        const int row = d->closing_list[i];
        value[i] = p.condition[row];
        for (int k = 0; k < c->n_moved; k++) {
            slope[i * n + c->moved[k]] = p.by_place[row * c->n_moved + k];
        }
    }
    return BGC_OK;
}
