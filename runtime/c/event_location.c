/* event_location.c: the time of the first event between two times.
 *
 * One of them is known to be within all modes, the other outside one of them.
 */
#include "switches.h"

#include <float.h>
#include <math.h>

/* The arguments of the switches of time alone. */
void bgc_evaluate_timed(const bgc_model *m, bgc_data *d, double t, double *z) {
    (m->timed_switches != NULL ? m->timed_switches : m->switches)(d->h, t, d->x, d->u, z, d->work);
}

/* The arguments of all switches along the step under way, or of those of time alone. Only the states that they read
 * are interpolated. */
void bgc_evaluate_arguments(const bgc_model *m, bgc_data *d, bgc_route way, double t, double *z) {
    const double *x = d->x;

    if (way == BGC_TIME_ALONE) {
        bgc_evaluate_timed(m, d, t, z);
        return;
    }
    if (m->n_timed < m->n_switch) {
        if (m->n_switch_state > 0) {
            bgc_interpolate_some(m, d, t, m->n_switch_state, m->switch_state, d->point);
        } else {
            bgc_interpolate(m, d, t, d->point);
        }
        x = d->point;
    }
    m->switches(d->h, t, x, d->u, z, d->work);
}

/* The argument of switch k, which a jump has turned back, is beyond its edge at `low` by rounding: halves
 * the bracket until its start is within the mode, if it is anywhere. */
static void find_inside(const bgc_model *m, bgc_data *d, bgc_route way, int k, double resolution,
                        double *low, double *high, double *z_low, double *z_high) {
    while (*high - *low > 2.0 * resolution) {
        const double half = 0.5 * (*low + *high);
        bgc_evaluate_arguments(m, d, way, half, d->probe);
        if (!bgc_has_left(m, d, k, d->probe[k])) {
            *low = half;
            *z_low = d->probe[k];
            return;
        }
        *high = half;
        *z_high = d->probe[k];
    }
    d->core.unreturned = 1;
}

/* Locates a time in (low, high] at which switch k leaves its mode, by the ITP method, whose worst case
 * is that of bisection and whose order is that of the secant method: I. F. D. Oliveira, R. H. C.
 * Takahashi, ACM Transactions on Mathematical Software 47 (2020) 5. The switch has left its mode at
 * `high`. Returns the end of a bracket of the width of the rounding of times, or of one bit where
 * only time matters. */
static double locate(const bgc_model *m, bgc_data *d, bgc_route way, int k, double low, double high,
                     double z_low, double z_high) {
    const double resolution =
        (way == BGC_TIME_ALONE ? 0.25 : 2.0) * DBL_EPSILON * fmax(fabs(low), fabs(high));
    double width, bend, at_low, at_high, most;

    if (m->n_jump > 0 && d->turned[k] != 0.0 && bgc_depth_of(m, d, k, z_low) <= 0.0) {
        find_inside(m, d, way, k, resolution, &low, &high, &z_low, &z_high);
    }
    width = high - low;
    bend = 0.2 / width;
    at_low = bgc_depth_of(m, d, k, z_low);
    at_high = bgc_depth_of(m, d, k, z_high);
    most = ceil(log2(fmax(width / (2.0 * resolution), 1.0))) + 1.0;

    for (double j = 0.0; high - low > 2.0 * resolution; j += 1.0) {
        /* Interpolate by regula falsi, truncate towards the middle, project on its neighbourhood. */
        const double half = 0.5 * (low + high), length = high - low;
        const double reach = resolution * exp2(most - j) - 0.5 * length;
        const double falsi = at_low > at_high ? (at_low * high - at_high * low) / (at_low - at_high)
                                              : half;
        const double side = half >= falsi ? 1.0 : -1.0;
        const double shift = fmin(bend * length * length, fabs(half - falsi));
        const double moved = falsi + side * shift;
        double t = fabs(moved - half) <= reach ? moved : half - side * fmax(reach, 0.0);
        if (!(t > low && t < high)) {
            t = half;
            if (!(t > low && t < high)) {
                break;
            }
        }

        /* Keep the half with the change of mode. */
        bgc_evaluate_arguments(m, d, way, t, d->probe);
        if (bgc_has_left(m, d, k, d->probe[k])) {
            high = t;
            at_high = bgc_depth_of(m, d, k, d->probe[k]);
        } else {
            low = t;
            at_low = bgc_depth_of(m, d, k, d->probe[k]);
        }
    }

    /* The width so far is a bit of the end of the step; earlier times have more bits. A step that begins at
     * the edge keeps that width as its length. */
    while (way == BGC_TIME_ALONE && low > d->core.t) {
        const double half = 0.5 * (low + high);
        if (!(half > low && half < high)) {
            break;
        }
        bgc_evaluate_arguments(m, d, way, half, d->probe);
        if (bgc_has_left(m, d, k, d->probe[k])) {
            high = half;
        } else {
            low = half;
        }
    }
    return high;
}

/* The first time in (low, high] at which any switch leaves its mode; some have left it at `high`.
 * z_low and z_high are the arguments at both ends; on return z_high are those at the time returned.
 * Switches of time alone are not located along a step, which ends at their event already. */
double bgc_locate_first(const bgc_model *m, bgc_data *d, bgc_route way, double low, double high,
                        const double *z_low, double *z_high) {
    for (int k = 0; k < m->n_switch; k++) {
        const int timed = m->switch_info[k].timed;
        if ((way == BGC_TIME_ALONE && !timed) || (way == BGC_ALONG_STEP && timed && high == d->core.t_end) ||
            !bgc_has_left(m, d, k, z_high[k])) {
            continue;
        }
        high = locate(m, d, way, k, low, high, z_low[k], z_high[k]);
        bgc_evaluate_arguments(m, d, way, high, z_high);
    }
    return high;
}
