/* complex_blocks.c: factors in blocks of rows, as in blocks.c, of W = c M - J for a complex c.
 *
 * Each column of doubles of blocks.c is two here, of the real and of the imaginary parts: in the sheet of
 * 8 each, in lu one behind the other. Rows are exchanged in every block. Numbers of rows and columns are
 * no constants: methods with complex stages are used for reference solutions, and code for each pair of
 * them takes the C compiler 2 s.
 */
#include "bgc_internal.h"
#include "block_vectors.h"
#include "blocks.h"
#include "complex_numbers.h"

#include <math.h>

static const double zero_rows[8] = {0.0};

/* Kernels for columns of type T with n doubles, as in blocks.c. */
#define BGC_COMPLEX_KERNELS(T, n)                                                              \
    /* (x, y) += (a, b) (u, v), of complex numbers */                                          \
    BGC_ALWAYS void accumulate_##T(T *x, T *y, T a, T b, double u, double v) {                 \
        *x = minus_##T(plus_##T(*x, a, u), b, v);                                              \
        *y = plus_##T(plus_##T(*y, a, v), b, u);                                               \
    }                                                                                          \
                                                                                               \
    static void clear_complex_##T(const bgc_block_info *info, const bgc_block *b,              \
                                  double *sheet) {                                             \
        const T zero = load_##T(zero_rows);                                                    \
        for (int e = b->left; e <= b[1].left; e++) { /* the blocks left of it, and itself */   \
            const bgc_block *s = e < b[1].left ? info->block + info->left[e] : b;              \
            for (int k = 0; k < 2 * s->rows; k++) {                                            \
                store_##T(sheet + 16 * s->at + 8 * k, zero);                                   \
            }                                                                                  \
        }                                                                                      \
        for (int e = b->right; e < b[1].right; e++) {                                          \
            store_##T(sheet + 16 * info->right[e], zero);                                      \
            store_##T(sheet + 16 * info->right[e] + 8, zero);                                  \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    static double *gather_complex_##T(const bgc_block_info *info, const bgc_block *b,          \
                                      const double *lu, double *sheet, double *keep) {         \
        for (int i = b->left; i < b[1].left; i++) {                                            \
            const bgc_block *s = info->block + info->left[i];                                  \
            const int *column = info->right + s->right, count = s[1].right - s->right;         \
            const int w = s->rows, wide = bgc_column_size(w);                                  \
            const double *inverse = lu + 2 * (size_t)s->upper, *upper = inverse + 2 * w * wide;\
            const double *from = sheet + 16 * s->at;                                           \
            T re[8], im[8];                                                                    \
            for (int k = 0; k < w; k++) {                                                      \
                const double *v = inverse + 2 * k * wide;                                      \
                re[k] = im[k] = load_##T(zero_rows);                                           \
                for (int j = 0; j <= k; j++) {                                                 \
                    accumulate_##T(re + k, im + k, load_##T(from + 16 * j),                    \
                                   load_##T(from + 16 * j + 8), v[j], v[wide + j]);            \
                }                                                                              \
                store_##T(keep + 2 * k * (n), re[k]);                                          \
                store_##T(keep + 2 * k * (n) + (n), im[k]);                                    \
            }                                                                                  \
            keep += 2 * w * (n);                                                               \
            for (int e = 0; e < count; e++) {                                                  \
                const double *u = upper + 2 * e * wide;                                        \
                double *at = sheet + 16 * column[e];                                           \
                T x = load_##T(at), y = load_##T(at + 8);                                      \
                for (int k = 0; k < w; k++) {                                                  \
                    accumulate_##T(&x, &y, re[k], im[k], -u[k], -u[wide + k]);                 \
                }                                                                              \
                store_##T(at, x);                                                              \
                store_##T(at + 8, y);                                                          \
            }                                                                                  \
        }                                                                                      \
        return keep;                                                                           \
    }                                                                                          \
                                                                                               \
    static void carry_complex_##T(int r, const double *lower, const int *column, int count,    \
                                  const double *sheet, double *to) {                           \
        for (int e = 0; e < count; e++) {                                                      \
            const double *z = sheet + 16 * column[e];                                          \
            T x = load_##T(r > 1 ? zero_rows : z), y = load_##T(r > 1 ? zero_rows : z + 8);    \
            for (int k = 0; k < r && r > 1; k++) {                                             \
                const double *l = lower + 2 * k * (n);                                         \
                accumulate_##T(&x, &y, load_##T(l), load_##T(l + (n)), z[k], z[8 + k]);        \
            }                                                                                  \
            store_##T(to + 2 * e * (n), x);                                                    \
            store_##T(to + 2 * e * (n) + (n), y);                                              \
        }                                                                                      \
    }                                                                                          \
                                                                                               \
    static void forward_complex_##T(const bgc_block_info *info, const bgc_block *b,            \
                                    const double *lu, bgc_complex *y) {                        \
        const double *l = lu + 2 * (size_t)b->factors;                                         \
        double part[2][8];                                                                     \
        T re = load_##T(zero_rows), im = re;                                                   \
        for (int i = b->left; i < b[1].left; i++) {                                            \
            const bgc_block *s = info->block + info->left[i];                                  \
            for (int k = 0; k < s->rows; k++, l += 2 * (n)) {                                  \
                const bgc_complex of = y[s->at + k];                                           \
                accumulate_##T(&re, &im, load_##T(l), load_##T(l + (n)), -of.re, -of.im);      \
            }                                                                                  \
        }                                                                                      \
        store_##T(part[0], re);                                                                \
        store_##T(part[1], im);                                                                \
        for (int k = 0; k < b->rows; k++) {                                                    \
            part[0][k] += y[b->at + k].re;                                                     \
            part[1][k] += y[b->at + k].im;                                                     \
        }                                                                                      \
        re = load_##T(b->rows > 1 ? zero_rows : part[0]);                                      \
        im = load_##T(b->rows > 1 ? zero_rows : part[1]);                                      \
        for (int k = 0; k < b->rows && b->rows > 1; k++, l += 2 * (n)) {                       \
            accumulate_##T(&re, &im, load_##T(l), load_##T(l + (n)), part[0][k], part[1][k]);  \
        }                                                                                      \
        put_complex_##T(re, im, b, y);                                                         \
    }                                                                                          \
                                                                                               \
    static void backward_complex_##T(const bgc_block_info *info, const bgc_block *b,           \
                                     const double *lu, bgc_complex *y) {                       \
        const double *inverse = lu + 2 * (size_t)b->upper, *u = inverse + 2 * b->rows * (n);   \
        double part[2][8];                                                                     \
        T re = load_##T(zero_rows), im = re;                                                   \
        for (int e = b->right; e < b[1].right; e++, u += 2 * (n)) {                            \
            const bgc_complex of = y[info->right[e]];                                          \
            accumulate_##T(&re, &im, load_##T(u), load_##T(u + (n)), -of.re, -of.im);          \
        }                                                                                      \
        store_##T(part[0], re);                                                                \
        store_##T(part[1], im);                                                                \
        re = im = load_##T(zero_rows);                                                         \
        for (int k = 0; k < b->rows; k++, inverse += 2 * (n)) {                                \
            const double a = y[b->at + k].re + part[0][k], c = y[b->at + k].im + part[1][k];   \
            accumulate_##T(&re, &im, load_##T(inverse), load_##T(inverse + (n)), a, c);        \
        }                                                                                      \
        put_complex_##T(re, im, b, y);                                                         \
    }

/* put: the entries of a block in a vector. */
#define BGC_COMPLEX_PUT(T, n)                                                                  \
    static void put_complex_##T(T re, T im, const bgc_block *b, bgc_complex *y) {              \
        double part[2][8];                                                                     \
        store_##T(part[0], re);                                                                \
        store_##T(part[1], im);                                                                \
        for (int k = 0; k < b->rows; k++) {                                                    \
            y[b->at + k] = (bgc_complex){part[0][k], part[1][k]};                              \
        }                                                                                      \
    }

BGC_COMPLEX_PUT(rows1, 1)
BGC_COMPLEX_PUT(rows2, 2)
BGC_COMPLEX_PUT(rows4, 4)
BGC_COMPLEX_PUT(rows8, 8)
BGC_COMPLEX_KERNELS(rows1, 1)
BGC_COMPLEX_KERNELS(rows2, 2)
BGC_COMPLEX_KERNELS(rows4, 4)
BGC_COMPLEX_KERNELS(rows8, 8)

/* Runs DO(T, n) with the constants of a block with this many rows. */
#define BGC_OF_SIZE(rows, DO)                                                                  \
    switch (bgc_column_size(rows)) {                                                           \
    case 1: DO(rows1, 1); break;                                                               \
    case 2: DO(rows2, 2); break;                                                               \
    case 4: DO(rows4, 4); break;                                                               \
    default: DO(rows8, 8);                                                                     \
    }

/* Adds the rows of a block of W = c M - J to its sheet, as in blocks.c. The Jacobian is real. */
static void assemble_complex_block(const bgc_model *m, const bgc_block *b, const double *mass,
                                   const double *jac, bgc_complex c, double *sheet, double *size) {
    const bgc_block_info *info = m->blocks;
    double *at = sheet + 16 * b->at;

    for (int e = b->mass; e < b[1].mass; e++) {
        const int column = info->mass_to[e] / 8, row = info->mass_to[e] % 8;
        const double inertia = m->n_mass > 0 ? mass[info->mass[e]] : 1.0;
        sheet[16 * column + row] += c.re * inertia;
        sheet[16 * column + 8 + row] += c.im * inertia;
    }
    for (int k = 0; k < b->rows; k++) {
        size[k] = at[16 * k + k];
    }
    for (int e = b->jac; e < b[1].jac; e++) {
        sheet[16 * (info->jac_to[e] / 8) + info->jac_to[e] % 8] -= jac[info->jac[e]];
    }
    for (int k = 0; k < b->rows; k++) {
        size[k] = fabs(size[k]) + fabs(size[k] - at[16 * k + k]) + fabs(at[16 * k + 8 + k]);
    }
}

/* N (of more than one row) and V of a block; returns the growth of its pivots. */
static double invert_complex(const bgc_block *b, const double *from, const double *size,
                             const double *unit, double *to) {
    const int r = b->rows, n = bgc_column_size(r);
    bgc_complex block[64], inverse[2][64];
    double growth;

    for (int k = 0; k < r; k++) {
        for (int i = 0; i < r; i++) {
            block[8 * k + i] = (bgc_complex){from[16 * k + i], from[16 * k + 8 + i]};
        }
    }
    growth = bgc_pivot_block(r, block, size, unit, inverse[0], inverse[1]);
    if (!isfinite(growth)) {
        return growth;
    }
    for (int half = r > 1 ? 0 : 1; half < 2; half++) {
        for (int k = 0; k < r; k++, to += 2 * n) {
            for (int i = 0; i < r; i++) {
                to[i] = inverse[half][8 * k + i].re;
                to[n + i] = inverse[half][8 * k + i].im;
            }
        }
    }
    return growth;
}

/* Factorises W = c M - J as bgc_block_factor does; scratch is 18 n_place doubles. */
int bgc_block_factor_complex(const bgc_model *m, const double *scale, const double *mass,
                             const double *jac, bgc_complex c, bgc_complex *factors,
                             double *growth, double *scratch) {
    const bgc_block_info *info = m->blocks;
    double *lu = (double *)(void *)factors, *sheet = scratch, sum = 0.0;
    double *unit = scratch + 16 * (size_t)info->n_place;

    bgc_order_units(m, scale, unit);
    for (const bgc_block *b = info->block; b < info->block + info->n_block; b++) {
        const int *column = info->right + b->right, count = b[1].right - b->right, r = b->rows;
        double *to = lu + 2 * (size_t)b->factors, size[8];

#define CLEAR_COMPLEX(T, n) clear_complex_##T(info, b, sheet)
        BGC_OF_SIZE(r, CLEAR_COMPLEX)
        assemble_complex_block(m, b, mass, jac, c, sheet, size);
#define GATHER_COMPLEX(T, n) to = gather_complex_##T(info, b, lu, sheet, to)
        BGC_OF_SIZE(r, GATHER_COMPLEX)
        sum += invert_complex(b, sheet + 16 * b->at, size, unit + b->at, to);
#define CARRY_COMPLEX(T, n)                                                                    \
    carry_complex_##T(r, to, column, count, sheet, to + 2 * (r > 1 ? 2 : 1) * r * (n))
        BGC_OF_SIZE(r, CARRY_COMPLEX)
    }
    *growth = sum;
    return sum < (double)INFINITY ? 0 : 1;
}

/* b := (c M - J)^-1 b with the factors of bgc_block_factor_complex, with inner unknowns; scratch is 18 n_place doubles. */
void bgc_block_solve_complex(const bgc_model *m, const bgc_complex *factors, bgc_complex *b,
                             double *scratch) {
    const bgc_block_info *info = m->blocks;
    const bgc_block *end = info->block + info->n_block;
    const double *lu = (const double *)(const void *)factors;
    const int n = bgc_unknowns(m);
    bgc_complex *y = (bgc_complex *)(void *)scratch;

    for (int k = 0; k < n; k++) {
        y[info->row_place[k]] = b[k];
    }
    for (const bgc_block *at = info->block; at < end; at++) {
#define FORWARD_COMPLEX(T, n) forward_complex_##T(info, at, lu, y)
        BGC_OF_SIZE(at->rows, FORWARD_COMPLEX)
    }
    for (const bgc_block *at = end; at-- > info->block;) {
#define BACKWARD_COMPLEX(T, n) backward_complex_##T(info, at, lu, y)
        BGC_OF_SIZE(at->rows, BACKWARD_COMPLEX)
    }
    for (int k = 0; k < n; k++) {
        b[k] = y[info->col_place[k]];
    }
}
