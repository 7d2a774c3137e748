/* bgc_inverse.h: the inverse of a matrix of parameters, computed when parameters are set.
 *
 * compiler/algebra/double_inverse.py computes the same numbers.
 */
#ifndef BGC_INVERSE_H
#define BGC_INVERSE_H

#include <math.h>

/* The row from `first` on whose entry of column `first` is largest in terms of its scale. */
static inline int bgc_pivot_row(const double *a, const double *scale, int n, int first) {
    double largest = -1.0;
    int chosen = first;

    for (int i = first; i < n; i++) {
        const double share = scale[i] > 0.0 ? fabs(a[i * n + first]) / scale[i] : 0.0;

        if (share > largest) {
            largest = share;
            chosen = i;
        }
    }
    return chosen;
}

static inline void bgc_exchange(double *a, double *b, int count, int stride) {
    for (int k = 0; k < count; k++) {
        const double kept = a[k * stride];

        a[k * stride] = b[k * stride];
        b[k * stride] = kept;
    }
}

/*
 * Inverts the n x n matrix a in place, by Gauss-Jordan elimination; w has n (n + 2) elements. All entries become
 * NaN where the matrix is singular but for rounding: where a pivot is less than 2^-48 of the terms it is the sum of.
 */
static inline void bgc_invert(double *a, int n, double *w) {
    double *terms = w, *scale = w + n * n, *chosen = scale + n;

    for (int i = 0; i < n; i++) {
        scale[i] = 0.0;
        for (int j = 0; j < n; j++) {
            terms[i * n + j] = fabs(a[i * n + j]);
            if (terms[i * n + j] > scale[i]) {
                scale[i] = terms[i * n + j];
            }
        }
    }
    for (int k = 0; k < n; k++) {
        const int row = bgc_pivot_row(a, scale, n, k);
        double *own = a + k * n;
        double pivot;

        chosen[k] = row;
        if (row != k) {
            bgc_exchange(own, a + row * n, n, 1);
            bgc_exchange(terms + k * n, terms + row * n, n, 1);
            bgc_exchange(scale + k, scale + row, 1, 1);
        }
        pivot = own[k];
        if (!(fabs(pivot) > 0x1p-48 * terms[k * n + k])) {
            for (int j = 0; j < n * n; j++) {
                a[j] = (double)NAN;
            }
            return;
        }
        own[k] = 1.0;
        for (int j = 0; j < n; j++) {
            own[j] /= pivot;
        }
        for (int i = 0; i < n; i++) {
            double *other = a + i * n;
            const double factor = other[k];

            if (i == k || factor == 0.0) {
                continue;
            }
            other[k] = 0.0;
            for (int j = 0; j < n; j++) {
                other[j] -= factor * own[j];
            }
            for (int j = 0; i > k && j < n; j++) {
                terms[i * n + j] += fabs(factor * own[j]);
            }
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        if ((int)chosen[k] != k) {
            bgc_exchange(a + k, a + (int)chosen[k], n, n);
        }
    }
}

#endif
