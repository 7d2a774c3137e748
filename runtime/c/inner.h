/* inner.h: elimination of the inner unknowns from the Jacobian of a model (see n_inner in bgc.h). */
#ifndef BGC_INNER_H
#define BGC_INNER_H

#include "bgc_internal.h"

#include <string.h>

/* The number of unknowns before the explicit ones: the last inner unknowns whose equations have no
 * later unknown, so that each follows from those before it. */
static inline int bgc_implicit_unknowns(const bgc_model *m) {
    int count = m->n_state;

    for (int k = 0; k < m->n_local; k++) {
        if (m->local_row[k] >= count && m->local_col[k] > m->local_row[k]) {
            count = m->local_row[k] + 1;
        }
    }
    return count;
}

/* Sets a row to the derivatives of equation `row` by the first `width` unknowns; the derivatives of
 * explicit unknowns are rows of a. k is the first entry of the row. Returns the coefficient of an
 * explicit unknown in its own equation. */
static inline double bgc_accumulate_row(const bgc_model *m, const double *local, int k, size_t width,
                                        double *a) {
    const int row = m->local_row[k];
    double *sum = a + (size_t)row * width, own = 0.0;

    memset(sum, 0, width * sizeof *sum);
    for (; k < m->n_local && m->local_row[k] == row; k++) {
        const size_t column = (size_t)m->local_col[k];
        const double entry = local[k];
        if (column < width) {
            sum[column] += entry;
        } else if (column == (size_t)row) {
            own = entry;
        } else {
            const double *other = a + column * width;
            for (size_t j = 0; j < width; j++) {
                sum[j] += entry * other[j];
            }
        }
    }
    return own;
}

/* Eliminates the inner unknowns: the explicit ones by substitution, the others from the last to the
 * first. a has room for n by n numbers, n = bgc_unknowns(m), and is filled with rows of the returned
 * width, one for each unknown. Those of the states then begin with df/dx, that of another inner unknown
 * holds its equation in the unknowns up to it, and that of an explicit one its derivatives by the
 * unknowns before the explicit ones. */
static inline size_t bgc_eliminate_inner(const bgc_model *m, const double *local, double *a) {
    const size_t first = (size_t)m->n_state, width = (size_t)bgc_implicit_unknowns(m);

    memset(a, 0, width * width * sizeof *a);
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < m->n_local; k++) {
            const int explicit = (size_t)m->local_row[k] >= width;
            if ((k == 0 || m->local_row[k] != m->local_row[k - 1]) && explicit == (pass == 0)) {
                const double own = bgc_accumulate_row(m, local, k, width, a);
                double *row = a + (size_t)m->local_row[k] * width;
                for (size_t j = 0; explicit && j < width; j++) {
                    row[j] /= -own;
                }
            }
        }
    }
    for (size_t last = width; last-- > first;) {
        const double *row = a + last * width;
        const double inverse = 1.0 / row[last];
        for (size_t i = 0; i < last; i++) {
            double *other = a + i * width;
            const double factor = other[last] * inverse;
            for (size_t j = 0; factor != 0.0 && j < last; j++) {
                other[j] -= factor * row[j];
            }
        }
    }
    return width;
}

/* The entries of df/dx in that matrix, in the order of jac_row, jac_col. */
static inline void bgc_gather_slopes(const bgc_model *m, const double *a, size_t width, double *jac) {
    for (int k = 0; k < m->n_jac; k++) {
        jac[k] = a[(size_t)m->jac_row[k] * width + (size_t)m->jac_col[k]];
    }
}

#endif
