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
 * Where a chain passes a singular position, its rows lose rank there, turn round, or turn aside. A step
 * that leaves less than a part of any of their combinations is therefore shortened. Near a singular
 * position this goes on until a pivot of S, relative to the largest diagonal so far, is rounding; there
 * the run ends.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

enum { MAX_PROJECTIONS = 12, MAX_CLOSING = 100 };
static const double projected = 1e-12;       /* last change, relative to scale plus state */
static const double least_gap = 1e-13;       /* of a condition in a run: m, rad */
static const double closed_gap = 1e-9;           /* of a condition: m, rad */
static const double redundant_gap = 1e-6;        /* the same for conditions that follow from others */
static const double first_damping = 1e-2;    /* of the normal equations at the start, to their trace */
static const double least_of_damping = 1e-4; /* after a step that did not help */
static const double rounding_of_start = 1e-3;          /* m, rad: given values may be moved by this */
static const double regularisation = 1e-13;         /* of the normal equations, to their trace */
static const double singular_pivot = 1e-10;  /* of S, relative: at a singular position */
static const double near_singular = 1e-4;    /* a failure at less is due to the position */
static const double least_row_part = 0.4;     /* of a row that a step may leave of it */
static const double left_part = 0.1;          /* of the change in a step that projection may move */
static const double negligible_move = 1e-6;   /* by projection, relative to scale */

/* --- the results of the kernel -------------------------------------------------------------- */

/* Parts of d->closing: results of the kernel, then scratch. */
typedef struct {
    double *flow, *condition, *by_impulse, *response, *by_place, *by_start;
    double *matrix, *other, *mixed, *table, *change;
} chain_parts;

static size_t larger_of(size_t a, size_t b) { return a > b ? a : b; }

static size_t place_chain_parts(const bgc_closure_info *c, double *from, chain_parts *p) {
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
    chain_parts p;

    return m->closure_info == NULL ? 0 : place_chain_parts(m->closure_info, none, &p);
}

/* Evaluates the kernel at (t, x); returns whether its results are finite. */
static int evaluate_chains(const bgc_model *m, bgc_data *d, double t, const double *x, chain_parts *p) {
    place_chain_parts(m->closure_info, d->closing, p);
    m->closures(d->h, t, x, d->u, d->closing, d->work);
    return bgc_first_bad((int)(p->matrix - d->closing), d->closing) < 0;
}

/* S of rows first to last, at positions of which `left` is dw/dx, and `right` the response. */
static void response_of(const bgc_closure_info *c, const double *left, const double *right,
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

/* The least change of `width` unknowns that satisfies the linearised conditions, with derivatives
 * `slopes` by these, in p->change; the normal equations are damped. Returns 0 where there is none. */
static int least_change(const bgc_model *m, bgc_data *d, const double *slopes, int width,
                        double damping, chain_parts *p) {
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

/* The largest condition among the first n. */
static double gap_of(const chain_parts *p, int n, int *worst) {
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
static bgc_status close_positions(const bgc_model *m, bgc_data *d, double t, double *x, chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;

    for (int i = 0; i < MAX_PROJECTIONS; i++) {
        double size = 0.0;
        int worst;
        if (!evaluate_chains(m, d, t, x, p)) {
            return BGC_NOT_FINITE;
        }
        if (gap_of(p, c->n_condition, &worst) <= least_gap) {
            return BGC_OK;
        }
        if (!least_change(m, d, p->by_place, c->n_moved, regularisation, p)) {
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
static bgc_status close_flows(const bgc_model *m, bgc_data *d, double *x, chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;
    const int n = c->n_row;
    int bad;

    if (n == 0) {
        return BGC_OK;
    }
    response_of(c, p->by_impulse, p->response, 0, n, p->matrix);
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
    chain_parts p;

    if (m->closure_info == NULL) {
        return BGC_OK;
    }
    status = close_positions(m, d, t, x, &p);
    return status == BGC_OK ? close_flows(m, d, x, &p) : status;
}

/* --- the start ---------------------------------------------------------------------------------- */

/* Sets the initial state from the parameters; d->next is scratch for the work of the kernel. */
static void set_start(const bgc_model *m, bgc_data *d) {
    if (m->defaults != NULL) {
        m->defaults(d->p, d->is_set, d->work);
    }
    m->prepare(d->p, d->h, d->work);
    m->initial(d->h, d->core.t, d->u, d->x, d->work);
}

/* The unknown k of the start: a parameter, or a state. */
static double *unknown_of(const bgc_model *m, bgc_data *d, int by_parameters, int k) {
    const bgc_closure_info *c = m->closure_info;

    return by_parameters ? d->p + c->start[k] : d->x + c->moved[k];
}

/* Adds part * change to the unknowns of the start. */
static void move_closed_start(const bgc_model *m, bgc_data *d, int by_parameters, double part,
                              const double *change) {
    const bgc_closure_info *c = m->closure_info;
    const int width = by_parameters ? c->n_start : c->n_moved;

    for (int k = 0; k < width; k++) {
        *unknown_of(m, d, by_parameters, k) += part * change[k];
    }
    if (by_parameters) {
        set_start(m, d);
    }
}

/* Euclidean norm of the first n conditions. */
static double misfit_of(const chain_parts *p, int n) {
    double sum = 0.0;

    for (int i = 0; i < n; i++) {
        sum += p->condition[i] * p->condition[i];
    }
    return sqrt(sum);
}

/* The derivatives of the conditions by parameters, in p->table: those by states, times those of
 * states by parameters. Parameters that are set stay. */
static void slopes_by_parameters(const bgc_closure_info *c, const bgc_data *d, chain_parts *p) {
    for (int j = 0; j < c->n_condition; j++) {
        for (int k = 0; k < c->n_start; k++) {
            double sum = 0.0;
            for (int l = 0; l < c->n_moved; l++) {
                sum += p->by_place[j * c->n_moved + l] * p->by_start[l * c->n_start + k];
            }
            p->table[j * c->n_start + k] = d->is_set[c->start[k]] ? 0.0 : sum;
        }
    }
}

/* Moves the parameters that may close the start, or (by_parameters 0) the states themselves, by damped
 * Gauss-Newton steps of least length (Levenberg, Marquardt). Returns whether the conditions hold. */
static int find_start(const bgc_model *m, bgc_data *d, int by_parameters, chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;
    const int width = by_parameters ? c->n_start : c->n_moved;
    double damping = first_damping;

    if (!evaluate_chains(m, d, d->core.t, d->x, p)) {
        return 0;
    }
    for (int i = 0; i < MAX_CLOSING && damping < 1e6; i++) {
        const double misfit = misfit_of(p, c->n_condition);
        int worst = 0;

        if (gap_of(p, c->n_condition, &worst) <= 0.1 * closed_gap) {
            return 1;
        }
        if (by_parameters) {
            slopes_by_parameters(c, d, p);
        }
        if (!least_change(m, d, by_parameters ? p->table : p->by_place, width, damping, p)) {
            return 0;
        }

        /* Take the step if it brings the conditions nearer, else damp more. */
        move_closed_start(m, d, by_parameters, 1.0, p->change);
        if (evaluate_chains(m, d, d->core.t, d->x, p) && misfit_of(p, c->n_condition) < misfit) {
            damping *= 0.1;
        } else {
            move_closed_start(m, d, by_parameters, -1.0, p->change);
            damping = fmax(4.0 * damping, least_of_damping);
            if (!evaluate_chains(m, d, d->core.t, d->x, p)) {
                return 0;
            }
        }
    }
    return 0;
}

/* The declared start: defaults where nothing is set. */
static void declare_start(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;

    for (int k = 0; k < c->n_start; k++) {
        if (!d->is_set[c->start[k]]) {
            d->p[c->start[k]] = m->param[c->start[k]].value;
        }
    }
    set_start(m, d);
}

/* At reset: closes the start in d->x. Parameters that give the start of a state, and that nothing
 * sets, take the values that close it; else given values are moved, by no more than their rounding. */
bgc_status bgc_close_start(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;
    double moved = 0.0;
    int worst = 0;
    chain_parts p;

    if (c == NULL || c->n_all_conditions == 0) {
        return BGC_OK;
    }
    declare_start(m, d);
    if (!evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    if (gap_of(&p, c->n_condition, &worst) > closed_gap &&
        (c->n_start == 0 || !find_start(m, d, 1, &p))) {
        declare_start(m, d);
        memcpy(d->start, d->x, (size_t)m->n_state * sizeof *d->x);
        d->core.failed_chain = worst;
        if (!find_start(m, d, 0, &p)) {
            return BGC_OPEN_CHAIN;
        }
        for (int k = 0; k < c->n_moved; k++) {
            moved = fmax(moved, fabs(d->x[c->moved[k]] - d->start[c->moved[k]]));
        }
        if (moved > rounding_of_start) {
            return BGC_OPEN_CHAIN;
        }
    }

    /* The conditions that follow from the others for the parameters' defaults. */
    if (!evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    if (gap_of(&p, c->n_all_conditions, &worst) > redundant_gap) {
        d->core.failed_chain = worst;
        return BGC_OPEN_CHAIN;
    }
    return BGC_OK;
}

/* --- singular positions --------------------------------------------------------------------------- */

static const double ones[1] = {1.0};

/* Cholesky factors of a symmetric matrix, in place; returns the least pivot over `whole_of` (`ones`: as
 * it is), by default over the diagonal. */
static double cholesky(int n, double *a, const double *whole_of) {
    double least = HUGE_VAL;

    for (int i = 0; i < n; i++) {
        const double whole = whole_of == ones ? 1.0 : whole_of == NULL ? a[i * n + i] : whole_of[i];
        for (int j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (int k = 0; k < j; k++) {
                sum -= a[i * n + k] * a[j * n + k];
            }
            if (j < i) {
                a[i * n + j] = sum / a[j * n + j];
            } else {
                if (!(sum > 0.0)) {
                    return 0.0;
                }
                least = fmin(least, sum / whole);
                a[i * n + i] = sqrt(sum);
            }
        }
    }
    return least;
}

/* a := L^-1 a, with L in the lower triangle of `factors`. */
static void substitute(int n, const double *factors, double *a) {
    for (int column = 0; column < n; column++) {
        for (int i = 0; i < n; i++) {
            double sum = a[i * n + column];
            for (int k = 0; k < i; k++) {
                sum -= factors[i * n + k] * a[k * n + column];
            }
            a[i * n + column] = sum / factors[i * n + i];
        }
    }
}

static void transpose(int n, double *a) {
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) {
            const double kept = a[i * n + j];
            a[i * n + j] = a[j * n + i];
            a[j * n + i] = kept;
        }
    }
}

/* Whether the rows first to last are much the same before and after the step, with G0 and G1: the
 * symmetric parts of L^-1 G0 M^-1 G1' L^-T (the identity where nothing changes), with S0 = L L' and
 * with S1 = L L', have pivots above `least_row_part`. */
static int are_resolved(const bgc_closure_info *c, const double *by_impulse_before,
                        const double *response_before, int first, int last, chain_parts *p) {
    const int n = last - first;

    for (int after = 0; after < 2; after++) {
        response_of(c, after ? p->by_impulse : by_impulse_before,
                    after ? p->response : response_before, first, last, p->matrix);
        response_of(c, by_impulse_before, p->response, first, last, p->mixed);
        if (cholesky(n, p->matrix, NULL) == 0.0) {
            return 0;
        }
        substitute(n, p->matrix, p->mixed);
        transpose(n, p->mixed);
        substitute(n, p->matrix, p->mixed);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j <= i; j++) {
                p->other[i * n + j] = 0.5 * (p->mixed[i * n + j] + p->mixed[j * n + i]);
            }
        }
        if (cholesky(n, p->other, ones) <= least_row_part) {
            return 0;
        }
    }
    return 1;
}

/* Whether projection has moved the states of chains, from d->magnitude to x, by a noticeable part of
 * their change in the step: then the step has not followed the chain. */
int bgc_chains_were_left(const bgc_model *m, const bgc_data *d, const double *x) {
    const bgc_closure_info *c = m->closure_info;
    const int counts[2] = {c->n_moved, c->n_impulse};
    const int *const states[2] = {c->moved, c->impulse};

    for (int part = 0; part < 2; part++) {
        double moved = 0.0, changed = 0.0;
        for (int k = 0; k < counts[part]; k++) {
            const int i = states[part][k];
            moved += pow((x[i] - d->magnitude[i]) / d->scale[i], 2);
            changed += pow((d->magnitude[i] - d->x[i]) / d->scale[i], 2);
        }
        if (sqrt(moved) > left_part * sqrt(changed) + negligible_move) {
            return 1;
        }
    }
    return 0;
}

/* At the end of a step in x, at time t: whether a chain is at a singular position, or has passed one
 * since the present (then d->core.too_coarse is set). */
bgc_status bgc_watch_chains(const bgc_model *m, bgc_data *d, double t, const double *x) {
    const bgc_closure_info *c = m->closure_info;
    const double *before = d->closed_before;
    int first = 0;
    chain_parts p;

    if (c == NULL) {
        return BGC_OK;
    }
    if (!evaluate_chains(m, d, t, x, &p)) {
        return BGC_NOT_FINITE;
    }
    d->core.next_chain_pivot = 1.0;
    while (first < c->n_row) {
        const int chain = c->chain_of[first];
        int last = first;
        double pivot;

        while (last < c->n_row && c->chain_of[last] == chain) {
            last++;
        }
        response_of(c, p.by_impulse, p.response, first, last, p.matrix);
        for (int i = first; i < last; i++) {
            const double now = p.matrix[(i - first) * (last - first + 1)];
            d->response_size[i] = fmax(d->response_size[i], now);
        }
        pivot = cholesky(last - first, p.matrix, d->response_size + first);
        if (pivot < d->core.next_chain_pivot) {
            d->core.next_chain_pivot = pivot;
            d->core.failed_chain = chain;
        }
        if (pivot < singular_pivot) {
            return BGC_SINGULAR_CHAIN;
        }
        if (d->core.watches_chains &&
            !are_resolved(c, before, before + c->n_row * c->n_impulse, first, last, &p)) {
            d->core.failed_chain = chain;
            d->core.passes_singular = d->core.too_coarse = 1;
            return BGC_OK;
        }
        first = last;
    }
    return BGC_OK;
}

/* Keeps the rows of the last `bgc_watch_chains` as those of the present. */
void bgc_enter_chains(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;
    chain_parts p;

    if (c == NULL) {
        return;
    }
    place_chain_parts(c, d->closing, &p);
    memcpy(d->closed_before, p.by_impulse,
           2 * (size_t)c->n_row * (size_t)c->n_impulse * sizeof *d->closed_before);
    d->core.chain_pivot = d->core.next_chain_pivot;
    d->core.watches_chains = 1;
}

/* The status of a failed attempt: near a singular position that is the cause. */
bgc_status bgc_status_near_chains(const bgc_model *m, const bgc_data *d, bgc_status status) {
    const int may_be = status == BGC_STEP_TOO_SMALL || status == BGC_NOT_FINITE ||
                       status == BGC_SINGULAR || status == BGC_NOT_CONVERGED;

    return m->closure_info != NULL && may_be && d->core.chain_pivot < near_singular
               ? BGC_SINGULAR_CHAIN
               : status;
}
