/* rounding.h: when the rounding of f limits the steps, of one instance and of a batch: rounding.c has the
 * method. */
#ifndef BGC_ROUNDING_H
#define BGC_ROUNDING_H

#include "number.h"
#include "tolerance.h"

#include <float.h>

enum { BGC_ROUNDING_INTERVAL = 256 }; /* steps between two samples */

static const double bgc_shift_of_step = 1e-2;
static const double bgc_shift_of_tolerance = 1e-6;
static const double bgc_shift_of_state = 8.0 * DBL_EPSILON;
static const double bgc_negligible_rounding = 0.05; /* rounding, over the tolerance */
static const double bgc_dominant_rounding = 0.5;    /* rounding, over the error estimate */

/* x shifted by a part of the tolerance of each state, to `shifted`, which may be x; sizes and signs follow a
 * low-discrepancy sequence. */
static inline void bgc_shift_states(int n, const number *x, const number *scale, number reached,
                                    double rtol, double atol, number *shifted) {
    double size = 0.25;

    for (int i = 0; i < n; i++) {
        const number value = x[i], now = number_fabs(value);
        const number tolerance = bgc_step_tolerance(now, scale[i], reached, rtol, atol);
        shifted[i] = value + (2.0 * size - 1.0) * (bgc_shift_of_tolerance * tolerance +
                                                   bgc_shift_of_state * now);
        size += 0.6180339887498949;
        size -= size >= 1.0 ? 1.0 : 0.0;
    }
}

/* Whether rounding makes up the error estimate of a step. */
static inline number_mask bgc_rounding_dominates(number noise, number error) {
    return (noise > number_of(bgc_negligible_rounding)) & (noise > bgc_dominant_rounding * error);
}

#endif
