/* lane_functions.c: the functions of <math.h> on lanes.
 *
 * glibc has some for whole registers (libmvec, which its libm brings along), with errors of 4 units in
 * the last place at most; the others, and all elsewhere, are called lane by lane.
 */
#include "bgc_lanes.h"

#include <string.h>

#if !defined(BGC_LANES_SCALAR) && defined(__GLIBC__) && defined(__x86_64__) && !defined(__clang__)
#if defined(__AVX512F__)
#define VECTOR(name) _ZGVeN8v_##name
#define VECTOR2(name) _ZGVeN8vv_##name
#elif defined(__AVX2__)
#define VECTOR(name) _ZGVdN4v_##name
#define VECTOR2(name) _ZGVdN4vv_##name
#endif
#if defined(VECTOR) && __GLIBC_PREREQ(2, 35)
#define VECTORS_OF_ALL
#endif
#endif

/* By way of arrays: compilers make vector instructions of such loops where there are any. */
#define UNARY(name) \
    lane lane_##name(lane a) { \
        double x[BGC_LANE_WIDTH]; \
        memcpy(x, &a, sizeof x); \
        for (int l = 0; l < BGC_LANE_WIDTH; l++) { \
            x[l] = name(x[l]); \
        } \
        memcpy(&a, x, sizeof x); \
        return a; \
    }

#define BINARY(name) \
    lane lane_##name(lane a, lane b) { \
        double x[BGC_LANE_WIDTH], y[BGC_LANE_WIDTH]; \
        memcpy(x, &a, sizeof x); \
        memcpy(y, &b, sizeof y); \
        for (int l = 0; l < BGC_LANE_WIDTH; l++) { \
            x[l] = name(x[l], y[l]); \
        } \
        memcpy(&a, x, sizeof x); \
        return a; \
    }

/* Those that glibc has for whole registers, since its first libmvec and since 2.35. */
#define OLDER(ONE, TWO) ONE(sin) ONE(cos) ONE(exp) ONE(log) TWO(pow)
#define NEWER(ONE, TWO) \
    ONE(tan) ONE(asin) ONE(acos) ONE(atan) ONE(sinh) ONE(cosh) ONE(tanh) ONE(asinh) ONE(acosh) \
    ONE(atanh) ONE(cbrt) ONE(expm1) ONE(log1p) ONE(log10) ONE(erf) TWO(atan2) TWO(hypot)

#if defined(VECTOR)
#define WHOLE(name) \
    lane VECTOR(name)(lane a); \
    lane lane_##name(lane a) { return VECTOR(name)(a); }
#define WHOLE2(name) \
    lane VECTOR2(name)(lane a, lane b); \
    lane lane_##name(lane a, lane b) { return VECTOR2(name)(a, b); }
OLDER(WHOLE, WHOLE2)
#else
OLDER(UNARY, BINARY)
#endif

#if defined(VECTORS_OF_ALL)
NEWER(WHOLE, WHOLE2)
#else
NEWER(UNARY, BINARY)
#endif

UNARY(sqrt)
UNARY(floor)
UNARY(ceil)
BINARY(fmod)
