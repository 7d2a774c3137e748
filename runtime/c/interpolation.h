/* interpolation.h: dense output in the form of bgc_internal.h, of one instance and of a batch:
 *     y(s) = (1 - s) y0 + s (y1 + (1 - s) (k1 + s (k2 + s k3))),  0 <= s <= 1. */
#ifndef BGC_INTERPOLATION_H
#define BGC_INTERPOLATION_H

#include "number.h"

static const double bgc_slope_ratio = 10.0; /* of the slopes' departures from the chord, see below */

/* k1 and k2 of the cubic Hermite polynomial with slopes f0 and f1 at its ends, per unit of s; where
 * it is not to be trusted, of the chord. The departures of the slopes from the chord are opposite
 * and equal up to the third order where the solution is smooth. One that is much larger than the
 * other belongs to a transient that ends within the step, and would make the cubic overshoot. */
static inline void bgc_hermite(number rise, number f0, number f1, number_mask has_slope, number *k1,
                               number *k2) {
    const number start = f0 - rise, end = f1 - rise;
    const number_mask smooth =
        has_slope & (number_fabs(start) <= bgc_slope_ratio * number_fabs(end)) &
        (number_fabs(end) <= bgc_slope_ratio * number_fabs(start));

    *k1 = number_select(smooth, start, number_of(0.0));
    *k2 = number_select(smooth, -(start + end), number_of(0.0));
}

/* y(s). */
static inline number bgc_interpolated(double s, number y0, number y1, number k1, number k2,
                                      number k3) {
    const double r = 1.0 - s;

    return r * y0 + s * (y1 + r * (k1 + s * (k2 + s * k3)));
}

/* dy/ds at s = 1/2. */
static inline number bgc_middle_slope(number y0, number y1, number k2, number k3) {
    return y1 - y0 + 0.25 * (k2 + k3);
}

/* dy/ds at s. */
static inline number bgc_interpolated_slope(double s, number y0, number y1, number k1, number k2,
                                            number k3) {
    return y1 - y0 + (1.0 - 2.0 * s) * (k1 + s * (k2 + s * k3)) + s * (1.0 - s) * (k2 + 2.0 * s * k3);
}

/* The absolute defect of the dense output in the middle of a step, less the part that the rounding of
 * the times makes of it. */
static inline number bgc_defect(number defect, number y0, number y1, double middle, double h) {
    const double time_rounding = 1e-15; /* relative */
    const number rounding = number_fabs(time_rounding * (middle * (y1 - y0) / h));
    const number size = number_fabs(defect);

    return number_select(size <= rounding, number_of(0.0), size - rounding);
}

#endif
