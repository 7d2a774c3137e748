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

/* --- columns ------------------------------------------------------------------------------------ */

/* Entry k of a column: one of complex numbers is one of real parts, and `gap` doubles behind it one of
 * imaginary parts: in lu the number of rows behind, in the sheet 8, in a solution n_place. */
static inline double get_entry(const double *from, int k, int gap) { return (void)gap, from[k]; }
static inline bgc_complex get_entry_complex(const double *from, int k, int gap) {
    return (bgc_complex){from[k], from[gap + k]};
}

/* Functions of a column that are not in block_vectors.h: 0, load, store, a - b. */
#define BGC_REAL_COLUMN(T)                                                                     \
    BGC_ALWAYS T zero_##T(void) { return load_##T(below_diagonal[7]); }                        \
    BGC_ALWAYS T take_##T(const double *from, int gap) { return (void)gap, load_##T(from); }   \
    BGC_ALWAYS void put_##T(double *to, int gap, T x) { (void)gap, store_##T(to, x); }         \
    BGC_ALWAYS T less_##T(T a, T b) { return minus_##T(a, b, 1.0); }

BGC_REAL_COLUMN(rows1)
BGC_REAL_COLUMN(rows2)
BGC_REAL_COLUMN(rows4)
BGC_REAL_COLUMN(rows8)

/* The complex column Z of two of type T. */
#define BGC_COMPLEX_COLUMN(Z, T)                                                               \
    typedef struct {                                                                           \
        T re, im;                                                                              \
    } Z;                                                                                       \
    BGC_ALWAYS Z zero_##Z(void) { return (Z){zero_##T(), zero_##T()}; }                        \
    BGC_ALWAYS Z take_##Z(const double *from, int gap) {                                       \
        return (Z){load_##T(from), load_##T(from + gap)};                                      \
    }                                                                                          \
    BGC_ALWAYS void put_##Z(double *to, int gap, Z x) {                                        \
        store_##T(to, x.re);                                                                   \
        store_##T(to + gap, x.im);                                                             \
    }                                                                                          \
    BGC_ALWAYS Z add_##Z(Z a, Z b) { return (Z){add_##T(a.re, b.re), add_##T(a.im, b.im)}; }   \
    BGC_ALWAYS Z less_##Z(Z a, Z b) { return (Z){less_##T(a.re, b.re), less_##T(a.im, b.im)}; } \
    BGC_ALWAYS Z plus_##Z(Z sum, Z x, bgc_complex s) {                                         \
        return (Z){minus_##T(plus_##T(sum.re, x.re, s.re), x.im, s.im),                        \
                   plus_##T(plus_##T(sum.im, x.re, s.im), x.im, s.re)};                        \
    }                                                                                          \
    BGC_ALWAYS Z minus_##Z(Z sum, Z x, bgc_complex s) {                                        \
        return plus_##Z(sum, x, (bgc_complex){-s.re, -s.im});                                  \
    }                                                                                          \
    BGC_ALWAYS Z times_##Z(Z x, bgc_complex s) { return plus_##Z(zero_##Z(), x, s); }          \
    BGC_ALWAYS Z plus_at_##Z(Z sum, Z x, Z e, const int k) {                                   \
        return plus_##Z(sum, x, (bgc_complex){get_##T(e.re, k), get_##T(e.im, k)});            \
    }

BGC_COMPLEX_COLUMN(complex1, rows1)
BGC_COMPLEX_COLUMN(complex2, rows2)
BGC_COMPLEX_COLUMN(complex4, rows4)
BGC_COMPLEX_COLUMN(complex8, rows8)

/* --- kernels ------------------------------------------------------------------------------------ */

/* Kernels for columns of type C. A column has n numbers of type ENTRY, each of S doubles. UNROLL unrolls a
 * loop, and UPDATE(C, rows, ...) calls update_C for a block with this many rows. For real columns the numbers of
 * rows and columns of other blocks are constants at each call, so that loops over them are unrolled and
 * vectors stay in registers. For complex columns they vary: methods with complex stages are used for
 * reference solutions, and code for each pair of numbers would take the C compiler 2 s.
 *
 * clear: the columns of a block and of its lists, 0.
 * update: one block `s` with w columns, `wide` numbers each: L at keep, then the columns right of it.
 * gather: the same for all blocks left of a block; returns the end of its L.
 * carry: U at to.
 * forward, backward: of one block in a solution. */
#define BGC_BLOCK_KERNELS(C, n, S, ENTRY, UNROLL, UPDATE)                                      \
    static void clear_##C(const bgc_block_info *info, const bgc_block *b, double *sheet) {     \
        const C zero = zero_##C();                                                             \
        for (int e = b->left; e < b[1].left; e++) {                                            \
            const bgc_block *s = info->block + info->left[e];                                  \
            for (int k = 0; k < s->rows; k++) {                                                \
                put_##C(sheet + 8 * (S) * (s->at + k), 8, zero);                               \
            }                                                                                  \
        }                                                                                      \
        for (int k = 0; k < b->rows; k++) {                                                    \
            put_##C(sheet + 8 * (S) * (b->at + k), 8, zero);                                   \
        }                                                                                      \
        for (int e = b->right; e < b[1].right; e++) {                                          \
            put_##C(sheet + 8 * (S) * info->right[e], 8, zero);                                \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void update_##C(const int w, const int wide, const double *restrict inverse,    \
                               const int *restrict column, int count, double *restrict sheet,  \
                               const double *restrict from, double *restrict keep) {           \
        const double *restrict upper = inverse + w * wide * (S);                               \
        C left[8];                                                                             \
        UNROLL for (int k = 0; k < w; k++) {                                                   \
            left[k] = take_##C(from + 8 * (S) * k, 8);                                         \
        }                                                                                      \
        UNROLL for (int k = w - 1; k >= 0; k--) {                                              \
            const double *v = inverse + k * wide * (S);                                        \
            C sum = times_##C(left[k], ENTRY(v, k, wide));                                     \
            UNROLL for (int j = 0; j < k; j++) {                                               \
                sum = plus_##C(sum, left[j], ENTRY(v, j, wide));                               \
            }                                                                                  \
            left[k] = sum;                                                                     \
            put_##C(keep + k * (n) * (S), n, sum);                                             \
        }                                                                                      \
        for (int e = 0; e < count; e++) {                                                      \
            double *at = sheet + 8 * (S) * column[e];                                          \
            C sum = take_##C(at, 8);                                                           \
            UNROLL for (int k = 0; k < w; k++) {                                               \
                sum = minus_##C(sum, left[k], ENTRY(upper + e * wide * (S), k, wide));         \
            }                                                                                  \
            put_##C(at, 8, sum);                                                               \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    static BGC_NEVER double *gather_##C(const bgc_block_info *info, const bgc_block *b,        \
                                        const double *lu, double *sheet, double *keep) {       \
        for (int e = b->left; e < b[1].left; e++) {                                            \
            const bgc_block *s = info->block + info->left[e];                                  \
            const int *column = info->right + s->right, count = s[1].right - s->right;         \
            const double *inverse = lu + (S) * s->upper, *from = sheet + 8 * (S) * s->at;      \
            UPDATE(C, s->rows, inverse, column, count, sheet, from, keep)                      \
            keep += s->rows * (n) * (S);                                                       \
        }                                                                                      \
        return keep;                                                                           \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void carry_##C(const int r, const double *restrict lower,                       \
                              const int *restrict column, int count,                           \
                              const double *restrict sheet, double *restrict to) {             \
        const int inner = r > 1 ? r : 0;                                                       \
        C across[8] = {zero_##C()};                                                            \
        UNROLL for (int k = 0; k < inner; k++) {                                               \
            across[k] = take_##C(lower + k * (n) * (S), n);                                    \
        }                                                                                      \
        for (int e = 0; e < count; e++) {                                                      \
            const double *x = sheet + 8 * (S) * column[e];                                     \
            C sum = r > 1 ? times_##C(across[0], ENTRY(x, 0, 8)) : take_##C(x, 8);             \
            UNROLL for (int k = 1; k < inner; k++) {                                           \
                sum = plus_##C(sum, across[k], ENTRY(x, k, 8));                                \
            }                                                                                  \
            put_##C(to + e * (n) * (S), n, sum);                                               \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void forward_##C(const int r, const bgc_block_info *info, const bgc_block *b,   \
                                const double *lu, double *restrict y) {                        \
        const int inner = r > 1 ? r : 0, gap = info->n_place;                                  \
        const double *l = lu + (S) * b->factors;                                               \
        C even = zero_##C(), odd = even, x;                                                    \
        for (int e = b->left; e < b[1].left; e++) {                                            \
            const bgc_block *s = info->block + info->left[e];                                  \
            const double *of = y + s->at;                                                      \
            int k = 0;                                                                         \
            for (; k + 2 <= s->rows; k += 2, l += 2 * (n) * (S)) {                             \
                even = plus_##C(even, take_##C(l, n), ENTRY(of, k, gap));                      \
                odd = plus_##C(odd, take_##C(l + (n) * (S), n), ENTRY(of, k + 1, gap));        \
            }                                                                                  \
            if (k < s->rows) {                                                                 \
                even = plus_##C(even, take_##C(l, n), ENTRY(of, k, gap));                      \
                l += (n) * (S);                                                                \
            }                                                                                  \
        }                                                                                      \
        x = less_##C(take_##C(y + b->at, gap), add_##C(even, odd));                            \
        odd = zero_##C();                                                                      \
        even = r > 1 ? odd : x;                                                                \
        UNROLL for (int k = 0; k < inner; k += 2) {                                            \
            even = plus_at_##C(even, take_##C(l + k * (n) * (S), n), x, k);                    \
            if (k + 1 < r) {                                                                   \
                odd = plus_at_##C(odd, take_##C(l + (k + 1) * (n) * (S), n), x, k + 1);        \
            }                                                                                  \
        }                                                                                      \
        put_##C(y + b->at, gap, add_##C(even, odd));                                           \
    }                                                                                          \
                                                                                               \
    BGC_ALWAYS void backward_##C(const int r, const bgc_block_info *info, const bgc_block *b,  \
                                 const double *lu, double *restrict y) {                       \
        const double *inverse = lu + (S) * b->upper, *u = inverse + r * (n) * (S);             \
        const int *column = info->right + b->right, count = b[1].right - b->right;             \
        const int wide = (n) * (S), gap = info->n_place;                                       \
        C one = zero_##C(), two = one, three = one, four = one;                                \
        int e = 0;                                                                             \
        for (; e + 4 <= count; e += 4, u += 4 * wide) {                                        \
            one = plus_##C(one, take_##C(u, n), ENTRY(y, column[e], gap));                     \
            two = plus_##C(two, take_##C(u + wide, n), ENTRY(y, column[e + 1], gap));          \
            three = plus_##C(three, take_##C(u + 2 * wide, n), ENTRY(y, column[e + 2], gap));  \
            four = plus_##C(four, take_##C(u + 3 * wide, n), ENTRY(y, column[e + 3], gap));    \
        }                                                                                      \
        for (; e < count; e++, u += wide) {                                                    \
            one = plus_##C(one, take_##C(u, n), ENTRY(y, column[e], gap));                     \
        }                                                                                      \
        one = add_##C(add_##C(one, two), add_##C(three, four));                                \
        two = less_##C(take_##C(y + b->at, gap), one);                                         \
        one = three = zero_##C();                                                              \
        UNROLL for (int k = 0; k < r; k += 2) {                                                \
            one = plus_at_##C(one, take_##C(inverse + k * wide, n), two, k);                   \
            if (k + 1 < r) {                                                                   \
                three = plus_at_##C(three, take_##C(inverse + (k + 1) * wide, n), two, k + 1); \
            }                                                                                  \
        }                                                                                      \
        put_##C(y + b->at, gap, add_##C(one, three));                                          \
    }

/* Calls update_C with the constants of a block with this many rows, */
#define BGC_UPDATE_EACH(C, rows, ...)                                                          \
    switch (rows) {                                                                            \
    case 1: update_##C(1, 1, __VA_ARGS__); break;                                              \
    case 2: update_##C(2, 2, __VA_ARGS__); break;                                              \
    case 3: update_##C(3, 4, __VA_ARGS__); break;                                              \
    case 4: update_##C(4, 4, __VA_ARGS__); break;                                              \
    case 5: update_##C(5, 8, __VA_ARGS__); break;                                              \
    case 6: update_##C(6, 8, __VA_ARGS__); break;                                              \
    case 7: update_##C(7, 8, __VA_ARGS__); break;                                              \
    default: update_##C(8, 8, __VA_ARGS__);                                                    \
    }
/* or the one form for all of them. */
#define BGC_UPDATE_ALL(C, rows, ...) update_##C(rows, bgc_column_size(rows), __VA_ARGS__);
#define BGC_NO_UNROLL

BGC_BLOCK_KERNELS(rows1, 1, 1, get_entry, BGC_UNROLL, BGC_UPDATE_EACH)
BGC_BLOCK_KERNELS(rows2, 2, 1, get_entry, BGC_UNROLL, BGC_UPDATE_EACH)
BGC_BLOCK_KERNELS(rows4, 4, 1, get_entry, BGC_UNROLL, BGC_UPDATE_EACH)
BGC_BLOCK_KERNELS(rows8, 8, 1, get_entry, BGC_UNROLL, BGC_UPDATE_EACH)
BGC_BLOCK_KERNELS(complex1, 1, 2, get_entry_complex, BGC_NO_UNROLL, BGC_UPDATE_ALL)
BGC_BLOCK_KERNELS(complex2, 2, 2, get_entry_complex, BGC_NO_UNROLL, BGC_UPDATE_ALL)
BGC_BLOCK_KERNELS(complex4, 4, 2, get_entry_complex, BGC_NO_UNROLL, BGC_UPDATE_ALL)
BGC_BLOCK_KERNELS(complex8, 8, 2, get_entry_complex, BGC_NO_UNROLL, BGC_UPDATE_ALL)

/* N and V at to, of a block with r rows of type T; returns the growth of its pivots, or infinity where
 * rows of more than one have to be exchanged. The size of a row is the root of its sum of squares. */
#define BGC_BLOCK_INVERSE(T, n)                                                                \
    BGC_ALWAYS double invert_##T(const int r, const double *from, const double *size,          \
                                 const double *unit, double *to) {                             \
        const int inner = r > 1 ? r : 0;                                                       \
        T lower[8], upper[8], inverse[8], of_row = load_##T(below_diagonal[7]), grown = of_row; \
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
    }

BGC_BLOCK_INVERSE(rows1, 1)
BGC_BLOCK_INVERSE(rows2, 2)
BGC_BLOCK_INVERSE(rows4, 4)
BGC_BLOCK_INVERSE(rows8, 8)

/* Runs DO(C, n, r) with the constants of a block with this many rows. */
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
#define BGC_OF_ROWS_complex(rows, DO)                                                          \
    switch (bgc_column_size(rows)) {                                                           \
    case 1: DO(complex1, 1, rows); break;                                                      \
    case 2: DO(complex2, 2, rows); break;                                                      \
    case 4: DO(complex4, 4, rows); break;                                                      \
    default: DO(complex8, 8, rows);                                                            \
    }

#define BGC_CLEAR(C, n, r) clear_##C(info, b, sheet)
#define BGC_FORWARD(C, n, r) forward_##C(r, info, at, lu, y)
#define BGC_BACKWARD(C, n, r) backward_##C(r, info, at, lu, y)
/* Rows are exchanged where that helps, */
#define BGC_ELIMINATE(C, n, r)                                                                 \
    do {                                                                                       \
        to = gather_##C(info, b, lu, sheet, to);                                               \
        part = invert_##C(r, from, size, unit + b->at, to);                                    \
        if (r > 1 && !(part <= bgc_block_growth)) {                                            \
            part = exchange_rows(b, from, size, unit + b->at, to);                             \
        }                                                                                      \
        carry_##C(r, to, column, count, sheet, to + (r > 1 ? 2 : 1) * r * (n));                \
    } while (0)
/* and in every complex block. */
#define BGC_ELIMINATE_complex(C, n, r)                                                         \
    do {                                                                                       \
        to = gather_##C(info, b, lu, sheet, to);                                               \
        part = exchange_rows_complex(b, from, size, unit + b->at, to);                         \
        carry_##C(r, to, column, count, sheet, to + (r > 1 ? 2 : 1) * r * (n) * 2);            \
    } while (0)

/* Doubles of a column of the sheet. */
enum { BGC_COLUMN = 8, BGC_COLUMN_complex = 16 };

/* The place in the sheet of one in a sheet of real columns, and entry k of a column. */
static inline int in_sheet(int place) { return place; }
static inline int in_sheet_complex(int place) { return place + (place & ~7); }
static inline void set_entry(double *to, int k, int gap, double x) { (void)gap, to[k] = x; }
static inline void set_entry_complex(double *to, int k, int gap, bgc_complex x) {
    to[k] = x.re;
    to[gap + k] = x.im;
}
static inline void add_entry(double *to, double x) { *to += x; }
static inline void add_entry_complex(double *to, bgc_complex x) {
    to[0] += x.re;
    to[8] += x.im;
}

/* Numbers as complex ones, and back. */
static inline bgc_complex widened(double x) { return (bgc_complex){x, 0.0}; }
static inline bgc_complex widened_complex(bgc_complex x) { return x; }
static inline double narrowed(bgc_complex x) { return x.re; }
static inline bgc_complex narrowed_complex(bgc_complex x) { return x; }

#include "blocks_kinds.h"

#define BGC_COMPLEX
#include "blocks_kinds.h"
#undef BGC_COMPLEX
