/* inner.h: elimination of the inner unknowns from the Jacobian of a model (see n_inner in bgc.h). */
#ifndef BGC_INNER_H
#define BGC_INNER_H

#include "bgc_internal.h"

#include <string.h>

/* Fills a, a matrix of all unknowns, from the entries at local_row, local_col, and eliminates the inner
 * unknowns from the last to the first. Afterwards its leading block of the states is df/dx, and the row
 * of an inner unknown holds its equation in the states and the inner unknowns before it. */
static inline void bgc_eliminate_inner(const bgc_model *m, const double *local, double *a) {
    const size_t n = (size_t)bgc_unknowns(m), first = (size_t)m->n_state;

    memset(a, 0, n * n * sizeof *a);
    for (int k = 0; k < m->n_local; k++) {
        a[(size_t)m->local_row[k] * n + (size_t)m->local_col[k]] = local[k];
    }
    for (size_t last = n; last-- > first;) {
        const double *row = a + last * n;
        const double inverse = 1.0 / row[last];
        for (size_t i = 0; i < last; i++) {
            double *other = a + i * n;
            const double factor = other[last] * inverse;
            for (size_t j = 0; factor != 0.0 && j < last; j++) {
                other[j] -= factor * row[j];
            }
        }
    }
}

/* The entries of df/dx in that matrix, in the order of jac_row, jac_col. */
static inline void bgc_gather_slopes(const bgc_model *m, const double *a, double *jac) {
    const size_t n = (size_t)bgc_unknowns(m);

    for (int k = 0; k < m->n_jac; k++) {
        jac[k] = a[(size_t)m->jac_row[k] * n + (size_t)m->jac_col[k]];
    }
}

#endif
