/* switch_minima.c: what the samples of a step show of the arguments of switches between them. */
#include "switches.h"

#include <math.h>

static const double outside_part = 0.25, inside_part = 0.1; /* of an interval between samples */

/* The time of the minimum of the parabola through three depths, and its depth; a NaN and INFINITY where it
 * has none. */
double bgc_parabola_minimum(const double t[3], const double inside[3], double *least) {
    const double left = (inside[1] - inside[0]) / (t[1] - t[0]);
    const double right = (inside[2] - inside[1]) / (t[2] - t[1]);
    const double curvature = (right - left) / (t[2] - t[0]);
    const double at = 0.5 * (t[0] + t[1] - left / curvature);

    *least = INFINITY;
    if (!(curvature > 0.0)) {
        return (double)NAN;
    }
    *least = inside[0] + (at - t[0]) * (left + curvature * (at - t[1]));
    return at;
}

/* A point within three times that is close to a minimum at `at`, which may be a little before the step `t` or
 * behind it: the parabola can miss by so much a minimum within. Else a NaN. */
double bgc_point_within(const double times[3], double at, const double *t) {
    const double first = times[1] - times[0], last = times[2] - times[1];

    if (times[0] == t[0] && at <= times[0] && at > times[0] - outside_part * first) {
        return times[0] + inside_part * first;
    }
    if (times[2] == t[BGC_SAMPLES] && at >= times[2] && at < times[2] + outside_part * last) {
        return times[2] - inside_part * last;
    }
    return at > times[0] && at < times[2] ? at : (double)NAN;
}

/* Narrows three times with the depths there to those next to a point at which the switch has not left its mode. */
void bgc_narrow(double times[3], double inside[3], double at, double depth) {
    const int before = at < times[1], deeper = depth < inside[1];
    const int outer = before == deeper ? 2 : 0; /* the end that is replaced */

    if (deeper) {
        times[outer] = times[1];
        inside[outer] = inside[1];
    }
    times[deeper ? 1 : outer] = at;
    inside[deeper ? 1 : outer] = depth;
}

/* Whether an argument near the edge of its mode varies too fast for the samples of this step, z[0] at
 * its start and z[1 + i] at the points. */
int bgc_is_unresolved(const bgc_model *m, const bgc_data *d, int k, const double *const *z) {
    double here[BGC_SAMPLES + 1], low = z[0][k], high = low, nearest = bgc_depth_of(m, d, k, low);

    for (int i = 0; i <= BGC_SAMPLES; i++) {
        here[i] = z[i][k];
        low = fmin(low, here[i]);
        high = fmax(high, here[i]);
        nearest = fmin(nearest, bgc_depth_of(m, d, k, here[i]));
    }
    return bgc_excess_over_cubic(here) > 0.0 && nearest < high - low &&
           high - low > d->core.rtol * d->extent[k];
}

/* Whether an argument changes in this step by more than the tolerances of the states change it: a
 * smaller change is noise, which no shorter step resolves. */
int bgc_is_beyond_tolerances(const bgc_model *m, bgc_data *d, int k, const double *const *z) {
    double low = z[0][k], high = low;

    for (int i = 1; i <= BGC_SAMPLES; i++) {
        low = fmin(low, z[i][k]);
        high = fmax(high, z[i][k]);
    }
    bgc_perturb_by_tolerances(m, d, d->next, d->point);
    m->switches(d->h, d->core.t_end, d->point, d->u, d->after, d->work);
    return !(high - low <= bgc_noise_factor * fabs(d->after[k] - z[BGC_SAMPLES][k]));
}
