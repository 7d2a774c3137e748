/* ahead.c: up to what time no switch of time alone leaves its mode.
 *
 * Interval arithmetic bounds the arguments of these switches over a window of many steps. Where all stay within
 * their modes, the steps of the window need no look at them. A window that holds an edge is shortened until
 * it ends before, and after that steps look by themselves for a while.
 */
#include "switches.h"

#include <float.h>
#include <math.h>

static const double rounding_margin = 64.0 * DBL_EPSILON; /* of the size of an argument */
enum { LONGEST_WINDOW = 1024, SKIPPED_TRIES = 16 };         /* steps of a window; steps between two tries */

/* Whether the argument of switch k stays within its mode over this range. */
static int stays(const bgc_model *m, const bgc_data *d, int k, bgc_range z) {
    const double size = fmax(fabs(z.low), fabs(z.high));

    if (isnan(d->mode[k]) || !isfinite(size) || bgc_is_outside(m, d, k, z.low) ||
        bgc_is_outside(m, d, k, z.high)) {
        return 0;
    }
    return z.low == z.high ||
           bgc_lesser_depth(m->switch_info[k].operation, d->mode[k], z.low, z.high) > rounding_margin * size;
}

/* Examines a window of steps as long as that from the present to `end`; returns whether no switch of time
 * alone leaves its mode in it. */
static int is_quiet(const bgc_model *m, bgc_data *d, double end) {
    bgc_core *core = &d->core;
    const double to = core->t + core->quiet_ahead * (end - core->t);

    m->timed_ranges(d->h_range, (bgc_range){core->t, to}, d->u_range, d->timed_range,
                    (bgc_range *)d->work);
    for (int k = 0; k < m->n_timed; k++) {
        if (!stays(m, d, k, d->timed_range[k])) {
            core->skipped_tries = core->quiet_ahead > 1.0 ? 0 : SKIPPED_TRIES;
            core->quiet_ahead = fmax(core->quiet_ahead / 4.0, 1.0);
            return 0;
        }
    }
    core->quiet_from = core->t;
    core->quiet_to = to;
    core->quiet_ahead = fmin(2.0 * core->quiet_ahead, LONGEST_WINDOW);
    return 1;
}

/* Discards the window: the times ahead have not been examined. */
void bgc_forget_quiet(bgc_data *d) {
    d->core.quiet_from = INFINITY;
    d->core.quiet_to = -INFINITY;
}

/* Whether a step from the present to `end` is known to pass no edge of a switch of time alone. A new
 * window is examined from time to time. */
int bgc_stays_quiet(const bgc_model *m, bgc_data *d, double end) {
    bgc_core *core = &d->core;

    if (core->t >= core->quiet_from && end <= core->quiet_to) {
        return 1;
    }
    if (m->timed_ranges == NULL || !(end > core->t)) {
        return 0;
    }
    if (core->skipped_tries > 0) {
        core->skipped_tries--;
        return 0;
    }
    return is_quiet(m, d, end);
}
