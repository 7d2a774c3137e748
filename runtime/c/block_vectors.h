/* block_vectors.h: arithmetic on 1, 2, 4 or 8 doubles that belong to the rows of a block of W.
 *
 * rows1 .. rows8 are one register where this machine has such registers, else two of half the
 * size; one double each where the compiler has no vector types. Elements are numbered by constants.
 */
#ifndef BGC_BLOCK_VECTORS_H
#define BGC_BLOCK_VECTORS_H

#include <string.h>

#if (defined(__GNUC__) || defined(__clang__)) && !defined(__TINYC__) && !defined(BGC_NO_VECTORS)
#define BGC_ALWAYS static inline __attribute__((always_inline, unused))
#define BGC_NEVER __attribute__((noinline))
#define BGC_HAS_VECTORS
#else
#define BGC_ALWAYS static inline
#define BGC_NEVER
#endif

#if defined(__clang__)
#define BGC_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(BGC_HAS_VECTORS)
#define BGC_UNROLL _Pragma("GCC unroll 8")
#else
#define BGC_UNROLL
#endif

/* Functions of a type T: load, store, x s, sum + x s, sum - x s, a + b, products and quotients of elements,
 * element k, and sum +- x e, where e is element k of a vector. */
typedef double rows1;

BGC_ALWAYS rows1 load_rows1(const double *from) { return *from; }
BGC_ALWAYS void store_rows1(double *to, rows1 x) { *to = x; }
BGC_ALWAYS rows1 times_rows1(rows1 x, double s) { return x * s; }
BGC_ALWAYS rows1 plus_rows1(rows1 sum, rows1 x, double s) { return sum + x * s; }
BGC_ALWAYS rows1 minus_rows1(rows1 sum, rows1 x, double s) { return sum - x * s; }
BGC_ALWAYS rows1 add_rows1(rows1 a, rows1 b) { return a + b; }
BGC_ALWAYS rows1 product_rows1(rows1 a, rows1 b) { return a * b; }
BGC_ALWAYS rows1 quotient_rows1(rows1 a, rows1 b) { return a / b; }
BGC_ALWAYS double get_rows1(rows1 x, const int k) { return (void)k, x; }
BGC_ALWAYS rows1 plus_at_rows1(rows1 sum, rows1 x, rows1 e, const int k) {
    return (void)k, sum + x * e;
}
BGC_ALWAYS rows1 minus_at_rows1(rows1 sum, rows1 x, rows1 e, const int k) {
    return (void)k, sum - x * e;
}

/* A type that is one register. */
#define BGC_REGISTER(T, n)                                                                      \
    typedef double T __attribute__((vector_size(8 * (n))));                                    \
    BGC_ALWAYS T load_##T(const double *from) {                                                \
        T x;                                                                                   \
        memcpy(&x, from, sizeof x);                                                            \
        return x;                                                                              \
    }                                                                                          \
    BGC_ALWAYS void store_##T(double *to, T x) { memcpy(to, &x, sizeof x); }                   \
    BGC_ALWAYS T times_##T(T x, double s) { return x * s; }                                    \
    BGC_ALWAYS T plus_##T(T sum, T x, double s) { return sum + x * s; }                        \
    BGC_ALWAYS T minus_##T(T sum, T x, double s) { return sum - x * s; }                       \
    BGC_ALWAYS T add_##T(T a, T b) { return a + b; }                                           \
    BGC_ALWAYS T product_##T(T a, T b) { return a * b; }                                       \
    BGC_ALWAYS T quotient_##T(T a, T b) { return a / b; }                                      \
    BGC_ALWAYS double get_##T(T x, const int k) { return x[k]; }                               \
    BGC_ALWAYS T plus_at_##T(T sum, T x, T e, const int k) { return sum + x * BGC_ALL_##n(e, k); } \
    BGC_ALWAYS T minus_at_##T(T sum, T x, T e, const int k) { return sum - x * BGC_ALL_##n(e, k); }

/* Element k in all places. */
#if defined(__clang__) || !defined(BGC_HAS_VECTORS)
#define BGC_ALL_2(e, k) ((e)[k])
#define BGC_ALL_4(e, k) ((e)[k])
#define BGC_ALL_8(e, k) ((e)[k])
#else
typedef long long bgc_places2 __attribute__((vector_size(16)));
typedef long long bgc_places4 __attribute__((vector_size(32)));
typedef long long bgc_places8 __attribute__((vector_size(64)));
#define BGC_ALL_2(e, k) __builtin_shuffle(e, (bgc_places2){k, k})
#define BGC_ALL_4(e, k) __builtin_shuffle(e, (bgc_places4){k, k, k, k})
#define BGC_ALL_8(e, k) __builtin_shuffle(e, (bgc_places8){k, k, k, k, k, k, k, k})
#endif

/* A type that is two of half its size, H of n / 2 doubles. */
#define BGC_PAIR(T, n, H)                                                                       \
    typedef struct {                                                                           \
        H low, high;                                                                           \
    } T;                                                                                       \
    BGC_ALWAYS T load_##T(const double *from) {                                                \
        return (T){load_##H(from), load_##H(from + (n) / 2)};                                  \
    }                                                                                          \
    BGC_ALWAYS void store_##T(double *to, T x) {                                               \
        store_##H(to, x.low);                                                                  \
        store_##H(to + (n) / 2, x.high);                                                       \
    }                                                                                          \
    BGC_ALWAYS T times_##T(T x, double s) { return (T){times_##H(x.low, s), times_##H(x.high, s)}; } \
    BGC_ALWAYS T plus_##T(T sum, T x, double s) {                                              \
        return (T){plus_##H(sum.low, x.low, s), plus_##H(sum.high, x.high, s)};                \
    }                                                                                          \
    BGC_ALWAYS T minus_##T(T sum, T x, double s) {                                             \
        return (T){minus_##H(sum.low, x.low, s), minus_##H(sum.high, x.high, s)};              \
    }                                                                                          \
    BGC_ALWAYS T add_##T(T a, T b) { return (T){add_##H(a.low, b.low), add_##H(a.high, b.high)}; } \
    BGC_ALWAYS T product_##T(T a, T b) {                                                       \
        return (T){product_##H(a.low, b.low), product_##H(a.high, b.high)};                    \
    }                                                                                          \
    BGC_ALWAYS T quotient_##T(T a, T b) {                                                      \
        return (T){quotient_##H(a.low, b.low), quotient_##H(a.high, b.high)};                  \
    }                                                                                          \
    BGC_ALWAYS double get_##T(T x, const int k) {                                              \
        return k < (n) / 2 ? get_##H(x.low, k % ((n) / 2)) : get_##H(x.high, k % ((n) / 2));   \
    }                                                                                          \
    BGC_ALWAYS T plus_at_##T(T sum, T x, T e, const int k) {                                   \
        const H from = k < (n) / 2 ? e.low : e.high;                                           \
        const int at = k % ((n) / 2);                                                          \
        return (T){plus_at_##H(sum.low, x.low, from, at), plus_at_##H(sum.high, x.high, from, at)}; \
    }                                                                                          \
    BGC_ALWAYS T minus_at_##T(T sum, T x, T e, const int k) {                                  \
        const H from = k < (n) / 2 ? e.low : e.high;                                           \
        const int at = k % ((n) / 2);                                                          \
        return (T){minus_at_##H(sum.low, x.low, from, at), minus_at_##H(sum.high, x.high, from, at)}; \
    }

#if defined(BGC_HAS_VECTORS)
BGC_REGISTER(rows2, 2)
#else
BGC_PAIR(rows2, 2, rows1)
#endif
#if defined(BGC_HAS_VECTORS) && defined(__AVX__)
BGC_REGISTER(rows4, 4)
#else
BGC_PAIR(rows4, 4, rows2)
#endif
#if defined(BGC_HAS_VECTORS) && defined(__AVX512F__)
BGC_REGISTER(rows8, 8)
#else
BGC_PAIR(rows8, 8, rows4)
#endif

/* Doubles of a column of a block with this many rows. */
static inline int bgc_column_size(int rows) { return rows <= 2 ? rows : rows <= 4 ? 4 : 8; }

#endif
