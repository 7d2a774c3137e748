/* chosen_rows.c: the rows of closed chains that hold them, where others follow from these.
 *
 * A chain in which constraints are redundant has more rows than its rank r. Their multipliers act alike,
 * whichever r independent rows have them, so that the motion does not depend on the choice; but in some
 * positions of a Bricard or Bennett linkage a row that was redundant is needed, because another becomes a
 * combination of the rest. The rows are therefore chosen by the pivots of S = G M^-1 G' (those of the
 * conditions by dg/dx (dg/dx)'), and others take their place after a step that ends where these are better
 * conditioned by far. f stays the same but for the rounding and the drift within a step. Only where even
 * the best r rows are dependent is the position singular.
 */
#include "closures.h"

#include <math.h>
#include <string.h>

static const double worth_a_change = 0.1; /* the least pivot, over that of the best rows */

int bgc_end_of_chain(const bgc_closure_info *c, int first) {
    int last = first;

    while (last < c->n_row && c->chain_of[last] == c->chain_of[first]) {
        last++;
    }
    return last;
}

int bgc_is_first_choice(const bgc_closure_info *c, int k) {
    const int rank = c->rank[c->chain_of[k]];

    return k < rank || c->chain_of[k - rank] != c->chain_of[k];
}

/* The largest pivots of Cholesky's factors of a symmetric matrix, each relative to `whole`: flags the `rank`
 * rows that have them in `chosen`, and returns the last. Rows without a flag in `allowed` are left out.
 * Overwrites the matrix. */
static double choose_pivots(int n, double *a, const double *whole, int rank, const double *allowed,
                            double *chosen) {
    double last = HUGE_VAL;

    memset(chosen, 0, (size_t)n * sizeof *chosen);
    for (int step = 0; step < rank; step++) {
        double largest = 0.0;
        int best = -1;

        /* The largest pivot that is left. */
        for (int k = 0; k < n; k++) {
            const double pivot = whole[k] > 0.0 ? a[k * n + k] / whole[k] : 0.0;
            if (chosen[k] == 0.0 && (allowed == NULL || allowed[k] != 0.0) && pivot > largest) {
                largest = pivot;
                best = k;
            }
        }
        if (best < 0) {
            return 0.0;
        }
        chosen[best] = 1.0;
        last = largest;

        /* What is left of the other rows. */
        for (int i = 0; i < n; i++) {
            const double factor = a[i * n + best] / a[best * n + best];
            for (int j = 0; j < n && chosen[i] == 0.0; j++) {
                a[i * n + j] -= factor * a[best * n + j];
            }
        }
    }
    return last;
}

/* Chooses `rank` of n rows with the matrix p->matrix: those of d->chosen unless others are conditioned better
 * by far. Returns the least pivot of the best ones. */
static double choose(bgc_data *d, int n, const double *whole, int rank, int first,
                     bgc_chain_parts *p) {
    const size_t size = (size_t)(n * n) * sizeof *p->matrix;
    const double *chosen = d->chosen + first;
    double *next = d->next_chosen + first;
    double best, present;

    memcpy(p->other, p->matrix, size);
    present = choose_pivots(n, p->other, whole, rank, chosen, next);
    memcpy(p->other, p->matrix, size);
    best = choose_pivots(n, p->other, whole, rank, NULL, next);
    if (!(present < worth_a_change * best)) {
        memcpy(next, chosen, (size_t)n * sizeof *next);
    }
    return best;
}

void bgc_whole_chain_response(const bgc_closure_info *c, bgc_data *d, int first, int last,
                              bgc_chain_parts *p) {
    const int n = last - first;

    for (int i = 0; i < n; i++) {
        d->closing_list[i] = first + i;
    }
    bgc_chain_response(c, p->by_impulse, p->response, n, d->closing_list, p->matrix);
    for (int i = 0; i < n; i++) {
        d->response_size[first + i] = fmax(d->response_size[first + i], p->matrix[i * (n + 1)]);
    }
}

double bgc_next_chain_rows(const bgc_closure_info *c, bgc_data *d, int first, int last,
                           bgc_chain_parts *p) {
    const int rank = c->rank[c->chain_of[first]];

    return choose(d, last - first, d->response_size + first, rank, first, p);
}

void bgc_next_conditions(const bgc_closure_info *c, bgc_data *d, bgc_chain_parts *p) {
    const int n = c->n_condition;

    if (c->condition_rank == n) {
        return;
    }
    for (int i = 0; i < n; i++) {
        p->change[i] = 1.0;
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int k = 0; k < c->n_moved; k++) {
                sum += p->by_place[i * c->n_moved + k] * p->by_place[j * c->n_moved + k];
            }
            p->matrix[i * n + j] = sum;
        }
    }
    choose(d, n, p->change, c->condition_rank, c->n_row, p);
}

/* Sets the selectors of the chosen rows, and what follows from them. */
static void select_rows(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;

    for (int k = 0; k < c->n_row; k++) {
        if (c->selector[k] >= 0) {
            d->p[c->selector[k]] = d->chosen[k];
        }
    }
}

void bgc_take_next_rows(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;
    const size_t size = (size_t)(c->n_row + c->n_condition) * sizeof *d->chosen;

    if (memcmp(d->chosen, d->next_chosen, size) != 0) {
        memcpy(d->chosen, d->next_chosen, size);
        select_rows(m, d);
        m->prepare(d->p, d->h, d->work);
        d->core.f_valid = d->core.jac_valid = d->core.held = 0;
    }
}

/* Chooses the rows and conditions for the present, where there is a choice. */
bgc_status bgc_choose_chain_rows(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;
    bgc_chain_parts p;

    if (c == NULL || (c->n_selector == 0 && c->condition_rank == c->n_condition)) {
        return BGC_OK;
    }
    if (!bgc_evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    memcpy(d->next_chosen, d->chosen, (size_t)(c->n_row + c->n_condition) * sizeof *d->chosen);
    bgc_next_conditions(c, d, &p);
    for (int first = 0, last; first < c->n_row; first = last) {
        last = bgc_end_of_chain(c, first);
        bgc_whole_chain_response(c, d, first, last, &p);
        bgc_next_chain_rows(c, d, first, last, &p);
    }
    bgc_take_next_rows(m, d);
    return BGC_OK;
}

/* At reset: the first choice. */
void bgc_reset_chains(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;

    if (c == NULL) {
        return;
    }
    for (int k = 0; k < c->n_row; k++) {
        d->chosen[k] = bgc_is_first_choice(c, k);
        d->response_size[k] = 0.0;
    }
    for (int k = 0; k < c->n_condition; k++) {
        d->chosen[c->n_row + k] = k < c->condition_rank;
    }
    select_rows(m, d);
}
