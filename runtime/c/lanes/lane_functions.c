/* lane_functions.c: the functions of <math.h> on lanes. */
#include "bgc_lanes.h"

#define UNARY(name) \
    lane lane_##name(lane a) { \
        for (int l = 0; l < BGC_LANE_WIDTH; l++) { \
            lane_set(&a, l, name(lane_get(a, l))); \
        } \
        return a; \
    }

#define BINARY(name) \
    lane lane_##name(lane a, lane b) { \
        for (int l = 0; l < BGC_LANE_WIDTH; l++) { \
            lane_set(&a, l, name(lane_get(a, l), lane_get(b, l))); \
        } \
        return a; \
    }

UNARY(sqrt)
UNARY(floor)
UNARY(ceil)
UNARY(cbrt)
UNARY(sin)
UNARY(cos)
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
UNARY(exp)
UNARY(expm1)
UNARY(log)
UNARY(log1p)
UNARY(log10)
UNARY(erf)
BINARY(pow)
BINARY(atan2)
BINARY(fmod)
BINARY(hypot)
