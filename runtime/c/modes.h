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

/* An argument is clear of the edge of its mode if its distance is this many times its variation. */
static const double bgc_clear_of_edge = 2.0;

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

#endif
