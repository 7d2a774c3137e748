/* blocks.c: LU factors of W in blocks of rows.
 *
 * A block is a group of at most 8 rows and columns that follow each other in the order of elimination
 * and have almost the same pattern: the compiler pads them to the same (emission/blocks.py). A column
 * of a block is one vector over its rows, so that nothing is gathered, scattered or transposed. The
 * factors of a block lie in lu one column after another: its columns of L, left of the block; N, the
 * inverse of its unit lower triangle with the exchanges of rows within the block; V, the inverse of its
 * upper triangle; its columns of U, right of it. A block of one row has no N. Triangles
 * of blocks are inverted since substitution would be a chain of dependent operations. N and V apart
 * lose no digits where a block is ill-conditioned, its inverse as a whole would.
 *
 * Blocks are factorised one after another. `sheet` has 8 doubles for each column of W: those of the
 * columns of one block. For each block s with entries left of the block, L = sheet[s] V_s, and
 * sheet[c] -= L U_s[c] for the columns c right of s. Pivots within a block are first those of the
 * diagonal. Where they let the entries of the block grow, its rows are exchanged (block_pivots.c); that
 * changes no pattern.
 */
#include "bgc_internal.h"
#include "block_vectors.h"
#include "blocks.h"

#include <math.h>

/* b := W^-1 b takes vectors in the order of blocks, where a block begins at a multiple of the size of its
 * columns: all loads and stores are of full columns. Entries between blocks are never used. */

/* Multipliers in the elimination of a block, with its columns in the units of the states and its rows
 * scaled to the same size, above which rows are exchanged: three of sixteen digits may be lost, and
 * exchanges are rare. */
static const double largest_multiplier = 1e3;

static const double below_diagonal[8][8] = {
    {0, 1, 1, 1, 1, 1, 1, 1}, {0, 0, 1, 1, 1, 1, 1, 1}, {0, 0, 0, 1, 1, 1, 1, 1},
    {0, 0, 0, 0, 1, 1, 1, 1}, {0, 0, 0, 0, 0, 1, 1, 1}, {0, 0, 0, 0, 0, 0, 1, 1},
    {0, 0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 0, 0},
};
static const double on_diagonal[8][8] = {
    {1, 0, 0, 0, 0, 0, 0, 0}, {0, 1, 0, 0, 0, 0, 0, 0}, {0, 0, 1, 0, 0, 0, 0, 0},
    {0, 0, 0, 1, 0, 0, 0, 0}, {0, 0, 0, 0, 1, 0, 0, 0}, {0, 0, 0, 0, 0, 1, 0, 0},
    {0, 0, 0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 0, 0, 1},
};

/* Kernels for columns of type T with n doubles. Numbers of rows and of columns of other blocks are
 * constants where they are called, so that loops over them leave no code and vectors stay in
 * registers.
 *
 * clear: the columns of a block and of its lists, 0.
 * update: one block `s` with w columns, wide doubles each: L at keep, then the columns right of it.
 * gather: the same for all blocks left of a block; returns the end of its L.
 * invert: N and V at to, of a block with r rows; returns the growth of its pivots, or infinity where
 *     rows of more than one have to be exchanged. The size of a row is the root of its sum of squares.
 * carry: U at to.
 * forward, backward: of one block in a solution. */
#define BGC_BLOCK_KERNELS(T, n)                                                                \
    static void clear_##T(const bgc_block_info *info, const bgc_block *b, double *sheet) {     \
        const T zero = load_##T(below_diagonal[7]);                                            \
        for (int e = b->left; e < b[1].left; e++) {                                            \
            const bgc_block *s = info->block + info->left[e];                                  \
            for (int k = 0; k < s->rows; k++) {                                                \
                store_##T(sheet + 8 * (s->at + k), zero);                                      \
            }                                                                                  \
        }                                                                                      \
        for (int k = 0; k < b->rows; k++) {                                                    \
            store_##T(sheet + 8 * (b->at + k), zero);                                          \
        }                                                                                      \
        for (int e = b->right; e < b[1].right; e++) {                                          \
            store_##T(sheet + 8 * info->right[e], zero);                                       \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void update_##T(const int w, const int wide, const double *restrict inverse,    \
                               const int *restrict column, int count, double *restrict sheet,  \
                               const double *restrict from, double *restrict keep) {           \
        const double *restrict upper = inverse + w * wide;                                     \
        T left[8];                                                                             \
        BGC_UNROLL for (int k = 0; k < w; k++) {                                               \
            left[k] = load_##T(from + 8 * k);                                                  \
        }                                                                                      \
        BGC_UNROLL for (int k = w - 1; k >= 0; k--) {                                          \
            T sum = times_##T(left[k], inverse[k * wide + k]);                                 \
            BGC_UNROLL for (int j = 0; j < k; j++) {                                           \
                sum = plus_##T(sum, left[j], inverse[k * wide + j]);                           \
            }                                                                                  \
            left[k] = sum;                                                                     \
            store_##T(keep + k * (n), sum);                                                    \
        }                                                                                      \
        for (int e = 0; e < count; e++) {                                                      \
            double *at = sheet + 8 * column[e];                                                \
            T sum = load_##T(at);                                                              \
            BGC_UNROLL for (int k = 0; k < w; k++) {                                           \
                sum = minus_##T(sum, left[k], upper[e * wide + k]);                            \
            }                                                                                  \
            store_##T(at, sum);                                                                \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    static BGC_NEVER double *gather_##T(const bgc_block_info *info, const bgc_block *b,        \
                                        const double *lu, double *sheet, double *keep) {       \
        for (int e = b->left; e < b[1].left; e++) {                                            \
            const bgc_block *s = info->block + info->left[e];                                  \
            const int *column = info->right + s->right, count = s[1].right - s->right;         \
            const double *inverse = lu + s->upper, *from = sheet + 8 * s->at;                  \
            switch (s->rows) {                                                                 \
            case 1: update_##T(1, 1, inverse, column, count, sheet, from, keep); break;        \
            case 2: update_##T(2, 2, inverse, column, count, sheet, from, keep); break;        \
            case 3: update_##T(3, 4, inverse, column, count, sheet, from, keep); break;        \
            case 4: update_##T(4, 4, inverse, column, count, sheet, from, keep); break;        \
            case 5: update_##T(5, 8, inverse, column, count, sheet, from, keep); break;        \
            case 6: update_##T(6, 8, inverse, column, count, sheet, from, keep); break;        \
            case 7: update_##T(7, 8, inverse, column, count, sheet, from, keep); break;        \
            default: update_##T(8, 8, inverse, column, count, sheet, from, keep);              \
            }                                                                                  \
            keep += s->rows * (n);                                                             \
        }                                                                                      \
        return keep;                                                                           \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS double invert_##T(const int r, const double *from, const double *size,          \
                                 const double *unit, double *to) {                             \
        const int inner = r > 1 ? r : 0;                                                       \
        T lower[8], upper[8], inverse[8], of_row = load_##T(below_diagonal[7]), grown = of_row;\
        double reciprocal[8], growth = 0.0, part[8], multipliers = 0.0;                        \
        BGC_UNROLL for (int k = 0; k < inner; k++) {                                           \
            const T x = times_##T(load_##T(from + 8 * k), unit[k]);                            \
            of_row = add_##T(of_row, product_##T(x, x));                                       \
        }                                                                                      \
        BGC_UNROLL for (int k = 0; k < r; k++) {                                               \
            const double before = fabs(from[8 * k + k]);                                       \
            T x = load_##T(from + 8 * k);                                                      \
            BGC_UNROLL for (int j = 0; j < k; j++) {                                           \
                x = minus_at_##T(x, lower[j], x, j);                                           \
            }                                                                                  \
            reciprocal[k] = 1.0 / get_##T(x, k);                                               \
            growth += (size[k] > before ? size[k] : before) * fabs(reciprocal[k]);             \
            upper[k] = x;                                                                      \
            lower[k] = times_##T(product_##T(x, load_##T(below_diagonal[k])), reciprocal[k]);  \
            grown = plus_at_##T(grown, product_##T(lower[k], lower[k]), of_row, k);            \
        }                                                                                      \
        store_##T(part, quotient_##T(grown, of_row));                                          \
        BGC_UNROLL for (int k = 0; k < inner; k++) {                                           \
            multipliers += part[k];                                                            \
        }                                                                                      \
        if (!(multipliers <= largest_multiplier * largest_multiplier)) {                       \
            return (double)INFINITY;                                                           \
        }                                                                                      \
        BGC_UNROLL for (int k = inner - 1; k >= 0; k--) {                                      \
            T sum = times_##T(lower[k], -1.0);                                                 \
            BGC_UNROLL for (int j = k + 1; j < r; j++) {                                       \
                sum = minus_at_##T(sum, inverse[j], lower[k], j);                              \
            }                                                                                  \
            inverse[k] = sum;                                                                  \
            store_##T(to + k * (n), add_##T(sum, load_##T(on_diagonal[k])));                   \
        }                                                                                      \
        to += r > 1 ? r * (n) : 0;                                                             \
        BGC_UNROLL for (int k = 0; k < r; k++) {                                               \
            T sum = load_##T(on_diagonal[k]);                                                  \
            BGC_UNROLL for (int j = 0; j < k; j++) {                                           \
                sum = minus_at_##T(sum, inverse[j], upper[k], j);                              \
            }                                                                                  \
            inverse[k] = times_##T(sum, reciprocal[k]);                                        \
            store_##T(to + k * (n), inverse[k]);                                               \
        }                                                                                      \
        return growth;                                                                         \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void carry_##T(const int r, const double *restrict lower,                       \
                              const int *restrict column, int count,                           \
                              const double *restrict sheet, double *restrict to) {             \
        const int inner = r > 1 ? r : 0;                                                       \
        T across[8] = {load_##T(below_diagonal[7])};                                           \
        BGC_UNROLL for (int k = 0; k < inner; k++) {                                           \
            across[k] = load_##T(lower + k * (n));                                             \
        }                                                                                      \
        for (int e = 0; e < count; e++) {                                                      \
            const double *x = sheet + 8 * column[e];                                           \
            T sum = r > 1 ? times_##T(across[0], x[0]) : load_##T(x);                          \
            BGC_UNROLL for (int k = 1; k < inner; k++) {                                       \
                sum = plus_##T(sum, across[k], x[k]);                                          \
            }                                                                                  \
            store_##T(to + e * (n), sum);                                                      \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void forward_##T(const int r, const bgc_block_info *info, const bgc_block *b,   \
                                const double *lu, double *restrict y) {                        \
        const int inner = r > 1 ? r : 0;                                                       \
        const double *l = lu + b->factors;                                                     \
        T even = load_##T(below_diagonal[7]), odd = even, x;                                   \
        for (int e = b->left; e < b[1].left; e++) {                                            \
            const bgc_block *s = info->block + info->left[e];                                  \
            const double *of = y + s->at;                                                      \
            int k = 0;                                                                         \
            for (; k + 2 <= s->rows; k += 2, l += 2 * (n)) {                                   \
                even = plus_##T(even, load_##T(l), of[k]);                                     \
                odd = plus_##T(odd, load_##T(l + (n)), of[k + 1]);                             \
            }                                                                                  \
            if (k < s->rows) {                                                                 \
                even = plus_##T(even, load_##T(l), of[k]);                                     \
                l += (n);                                                                      \
            }                                                                                  \
        }                                                                                      \
        x = minus_##T(load_##T(y + b->at), add_##T(even, odd), 1.0);                           \
        odd = load_##T(below_diagonal[7]);                                                     \
        even = r > 1 ? odd : x;                                                                \
        BGC_UNROLL for (int k = 0; k < inner; k += 2) {                                        \
            even = plus_at_##T(even, load_##T(l + k * (n)), x, k);                             \
            if (k + 1 < r) {                                                                   \
                odd = plus_at_##T(odd, load_##T(l + (k + 1) * (n)), x, k + 1);                 \
            }                                                                                  \
        }                                                                                      \
        store_##T(y + b->at, add_##T(even, odd));                                              \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void backward_##T(const int r, const bgc_block_info *info, const bgc_block *b,  \
                                 const double *lu, double *restrict y) {                       \
        const double *inverse = lu + b->upper, *u = inverse + r * (n);                         \
        const int *column = info->right + b->right, count = b[1].right - b->right;             \
        T one = load_##T(below_diagonal[7]), two = one, three = one, four = one;               \
        int e = 0;                                                                             \
        for (; e + 4 <= count; e += 4, u += 4 * (n)) {                                         \
            one = plus_##T(one, load_##T(u), y[column[e]]);                                    \
            two = plus_##T(two, load_##T(u + (n)), y[column[e + 1]]);                          \
            three = plus_##T(three, load_##T(u + 2 * (n)), y[column[e + 2]]);                  \
            four = plus_##T(four, load_##T(u + 3 * (n)), y[column[e + 3]]);                    \
        }                                                                                      \
        for (; e < count; e++, u += (n)) {                                                     \
            one = plus_##T(one, load_##T(u), y[column[e]]);                                    \
        }                                                                                      \
        one = add_##T(add_##T(one, two), add_##T(three, four));                                \
        two = minus_##T(load_##T(y + b->at), one, 1.0);                                        \
        one = three = load_##T(below_diagonal[7]);                                             \
        BGC_UNROLL for (int k = 0; k < r; k += 2) {                                            \
            one = plus_at_##T(one, load_##T(inverse + k * (n)), two, k);                       \
            if (k + 1 < r) {                                                                   \
                three = plus_at_##T(three, load_##T(inverse + (k + 1) * (n)), two, k + 1);     \
            }                                                                                  \
        }                                                                                      \
        store_##T(y + b->at, add_##T(one, three));                                             \
    }

BGC_BLOCK_KERNELS(rows1, 1)
BGC_BLOCK_KERNELS(rows2, 2)
BGC_BLOCK_KERNELS(rows4, 4)
BGC_BLOCK_KERNELS(rows8, 8)

/* Runs DO(T, n, r) with the constants of a block with this many rows. */
#define BGC_OF_ROWS(rows, DO)                                                                  \
    switch (rows) {                                                                            \
    case 1: DO(rows1, 1, 1); break;                                                            \
    case 2: DO(rows2, 2, 2); break;                                                            \
    case 3: DO(rows4, 4, 3); break;                                                            \
    case 4: DO(rows4, 4, 4); break;                                                            \
    case 5: DO(rows8, 8, 5); break;                                                            \
    case 6: DO(rows8, 8, 6); break;                                                            \
    case 7: DO(rows8, 8, 7); break;                                                            \
    default: DO(rows8, 8, 8);                                                                  \
    }

/* Adds the rows of a block of W = c M - J to its sheet; size[k] := the sum of the absolute values of
 * the terms of entry k of the diagonal. */
static void load_block(const bgc_model *m, const bgc_block *b, const double *restrict mass,
                       const double *restrict jac, double c, double *restrict sheet,
                       double *restrict size) {
    const bgc_block_info *info = m->blocks;
    const int *restrict entry = info->jac, *restrict to = info->jac_to, end = b[1].jac;
    double *at = sheet + 8 * b->at;

    for (int e = b->mass; e < b[1].mass; e++) {
        sheet[info->mass_to[e]] += m->n_mass > 0 ? c * mass[info->mass[e]] : c;
    }
    for (int k = 0; k < b->rows; k++) {
        size[k] = at[8 * k + k];
    }
    BGC_UNROLL for (int e = b->jac; e < end; e++) {
        sheet[to[e]] -= jac[entry[e]];
    }
    for (int k = 0; k < b->rows; k++) {
        size[k] = fabs(size[k]) + fabs(size[k] - at[8 * k + k]);
    }
}

/* Exchanges rows of a block whose pivots grow; returns the growth, which is not finite where no
 * exchange helps. */
static BGC_NEVER double exchange_rows(const bgc_block *b, const double *from, const double *size,
                                      const double *unit, double *to) {
    const int wide = bgc_column_size(b->rows);
    bgc_complex block[64], lower[64], upper[64];
    double growth;

    for (int k = 0; k < b->rows; k++) {
        for (int i = 0; i < b->rows; i++) {
            block[8 * k + i] = (bgc_complex){from[8 * k + i], 0.0};
        }
    }
    growth = bgc_pivot_block(b->rows, block, size, unit, lower, upper);
    if (!isfinite(growth)) {
        return growth;
    }
    for (int k = 0; k < b->rows; k++) {
        for (int i = 0; i < b->rows; i++) {
            to[k * wide + i] = lower[8 * k + i].re;
            to[(b->rows + k) * wide + i] = upper[8 * k + i].re;
        }
    }
    return growth;
}

/* Factorises W = c M - J as bgc_model.factor does, with the scales of the unknowns; scratch is 9 n_place
 * doubles. */
int bgc_block_factor(const bgc_model *m, const double *scale, const double *mass,
                     const double *jac, double c, double *lu, double *growth, double *scratch) {
    const bgc_block_info *info = m->blocks;
    double *sheet = scratch, *unit = scratch + 8 * (size_t)info->n_place, sum = 0.0;

    bgc_order_units(m, scale, unit);
    for (const bgc_block *b = info->block; b < info->block + info->n_block; b++) {
        const int *column = info->right + b->right, count = b[1].right - b->right;
        const double *from = sheet + 8 * b->at;
        double *to = lu + b->factors, size[8], part;

#define CLEAR(T, n, r) clear_##T(info, b, sheet)
        BGC_OF_ROWS(b->rows, CLEAR)
        load_block(m, b, mass, jac, c, sheet, size);
#define ELIMINATE(T, n, r)                                                                     \
    do {                                                                                       \
        to = gather_##T(info, b, lu, sheet, to);                                               \
        part = invert_##T(r, from, size, unit + b->at, to);                                    \
        if (r > 1 && !(part <= bgc_block_growth)) {                                            \
            part = exchange_rows(b, from, size, unit + b->at, to);                             \
        }                                                                                      \
        carry_##T(r, to, column, count, sheet, to + (r > 1 ? 2 : 1) * r * (n));                \
    } while (0)
        BGC_OF_ROWS(b->rows, ELIMINATE)
        sum += part;
    }
    *growth = sum;
    return sum < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b, with inner unknowns; scratch is 9 n_place doubles. */
void bgc_block_solve(const bgc_model *m, const double *lu, double *b, double *scratch) {
    const bgc_block_info *info = m->blocks;
    const bgc_block *end = info->block + info->n_block;
    const int n = bgc_unknowns(m);
    double *y = scratch;

    for (int k = 0; k < n; k++) {
        y[info->row_place[k]] = b[k];
    }
    for (const bgc_block *at = info->block; at < end; at++) {
#define FORWARD(T, n, r) forward_##T(r, info, at, lu, y)
        BGC_OF_ROWS(at->rows, FORWARD)
    }
    for (const bgc_block *at = end; at-- > info->block;) {
#define BACKWARD(T, n, r) backward_##T(r, info, at, lu, y)
        BGC_OF_ROWS(at->rows, BACKWARD)
    }
    for (int k = 0; k < n; k++) {
        b[k] = y[info->col_place[k]];
    }
}
