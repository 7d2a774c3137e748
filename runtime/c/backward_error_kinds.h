/* backward_error_kinds.h: the componentwise backward error of a solution of W x = b, W = c M - J: J. W.
 * Demmel, Applied Numerical Linear Algebra, 2.7. */
#include "kind.h"

/* out = W v, and magnitude = |W| reach, with the sizes of v that count. */
static void BGC_KIND(multiply)(const bgc_model *m, bgc_ivp *d, const bgc_scalar *v, bgc_scalar *out,
                               number *magnitude) {
    const bgc_entries j = bgc_local_entries(m);
    const bgc_scalar c = kind_of(d->core.BGC_KIND(c)), zero = kind_zero;
    const number none = number_of(0.0), *reach = d->reach;
    const int n = bgc_unknowns(m), alone = m->n_mass == 0 ? m->n_state : 0;

    for (int i = 0; i < n; i++) {
        d->reach[i] = kind_size(v[i]);
    }
    raise_to_least_part(m, d);
    for (int i = 0; i < n; i++) {
        out[i] = i < alone ? kind_times(c, v[i]) : zero;
        magnitude[i] = i < alone ? kind_size(c) * reach[i] : none;
    }
    for (int k = 0; k < m->n_mass; k++) {
        const bgc_scalar entry = kind_scaled(d->mass[k], c);
        const int row = m->mass_row[k], col = m->mass_col[k];
        out[row] = kind_plus(out[row], kind_times(entry, v[col]));
        magnitude[row] += kind_size(entry) * reach[col];
    }
    /* Entries of a row are contiguous: their sums stay in registers. */
    for (int k = 0; k < j.count;) {
        const int row = j.row[k];
        bgc_scalar sum = zero;
        number size = none;
        for (; k < j.count && j.row[k] == row; k++) {
            sum = kind_plus_scaled(sum, d->jac[k], v[j.col[k]]);
            size += number_fabs(d->jac[k]) * reach[j.col[k]];
        }
        out[row] = kind_minus(out[row], sum);
        magnitude[row] += size;
    }
}

/* The residual b - W x goes to d->residual; returns the componentwise backward error of x, with a floor
 * for small x. */
number BGC_KIND(bgc_backward_error)(const bgc_model *m, bgc_ivp *d, const bgc_scalar *b,
                                    const bgc_scalar *x) {
    bgc_scalar *residual = d->BGC_KIND(residual);
    number worst = number_of(0.0);

    BGC_KIND(multiply)(m, d, x, residual, d->magnitude);
    for (int i = 0; i < bgc_unknowns(m); i++) {
        const number size = d->magnitude[i] + kind_size(b[i]);
        number error;
        residual[i] = kind_minus(b[i], residual[i]);
        error = kind_size(residual[i]) / size;
        worst = number_select((size > number_of(bgc_underflow)) & number_not(error <= worst), error,
                              worst); /* a NaN stays */
    }
    return worst;
}
