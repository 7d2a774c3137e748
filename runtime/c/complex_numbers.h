/* complex_numbers.h: arithmetic of complex numbers, written out: C's own product handles infinities at
 * four times the cost. Sizes are |re| + |im|.
 */
#ifndef BGC_COMPLEX_NUMBERS_H
#define BGC_COMPLEX_NUMBERS_H

#include "bgc_internal.h"

#include <math.h>

static inline bgc_complex bgc_times(bgc_complex a, bgc_complex b) {
    return (bgc_complex){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static inline bgc_complex bgc_plus(bgc_complex a, bgc_complex b) {
    return (bgc_complex){a.re + b.re, a.im + b.im};
}

static inline bgc_complex bgc_minus(bgc_complex a, bgc_complex b) {
    return (bgc_complex){a.re - b.re, a.im - b.im};
}

static inline bgc_complex bgc_scaled(double a, bgc_complex b) {
    return (bgc_complex){a * b.re, a * b.im};
}

static inline bgc_complex bgc_reciprocal(bgc_complex a) {
    const double size = hypot(a.re, a.im);
    return (bgc_complex){a.re / size / size, -a.im / size / size};
}

static inline double bgc_size_of(bgc_complex a) { return fabs(a.re) + fabs(a.im); }

#endif
