/* chain_kernel.c: the results of the kernel of closed chains: their places, and what is listed of them. */
#include "closures.h"

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
                        int n, const int *row, double *s) {
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int k = 0; k < c->n_impulse; k++) {
                sum -= left[row[i] * c->n_impulse + k] * right[k * c->n_row + row[j]];
            }
            s[i * n + j] = sum;
        }
    }
}

int bgc_list_chosen(const double *flag, int first, int last, int *list) {
    int n = 0;

    for (int k = first; k < last; k++) {
        if (flag[k] != 0.0) {
            list[n++] = k;
        }
    }
    return n;
}

int bgc_list_conditions(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;

    return bgc_list_chosen(d->chosen + c->n_row, 0, c->n_condition, d->closing_list);
}
