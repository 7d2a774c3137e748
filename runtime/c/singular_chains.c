/* singular_chains.c: singular positions of closed chains.
 *
 * Where a chain passes a singular position, its rows lose rank there, turn round, or turn aside. A step
 * that leaves less than a part of any of their combinations is therefore shortened. Near a singular
 * position this goes on until a pivot of S, relative to the largest diagonal so far, is rounding; there
 * the run ends.
 */
#include "closures.h"

#include <math.h>
#include <string.h>

static const double singular_pivot = 1e-10; /* of S, relative: at a singular position */
static const double near_singular = 1e-4; /* a failure at less is due to the position */
static const double least_row_part = 0.4; /* of a row that a step may leave of it */
static const double left_part = 0.1; /* of the change in a step that projection may move */
static const double negligible_move = 1e-6; /* by projection, relative to scale */

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

/* Whether n rows are much the same before and after the step, with G0 and G1: the
 * symmetric parts of L^-1 G0 M^-1 G1' L^-T (the identity where nothing changes), with S0 = L L' and
 * with S1 = L L', have pivots above `least_row_part`. */
static int are_resolved(const bgc_closure_info *c, const double *by_impulse_before,
                        const double *response_before, int n, const int *row, bgc_chain_parts *p) {
    for (int after = 0; after < 2; after++) {
        bgc_chain_response(c, after ? p->by_impulse : by_impulse_before,
                    after ? p->response : response_before, n, row, p->matrix);
        bgc_chain_response(c, by_impulse_before, p->response, n, row, p->mixed);
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
    const size_t count = c == NULL ? 0 : (size_t)c->n_row * (size_t)c->n_impulse;
    int *row = d->closing_list;
    int first = 0;
    bgc_chain_parts p;

    if (c == NULL) {
        return BGC_OK;
    }
    if (!bgc_evaluate_chains(m, d, t, x, &p)) {
        return BGC_NOT_FINITE;
    }
    d->core.next_chain_pivot = 1.0;
    memcpy(d->closed_after, p.by_impulse, 2 * count * sizeof *d->closed_after);
    memcpy(d->next_chosen, d->chosen, (size_t)(c->n_row + c->n_condition) * sizeof *d->chosen);
    bgc_next_conditions(c, d, &p);
    while (first < c->n_row) {
        const int chain = c->chain_of[first];
        const int last = bgc_end_of_chain(c, first);
        int n = last - first;
        double pivot;

        /* The smallest pivot of its best rows, relative to the largest size of the diagonal so far. */
        bgc_whole_chain_response(c, d, first, last, &p);
        pivot = c->rank[chain] < n ? bgc_next_chain_rows(c, d, first, last, &p)
                                   : cholesky(n, p.matrix, d->response_size + first);
        if (pivot < d->core.next_chain_pivot) {
            d->core.next_chain_pivot = pivot;
            d->core.failed_chain = chain;
        }
        if (pivot < singular_pivot) {
            return BGC_SINGULAR_CHAIN;
        }

        /* Whether the step may have passed a singular position. */
        n = bgc_list_chosen(d->chosen, first, last, row);
        if (d->core.watches_chains &&
            !are_resolved(c, before, before + count, n, row, &p)) {
            d->core.failed_chain = chain;
            d->core.passes_singular = d->core.too_coarse = 1;
            return BGC_OK;
        }
        first = last;
    }
    return BGC_OK;
}

/* Keeps the rows of the last `bgc_watch_chains` as those of the present, and changes the choice. */
void bgc_enter_chains(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;

    if (c == NULL) {
        return;
    }
    memcpy(d->closed_before, d->closed_after,
           2 * (size_t)c->n_row * (size_t)c->n_impulse * sizeof *d->closed_before);
    bgc_take_next_rows(m, d);
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
