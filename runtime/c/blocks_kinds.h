/* blocks_kinds.h: factors in blocks of rows and solutions with them, by the kernels of blocks.c. */
#include "kind.h"

/* Adds the rows of a block of W = c M - J to its sheet; size[k] := the sum of the sizes of the terms of
 * entry k of the diagonal. */
static void BGC_KIND(load_block)(const bgc_model *m, const bgc_block *b,
                                 const double *restrict mass, const double *restrict jac,
                                 bgc_scalar c, double *restrict sheet, double *restrict size) {
    const bgc_block_info *info = m->blocks;
    const int *restrict entry = info->jac, *restrict to = info->jac_to, end = b[1].jac;
    double *at = sheet + BGC_KIND(BGC_COLUMN) * b->at;

    for (int e = b->mass; e < b[1].mass; e++) {
        BGC_KIND(add_entry)(sheet + BGC_KIND(in_sheet)(info->mass_to[e]),
                            m->n_mass > 0 ? kind_scaled(mass[info->mass[e]], c) : c);
    }
    for (int k = 0; k < b->rows; k++) {
        size[k] = at[BGC_KIND(BGC_COLUMN) * k + k];
    }
    BGC_UNROLL for (int e = b->jac; e < end; e++) {
        sheet[BGC_KIND(in_sheet)(to[e])] -= jac[entry[e]];
    }
    for (int k = 0; k < b->rows; k++) {
        const bgc_scalar sum = BGC_KIND(get_entry)(at + BGC_KIND(BGC_COLUMN) * k, k, 8);
        size[k] = kind_size(kind_with_re(sum, size[k])) + fabs(size[k] - kind_re(sum));
    }
}

/* N, of more than one row, and V of a block with exchanges of its rows; returns the growth, which is not
 * finite where no exchange helps. */
static BGC_NEVER double BGC_KIND(exchange_rows)(const bgc_block *b, const double *from,
                                                const double *size, const double *unit,
                                                double *to) {
    const int r = b->rows, n = bgc_column_size(r);
    bgc_complex block[64], inverse[2][64];
    double growth;

    for (int k = 0; k < r; k++) {
        for (int i = 0; i < r; i++) {
            block[8 * k + i] =
                BGC_KIND(widened)(BGC_KIND(get_entry)(from + BGC_KIND(BGC_COLUMN) * k, i, 8));
        }
    }
    growth = bgc_pivot_block(r, block, size, unit, inverse[0], inverse[1]);
    if (!isfinite(growth)) {
        return growth;
    }
    for (int half = r > 1 ? 0 : 1; half < 2; half++) {
        for (int k = 0; k < r; k++, to += n * BGC_KIND(BGC_COLUMN) / 8) {
            for (int i = 0; i < r; i++) {
                BGC_KIND(set_entry)(to, i, n, BGC_KIND(narrowed)(inverse[half][8 * k + i]));
            }
        }
    }
    return growth;
}

/* Factorises W = c M - J as bgc_model.factor does, with the scales of the unknowns; scratch is
 * BGC_COLUMN + 1 doubles for each place. */
int BGC_KIND(bgc_block_factor)(const bgc_model *m, const double *scale, const double *mass,
                               const double *jac, bgc_scalar c, bgc_scalar *factors,
                               double *growth, double *scratch) {
    const bgc_block_info *info = m->blocks;
    double *lu = (double *)(void *)factors, *sheet = scratch, sum = 0.0;
    double *unit = scratch + BGC_KIND(BGC_COLUMN) * (size_t)info->n_place;

    bgc_order_units(m, scale, unit);
    for (const bgc_block *b = info->block; b < info->block + info->n_block; b++) {
        const int *column = info->right + b->right, count = b[1].right - b->right;
        const double *from = sheet + BGC_KIND(BGC_COLUMN) * b->at;
        double *to = lu + BGC_KIND(BGC_COLUMN) / 8 * b->factors, size[8], part;

        BGC_KIND(BGC_OF_ROWS)(b->rows, BGC_CLEAR)
        BGC_KIND(load_block)(m, b, mass, jac, c, sheet, size);
        BGC_KIND(BGC_OF_ROWS)(b->rows, BGC_KIND(BGC_ELIMINATE))
        sum += part;
    }
    *growth = sum;
    return sum < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b, with inner unknowns; scratch is as much. */
void BGC_KIND(bgc_block_solve)(const bgc_model *m, const bgc_scalar *factors, bgc_scalar *b,
                               double *scratch) {
    const bgc_block_info *info = m->blocks;
    const bgc_block *end = info->block + info->n_block;
    const double *lu = (const double *)(const void *)factors;
    const int n = bgc_unknowns(m), gap = info->n_place;
    double *y = scratch;

    for (int k = 0; k < n; k++) {
        BGC_KIND(set_entry)(y, info->row_place[k], gap, b[k]);
    }
    for (const bgc_block *at = info->block; at < end; at++) {
        BGC_KIND(BGC_OF_ROWS)(at->rows, BGC_FORWARD)
    }
    for (const bgc_block *at = end; at-- > info->block;) {
        BGC_KIND(BGC_OF_ROWS)(at->rows, BGC_BACKWARD)
    }
    for (int k = 0; k < n; k++) {
        b[k] = BGC_KIND(get_entry)(y, info->col_place[k], gap);
    }
}
