/* switches.h: the modes of the switches of one instance. */
#ifndef BGC_SWITCHES_H
#define BGC_SWITCHES_H

#include "bgc_internal.h"
#include "modes.h"

#include <math.h>

static const double bgc_rest_margin = 100.0; /* by which a kink at rest may vary more than it did (switch_margins.c) */
static const double bgc_noise_factor = 4.0; /* changes below this many state tolerances are noise */

/* d->ignored in the step under way: the change of a kink is negligible; a switch is far from the edge of its
 * mode. */
static const double bgc_released = 2.0, bgc_marked_far = 4.0;

/* The result of an operation; a NaN of an undefined argument: kernels compare then, and an undefined
 * law that is not guarded makes f undefined. */
static inline double bgc_value_of(int operation, double z) {
    return isnan(z) ? z : bgc_result(operation, z);
}

/* Whether switch k is left to error control until the run ends. */
static inline int bgc_is_given_up(const bgc_data *d, int k) { return isinf(d->returns[k]); }

/* Whether the argument z is outside the range of the mode of switch k. */
static inline int bgc_is_outside(const bgc_model *m, const bgc_data *d, int k, double z) {
    const int operation = m->switch_info[k].operation;
    const double mode = d->mode[k];

    if (operation == BGC_ABOVE) {
        return mode > 0.0 ? z <= 0.0 : mode == 0.0 && z > 0.0;
    }
    if (operation == BGC_NOT_BELOW) {
        return mode > 0.0 ? z < 0.0 : mode == 0.0 && z >= 0.0;
    }
    return !isnan(mode) && !isnan(z) && bgc_value_of(operation, z) != mode;
}

/* The same, but for switches whose change is negligible in the step under way, or which are far from it. */
static inline int bgc_has_left(const bgc_model *m, const bgc_data *d, int k, double z) {
    return d->ignored[k] == 0.0 && bgc_is_outside(m, d, k, z);
}

static inline double bgc_depth_of(const bgc_model *m, const bgc_data *d, int k, double z) {
    return bgc_depth(m->switch_info[k].operation, d->mode[k], z);
}

/* The lesser distance of two arguments from the edge of the mode of an operation. */
static inline double bgc_lesser_depth(int operation, double mode, double a, double b) {
    double first, second;

    if (operation == BGC_ABOVE || operation == BGC_NOT_BELOW) {
        first = mode > 0.0 ? a : -a;
        second = mode > 0.0 ? b : -b;
    } else {
        first = bgc_depth(operation, mode, a);
        second = bgc_depth(operation, mode, b);
    }
    return first < second ? first : second;
}

#endif
