/* global_error.c: how far the states of a run are off, followed step by step.
 *
 * The error e, true minus computed, obeys M e' = J e between steps, and each step adds its local error l, of
 * local_error.c:
 *
 *   e_new = R(h J) e + l.
 *
 * R is a sum of four powers of S = (M - J/c)^-1 M with the factors of W = c M - J that the step has used, of order 3
 * and L-stable for gamma = 1/(c h) from 0.2236 to 0.5728; about 0.4359 three are the same. For less gamma, oscillations
 * that turn far in a step grow by four: there they have a part of three in them, which are of order 2 and L-stable from
 * 0.18 to 1. E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.6. The change of J over the step is
 * added to it, by a difference of f at the step's end; where it changes e by little it is left out until the next
 * measurement of l.
 * Explicit steps use three differences of f in a method of order 2 that keeps the amplitude of oscillations.
 * Where e points along the motion, the solution is late or early: that delay stays as it is in a model whose
 * f does not depend on time, however steep the motion becomes.
 *
 * Events: error_events.c. Global errors: J. Lang, J. Verwer, SIAM J. Sci. Comput. 29 (2007) 1460.
 */
#include "global_error.h"
#include "integrator.h"

#include <math.h>
#include <string.h>

enum { MOST_POWERS = 4, LEAST_POWERS = 3 };    /* of S, */
static const double three_from = 0.4, three_to = 0.46; /* gamma between which these suffice */
static const double stable_gamma = 0.2236;     /* below which four have this part of three in them, so that */
static const double low_order_part = 0.25;     /* |R(i y)| <= 1 from 0.21 on, */
static const double far_turn = 2.0;            /* where |h J e| / |e| is more than this */
static const double same_gamma = 1e-9;         /* relative difference of gamma, from rounding */
static const double beside_delay = 1e-2;       /* part of |e|^2 that may be left beside a delay */
static const double bent_chord = 0.3;          /* deviation of a chord from the slopes at its ends, relative */
static const double timed_slope = 1e-2;        /* part of the slope that may depend on time, squared */
static const double short_delay = 1e-2;        /* of a step: by so much a difference may leave its time */
static const double largest_turn = 1.7;       /* |h J| along e for the first of the two explicit formulas */
static const double slight_change = 1e-3;      /* of J e: it is left out */
static const double seen_bends = 1e-4;         /* relative size of e from which on bends of f are looked at, */
static const double most_bent = 0.3;           /* and their part in the change of e that is doubtful */

/* At the start of a run. */
void bgc_reset_errors(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof(double);

    memset(d->off, 0, size);
    memset(d->off_before, 0, size);
    memset(d->off_at_end, 0, size);
    memset(d->off_local, 0, size);
    memset(d->off_inside, 0, 3 * bgc_padded(m->n_state) * sizeof(double));
    memset(d->largest_off, 0, (size_t)m->n_output * sizeof(double));
    memset(d->last_off, 0, (size_t)m->n_output * sizeof(double));
    for (int k = 0; k < m->n_output; k++) {
        d->lowest[k] = HUGE_VAL;
        d->highest[k] = -HUGE_VAL;
    }
    d->core.off_noted = d->core.off_event = d->core.t;
    d->core.off_delayed = d->core.off_bends = 0;
    d->core.off_gamma = 0.0;
    d->core.off_slope = 0.0;
    d->core.off_method = -1;
    bgc_forget_local_error(&d->core);
}

/* --- slopes along e, and powers of S ------------------------------------------------------------ */

/* out = J v - delay df/dt at (t, y), where f is `f`, as a difference that leaves t by at most `most`. */
static void differentiate_along_error(const bgc_model *m, bgc_data *d, double t, const double *y, const double *f,
                                      const double *v, double delay, double most, double *out) {
    const double wanted = bgc_error_shift(m, d, y, v);
    const double shift = wanted * fabs(delay) > most ? most / fabs(delay) : wanted;

    for (int i = 0; i < m->n_state; i++) {
        d->point[i] = y[i] + shift * v[i];
    }
    m->rhs(d->h, t - shift * delay, d->point, d->u, out, d->work);
    for (int i = 0; i < m->n_state; i++) {
        out[i] = (out[i] - f[i]) / shift;
    }
}

/* Coefficients of S, S^2, .. so that their sum agrees with exp(h J) to so many terms; with gamma = 1 / (c h),
 * S^k = sum of C(k + j - 1, j) (gamma h J)^j. */
static void match_exponential(int terms, double gamma, double *coefficient) {
    double a[MOST_POWERS * MOST_POWERS], size[MOST_POWERS], factor = 1.0;
    int pivot[MOST_POWERS];

    for (int j = 0; j < terms; j++) {
        factor *= j > 0 ? 1.0 / (gamma * j) : 1.0;
        coefficient[j] = factor;
        for (int k = 0; k < terms; k++) { /* C(k + j, j), of S^(k + 1) */
            a[j * terms + k] = j == 0 ? 1.0 : a[(j - 1) * terms + k] * (k + j) / j;
        }
    }
    if (bgc_factorise_dense(terms, a, pivot, size) >= 0) {
        coefficient[0] = (double)NAN;
        return;
    }
    bgc_solve_dense(terms, a, pivot, coefficient);
}

/* The coefficients of R, kept while gamma and the part of three powers stay. */
static const double *powers_of_step(bgc_core *core, double gamma) {
    const int powers = gamma > three_from && gamma < three_to ? LEAST_POWERS : MOST_POWERS;
    const double part = gamma < stable_gamma && core->off_slope > far_turn ? low_order_part : 0.0;
    double lower[MOST_POWERS] = {0.0};

    if (core->off_part != part || !(fabs(core->off_gamma - gamma) <= same_gamma * gamma)) {
        match_exponential(powers, gamma, core->off_power);
        if (part > 0.0) {
            match_exponential(LEAST_POWERS, gamma, lower);
            for (int k = 0; k < MOST_POWERS; k++) {
                core->off_power[k] += part * (lower[k] - core->off_power[k]);
            }
        }
        core->off_powers = powers;
        core->off_part = part;
        core->off_gamma = gamma;
    }
    return core->off_power;
}

/* --- one step ---------------------------------------------------------------------------------- */

/* The delay of the computed solution where e points along the motion; 0 where it does not, or where its
 * parts would not stay small. */
static double delay_of_step(const bgc_model *m, bgc_data *d, const bgc_error_step *s) {
    double along = 0.0, error = 0.0, start = 0.0, end = 0.0, bent = 0.0, timed = 0.0;

    if (m->n_mass > 0 || !bgc_is_adaptive(s->method)) {
        return 0.0;
    }
    for (int i = 0; i < m->n_state; i++) {
        const double weight = 1.0 / bgc_tolerance(d, i, fmax(fabs(d->x[i]), fabs(d->next[i])));
        const double e = d->off[i] * weight, f0 = s->f_start[i] * weight, f1 = s->f_end[i] * weight;
        const double chord = (d->next[i] - d->x[i]) * (weight / s->h);
        const double shift = s->implicit ? s->h * d->dfdt[i] * weight : 0.0;
        along += f0 * e;
        error += e * e;
        start += f0 * f0;
        end += f1 * f1;
        bent += (f0 + f1 - 2.0 * chord) * (f0 + f1 - 2.0 * chord);
        timed += shift * shift;
    }
    if (!(start > 0.0) || error - along * along / start > beside_delay * error ||
        sqrt(bent) > bent_chord * (sqrt(start) + sqrt(end)) || timed > timed_slope * fmin(start, end)) {
        return 0.0;
    }
    return along / start;
}

/* change = (J_new - J) e - delay (df/dt_new - df/dt), the change of the slopes over the step along e at its end, with
 * J e = c (M e - right). Returns whether it is more than slight. */
static int find_change_of_slopes(const bgc_model *m, bgc_data *d, const bgc_error_step *s, const double *right,
                                 const double *product, double delay, double *change) {
    const double c = d->core.c;
    double changed = 0.0, slopes = 0.0, all = 0.0;

    differentiate_along_error(m, d, s->t + s->h, d->next, s->f_end, d->off, delay, short_delay * s->h, change);
    for (int i = 0; i < m->n_state; i++) {
        const double weight = 1.0 / bgc_tolerance(d, i, fabs(d->next[i]));
        const double slope = c * (product[i] - right[i]), own = c * product[i];
        change[i] += delay * d->dfdt[i] - slope;
        changed += change[i] * weight * (change[i] * weight);
        slopes += slope * weight * (slope * weight);
        all += own * weight * (own * weight);
    }
    d->core.off_slope = s->h * c * sqrt(slopes / all);
    return !(changed <= slight_change * slight_change * (slopes + all));
}

/* d->off := R d->off by the factors of the step. */
static void carry_implicit(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double delay, int measured) {
    const int n = m->n_state, looks = measured || d->core.off_bends;
    const double c = d->core.c;
    const double *power = powers_of_step(&d->core, 1.0 / (c * s->h));
    double *v = bgc_error_vector(m, d, 0), *right = bgc_error_vector(m, d, 1), *change = bgc_error_vector(m, d, 2);

    /* The powers of S by Horner's scheme. */
    for (int k = d->core.off_powers; k >= 1; k--) {
        for (int i = 0; i < n; i++) {
            v[i] = (k < d->core.off_powers ? v[i] : 0.0) + power[k - 1] * d->off[i];
        }
        bgc_apply_mass_to_error(m, d, v);
        for (int i = 0; i < n && k == 2 && delay != 0.0; i++) {
            v[i] -= s->h * delay * d->dfdt[i];
        }
        if (k == 1 && looks) {
            memcpy(right, v, (size_t)n * sizeof *v);
        }
        bgc_solve_for_error(m, d, v);
    }
    memcpy(d->off, v, (size_t)n * sizeof *v);

    /* The change of J: half of it over the step in slow parts, all of it where W is close to -J. */
    if (looks) {
        bgc_apply_mass_to_error(m, d, v);
        d->core.off_bends = find_change_of_slopes(m, d, s, right, v, delay, change);
    }
    if (looks && d->core.off_bends) {
        for (int i = 0; i < n; i++) {
            v[i] = (0.5 * s->h - 1.0 / c) * change[i];
        }
        bgc_solve_for_error(m, d, v);
        bgc_apply_mass_to_error(m, d, v);
        for (int i = 0; i < n; i++) {
            v[i] += change[i] / c;
        }
        bgc_solve_for_error(m, d, v);
        for (int i = 0; i < n; i++) {
            d->off[i] += v[i];
        }
    }
}

/* M^-1 h J v at the end of the step, or at its start. */
static void multiply_slopes(const bgc_model *m, bgc_data *d, const bgc_error_step *s, int later, const double *v,
                            double delay, double *out) {
    const double t = later ? s->t + s->h : s->t;

    differentiate_along_error(m, d, t, later ? d->next : d->x, later ? s->f_end : s->f_start, v, delay,
                              short_delay * s->h, out);
    for (int i = 0; i < m->n_state; i++) {
        out[i] *= s->h * d->inverse_mass[i];
    }
}

/* d->off := R(z) d->off over an explicit step, R = 1 + z + z^2/2 + b z^3 with z = h J. With b = 1/8
 * |R(i y)|^2 = 1 + y^6/64; b = 1/16 is stable to z = -6.26. */
static void carry_explicit(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double delay) {
    const int n = m->n_state;
    double *k1 = bgc_error_vector(m, d, 0), *k2 = bgc_error_vector(m, d, 1), *k3 = bgc_error_vector(m, d, 2);
    double *point = bgc_error_vector(m, d, 3), *change = bgc_error_vector(m, d, 5), b;

    multiply_slopes(m, d, s, 0, d->off, delay, k1);
    for (int i = 0; i < n; i++) {
        point[i] = d->off[i] + k1[i];
    }
    multiply_slopes(m, d, s, 1, point, delay, k2);
    for (int i = 0; i < n; i++) {
        point[i] = d->off[i] + 0.5 * (k1[i] + k2[i]);
    }
    multiply_slopes(m, d, s, 1, point, delay, k3);

    /* |z v| / |v| of the difference v of the last two points chooses b. */
    for (int i = 0; i < n; i++) {
        change[i] = 0.5 * (k2[i] - k1[i]);
        point[i] = k3[i] - k2[i];
    }
    b = bgc_norm(m, d, point, d->x, d->next) > largest_turn * bgc_norm(m, d, change, d->x, d->next) ? 1.0 / 16
                                                                                                      : 1.0 / 8;
    for (int i = 0; i < n; i++) {
        d->off[i] += 0.5 * k1[i] + (0.5 - 2.0 * b) * k2[i] + 2.0 * b * k3[i];
    }
}

/* f at a part of e away from the end of the step. */
static void find_beside(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double part, double *f) {
    for (int i = 0; i < m->n_state; i++) {
        d->point[i] = d->next[i] + part * d->off[i];
    }
    m->rhs(d->h, s->t + s->h, d->point, d->u, f, d->work);
}

/* Tests that f bends within e at the end of the step by a large part of what changes e there: the linearised equations
 * do not say then how it goes on. */
static int bends_within_error(const bgc_model *m, bgc_data *d, const bgc_error_step *s) {
    double *beyond = bgc_error_vector(m, d, 4), *before = bgc_error_vector(m, d, 5);
    double slopes = 0.0, bends = 0.0, all = 0.0, relative = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        relative = fmax(relative, d->core.rtol * fabs(d->off[i]) / bgc_tolerance(d, i, fabs(d->next[i])));
    }
    if (!(relative > seen_bends)) {
        return 0;
    }
    find_beside(m, d, s, 1.0, beyond);
    find_beside(m, d, s, -1.0, before);
    for (int i = 0; i < m->n_state; i++) {
        const double weight = 1.0 / bgc_tolerance(d, i, fabs(d->next[i])), e = d->off[i] * weight;
        const double slope = 0.5 * s->h * (beyond[i] - before[i]) * weight;
        const double bend = s->h * (0.5 * (beyond[i] + before[i]) - s->f_end[i]) * weight;
        slopes += slope * slope;
        bends += bend * bend;
        all += e * e;
    }
    return bends > most_bent * most_bent * fmax(slopes, all);
}

/* Tests that the modes are those of the step: a law that is undefined beyond its switch releases them. */
static int holds_modes(const bgc_model *m, const bgc_data *d) {
    return m->n_switch == 0 ||
           memcmp(d->u + m->n_input, d->mode, (size_t)m->n_switch * sizeof *d->mode) == 0;
}

/* f at the end of the step, at t, to vector 8. The next step begins with it, where no event is between, and counts
 * it as one of its own. */
static void find_slope_at_end(const bgc_model *m, bgc_data *d, double t) {
    bgc_core *core = &d->core;
    const size_t size = (size_t)m->n_state * sizeof(double);
    double *f_end = bgc_error_vector(m, d, 8);

    if (t == core->t_end && (core->f_at_end || core->f_last_at == t)) {
        memcpy(f_end, core->f_at_end ? d->error : d->f_last, size);
        return;
    }
    m->rhs(d->h, t, d->next, d->u, f_end, d->work);
    if (t == core->t_end && !core->event && holds_modes(m, d)) {
        memcpy(d->error, f_end, size);
        core->f_at_end = 1;
        core->counts.rhs++;
    }
}

/* Before d->next, to which a step of the method leads, becomes the present at t: carries the error to it. The counts,
 * and how solutions are checked, stay those of the step. */
void bgc_follow_error(const bgc_model *m, bgc_data *d, const bgc_method *method, double t) {
    bgc_core *core = &d->core;
    const bgc_error_step s = {.t = core->t,
                              .h = t - core->t,
                              .method = method,
                              .implicit = method->family->jacobian,
                              .f_start = d->f,
                              .f_end = bgc_error_vector(m, d, 8)};
    const int n = m->n_state, watched = core->watched;
    const bgc_pivoting pivoting = core->pivoting;
    double *local = bgc_error_vector(m, d, 9), *missed = bgc_error_vector(m, d, 11);
    bgc_counts counts;
    double delay;
    int measured;

    find_slope_at_end(m, d, t);
    counts = core->counts;
    if (core->off_method != method - bgc_methods) {
        bgc_forget_local_error(core);
        core->off_method = (int)(method - bgc_methods);
    }
    measured = bgc_local_error(m, d, &s, local, missed);
    if (measured && core->off_noted != core->t) {
        bgc_note_errors(m, d, core->t, d->x, d->u, d->off, NULL);
    }
    memcpy(d->off_before, d->off, (size_t)n * sizeof *d->off);
    for (int i = 0; i < n && measured; i++) {
        d->off[i] += missed[i];
    }

    /* A delay stays; the rest of e is carried. */
    delay = measured || core->off_delayed ? delay_of_step(m, d, &s) : 0.0;
    core->off_delayed = delay != 0.0;
    for (int i = 0; i < n && delay != 0.0; i++) {
        d->off[i] -= delay * bgc_rate_of_state(d, s.f_start, i);
    }
    if (s.implicit) {
        carry_implicit(m, d, &s, delay, measured);
    } else {
        carry_explicit(m, d, &s, delay);
    }
    for (int i = 0; i < n; i++) {
        d->off[i] += local[i];
    }
    if (!s.implicit && d->n_block > 0) {
        d->off[0] = (double)NAN; /* explicit steps solve the algebraic equations at each stage */
    }
    for (int i = 0; i < n && delay != 0.0; i++) {
        d->off[i] += delay * bgc_rate_of_state(d, s.f_end, i);
    }
    memcpy(d->off_at_end, d->off, (size_t)n * sizeof *d->off);
    if (core->event) {
        bgc_look_at_switches(m, d, t, s.f_end);
    }
    counts.doubtful_errors += measured && bends_within_error(m, d, &s);
    core->counts = counts;
    core->watched = watched;
    core->pivoting = pivoting;
}
