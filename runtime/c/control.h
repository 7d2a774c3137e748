/* control.h: control of the step length, of one instance and of a batch, whose lanes share a step.
 *
 * PI control: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2. Errors are
 * relative to the tolerances and fall with the power q of the step.
 */
#ifndef BGC_CONTROL_H
#define BGC_CONTROL_H

#include <float.h>
#include <math.h>

static const double bgc_safety = 0.9, bgc_least_factor = 0.2, bgc_largest_factor = 5.0;
static const double bgc_proportional = 0.7, bgc_integral = 0.4;
static const double bgc_least_error = 1e-10; /* a smaller error counts as this */

/* Consecutive attempts that the error of the accounts may reject: a power that grows from nothing
 * has no energy at first that its error could be compared with. */
enum { BGC_MOST_ACCOUNT_REJECTIONS = 8 };

/* --- the length of the next step -------------------------------------------------------------- */

/* After a step of length h whose error is above 1. */
static inline double bgc_shorter_step(double h, double error, double q) {
    return h * fmax(bgc_least_factor, bgc_safety * pow(error, -1.0 / q));
}

/* After an accepted step of length h, from its error and that of the step before. A step that was cut
 * below the wanted length does not shorten the next one. */
static inline double bgc_next_step(double h, double wanted, double error, double before, double q,
                                   int may_grow) {
    const double factor =
        bgc_safety * pow(error, -bgc_proportional / q) * pow(before, bgc_integral / q);
    const double length =
        h * fmin(may_grow ? bgc_largest_factor : 1.0, fmax(bgc_least_factor, factor));

    return h < wanted ? fmax(wanted, length) : length;
}

/* The error that enters the control of the next step: a very small one does not slow it. */
static inline double bgc_remembered(double error) {
    return fmax(error, 1e-2);
}

/* --- times ------------------------------------------------------------------------------------ */

/* Times closer than this count as equal. A call of fmax after vector code costs as much as fifty
 * additions. */
static inline double bgc_time_slack(double t, double t_old) {
    const double rounding = 8.0 * DBL_EPSILON * fabs(t), part = 1e-9 * (t - t_old);

    return rounding > part ? rounding : part;
}

/* Whether a step of length h is lost in the rounding of the time. */
static inline int bgc_is_too_short(double t, double h) {
    return h < fmax(16.0 * DBL_EPSILON * fabs(t), 1e-30);
}

/* Limits a step from t to the next stop, and ends it there exactly if it reaches that far. A step
 * that leaves less than its own length is halved, so that no tiny one follows. Sets t_new. */
static inline double bgc_limit_step(double t, double h, double stop, double *t_new) {
    const double rest = stop - t;

    if (h >= 0.999 * rest) {
        *t_new = stop;
        return rest;
    }
    h = fmin(h, 0.5 * rest);
    *t_new = t + h;
    return h;
}

#endif
