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

#if defined(VECTOR)
lane VECTOR(sin)(lane a), VECTOR(cos)(lane a), VECTOR(exp)(lane a), VECTOR(log)(lane a);
lane VECTOR2(pow)(lane a, lane b);

lane lane_sin(lane a) { return VECTOR(sin)(a); }
lane lane_cos(lane a) { return VECTOR(cos)(a); }
lane lane_exp(lane a) { return VECTOR(exp)(a); }
lane lane_log(lane a) { return VECTOR(log)(a); }
lane lane_pow(lane a, lane b) { return VECTOR2(pow)(a, b); }
#else
UNARY(sin)
UNARY(cos)
UNARY(exp)
UNARY(log)
BINARY(pow)
#endif

UNARY(sqrt)
UNARY(floor)
UNARY(ceil)
UNARY(cbrt)
UNARY(tan)
UNARY(asin)
UNARY(acos)
UNARY(atan)
UNARY(sinh)
UNARY(cosh)
UNARY(tanh)
UNARY(asinh)
UNARY(acosh)
UNARY(atanh)
UNARY(expm1)
UNARY(log1p)
UNARY(log10)
UNARY(erf)
BINARY(atan2)
BINARY(fmod)
BINARY(hypot)
