/* time_events.c: the first time at which a switch of time alone leaves its mode.
 *
 * Interval arithmetic bounds the arguments of these switches over a stretch of time. Where all stay within
 * their modes over a window of many steps, the steps of the window need no look at them. A step without such
 * a window is divided into pieces, from its start on, until each piece stays within the modes or a piece is found
 * whose end is outside: however narrow the excursion of an argument is, and whatever the step was chosen for.
 * Ranges that are too wide to decide leave a step to the samples of events.c.
 */
#include "switches.h"

#include <float.h>
#include <math.h>

static const double rounding_margin = 64.0 * DBL_EPSILON; /* of the size of an argument */
static const double narrow_part = 1e-4;   /* of a step: a bracket that is left to the location of the edge */
static const double shortest_part = 1e-9; /* of a step: a shorter excursion is not looked for */
static const double division = 8.0;       /* of a piece that does not decide; the next one is so much longer */
enum { LONGEST_WINDOW = 1024, SKIPPED_TRIES = 16 }; /* steps of a window; steps between two tries */
enum { MOST_RANGES = 400, MOST_UNDECIDED = 1024 };  /* of a step; steps left to samples in a row */

/* Whether the argument of switch k stays within its mode over this range. */
static int stays(const bgc_model *m, const bgc_data *d, int k, bgc_range z) {
    const double size = fmax(fabs(z.low), fabs(z.high));

    if (bgc_is_given_up(d, k)) {
        return 1;
    }
    if (isnan(d->mode[k]) || !isfinite(size) || bgc_is_outside(m, d, k, z.low) ||
        bgc_is_outside(m, d, k, z.high)) {
        return 0;
    }
    return z.low == z.high ||
           bgc_lesser_depth(m->switch_info[k].operation, d->mode[k], z.low, z.high) > rounding_margin * size;
}

/* The range of an argument over a stretch of this length, with its values at both ends, where its derivative is
 * within `rate`, which has both signs: the lines of these slopes through both values bound it. */
static bgc_range between(double first, double last, bgc_range rate, double length) {
    const double spread = rate.high - rate.low, most = rate.high * rate.low * length;

    return (bgc_range){(rate.high * first - rate.low * last + most) / spread,
                       (rate.high * last - rate.low * first - most) / spread};
}

/* Whether an argument of the range z[0], and of the range z[1] of its derivative, stays within the mode of switch k,
 * with its values at both ends of a stretch of this length. */
static int stays_between(const bgc_model *m, const bgc_data *d, int k, const bgc_range z[2], double first,
                         double last, double length) {
    bgc_range range;

    if (isnan(d->mode[k]) || !isfinite(z[1].low) || !isfinite(z[1].high)) {
        return 0;
    }
    if (z[1].low >= 0.0 || z[1].high <= 0.0) { /* it rises or falls all the way */
        return !bgc_is_outside(m, d, k, first) && !bgc_is_outside(m, d, k, last);
    }
    range = between(first, last, z[1], length);
    return stays(m, d, k, (bgc_range){fmax(range.low, z[0].low), fmin(range.high, z[0].high)});
}

/* Whether all switches of time alone stay within their modes over a stretch, by ranges alone. */
static int all_stay(const bgc_model *m, bgc_data *d, double from, double to) {
    m->timed_ranges(d->h_range, (bgc_range){from, to}, d->u_range, d->timed_range, (bgc_range *)d->work);
    for (int k = 0; k < m->n_timed; k++) {
        if (!stays(m, d, k, d->timed_range[2 * k])) {
            return 0;
        }
    }
    return 1;
}

/* What they do over a stretch, by ranges and their arguments at both ends. */
static bgc_outlook look_at(const bgc_model *m, bgc_data *d, double from, double to) {
    if (all_stay(m, d, from, to)) {
        return BGC_STAYS;
    }
    bgc_evaluate_timed(m, d, to, d->probe);
    for (int k = 0; k < m->n_timed; k++) {
        if (bgc_is_outside(m, d, k, d->probe[k])) {
            return BGC_LEAVES;
        }
    }
    bgc_evaluate_timed(m, d, from, d->after);
    for (int k = 0; k < m->n_timed; k++) {
        const bgc_range *z = d->timed_range + 2 * k;
        if (!stays(m, d, k, z[0]) && !stays_between(m, d, k, z, d->after[k], d->probe[k], to - from)) {
            return BGC_UNDECIDED;
        }
    }
    return BGC_STAYS;
}

/* Examines a window of steps as long as that from `from` to `to`; returns whether all stay within their modes
 * in it. */
static int is_quiet(const bgc_model *m, bgc_data *d, double from, double to) {
    bgc_core *core = &d->core;
    const double end = from + core->event_window * (to - from);

    if (!all_stay(m, d, from, end)) {
        core->skipped_tries = core->event_window > 1.0 ? 0 : SKIPPED_TRIES;
        core->event_window = fmax(core->event_window / 4.0, 1.0);
        return 0;
    }
    core->quiet_from = from;
    core->quiet_to = end;
    core->event_window = fmin(2.0 * core->event_window, LONGEST_WINDOW);
    return 1;
}

/* Examines a step piece by piece. Once a time outside is known, the event is between the pieces before and that
 * time. */
static bgc_outlook examine(const bgc_model *m, bgc_data *d, double from, double to, double *inside,
                           double *outside) {
    const double rounding = 4.0 * DBL_EPSILON * fmax(fabs(from), fabs(to));
    const double narrow = fmax(narrow_part * (to - from), rounding);
    const double least = fmax(shortest_part * (to - from), rounding);
    double at = from, end = to, piece = to - from;
    int leaves = 0;

    for (int n = 0; n < MOST_RANGES; n++) {
        const double next = at + piece < end ? at + piece : end;
        const bgc_outlook outlook = look_at(m, d, at, next);
        if (outlook == BGC_LEAVES) {
            leaves = 1;
            end = next;
        } else if (outlook == BGC_STAYS || next - at <= least) {
            at = next;
            piece *= division;
        } else {
            piece = (next - at) / division;
            continue;
        }
        if (!leaves && at >= end) {
            return BGC_STAYS;
        }
        if (leaves && end - at <= narrow) {
            *inside = at;
            *outside = end;
            return BGC_LEAVES;
        }
        piece = leaves ? 0.5 * (end - at) : piece;
    }
    return BGC_UNDECIDED;
}

/* Whether an argument has had no value: its switch gets a mode as soon as it has one. */
static int any_without_mode(const bgc_model *m, const bgc_data *d) {
    for (int k = 0; k < m->n_timed; k++) {
        if (isnan(d->mode[k]) && !bgc_is_given_up(d, k)) {
            return 1;
        }
    }
    return 0;
}

/* Discards the window: the times ahead have not been examined. */
void bgc_forget_quiet(bgc_data *d) {
    d->core.quiet_from = INFINITY;
    d->core.quiet_to = -INFINITY;
}

/* What the switches of time alone do in a step: the end of the bracket of their first event is outside the mode of
 * one of them. A new window is examined from time to time. */
bgc_outlook bgc_find_time_event(const bgc_model *m, bgc_data *d, double from, double to, double *inside,
                           double *outside) {
    bgc_core *core = &d->core;
    bgc_outlook outlook;

    if (from >= core->quiet_from && to <= core->quiet_to) {
        return BGC_STAYS;
    }
    if (m->timed_ranges == NULL || !(to > from) || any_without_mode(m, d)) {
        return BGC_UNDECIDED;
    }
    if (core->skipped_tries > 0) {
        core->skipped_tries--;
    } else if (is_quiet(m, d, from, to)) {
        return BGC_STAYS;
    }
    if (core->undecided_left > 0) {
        core->undecided_left--;
        return BGC_UNDECIDED;
    }
    outlook = examine(m, d, from, to, inside, outside);
    if (outlook == BGC_UNDECIDED) {
        core->undecided = core->undecided > 0 ? 2 * core->undecided : 1;
        core->undecided = core->undecided < MOST_UNDECIDED ? core->undecided : MOST_UNDECIDED;
        core->undecided_left = core->undecided;
    } else {
        core->undecided = 0;
    }
    return outlook;
}
