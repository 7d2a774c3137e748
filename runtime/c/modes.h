/* modes.h: results of piecewise operations and the ranges of their modes, of one instance and of a
 * batch. */
#ifndef BGC_MODES_H
#define BGC_MODES_H

#include "bgc.h"
#include "number.h"

/* The result of an operation on a defined argument: its mode. */
static inline number bgc_result(int operation, number z) {
    const number zero = number_of(0.0), one = number_of(1.0);

    switch (operation) {
    case BGC_ABOVE:
        return number_select(z > zero, one, zero);
    case BGC_NOT_BELOW:
        return number_select(z >= zero, one, zero);
    case BGC_SIGN:
        return number_select(z > zero, one, number_select(z < zero, -one, zero));
    case BGC_FLOOR:
        return number_floor(z);
    case BGC_CEIL:
        return number_ceil(z);
    default:
        return number_select(z > zero, number_floor(z), number_ceil(z));
    }
}

/* An argument is far from the edge of its mode if its distance is this many times its variation. */
static const double bgc_far_from_edge = 2.0;

/* The distance of an argument from the edge of the range of its mode: negative outside. */
static inline number bgc_depth(int operation, number mode, number z) {
    const number zero = number_of(0.0), one = number_of(1.0);

    switch (operation) {
    case BGC_FLOOR:
        return number_smaller(z - mode, mode + one - z);
    case BGC_CEIL:
        return number_smaller(mode - z, z - (mode - one));
    case BGC_TRUNC:
        return number_smaller(z - number_select(mode > zero, mode, mode - one),
                              number_select(mode < zero, mode, mode + one) - z);
    case BGC_SIGN:
        return number_select(mode > zero, z, number_select(mode < zero, -z, -number_fabs(z)));
    default:
        return number_select(mode > zero, z, -z);
    }
}

/* --- arguments at the samples of a step -------------------------------------------------------- */

/* Weights of the arguments at 0, 0.17, 0.86 and 1 in the values at 0.41 and 0.63 of the cubic through
 * them. */
static const double bgc_cubic_weight[2][4] = {
    {-0.4358413132694938, 1.1180784519150777, 0.6988299869998555, -0.3810671256454388},
    {-0.2677564979480164, 0.5506732813607370, 1.2906976744186045, -0.5736144578313251},
};
static const double bgc_cubic_tolerance = 0.005; /* deviation from the cubic, relative to the range */

/* By how much more than the tolerance the arguments z at the start and the five samples of a step deviate from a
 * cubic: a smooth argument is close to one, a positive result is of one that varies too fast for the step. */
static inline number bgc_excess_over_cubic(const number z[6]) {
    number low = z[0], high = z[0], off = number_of(0.0);

    for (int i = 1; i <= 5; i++) {
        low = number_smaller(low, z[i]);
        high = number_larger(high, z[i]);
    }
    for (int i = 0; i < 2; i++) {
        const double *w = bgc_cubic_weight[i];
        const number cubic = number_of(w[0]) * z[0] + number_of(w[1]) * z[1] + number_of(w[2]) * z[4] +
                             number_of(w[3]) * z[5];
        off = number_larger(off, number_fabs(cubic - z[2 + i]));
    }
    return off - number_of(bgc_cubic_tolerance) * (high - low);
}

#endif
