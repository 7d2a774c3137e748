/* watch.c: pulses of functions of states that a step jumps over.
 *
 * exp(z), with z = -((x - a)/w)^2, differs from zero for a moment while x passes a. The argument z moves
 * smoothly along the dense output of a step even where exp(z) does not, so its largest value inside the
 * step shows what no stage has seen. A step that hides such a pulse is rejected, if f shows that it
 * matters, and the next one ends before it.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

static const double hidden_part = 0.5; /* of the variation between the ends: beyond lies a pulse */
static const double wide = 0.2;        /* part of a step: stages see what is wider */
static const double slow = 0.3;        /* variation of an argument whose function has no narrow pulse */
static const double matters = 0.1;     /* change of the states by a pulse, over the tolerances */
static const double before = 3.0;      /* widths of a pulse by which a step ends before it */
enum { REFINEMENTS = 8, MOST_IN_A_ROW = 30 };

/* The value of a function, up to a factor; `towards` is 1 where it has its pulses at large arguments,
 * else -1. */
static double value_of_kind(int kind, double z) {
    return kind == BGC_EXPONENTIAL ? exp(z) : kind == BGC_SATURATING ? tanh(z) : 1.0 / z;
}

/* The direction of the argument towards a pulse; 0 where its samples show the function move anyway. */
static double direction_of(int kind, const double *z) {
    if (kind == BGC_EXPONENTIAL) {
        return 1.0;
    }
    for (int i = 1; i <= BGC_SAMPLES; i++) {
        if (!(z[i] * z[0] > 0.0)) {
            return 0.0;
        }
    }
    return z[0] > 0.0 ? -1.0 : 1.0;
}

/* The place between the outer two of three samples where a parabola through them is highest; a NaN where
 * that is not between them. */
static double top_of(const double s[3], const double g[3], double *highest, double *bend) {
    const double left = (g[1] - g[0]) / (s[1] - s[0]), right = (g[2] - g[1]) / (s[2] - s[1]);
    const double curvature = (right - left) / (s[2] - s[0]);
    const double at = 0.5 * (s[0] + s[1] - left / curvature);

    *bend = curvature;
    *highest = g[0] + (at - s[0]) * (left + curvature * (at - s[1]));
    return curvature < 0.0 && at > s[0] && at < s[2] ? at : (double)NAN;
}

/* The part of a step over which a function falls from its value at a peak to a part of it. */
static double peak_width(int kind, double peak, double bend) {
    const double fall = kind == BGC_RECIPROCAL ? fabs(peak) : 1.0;

    return fmin(1.0, sqrt(fall / fmax(-bend, 1e-300)));
}

/* Whether a peak is hidden: narrow, and far outside the values at the ends of the step, which its stages
 * see. */
static int is_hidden_peak(int kind, const double *z, double peak, double width) {
    const double v = value_of_kind(kind, peak), v0 = value_of_kind(kind, z[0]);
    const double v1 = value_of_kind(kind, z[BGC_SAMPLES]);

    return isfinite(v) && width < wide &&
           fmax(v - fmax(v0, v1), fmin(v0, v1) - v) > hidden_part * fabs(v1 - v0);
}

/* Where an argument, by its values z at the start and the samples, may be farthest towards a hidden pulse; a
 * NaN where there is none. */
double bgc_hidden_peak(int kind, const double *z) {
    const double direction = direction_of(kind, z);
    double best = -INFINITY, found = (double)NAN, bend = 0.0;

    for (int i = 0; i + 2 <= BGC_SAMPLES && direction != 0.0; i++) {
        double s[3], g[3], highest, curvature, at;
        for (int j = 0; j < 3; j++) {
            s[j] = i + j == 0 ? 0.0 : bgc_sample_at[i + j - 1];
            g[j] = direction * z[i + j];
        }
        at = top_of(s, g, &highest, &curvature);
        if (isfinite(at) && highest > best) {
            best = highest;
            bend = curvature;
            found = at;
        }
    }
    if (!isfinite(found)) {
        return found;
    }

    /* A parabola may pass zero where the argument does not. */
    if (kind != BGC_EXPONENTIAL && best > -0.1 * fabs(z[0])) {
        return peak_width(kind, 0.1 * z[0], bend) < wide ? found : (double)NAN;
    }
    return is_hidden_peak(kind, z, direction * best, peak_width(kind, best, bend)) ? found : (double)NAN;
}

/* All arguments at the part s of the step to `end`, by the states that they read. */
static void evaluate_watched(const bgc_model *m, bgc_data *d, double s, double end, double *z) {
    const double t = d->core.t + s * (end - d->core.t);

    if (s > 0.0 && m->n_watch_state > 0) {
        bgc_interpolate_some(m, d, t, m->n_watch_state, m->watch_state, d->point);
    } else if (s > 0.0) {
        bgc_interpolate(m, d, t, d->point);
    }
    m->watched(d->h, t, s > 0.0 ? d->point : d->x, d->u_step, z, d->work);
}

static double argument_at(const bgc_model *m, bgc_data *d, int k, double s, double end) {
    evaluate_watched(m, d, s, end, d->watch_probe);
    return d->watch_probe[k];
}

/* Refines the place of a peak of argument k by parabolas through its true values; sets its height, and the
 * width over which the function falls to a part of its value. */
static double refine_peak(const bgc_model *m, bgc_data *d, int k, const double *z, double at, double end,
                     double *peak, double *width) {
    const double direction = direction_of(m->watch[k], z);
    double s[3] = {0.0, at, 1.0}, g[3], left, right, bend;
    int i = 0;

    while (i < BGC_SAMPLES - 1 && bgc_sample_at[i] <= at) {
        i++;
    }
    s[0] = i > 0 ? bgc_sample_at[i - 1] : 0.0; /* the samples around it */
    s[2] = bgc_sample_at[i];
    g[0] = direction * z[i];
    g[2] = direction * z[i + 1];
    g[1] = direction * argument_at(m, d, k, at, end);
    for (int n = 0; n < REFINEMENTS; n++) {
        double highest, here;
        at = top_of(s, g, &highest, &bend);
        if (!isfinite(at) || fabs(at - s[1]) < 1e-6 * (s[2] - s[0])) {
            break;
        }
        here = direction * argument_at(m, d, k, at, end);
        if (here > g[1]) {
            const int outer = at < s[1] ? 2 : 0;
            s[outer] = s[1];
            g[outer] = g[1];
            s[1] = at;
            g[1] = here;
        } else {
            s[at < s[1] ? 0 : 2] = at;
            g[at < s[1] ? 0 : 2] = here;
        }
    }
    *peak = direction * g[1];
    left = (g[0] - g[1]) / ((s[1] - s[0]) * (s[1] - s[0]));
    right = (g[2] - g[1]) / ((s[2] - s[1]) * (s[2] - s[1]));
    *width = peak_width(m->watch[k], *peak, fmin(left, right));
    return s[1];
}

/* Whether f at a peak differs by enough from f at the ends of the step, over the width of the peak. */
static int does_matter(const bgc_model *m, bgc_data *d, double s, double width, double end) {
    const double h = end - d->core.t, t = d->core.t + s * h;

    bgc_interpolate(m, d, t, d->point);
    m->rhs(d->h, t, d->point, d->u_step, d->right, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        const double change = d->right[i] - d->f[i];
        if (d->inverse_mass[i] == 0.0 && d->algebraic[i] == 0.0) {
            return 1;
        }
        d->right[i] = width * h * d->inverse_mass[i] * change;
    }
    return !(bgc_norm(m, d, d->right, d->x, d->next) <= matters);
}

/* The arguments at the start (0) or at a sample. */
static double *watched_place(const bgc_model *m, const bgc_data *d, int i) {
    return d->watch_sample + (size_t)i * (size_t)m->n_watch;
}

/* Whether the arguments hardly move in a step, by the start and the first samples. */
static int are_all_slow(const bgc_model *m, const bgc_data *d) {
    for (int k = 0; k < m->n_watch; k++) {
        double low = watched_place(m, d, 0)[k], high = low;
        for (int j = 0; j < BGC_FIRST_SAMPLES; j++) {
            const double z = watched_place(m, d, bgc_first_sample[j])[k];
            low = z < low ? z : low;
            high = z > high ? z : high;
        }
        if (!(high - low < (m->watch[k] == BGC_RECIPROCAL ? slow * fabs(low + high) : slow))) {
            return 0;
        }
    }
    return 1;
}

/* After a step to d->next at `end`, with its dense output stored: the length of the step that ends before
 * the first pulse hidden in it; INFINITY where there is none. */
double bgc_before_hidden(const bgc_model *m, bgc_data *d, double end) {
    const double h = end - d->core.t;
    double shortest = INFINITY;

    if (d->core.hidden >= MOST_IN_A_ROW) {
        return INFINITY;
    }

    /* Arguments at the start and the samples: at a few first. */
    evaluate_watched(m, d, 0.0, end, watched_place(m, d, 0));
    for (int j = 0; j < BGC_FIRST_SAMPLES; j++) {
        const int i = bgc_first_sample[j];
        evaluate_watched(m, d, bgc_sample_at[i - 1], end, watched_place(m, d, i));
    }
    if (are_all_slow(m, d)) {
        return INFINITY;
    }
    for (int i = 1; i < BGC_SAMPLES; i++) {
        evaluate_watched(m, d, bgc_sample_at[i - 1], end, watched_place(m, d, i));
    }

    /* Peaks between them. */
    for (int k = 0; k < m->n_watch; k++) {
        double z[BGC_SAMPLES + 1], at, peak, width;
        for (int i = 0; i <= BGC_SAMPLES; i++) {
            z[i] = watched_place(m, d, i)[k];
        }
        at = bgc_hidden_peak(m->watch[k], z);
        if (!isfinite(at)) {
            continue;
        }
        at = refine_peak(m, d, k, z, at, end, &peak, &width);
        if (is_hidden_peak(m->watch[k], z, peak, width) && does_matter(m, d, at, width, end)) {
            shortest = fmin(shortest, fmin(0.5, fmax(at - before * width, 0.5 * width)) * h);
        }
    }
    return shortest;
}
