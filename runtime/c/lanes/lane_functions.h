/* lane_functions.h: define a function of <math.h> on lanes.
 *
 * LANE_LOOP_n(name) calls the scalar function lane by lane; n is the number of operands.
 * LANE_LIBMVEC_n(name) and LANE_LIBMVEC_2_35_n(name) call glibc's function for whole registers
 * (libmvec, which its libm brings along; errors of at most 4 units in the last place) where there
 * is one, in every libmvec or since glibc 2.35, and are LANE_LOOP_n elsewhere.
 *
 * The compiler emits one such line for each function of the language.
 */
#ifndef BGC_LANE_FUNCTIONS_H
#define BGC_LANE_FUNCTIONS_H

#include "bgc_lanes.h"

#include <string.h>

#if !defined(BGC_LANES_SCALAR) && defined(__GLIBC__) && defined(__x86_64__) && !defined(__clang__)
#if defined(__AVX512F__)
#define LANE_VECTOR_1(name) _ZGVeN8v_##name
#define LANE_VECTOR_2(name) _ZGVeN8vv_##name
#elif defined(__AVX2__)
#define LANE_VECTOR_1(name) _ZGVdN4v_##name
#define LANE_VECTOR_2(name) _ZGVdN4vv_##name
#endif
#endif

/* The loop runs over arrays, which compilers turn into vector instructions where there are any. */
#define LANE_LOOP_1(name) \
    lane lane_##name(lane a); \
    lane lane_##name(lane a) { \
        double x[BGC_LANE_WIDTH]; \
        memcpy(x, &a, sizeof x); \
        for (int l = 0; l < BGC_LANE_WIDTH; l++) { \
            x[l] = name(x[l]); \
        } \
        memcpy(&a, x, sizeof x); \
        return a; \
    }

#define LANE_LOOP_2(name) \
    lane lane_##name(lane a, lane b); \
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

#if defined(LANE_VECTOR_1)
#define LANE_LIBMVEC_1(name) \
    lane lane_##name(lane a); \
    lane LANE_VECTOR_1(name)(lane a); \
    lane lane_##name(lane a) { return LANE_VECTOR_1(name)(a); }
#define LANE_LIBMVEC_2(name) \
    lane lane_##name(lane a, lane b); \
    lane LANE_VECTOR_2(name)(lane a, lane b); \
    lane lane_##name(lane a, lane b) { return LANE_VECTOR_2(name)(a, b); }
#else
#define LANE_LIBMVEC_1(name) LANE_LOOP_1(name)
#define LANE_LIBMVEC_2(name) LANE_LOOP_2(name)
#endif

#if defined(LANE_VECTOR_1)
#if __GLIBC_PREREQ(2, 35)
#define LANE_LIBMVEC_2_35_1(name) LANE_LIBMVEC_1(name)
#define LANE_LIBMVEC_2_35_2(name) LANE_LIBMVEC_2(name)
#endif
#endif
#if !defined(LANE_LIBMVEC_2_35_1)
#define LANE_LIBMVEC_2_35_1(name) LANE_LOOP_1(name)
#define LANE_LIBMVEC_2_35_2(name) LANE_LOOP_2(name)
#endif

#endif
