/* block_pivots.c: exchanges of rows within a block of W whose diagonal pivots are small. */
#include "bgc_internal.h"
#include "blocks.h"
#include "complex_numbers.h"

#include <math.h>

/* The row with the largest scaled pivot of column k from row k on, or -1. */
static int largest_in_column(int r, const bgc_complex *block, const double *weight, int k) {
    double largest = 0.0;
    int best = -1;

    for (int i = k; i < r; i++) {
        const double candidate = bgc_size_of(block[8 * k + i]) * weight[i];
        if (candidate > largest && isfinite(candidate)) {
            largest = candidate;
            best = i;
        }
    }
    return best;
}

/* Exchanges rows k and p of the block, and what belongs to them. */
static void exchange(int r, bgc_complex *block, double *weight, int *origin, int k, int p) {
    const double weight_of_p = weight[p];
    const int origin_of_p = origin[p];

    weight[p] = weight[k];
    weight[k] = weight_of_p;
    origin[p] = origin[k];
    origin[k] = origin_of_p;
    for (int j = 0; j < r; j++) {
        const bgc_complex swap = block[8 * j + k];
        block[8 * j + k] = block[8 * j + p];
        block[8 * j + p] = swap;
    }
}

/* The LU factors of the block, in place; the diagonal holds reciprocals of pivots. Row k of the factors
 * is row origin[k] of the block. Returns the growth, as blocks.h says. */
static double factorise_pivoted(int r, bgc_complex *block, const double *size,
                                const double *unit, int *origin) {
    double weight[8], entry[64], growth = 0.0;

    for (int i = 0; i < r; i++) {
        double largest = 0.0;
        for (int k = 0; k < r; k++) {
            entry[8 * k + i] = bgc_size_of(block[8 * k + i]);
            largest = fmax(largest, entry[8 * k + i] * unit[k]);
        }
        weight[i] = largest > 0.0 ? 1.0 / largest : 0.0;
        origin[i] = i;
    }
    for (int k = 0; k < r; k++) {
        bgc_complex *column = block + 8 * k;
        const int best = largest_in_column(r, block, weight, k);
        double before;

        if (best < 0) {
            return (double)INFINITY;
        }
        exchange(r, block, weight, origin, k, best);
        before = fmax(origin[k] == k ? size[k] : 0.0, entry[8 * k + origin[k]]);
        column[k] = bgc_reciprocal(column[k]);
        growth += before * bgc_size_of(column[k]);
        for (int i = k + 1; i < r; i++) {
            column[i] = bgc_times(column[i], column[k]);
            for (int j = k + 1; j < r; j++) {
                block[8 * j + i] = bgc_minus(block[8 * j + i], bgc_times(column[i], block[8 * j + k]));
            }
        }
    }
    return growth;
}

double bgc_pivot_block(int r, bgc_complex *block, const double *size, const double *unit,
                       bgc_complex *lower, bgc_complex *upper) {
    int origin[8];
    const double growth = factorise_pivoted(r, block, size, unit, origin);

    for (int k = 0; k < r && isfinite(growth); k++) {
        /* Column origin[k] of the inverse of L by forward substitution from unit vector k, */
        bgc_complex *x = lower + 8 * origin[k], *u = upper + 8 * k;
        for (int i = 0; i < r; i++) {
            x[i] = (bgc_complex){i == k, 0.0};
            for (int j = k; j < i; j++) {
                x[i] = bgc_minus(x[i], bgc_times(block[8 * j + i], x[j]));
            }
        }
        /* and column k of the inverse of U by backward substitution. */
        for (int i = r; i-- > 0;) {
            u[i] = (bgc_complex){i == k, 0.0};
            for (int j = i + 1; j <= k; j++) {
                u[i] = bgc_minus(u[i], bgc_times(block[8 * j + i], u[j]));
            }
            u[i] = bgc_times(u[i], block[8 * i + i]);
        }
    }
    return growth;
}
