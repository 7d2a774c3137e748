/* backward_error.c: the componentwise backward error of a solution of W x = b, W = c M - J: J. W.
 * Demmel, Applied Numerical Linear Algebra, 2.7. */
#include "bgc_internal.h"
#include "solutions.h"

#include <math.h>

/* Turns the sizes in d->reach into those that count in the check of a solution. */
void bgc_raise_to_least_part(const bgc_model *m, bgc_ivp *d) {
    number largest = number_of(0.0);

    for (int i = 0; i < m->n_state; i++) {
        const number part = d->reach[i] / d->scale[i];
        largest = number_larger(largest, part);
    }
    for (int i = 0; i < bgc_unknowns(m); i++) {
        d->reach[i] += bgc_least_part * largest * d->scale[i];
    }
}

/* out = W v, and magnitude = |W| reach, with the sizes of v that count. */
static void multiply(const bgc_model *m, bgc_ivp *d, const number *v, number *out,
                     number *magnitude) {
    const bgc_entries j = bgc_local_entries(m);
    const double c = d->core.c;
    const number none = number_of(0.0), *reach = d->reach;
    const int n = bgc_unknowns(m), alone = m->n_mass == 0 ? m->n_state : 0;

    for (int i = 0; i < n; i++) {
        d->reach[i] = number_fabs(v[i]);
    }
    bgc_raise_to_least_part(m, d);
    for (int i = 0; i < n; i++) {
        out[i] = i < alone ? c * v[i] : none;
        magnitude[i] = i < alone ? fabs(c) * reach[i] : none;
    }
    for (int k = 0; k < m->n_mass; k++) {
        const number entry = c * d->mass[k];
        out[m->mass_row[k]] += entry * v[m->mass_col[k]];
        magnitude[m->mass_row[k]] += number_fabs(entry) * reach[m->mass_col[k]];
    }
    /* Entries of a row are contiguous: their sums stay in registers. */
    for (int k = 0; k < j.count;) {
        const int row = j.row[k];
        number sum = none, size = none;
        for (; k < j.count && j.row[k] == row; k++) {
            sum += d->jac[k] * v[j.col[k]];
            size += number_fabs(d->jac[k]) * reach[j.col[k]];
        }
        out[row] -= sum;
        magnitude[row] += size;
    }
}

/* d->residual = b - W x; returns the componentwise backward error of x, with a floor for small
 * x. */
number bgc_backward_error(const bgc_model *m, bgc_ivp *d, const number *b, const number *x) {
    number worst = number_of(0.0);

    multiply(m, d, x, d->residual, d->magnitude);
    for (int i = 0; i < bgc_unknowns(m); i++) {
        const number size = d->magnitude[i] + number_fabs(b[i]);
        number error;
        d->residual[i] = b[i] - d->residual[i];
        error = number_fabs(d->residual[i]) / size;
        worst = number_select((size > number_of(bgc_underflow)) & number_not(error <= worst), error,
                              worst); /* a NaN stays */
    }
    return worst;
}
