/* corrections.h: when a fixed step is far too long, of one instance and of a batch. */
#ifndef BGC_CORRECTIONS_H
#define BGC_CORRECTIONS_H

#include "number.h"

/* A correction relative to the range of a state. An oscillation at 0.9 radians a step reaches this;
 * steps that resolve their motion stay below 0.1, most of them far below. */
static const double bgc_unresolved_part = 0.15;

/* The largest correction that does not show too long a step, of a state that has had this range. */
static inline number bgc_resolved_correction(number scale, number range) {
    return bgc_unresolved_part * number_larger(scale, range);
}

#endif
