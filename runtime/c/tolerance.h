/* tolerance.h: the tolerance of a state in a step, of one instance and of a batch. */
#ifndef BGC_TOLERANCE_H
#define BGC_TOLERANCE_H

#include "number.h"

static const double bgc_least_reached = 1e-6; /* smaller states, relative to their scale, are noise */

/* The largest abs(x_i) / scale_i so far, at most 1: step tolerances take this part of the scales, so
 * that a motion far below its scale is resolved too. */
static inline number bgc_scale_reached(int n, const number *x, const number *scale, number before) {
    number most = number_larger(number_of(bgc_least_reached), before);

    for (int i = 0; i < n; i++) {
        most = number_larger(most, number_fabs(x[i]) / scale[i]);
    }
    return number_smaller(most, number_of(1.0));
}

/* The tolerance of a state of this size; `reached` is bgc_scale_reached. */
static inline number bgc_step_tolerance(number size, number scale, number reached, double rtol,
                                        double atol) {
    const number unit = number_smaller(number_larger(size, reached * scale), scale);

    return atol > 0.0 ? atol + rtol * size : rtol * (unit + size);
}

#endif
