/* subtolerance.c: states that fall below their tolerance and grow again by orders of magnitude, or that stay
 * below it.
 *
 * Below its tolerance error control does not see a state: a decay over many decades may end anywhere,
 * also with the wrong sign. Where the state then grows by an instability of its own, the run depends
 * on that remainder. The motion of a state that stays there may be wrong altogether, and so may be what it
 * moves. Whether it matters is left to the caller, who has the times to compare runs: a state may as well be
 * driven by others, or be of no effect.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double well_above = 10.0; /* times the tolerance: a state that has been resolved, */
static const double resolved = 30.0;   /* and one whose motion is right to some percent */
static const double regrown = 1e3;     /* times the tolerance, */
static const double of_size = 0.1;     /* or this part of the scale, if that is less */
static const double linear = 50.0;     /* a state that passes through zero at constant rate takes 500
                                        * times as long to grow as it was below its tolerance */

static const double least_motion = 1e5 * DBL_EPSILON; /* of the scale that states have reached: less is rounding */

enum { STILL, NEVER_ABOVE, ABOVE, BELOW_ONCE, BELOW, GROWING };

/* Sets the phase of state i, and between which multiples of its tolerance nothing happens to it. */
static void enter(bgc_data *d, int i, int phase, double limit) {
    double from = 0.0, to = resolved;

    switch (phase) {
    case STILL:
        to = fmin(resolved, least_motion / d->core.rtol);
        break;
    case ABOVE:
        from = 1.0;
        to = INFINITY;
        break;
    case BELOW_ONCE:
        to = -1.0;
        break;
    case BELOW:
        from = d->subtol_low[i] / limit;
        to = 1.0;
        break;
    case GROWING:
        from = 1.0;
        to = fmax(well_above, fmin(regrown, of_size / d->core.rtol));
        break;
    default:
        break;
    }
    d->subtol_phase[i] = phase;
    d->subtol_from[i] = from;
    d->subtol_to[i] = to;
}

/* No state has fallen, or stayed, below its tolerance. */
static const bgc_subtolerance_state nothing = {.low = INFINITY, .fell = -INFINITY, .grown = -INFINITY};

void bgc_reset_subtolerance(const bgc_model *m, bgc_data *d) {
    for (int i = 0; i < m->n_state; i++) {
        enter(d, i, STILL, 0.0);
        d->subtol[i] = nothing;
    }
}

/* Follows state i with a value at t that is beyond the multiples of its tolerance between which nothing
 * happens to it. One step below its tolerance may be a passage through zero; two are not. */
void bgc_follow_subtolerance_state(bgc_data *d, int i, double value, double limit, double t) {
    const double size = fabs(value);
    const int before = (int)d->subtol_phase[i];
    bgc_subtolerance_state *found = d->subtol + i;
    int phase = before;

    if (before <= NEVER_ABOVE) {
        phase = size > resolved * limit ? ABOVE : NEVER_ABOVE;
        if (!(found->grown > found->fell)) { /* no fall before a jump */
            *found = phase == ABOVE ? nothing : (bgc_subtolerance_state){limit, size, t, t, value};
        }
    } else if (size < limit) {
        if (before == ABOVE) {
            d->subtol_low[i] = INFINITY;
            d->subtol_entered[i] = t;
        }
        if (size < d->subtol_low[i]) {
            d->subtol_low[i] = size;
            d->subtol_at[i] = t;
        }
        phase = before == ABOVE ? BELOW_ONCE : BELOW;
    } else if (before == BELOW_ONCE) {
        phase = ABOVE;
    } else if (before == BELOW) {
        phase = GROWING;
        d->subtol_left[i] = t;
    }
    enter(d, i, phase, limit);
    if (phase == GROWING && size > d->subtol_to[i] * limit) {
        const double below = d->subtol_left[i] - d->subtol_entered[i], low = d->subtol_low[i];
        enter(d, i, ABOVE, limit);
        if (t - d->subtol_left[i] <= linear * below && low < found->low) {
            *found = (bgc_subtolerance_state){limit, low, d->subtol_at[i], t, value};
        }
    }
}

int bgc_get_subtolerance(const bgc_model *m, const bgc_data *d, int k, bgc_subtolerance_state *state) {
    if (k < 0 || k >= m->n_state || d->subtol[k].grown == -(double)INFINITY) {
        return 0;
    }
    *state = d->subtol[k];
    return 1;
}
