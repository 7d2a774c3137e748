/* control.h: PI control of the step, of one instance and of many in lockstep: E. Hairer,
 * G. Wanner, Solving Ordinary Differential Equations II, IV.2. Errors are over the tolerances, and
 * fall with the power q of the step. */
#ifndef BGC_CONTROL_H
#define BGC_CONTROL_H

#include <math.h>

static const double bgc_safety = 0.9, bgc_least_factor = 0.2, bgc_largest_factor = 5.0;
static const double bgc_proportional = 0.7, bgc_integral = 0.4;
static const double bgc_least_error = 1e-10; /* for a step that is as long as any */

static const double bgc_least_lively = 1e-6; /* what moves less, over its scale, is noise */

static const double bgc_of_the_time = 1e-15; /* a time is rounded by less than this part of it */

static const double bgc_drift_weight = 4.0; /* a residual comes to a half of its tolerance */
/* In a row: a power that grows from nothing has no energy to compare its error with at first. */
enum { BGC_MOST_ACCOUNT_REJECTIONS = 8 };

/* What to try after a step of length h whose error is beyond 1. */
static inline double bgc_shorter_step(double h, double error, double q) {
    return h * fmax(bgc_least_factor, bgc_safety * pow(error, -1.0 / q));
}

/* What to try after an accepted step of length h, from its error and the one before. One that was
 * cut short of what was wanted says nothing against that. */
static inline double bgc_next_step(double h, double wanted, double error, double before, double q,
                                   int may_grow) {
    const double factor =
        bgc_safety * pow(error, -bgc_proportional / q) * pow(before, bgc_integral / q);
    const double length =
        h * fmin(may_grow ? bgc_largest_factor : 1.0, fmax(bgc_least_factor, factor));

    return h < wanted ? fmax(wanted, length) : length;
}

/* The error that the next step is told of: a lucky small one does not slow it. */
static inline double bgc_remembered(double error) {
    return fmax(error, 1e-2);
}

#endif
