/* matrices_kinds.h: dense matrices, stored by rows, and their factors. */
#include "kind.h"

/* Makes room for n by n numbers in *matrix, which has room for *room by *room; returns 0 where the
 * memory does not suffice. */
int BGC_KIND(bgc_make_room)(bgc_scalar **matrix, size_t *room, size_t n) {
    if (*matrix != NULL && n <= *room) {
        return 1;
    }
    free(*matrix);
    *matrix = calloc(n * n + 1, sizeof **matrix);
    *room = *matrix != NULL ? n : 0;
    return *matrix != NULL;
}

/* Factorises the finite n by n matrix a in place: Gaussian elimination with scaled partial pivoting, so
 * that units do not choose the pivots. Returns -1, or the first state that the rows do not determine.
 * weight is scratch. */
int BGC_KIND(bgc_factorise_dense)(int n, bgc_scalar *a, int *pivot, double *weight) {
    /* Row scales. */
    for (int i = 0; i < n; i++) {
        const bgc_scalar *row = a + (size_t)i * (size_t)n;
        double largest = 0.0;
        for (int j = 0; j < n; j++) {
            largest = fmax(largest, kind_size(row[j]));
        }
        weight[i] = largest > 0.0 ? 1.0 / largest : 0.0;
    }
    for (int k = 0; k < n; k++) {
        bgc_scalar *top = a + (size_t)k * (size_t)n;
        int best = k;
        double size = -1.0;

        /* The largest scaled pivot of the column, and its row. */
        for (int i = k; i < n; i++) {
            const double candidate = kind_size(a[(size_t)i * (size_t)n + (size_t)k]) * weight[i];
            if (candidate > size) {
                size = candidate;
                best = i;
            }
        }
        if (!(size > 0.0) || !isfinite(size)) {
            return k;
        }
        pivot[k] = best;
        if (best != k) {
            bgc_scalar *other = a + (size_t)best * (size_t)n;
            for (int j = 0; j < n; j++) {
                const bgc_scalar swap = top[j];
                top[j] = other[j];
                other[j] = swap;
            }
            weight[best] = weight[k];
        }

        /* Eliminate below the pivot. */
        for (int i = k + 1; i < n; i++) {
            bgc_scalar *row = a + (size_t)i * (size_t)n;
            if (!kind_is_zero(row[k])) {
                row[k] = kind_over(row[k], top[k]);
                for (int j = k + 1; j < n; j++) {
                    row[j] = kind_minus_product(row[j], row[k], top[j]);
                }
            }
        }
    }
    return -1;
}

/* b := a^-1 b, with the factors of bgc_factorise_dense. */
void BGC_KIND(bgc_solve_dense)(int n, const bgc_scalar *lu, const int *pivot, bgc_scalar *b) {
    for (int k = 0; k < n; k++) {
        const bgc_scalar swap = b[k];
        b[k] = b[pivot[k]];
        b[pivot[k]] = swap;
    }
    /* Forward, then backward substitution. */
    for (int i = 1; i < n; i++) {
        const bgc_scalar *row = lu + (size_t)i * (size_t)n;
        for (int j = 0; j < i; j++) {
            b[i] = kind_minus_product(b[i], row[j], b[j]);
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        const bgc_scalar *row = lu + (size_t)i * (size_t)n;
        for (int j = i + 1; j < n; j++) {
            b[i] = kind_minus_product(b[i], row[j], b[j]);
        }
        b[i] = kind_over(b[i], row[i]);
    }
}
