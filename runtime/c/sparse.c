/* sparse.c: elimination over the pattern of W, by loops over the model's tables.
 *
 * Row k of the factors is at lu_row[k] .. lu_row[k + 1]: entries of L left of the pivot (its diagonal
 * is one), the reciprocal of the pivot at lu_pivot[k], entries of U right of it; lu_col has the
 * columns. Rows and columns count in the order of elimination: row k is row
 * pivot_row[k] of W, column k is column pivot_col[k]. Entry e of the Jacobian goes to place
 * lu_jac[e], of M to lu_mass[e]. Right-hand sides have rows of inner unknowns too. The real form serves models that are too large for unrolled code,
 * the complex one methods with complex stages.
 */
#include "bgc_internal.h"
#include "complex_numbers.h"

#include <math.h>
#include <string.h>

/* --- real ------------------------------------------------------------------------------------- */

/* lu := c M - J, and size[k] := the sum of the absolute values of the terms of pivot k: of the entry of
 * c M, and of what the Jacobian changes it by. */
static void assemble(const bgc_model *m, const double *mass, const double *jac, double c,
                     double *lu, double *size) {
    const int n = bgc_unknowns(m), entries = bgc_local_entries(m).count;

    memset(lu, 0, (size_t)m->n_lu * sizeof *lu);
    for (int e = 0; e < m->n_mass; e++) {
        lu[m->lu_mass[e]] += c * mass[e];
    }
    for (int k = 0; k < n; k++) {
        double *entry = lu + m->lu_pivot[k];
        size[k] = *entry = m->n_mass == 0 && m->pivot_row[k] < m->n_state ? c : *entry;
    }
    for (int e = 0; e < entries; e++) {
        lu[m->lu_jac[e]] -= jac[e];
    }
    for (int k = 0; k < n; k++) {
        size[k] = fabs(size[k]) + fabs(size[k] - lu[m->lu_pivot[k]]);
    }
}

/* Factorises W = c M - J as bgc_model.factor does; scratch is two doubles for each unknown. */
int bgc_sparse_factor(const bgc_model *m, const double *mass, const double *jac, double c,
                      double *lu, double *growth, double *scratch) {
    const int n = bgc_unknowns(m);
    double *row = scratch, *size = scratch + n;
    double sum = 0.0;

    assemble(m, mass, jac, c, lu, size);
    for (int k = 0; k < n; k++) {
        const int begin = m->lu_row[k], pivot = m->lu_pivot[k], end = m->lu_row[k + 1];
        /* Row k, scattered to a dense row. */
        for (int e = begin; e < end; e++) {
            row[m->lu_col[e]] = lu[e];
        }
        /* Subtract multiples of the rows above: entries of L. */
        for (int e = begin; e < pivot; e++) {
            const int j = m->lu_col[e];
            const double factor = row[j] * lu[m->lu_pivot[j]];
            lu[e] = factor;
            for (int i = m->lu_pivot[j] + 1; i < m->lu_row[j + 1]; i++) {
                row[m->lu_col[i]] -= factor * lu[i];
            }
        }
        /* The pivot, its growth, and the entries of U. */
        lu[pivot] = 1.0 / row[k];
        sum += (size[k] > 0.0 ? size[k] : fabs(row[k])) * fabs(lu[pivot]);
        for (int e = pivot + 1; e < end; e++) {
            lu[e] = row[m->lu_col[e]];
        }
    }
    *growth = sum;
    return sum < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b, with inner unknowns; scratch is a double for each unknown. */
void bgc_sparse_solve(const bgc_model *m, const double *lu, double *b, double *scratch) {
    const int n = bgc_unknowns(m);

    /* Forward, then backward substitution. */
    for (int k = 0; k < n; k++) {
        double y = b[m->pivot_row[k]];
        for (int e = m->lu_row[k]; e < m->lu_pivot[k]; e++) {
            y -= lu[e] * scratch[m->lu_col[e]];
        }
        scratch[k] = y;
    }
    for (int k = n - 1; k >= 0; k--) {
        double y = scratch[k];
        for (int e = m->lu_pivot[k] + 1; e < m->lu_row[k + 1]; e++) {
            y -= lu[e] * scratch[m->lu_col[e]];
        }
        scratch[k] = y * lu[m->lu_pivot[k]];
        b[m->pivot_col[k]] = scratch[k];
    }
}

/* --- complex ---------------------------------------------------------------------------------- */

/* lu := c M - J, and size[k] := the sum of the sizes of the terms of pivot k, as above. The Jacobian is
 * real: imaginary parts are those of c M. */
static void assemble_complex(const bgc_model *m, const double *mass, const double *jac,
                             bgc_complex c, bgc_complex *lu, double *size) {
    const int n = bgc_unknowns(m), entries = bgc_local_entries(m).count;

    memset(lu, 0, (size_t)m->n_lu * sizeof *lu);
    for (int e = 0; e < m->n_mass; e++) {
        lu[m->lu_mass[e]].re += c.re * mass[e];
        lu[m->lu_mass[e]].im += c.im * mass[e];
    }
    for (int k = 0; k < n; k++) {
        bgc_complex *entry = lu + m->lu_pivot[k];
        *entry = m->n_mass == 0 && m->pivot_row[k] < m->n_state ? c : *entry;
        size[k] = entry->re;
    }
    for (int e = 0; e < entries; e++) {
        lu[m->lu_jac[e]].re -= jac[e];
    }
    for (int k = 0; k < n; k++) {
        const bgc_complex sum = lu[m->lu_pivot[k]];
        size[k] = bgc_size_of((bgc_complex){size[k], sum.im}) + fabs(size[k] - sum.re);
    }
}

/* Factorises c M - J for a complex c as bgc_sparse_factor does; scratch is three doubles for each
 * unknown. */
int bgc_complex_factor(const bgc_model *m, const double *mass, const double *jac, bgc_complex c,
                       bgc_complex *lu, double *growth, double *scratch) {
    const int n = bgc_unknowns(m);
    bgc_complex *row = (bgc_complex *)(void *)scratch;
    double *size = scratch + 2 * (size_t)n, sum = 0.0;

    assemble_complex(m, mass, jac, c, lu, size);
    for (int k = 0; k < n; k++) {
        const int begin = m->lu_row[k], pivot = m->lu_pivot[k], end = m->lu_row[k + 1];
        /* Row k, scattered to a dense row. */
        for (int e = begin; e < end; e++) {
            row[m->lu_col[e]] = lu[e];
        }
        /* Subtract multiples of the rows above: entries of L. */
        for (int e = begin; e < pivot; e++) {
            const int j = m->lu_col[e];
            const bgc_complex factor = bgc_times(row[j], lu[m->lu_pivot[j]]);
            lu[e] = factor;
            for (int i = m->lu_pivot[j] + 1; i < m->lu_row[j + 1]; i++) {
                row[m->lu_col[i]] = bgc_minus(row[m->lu_col[i]], bgc_times(factor, lu[i]));
            }
        }
        /* The pivot, its growth, and the entries of U. */
        lu[pivot] = bgc_reciprocal(row[k]);
        sum += (size[k] > 0.0 ? size[k] : bgc_size_of(row[k])) * bgc_size_of(lu[pivot]);
        for (int e = pivot + 1; e < end; e++) {
            lu[e] = row[m->lu_col[e]];
        }
    }
    *growth = sum;
    return sum < (double)INFINITY ? 0 : 1;
}

/* b := (c M - J)^-1 b with the factors of bgc_complex_factor, with inner unknowns; scratch is a number
 * for each unknown. */
void bgc_complex_solve(const bgc_model *m, const bgc_complex *lu, bgc_complex *b,
                       bgc_complex *scratch) {
    const int n = bgc_unknowns(m);

    /* Forward, then backward substitution. */
    for (int k = 0; k < n; k++) {
        bgc_complex y = b[m->pivot_row[k]];
        for (int e = m->lu_row[k]; e < m->lu_pivot[k]; e++) {
            y = bgc_minus(y, bgc_times(lu[e], scratch[m->lu_col[e]]));
        }
        scratch[k] = y;
    }
    for (int k = n - 1; k >= 0; k--) {
        bgc_complex y = scratch[k];
        for (int e = m->lu_pivot[k] + 1; e < m->lu_row[k + 1]; e++) {
            y = bgc_minus(y, bgc_times(lu[e], scratch[m->lu_col[e]]));
        }
        scratch[k] = bgc_times(y, lu[m->lu_pivot[k]]);
        b[m->pivot_col[k]] = scratch[k];
    }
}
