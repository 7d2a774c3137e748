/* bgc_ranges.h: interval arithmetic: the range of an operation over ranges of its operands.
 *
 * Ends are computed in the rounding of doubles, not outwards: ranges serve to find where an expression
 * may vary. A range with an infinite end is not known at that end. A condition is [0, 0], [1, 1] or, if
 * it is not certain, [0, 1].
 */
#ifndef BGC_RANGES_H
#define BGC_RANGES_H

#include "bgc.h"

#include <math.h>

static inline bgc_range bgc_range_of(double a) { return (bgc_range){a, a}; }
static inline bgc_range bgc_range_unknown(void) { return (bgc_range){-INFINITY, INFINITY}; }

/* Between two values; unknown where one is undefined. */
static inline bgc_range bgc_range_between(double low, double high) {
    return low <= high ? (bgc_range){low, high} : bgc_range_unknown();
}

/* The smallest range that contains four values; unknown where one is undefined. */
static inline bgc_range bgc_range_around(double a, double b, double c, double d) {
    const double low = fmin(fmin(a, b), fmin(c, d)), high = fmax(fmax(a, b), fmax(c, d));

    return isnan(a) || isnan(b) || isnan(c) || isnan(d) ? bgc_range_unknown()
                                                        : (bgc_range){low, high};
}

static inline bgc_range bgc_range_union(bgc_range a, bgc_range b) {
    return (bgc_range){fmin(a.low, b.low), fmax(a.high, b.high)};
}

static inline bgc_range bgc_range_rising(double (*f)(double), bgc_range a) {
    return bgc_range_between(f(a.low), f(a.high));
}
static inline bgc_range bgc_range_falling(double (*f)(double), bgc_range a) {
    return bgc_range_between(f(a.high), f(a.low));
}

/* --- arithmetic ---------------------------------------------------------------------------- */

static inline bgc_range bgc_range_sum(bgc_range a, bgc_range b) {
    return bgc_range_between(a.low + b.low, a.high + b.high);
}
static inline bgc_range bgc_range_opposite(bgc_range a) { return (bgc_range){-a.high, -a.low}; }
static inline bgc_range bgc_range_difference(bgc_range a, bgc_range b) {
    return bgc_range_between(a.low - b.high, a.high - b.low);
}

/* A product in which 0 times anything is 0: an infinite end is a bound that is not known. */
static inline double bgc_range_times(double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a * b; }

static inline bgc_range bgc_range_product(bgc_range a, bgc_range b) {
    return bgc_range_around(bgc_range_times(a.low, b.low), bgc_range_times(a.low, b.high),
                            bgc_range_times(a.high, b.low), bgc_range_times(a.high, b.high));
}
static inline bgc_range bgc_range_abs(bgc_range a) {
    const double high = fmax(-a.low, a.high);

    return (bgc_range){fmax(fmax(a.low, -a.high), 0.0), high};
}
static inline bgc_range bgc_range_square(bgc_range a) {
    const bgc_range size = bgc_range_abs(a);

    return (bgc_range){size.low * size.low, size.high * size.high};
}
static inline bgc_range bgc_range_quotient(bgc_range a, bgc_range b) {
    if (!(b.low > 0.0 || b.high < 0.0)) {
        return bgc_range_unknown();
    }
    return bgc_range_product(a, (bgc_range){1.0 / b.high, 1.0 / b.low});
}
static inline bgc_range bgc_range_power(bgc_range a, bgc_range b) {
    if (a.low < 0.0 && !(b.low == b.high && b.low == floor(b.low))) {
        return bgc_range_unknown();
    }
    if (a.low < 0.0 && fmod(b.low, 2.0) == 0.0) {
        a = bgc_range_abs(a);
    }
    if (a.low <= 0.0 && a.high >= 0.0 && b.low < 0.0) {
        return bgc_range_unknown();
    }
    return bgc_range_around(pow(a.low, b.low), pow(a.low, b.high), pow(a.high, b.low),
                            pow(a.high, b.high));
}

/* --- conditions ---------------------------------------------------------------------------- */

static inline bgc_range bgc_range_truth(int is, int may_be) {
    return (bgc_range){is ? 1.0 : 0.0, may_be ? 1.0 : 0.0};
}
static inline int bgc_range_is(bgc_range a) { return a.low > 0.0 || a.high < 0.0; }
static inline int bgc_range_may_be(bgc_range a) { return a.low != 0.0 || a.high != 0.0; }
static inline bgc_range bgc_range_less(bgc_range a, bgc_range b) {
    return bgc_range_truth(a.high < b.low, !(a.low >= b.high));
}
static inline bgc_range bgc_range_at_most(bgc_range a, bgc_range b) {
    return bgc_range_truth(a.high <= b.low, !(a.low > b.high));
}

/* The test of a mode, which is not a number while ranges are computed, is false. */
static inline bgc_range bgc_range_equal(bgc_range a, bgc_range b) {
    return bgc_range_truth(a.low == a.high && b.low == b.high && a.low == b.low,
                           a.low <= b.high && b.low <= a.high);
}
static inline bgc_range bgc_range_both(bgc_range a, bgc_range b) {
    return bgc_range_truth(bgc_range_is(a) && bgc_range_is(b),
                           bgc_range_may_be(a) && bgc_range_may_be(b));
}
static inline bgc_range bgc_range_either(bgc_range a, bgc_range b) {
    return bgc_range_truth(bgc_range_is(a) || bgc_range_is(b),
                           bgc_range_may_be(a) || bgc_range_may_be(b));
}
static inline bgc_range bgc_range_negation(bgc_range a) {
    return bgc_range_truth(!bgc_range_may_be(a), !bgc_range_is(a));
}
static inline bgc_range bgc_range_choice(bgc_range condition, bgc_range yes, bgc_range no) {
    return bgc_range_is(condition)       ? yes
           : bgc_range_may_be(condition) ? bgc_range_union(yes, no)
                                         : no;
}

/* --- functions ------------------------------------------------------------------------------ */

static inline bgc_range bgc_range_max(bgc_range a, bgc_range b) {
    return (bgc_range){fmax(a.low, b.low), fmax(a.high, b.high)};
}
static inline bgc_range bgc_range_min(bgc_range a, bgc_range b) {
    return (bgc_range){fmin(a.low, b.low), fmin(a.high, b.high)};
}

/* Of a function of period 2 pi, with its maximum 1 at `top` and its minimum -1 half a period later,
 * whose values at both ends are given. */
static inline bgc_range bgc_range_wave(bgc_range a, double top, double at_low, double at_high) {
    const double period = 6.283185307179586, low = (a.low - top) / period;
    const double high = (a.high - top) / period;
    const int has_top = floor(high) > floor(low) || low == floor(low);
    const int has_bottom = floor(high - 0.5) > floor(low - 0.5);

    if (!(high - low < 1.0)) {
        return (bgc_range){-1.0, 1.0};
    }
    return (bgc_range){has_bottom ? -1.0 : fmin(at_low, at_high),
                       has_top ? 1.0 : fmax(at_low, at_high)};
}
static inline bgc_range bgc_range_sin(bgc_range a) {
    return bgc_range_wave(a, 1.5707963267948966, sin(a.low), sin(a.high));
}
static inline bgc_range bgc_range_cos(bgc_range a) {
    return bgc_range_wave(a, 0.0, cos(a.low), cos(a.high));
}
static inline bgc_range bgc_range_tan(bgc_range a) {
    const double pi = 3.141592653589793;
    const int same = floor(a.low / pi + 0.5) == floor(a.high / pi + 0.5);

    return same ? bgc_range_rising(tan, a) : bgc_range_unknown();
}
static inline bgc_range bgc_range_cosh(bgc_range a) {
    return bgc_range_rising(cosh, bgc_range_abs(a));
}
static inline bgc_range bgc_range_hypot(bgc_range a, bgc_range b) {
    const bgc_range x = bgc_range_abs(a), y = bgc_range_abs(b);

    return (bgc_range){hypot(x.low, y.low), hypot(x.high, y.high)};
}
static inline bgc_range bgc_range_atan2(bgc_range y, bgc_range x) {
    if (!(x.low > 0.0)) {
        return (bgc_range){-3.141592653589793, 3.141592653589793};
    }
    return bgc_range_around(atan2(y.low, x.low), atan2(y.low, x.high), atan2(y.high, x.low),
                            atan2(y.high, x.high));
}

/* Of fmod: exact where the quotient keeps its whole part. */
static inline bgc_range bgc_range_remainder(bgc_range a, bgc_range b) {
    const double size = fmin(bgc_range_abs(a).high, bgc_range_abs(b).high);

    if (b.low == b.high && trunc(a.low / b.low) == trunc(a.high / b.low)) {
        return bgc_range_between(fmod(a.low, b.low), fmod(a.high, b.low));
    }
    return (bgc_range){a.low < 0.0 ? -size : 0.0, a.high > 0.0 ? size : 0.0};
}

#endif
