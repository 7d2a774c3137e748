/* blocks.h: what the real and the complex factors in blocks of rows share. */
#ifndef BGC_BLOCKS_H
#define BGC_BLOCKS_H

#include "bgc_internal.h"

/* Growth of the pivots of a block above which its rows are exchanged. It is the number of its rows
 * where no pivot cancels; exchanges cost some hundred operations, and are rare. */
static const double bgc_block_growth = 1e3;

/* Inverts the triangles of a block of r rows with scaled partial pivoting. Entry (i, k) of the block and
 * of the results is at 8 k + i. `lower` is the inverse of the unit lower triangle, with the exchange of
 * rows; `upper` that of the upper triangle. size[k]: sum of the absolute values
 * of the terms of entry k of the diagonal; unit[k]: the scale of the state of column k. Returns the sum over the pivots of the size of a pivot's
 * entry over the pivot; infinite where the block is singular. */
double bgc_pivot_block(int r, bgc_complex *block, const double *size, const double *unit,
                       bgc_complex *lower, bgc_complex *upper);

/* The scales of the unknowns in the order of the columns of blocks, so that their units choose no
 * pivots. The scale of an inner unknown is 0 where it is not known. */
static inline void bgc_order_units(const bgc_model *m, const double *scale, double *unit) {
    for (int k = 0; k < bgc_unknowns(m); k++) {
        unit[m->blocks->col_place[k]] = scale[k] > 0.0 ? scale[k] : 1.0;
    }
}

#endif
