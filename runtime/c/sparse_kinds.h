/* sparse_kinds.h: elimination over the pattern of W, by loops over the model's tables.
 *
 * Row k of the factors is at lu_row[k] .. lu_row[k + 1]: entries of L left of the pivot (its diagonal
 * is one), the reciprocal of the pivot at lu_pivot[k], entries of U right of it; lu_col has the
 * columns. Rows and columns count in the order of elimination: row k is row
 * pivot_row[k] of W, column k is column pivot_col[k]. Entry e of the Jacobian goes to place
 * lu_jac[e], of M to lu_mass[e]. Right-hand sides have rows of inner unknowns too.
 */
#include "kind.h"

/* lu := c M - J, and size[k] := the sum of the sizes of the terms of pivot k: of the entry of c M, and of
 * what the Jacobian changes it by. */
static void BGC_KIND(assemble)(const bgc_model *m, const double *mass, const double *jac,
                               bgc_scalar c, bgc_scalar *lu, double *size) {
    const int n = bgc_unknowns(m), entries = bgc_local_entries(m).count;

    memset(lu, 0, (size_t)m->n_lu * sizeof *lu);
    for (int e = 0; e < m->n_mass; e++) {
        bgc_scalar *entry = lu + m->lu_mass[e];
        *entry = kind_plus_scaled(*entry, mass[e], c);
    }
    for (int k = 0; k < n; k++) {
        bgc_scalar *entry = lu + m->lu_pivot[k];
        *entry = m->n_mass == 0 && m->pivot_row[k] < m->n_state ? c : *entry;
        size[k] = kind_re(*entry);
    }
    for (int e = 0; e < entries; e++) {
        kind_re(lu[m->lu_jac[e]]) -= jac[e];
    }
    for (int k = 0; k < n; k++) {
        const bgc_scalar pivot = lu[m->lu_pivot[k]];
        size[k] = kind_size(kind_with_re(pivot, size[k])) + fabs(size[k] - kind_re(pivot));
    }
}

/* Factorises W = c M - J as bgc_model.factor does; scratch is a number and a double for each unknown. */
int BGC_KIND(bgc_sparse_factor)(const bgc_model *m, const double *mass, const double *jac,
                                bgc_scalar c, bgc_scalar *lu, double *growth, double *scratch) {
    const int n = bgc_unknowns(m);
    bgc_scalar *row = (bgc_scalar *)(void *)scratch;
    double *size = (double *)(void *)(row + n), sum = 0.0;

    BGC_KIND(assemble)(m, mass, jac, c, lu, size);
    for (int k = 0; k < n; k++) {
        const int begin = m->lu_row[k], pivot = m->lu_pivot[k], end = m->lu_row[k + 1];
        /* Row k, scattered to a dense row. */
        for (int e = begin; e < end; e++) {
            row[m->lu_col[e]] = lu[e];
        }
        /* Subtract multiples of the rows above: entries of L. */
        for (int e = begin; e < pivot; e++) {
            const int j = m->lu_col[e];
            const bgc_scalar factor = kind_times(row[j], lu[m->lu_pivot[j]]);
            lu[e] = factor;
            for (int i = m->lu_pivot[j] + 1; i < m->lu_row[j + 1]; i++) {
                bgc_scalar *entry = row + m->lu_col[i];
                *entry = kind_minus_product(*entry, factor, lu[i]);
            }
        }
        /* The pivot, its growth, and the entries of U. */
        lu[pivot] = kind_reciprocal(row[k]);
        sum += (size[k] > 0.0 ? size[k] : kind_size(row[k])) * kind_size(lu[pivot]);
        for (int e = pivot + 1; e < end; e++) {
            lu[e] = row[m->lu_col[e]];
        }
    }
    *growth = sum;
    return sum < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b, with inner unknowns; scratch is a number for each unknown. */
void BGC_KIND(bgc_sparse_solve)(const bgc_model *m, const bgc_scalar *lu, bgc_scalar *b,
                                double *scratch) {
    const int n = bgc_unknowns(m);
    bgc_scalar *x = (bgc_scalar *)(void *)scratch;

    /* Forward, then backward substitution. */
    for (int k = 0; k < n; k++) {
        bgc_scalar y = b[m->pivot_row[k]];
        for (int e = m->lu_row[k]; e < m->lu_pivot[k]; e++) {
            y = kind_minus_product(y, lu[e], x[m->lu_col[e]]);
        }
        x[k] = y;
    }
    for (int k = n - 1; k >= 0; k--) {
        bgc_scalar y = x[k];
        for (int e = m->lu_pivot[k] + 1; e < m->lu_row[k + 1]; e++) {
            y = kind_minus_product(y, lu[e], x[m->lu_col[e]]);
        }
        x[k] = kind_times(y, lu[m->lu_pivot[k]]);
        b[m->pivot_col[k]] = x[k];
    }
}
