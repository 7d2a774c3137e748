/* switches.h: the modes of the switches of one instance. */
#ifndef BGC_SWITCHES_H
#define BGC_SWITCHES_H

#include "bgc_internal.h"
#include "modes.h"

#include <math.h>

static const double bgc_noise_factor = 4.0; /* changes below this many state tolerances are noise */

/* The result of an operation; a NaN of an undefined argument: kernels compare then, and an undefined
 * law that is not guarded makes f undefined. */
static inline double bgc_value_of(int operation, double z) {
    return isnan(z) ? z : bgc_result(operation, z);
}

/* Whether switch k is left to error control until the run ends. */
static inline int bgc_is_given_up(const bgc_data *d, int k) { return isinf(d->returns[k]); }

/* Whether the argument z is outside the range of the mode of switch k. */
static inline int bgc_is_outside(const bgc_model *m, const bgc_data *d, int k, double z) {
    const double mode = d->mode[k];

    return !isnan(mode) && !isnan(z) && bgc_value_of(m->switch_info[k].operation, z) != mode;
}

/* The same, but for switches whose change is negligible in the step under way. */
static inline int bgc_has_left(const bgc_model *m, const bgc_data *d, int k, double z) {
    return d->ignored[k] == 0.0 && bgc_is_outside(m, d, k, z);
}

static inline double bgc_depth_of(const bgc_model *m, const bgc_data *d, int k, double z) {
    return bgc_depth(m->switch_info[k].operation, d->mode[k], z);
}

#endif
