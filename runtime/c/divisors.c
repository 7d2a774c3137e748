/* divisors.c: divisors of the equations that vanish at a state, such as the reduced mass of an inertia
 * behind a modulus that passes through zero. The rates have a pole there, which a step may jump over.
 *
 * Divisors are evaluated at samples of the dense output of each step. One that changes its sign
 * vanishes between two of them. One that is a square, as a mass is, touches zero from one side: where
 * it falls to a fraction within the step, its least value is searched for.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

static const double zero_crossing = 1e-6; /* relative to the samples around a change of sign */
static const double touching = 1e-9;      /* relative to the samples on both sides of a minimum */
static const double at_end = 1e-12;       /* relative to the sample before, at an end of the step */
static const double dip = 0.3;            /* samples that fall to this part of another */
static const double quadratic = 0.1;      /* of the ratio of square roots next to an end */
static const double suspect = 1e-4;       /* after a failed step: relative to the largest so far */
static const double close_by = 1e-3;      /* the same: predicted time to zero, relative to the run */
static const double golden = 0.38196601125010515;
enum { BISECTIONS = 60 };

/* Forgets the sizes and slopes of the divisors. */
void bgc_reset_divisors(const bgc_model *m, bgc_data *d) {
    memset(d->divisor_extent, 0, (size_t)m->n_divisor * sizeof *d->divisor_extent);
    memset(d->divisor_slope, 0, (size_t)m->n_divisor * sizeof *d->divisor_slope);
}

/* The divisors at t inside the last step to z. */
static void divisors_at(const bgc_model *m, bgc_data *d, double t, double *z) {
    bgc_interpolate(m, d, t, d->point);
    m->divisors(d->h, t, d->point, d->u_step, z, d->work);
}

/* Divisor k at t inside the last step. */
static double divisor_at(const bgc_model *m, bgc_data *d, int k, double t) {
    double *z = d->divisors + BGC_SAMPLES * bgc_padded(m->n_divisor);

    divisors_at(m, d, t, z);
    return z[k];
}

/* The time between low and high at which divisor k, of the sign of `before` at low, changes it. */
static double bisect(const bgc_model *m, bgc_data *d, int k, double before, double low,
                     double high) {
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = 0.5 * (low + high);
        if (divisor_at(m, d, k, middle) * before > 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return high;
}

/* The time between low and high at which divisor k is closest to zero: golden section search. */
static double closest(const bgc_model *m, bgc_data *d, int k, double low, double high) {
    double first = low + golden * (high - low), second = high - golden * (high - low);
    double z1 = fabs(divisor_at(m, d, k, first)), z2 = fabs(divisor_at(m, d, k, second));

    for (int i = 0; i < BISECTIONS; i++) {
        if (z1 < z2) {
            high = second;
            second = first;
            z2 = z1;
            first = low + golden * (high - low);
            z1 = fabs(divisor_at(m, d, k, first));
        } else {
            low = first;
            first = second;
            z1 = z2;
            second = high - golden * (high - low);
            z2 = fabs(divisor_at(m, d, k, second));
        }
    }
    return z1 < z2 ? first : second;
}

/* Whether divisor k changes its sign through zero, rather than a pole, before sample i. */
static int crosses(const bgc_model *m, bgc_data *d, int k, int i, const double *time) {
    const double *z = d->divisors + k;
    const double before = z[(size_t)(i - 1) * bgc_padded(m->n_divisor)];
    const double after = z[(size_t)i * bgc_padded(m->n_divisor)];

    d->core.failed_time = bisect(m, d, k, before, time[i - 1], time[i]);
    return fabs(divisor_at(m, d, k, d->core.failed_time)) <=
           zero_crossing * fmax(fabs(before), fabs(after));
}

/* Whether divisor k touches zero around its smallest sample i: between two samples that are much
 * larger, or at an end of the step, as the square of the distance in time. A divisor that is small
 * on one side, such as the resistance of a switch, does neither. */
static int touches(const bgc_model *m, bgc_data *d, int k, int i, const double *time) {
    const size_t width = bgc_padded(m->n_divisor);
    const double *z = d->divisors + k;
    const int last = BGC_SAMPLES - 1, inner = i == 0 ? 1 : i - 1;
    const int left = i > 0 ? i - 1 : 0, right = i < last ? i + 1 : last;
    const double before = fabs(z[(size_t)left * width]), after = fabs(z[(size_t)right * width]);
    const double at = closest(m, d, k, time[left], time[right]);

    d->core.failed_time = at;
    if (fabs(divisor_at(m, d, k, at)) <= touching * fmin(before, after)) {
        return 1;
    }
    d->core.failed_time = time[i];
    if ((i == 0 || i == last) &&
        fabs(z[(size_t)i * width]) <= at_end * fabs(z[(size_t)inner * width])) {
        const int next = i == 0 ? 2 : i - 2;
        const double ratio = z[(size_t)inner * width] / z[(size_t)next * width];
        return fabs(sqrt(fabs(ratio)) - 0.5) <= quadratic;
    }
    return 0;
}

/* BGC_VANISHING where a divisor vanishes between the start of the last step and `end`:
 * core.failed_divisor, core.failed_time. */
bgc_status bgc_check_divisors(const bgc_model *m, bgc_data *d, double end) {
    const size_t width = bgc_padded(m->n_divisor);
    double time[BGC_SAMPLES];

    for (int i = 0; i < BGC_SAMPLES; i++) {
        const double part = (double)i / (BGC_SAMPLES - 1);
        time[i] = i == BGC_SAMPLES - 1 ? end : d->core.t_old + part * (end - d->core.t_old);
        divisors_at(m, d, time[i], d->divisors + (size_t)i * width);
    }
    for (int k = 0; k < m->n_divisor; k++) {
        const double *z = d->divisors + k;
        double largest = 0.0, least = INFINITY;
        int turning = -1, lowest = 0;

        /* Sizes, the sample closest to zero, and the first change of sign. */
        for (int i = 0; i < BGC_SAMPLES; i++) {
            const double size = fabs(z[(size_t)i * width]);
            largest = fmax(largest, size);
            lowest = size < least ? i : lowest;
            least = fmin(least, size);
            if (turning < 0 && i > 0 && z[(size_t)i * width] * z[(size_t)(i - 1) * width] < 0.0) {
                turning = i;
            }
        }
        d->divisor_extent[k] = fmax(d->divisor_extent[k], largest);
        if ((turning > 0 && crosses(m, d, k, turning, time)) ||
            (least <= dip * largest && touches(m, d, k, lowest, time))) {
            d->core.failed_divisor = k;
            return BGC_VANISHING;
        }
        d->divisor_slope[k] = (z[(BGC_SAMPLES - 1) * width] - z[(BGC_SAMPLES - 2) * width]) /
                              (time[BGC_SAMPLES - 1] - time[BGC_SAMPLES - 2]);
    }
    return BGC_OK;
}

/* After a step from the present that failed: BGC_VANISHING where a divisor is next to zero there, and
 * was about to reach it. */
bgc_status bgc_blame_divisor(const bgc_model *m, bgc_data *d, bgc_status status) {
    const double t = d->core.t, run = fmax(fabs(t), t - d->core.origin);

    if (m->n_divisor == 0 || !(status == BGC_STEP_TOO_SMALL || status == BGC_NOT_FINITE ||
                               status == BGC_SINGULAR || status == BGC_NOT_CONVERGED)) {
        return status;
    }
    m->divisors(d->h, t, d->x, d->u, d->divisors, d->work);
    for (int k = 0; k < m->n_divisor; k++) {
        const double z = d->divisors[k], slope = d->divisor_slope[k];
        if (fabs(z) <= suspect * d->divisor_extent[k] && z * slope <= 0.0 &&
            fabs(z) <= close_by * run * fabs(slope)) {
            d->core.failed_divisor = k;
            d->core.failed_time = t;
            return BGC_VANISHING;
        }
    }
    return status;
}
