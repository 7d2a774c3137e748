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
 * closed_start.c closes the start, singular_chains.c watches for singular positions.
 */
#include "closures.h"

#include <math.h>
#include <string.h>

enum { MAX_PROJECTIONS = 12 };
static const double projected = 1e-12;       /* last change, relative to scale plus state */
static const double least_gap = 1e-13;       /* of a condition in a run: m, rad */
static const double regularisation = 1e-13;         /* of the normal equations, to their trace */

/* --- the results of the kernel -------------------------------------------------------------- */

static size_t larger_of(size_t a, size_t b) { return a > b ? a : b; }

size_t bgc_place_chain_parts(const bgc_closure_info *c, double *from, bgc_chain_parts *p) {
    const size_t rows = (size_t)c->n_row, conditions = (size_t)c->n_condition;
    const size_t size = larger_of(rows, conditions);
    double *at = from;

    p->flow = at, at += c->n_all_rows;
    p->condition = at, at += c->n_all_conditions;
    p->by_impulse = at, at += rows * (size_t)c->n_impulse;
    p->response = at, at += rows * (size_t)c->n_impulse;
    p->by_place = at, at += conditions * (size_t)c->n_moved;
    p->by_start = at, at += (size_t)c->n_moved * (size_t)c->n_start;
    p->matrix = at, at += size * size;
    p->other = at, at += size * size;
    p->mixed = at, at += size * size;
    p->table = at, at += conditions * (size_t)c->n_start;
    p->change = at, at += larger_of(larger_of(size, (size_t)c->n_moved), (size_t)c->n_start) + size;
    return (size_t)(at - from);
}

/* Number of doubles of d->closing. */
size_t bgc_closing_size(const bgc_model *m) {
    static double none[1];
    bgc_chain_parts p;

    return m->closure_info == NULL ? 0 : bgc_place_chain_parts(m->closure_info, none, &p);
}

int bgc_evaluate_chains(const bgc_model *m, bgc_data *d, double t, const double *x, bgc_chain_parts *p) {
    bgc_place_chain_parts(m->closure_info, d->closing, p);
    m->closures(d->h, t, x, d->u, d->closing, d->work);
    return bgc_first_bad((int)(p->matrix - d->closing), d->closing) < 0;
}

void bgc_chain_response(const bgc_closure_info *c, const double *left, const double *right,
                        int first, int last, double *s) {
    const int size = last - first;

    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++) {
            double sum = 0.0;
            for (int k = 0; k < c->n_impulse; k++) {
                sum -= left[(first + i) * c->n_impulse + k] * right[k * c->n_row + first + j];
            }
            s[i * size + j] = sum;
        }
    }
}

/* --- positions -------------------------------------------------------------------------------- */

int bgc_least_chain_change(const bgc_model *m, bgc_data *d, const double *slopes, int width,
                        double damping, bgc_chain_parts *p) {
    const int n = m->closure_info->n_condition;
    double *multiplier = p->change + width;
    double trace = 0.0;

    /* The normal equations. */
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int k = 0; k < width; k++) {
                sum += slopes[i * width + k] * slopes[j * width + k];
            }
            p->matrix[i * n + j] = sum;
        }
        trace += p->matrix[i * n + i];
        multiplier[i] = -p->condition[i];
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
            sum += slopes[i * width + k] * multiplier[i];
        }
        p->change[k] = sum;
    }
    return bgc_first_bad(width, p->change) < 0;
}

double bgc_chain_gap(const bgc_chain_parts *p, int n, int *worst) {
    double gap = 0.0;

    for (int i = 0; i < n; i++) {
        if (!(fabs(p->condition[i]) <= gap)) {
            gap = fabs(p->condition[i]);
            *worst = i;
        }
    }
    return gap;
}

/* Moves the positions in x until the conditions hold; the results of the kernel are those there. */
static bgc_status close_positions(const bgc_model *m, bgc_data *d, double t, double *x, bgc_chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;

    for (int i = 0; i < MAX_PROJECTIONS; i++) {
        double size = 0.0;
        int worst;
        if (!bgc_evaluate_chains(m, d, t, x, p)) {
            return BGC_NOT_FINITE;
        }
        if (bgc_chain_gap(p, c->n_condition, &worst) <= least_gap) {
            return BGC_OK;
        }
        if (!bgc_least_chain_change(m, d, p->by_place, c->n_moved, regularisation, p)) {
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
    const int n = c->n_row;
    int bad;

    if (n == 0) {
        return BGC_OK;
    }
    bgc_chain_response(c, p->by_impulse, p->response, 0, n, p->matrix);
    memcpy(p->change, p->flow, (size_t)n * sizeof *p->change);
    bad = bgc_factorise_dense(n, p->matrix, d->closing_pivot, p->other);
    if (bad >= 0) {
        d->core.failed_chain = c->chain_of[bad];
        return BGC_SINGULAR_CHAIN;
    }
    bgc_solve_dense(n, p->matrix, d->closing_pivot, p->change);
    if (bgc_first_bad(n, p->change) >= 0) {
        return BGC_NOT_FINITE;
    }
    for (int k = 0; k < c->n_impulse; k++) {
        for (int j = 0; j < n; j++) {
            x[c->impulse[k]] += p->response[k * n + j] * p->change[j];
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

    return c == NULL ? 0 : c->n_row + c->n_condition;
}

bgc_status bgc_evaluate_chain_rows(const bgc_model *m, bgc_data *d, double *value, double *slope) {
    const bgc_closure_info *c = m->closure_info;
    const int n = m->n_state;
    bgc_chain_parts p;

    if (bgc_chain_rows(m) == 0) {
        return BGC_OK;
    }
    if (!bgc_evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    memcpy(value, p.flow, (size_t)c->n_row * sizeof *value);
    memcpy(value + c->n_row, p.condition, (size_t)c->n_condition * sizeof *value);
    memset(slope, 0, (size_t)(c->n_row + c->n_condition) * (size_t)n * sizeof *slope);

    /* Flows by momenta, then conditions by positions. */
    for (int i = 0; i < c->n_row; i++) {
        for (int k = 0; k < c->n_impulse; k++) {
            slope[i * n + c->impulse[k]] = p.by_impulse[i * c->n_impulse + k];
        }
    }
    for (int i = 0; i < c->n_condition; i++) {
        for (int k = 0; k < c->n_moved; k++) {
            slope[(c->n_row + i) * n + c->moved[k]] = p.by_place[i * c->n_moved + k];
        }
    }
    return BGC_OK;
}
