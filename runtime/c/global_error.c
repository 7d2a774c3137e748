/* global_error.c: how far the states of a run are off, followed step by step.
 *
 * The error e, true minus computed, obeys M e' = J e between steps, and each step adds its local error:
 *
 *   e_new = R(h J) e + l.
 *
 * l is what is missing in M (y_new - y) = integral of f, by Lobatto's quadrature of order 6 with f at two points
 * inside the step. The dense output there is corrected by one sweep of the collocation equations first, since
 * its error would count: K. Dutt, L. Greengard, V. Rokhlin, BIT 40 (2000) 241. R is a sum of powers of
 * S = (M - J/c)^-1 M with the factors of W = c M - J that the step has used, of order 3 but for a part of order 2
 * that makes it stable on the imaginary axis; the change of J over the step is added to it. Explicit steps use
 * differences of f in a method of order 3.
 * Where e points along the motion, the solution is late or early: that delay stays as it is in a model whose
 * f does not depend on time, however steep the motion becomes.
 *
 * At an event e jumps by the saltation matrix: S. Galan, W. Feehery, P. Barton, Applied Numerical Mathematics
 * 31 (1999) 17. Global errors: J. Lang, J. Verwer, SIAM J. Sci. Comput. 29 (2007) 1460.
 */
#include "bgc_internal.h"
#include "integrator.h"
#include "interpolation.h"

#include <math.h>
#include <string.h>

enum { ERROR_POWERS = 4 };                       /* of S */
static const double low_order_part = 0.25;     /* of order 2 in R: |R(i y)| <= 1 from gamma = 0.21 on */
static const double beside_delay = 1e-2;   /* part of |e|^2 that may be left beside a delay */
static const double bent_chord = 0.3;          /* deviation of a chord from the slopes at its ends, relative */
static const double timed_slope = 1e-2;    /* part of the slope that may depend on time, squared */
static const double error_node[2] = {0.27639320225002103, 0.72360679774997897}; /* Lobatto's, inside */
static const double node_weight[2][4] = {        /* integrals from the start to the nodes */
    {0.11030056647916491, 0.18969943352083510, -0.033907364229143883, 0.010300566479164914},
    {0.073032766854168419, 0.45057403089581055, 0.22696723314583160, -0.026967233145831604}};
static const double end_weight[4] = {1.0 / 12, 5.0 / 12, 5.0 / 12, 1.0 / 12};

/* At the start of a run. */
void bgc_reset_errors(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof(double);

    memset(d->off, 0, size);
    memset(d->off_before, 0, size);
    memset(d->off_at_end, 0, size);
    memset(d->off_inside, 0, 2 * bgc_padded(m->n_state) * sizeof(double));
    memset(d->largest_off, 0, (size_t)m->n_output * sizeof(double));
    for (int k = 0; k < m->n_output; k++) {
        d->lowest[k] = HUGE_VAL;
        d->highest[k] = -HUGE_VAL;
    }
    d->core.off_noted = d->core.t;
}

/* --- products and solutions -------------------------------------------------------------------- */

static double *error_vector(const bgc_model *m, const bgc_data *d, int k) {
    return d->off_work + (size_t)k * bgc_padded(m->n_state);
}

/* v := M v. */
static void apply_mass_to_error(const bgc_model *m, bgc_data *d, double *v) {
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, v, d->magnitude);
        memcpy(v, d->magnitude, (size_t)m->n_state * sizeof *v);
    }
}

/* v := W^-1 c v. A vector that cannot be solved for becomes NaN, and so do the errors. */
static void solve_for_error(const bgc_model *m, bgc_data *d, double *v) {
    for (int i = 0; i < m->n_state; i++) {
        v[i] *= d->core.c;
    }
    if (bgc_solve(m, d, v) != BGC_OK) {
        v[0] = (double)NAN;
    }
}

/* A factor by which a difference along v from y is neither lost in rounding nor nonlinear. */
static double difference_shift(const bgc_model *m, const bgc_data *d, const double *y, const double *v) {
    double part = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        const double size = fabs(y[i]) + d->scale[i] * d->core.counts.scale_reached;
        part = fmax(part, fabs(v[i]) / size);
    }
    return part > 1e-4 ? 1e-4 / part : part > 0.0 && part < 1e-8 ? 1e-8 / part : 1.0;
}

/* out = J v - delay df/dt at (t, y), where f is `f`, as a difference. */
static void differentiate_along_error(const bgc_model *m, bgc_data *d, double t, const double *y,
                                const double *f, const double *v, double delay, double *out) {
    const double shift = difference_shift(m, d, y, v);

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
    double a[ERROR_POWERS * ERROR_POWERS], size[ERROR_POWERS], factor = 1.0;
    int pivot[ERROR_POWERS];

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

/* The coefficients of R, kept while gamma stays. */
static const double *powers_of_step(bgc_core *core, double gamma) {
    double lower[ERROR_POWERS] = {0.0};

    if (core->off_gamma != gamma) {
        match_exponential(ERROR_POWERS, gamma, core->off_power);
        match_exponential(ERROR_POWERS - 1, gamma, lower);
        for (int k = 0; k < ERROR_POWERS; k++) {
            core->off_power[k] += low_order_part * (lower[k] - core->off_power[k]);
        }
        core->off_gamma = gamma;
    }
    return core->off_power;
}

/* --- one step ---------------------------------------------------------------------------------- */

/* f at a step's start, its two nodes and its end; the states at the nodes. */
typedef struct {
    double t, h;
    const double *f[4];
    double *inner[2], *f_inner[2];
} step_slopes;

/* The integral of f from the start of the step with these weights, in entry i. */
static double integral_within(const step_slopes *s, const double *w, int i) {
    return s->h * (w[0] * s->f[0][i] + w[1] * s->f[1][i] + w[2] * s->f[2][i] + w[3] * s->f[3][i]);
}

static void evaluate_error_nodes(const bgc_model *m, bgc_data *d, const step_slopes *s) {
    for (int k = 0; k < 2; k++) {
        m->rhs(d->h, s->t + error_node[k] * s->h, s->inner[k], d->u, s->f_inner[k], d->work);
    }
}

/* f at the points of a step to d->next, after one sweep that corrects the dense output at the nodes by
 * d->off_inside. */
static void correct_error_nodes(const bgc_model *m, bgc_data *d, const step_slopes *s, int implicit) {
    const size_t width = bgc_padded(m->n_state);

    evaluate_error_nodes(m, d, s);
    for (int k = 0; k < 2; k++) {
        double *change = d->off_inside + (size_t)k * width;
        for (int i = 0; i < m->n_state; i++) {
            change[i] = d->x[i] - s->inner[k][i];
        }
        if (implicit) {
            apply_mass_to_error(m, d, change);
        }
        for (int i = 0; i < m->n_state; i++) {
            change[i] += integral_within(s, node_weight[k], i) * (implicit ? 1.0 : d->inverse_mass[i]);
        }
        if (implicit) {
            solve_for_error(m, d, change);
        }
        for (int i = 0; i < m->n_state; i++) {
            s->inner[k][i] += change[i];
        }
    }
    evaluate_error_nodes(m, d, s);
}

/* The rate of state i where f is `f`. */
static double rate_of_state(const bgc_data *d, const double *f, int i) { return d->inverse_mass[i] * f[i]; }

/* The delay of the computed solution where e points along the motion; 0 where it does not, or where its
 * parts would not stay small. */
static double delay_of_step(const bgc_model *m, bgc_data *d, const step_slopes *s, int implicit) {
    double along = 0.0, error = 0.0, start = 0.0, end = 0.0, bent = 0.0, timed = 0.0;

    if (m->n_mass > 0 || !bgc_is_adaptive(bgc_present_method(&d->core))) {
        return 0.0;
    }
    for (int i = 0; i < m->n_state; i++) {
        const double size = bgc_tolerance(d, i, fmax(fabs(d->x[i]), fabs(d->next[i])));
        const double e = d->off[i] / size, f0 = s->f[0][i] / size, f1 = s->f[3][i] / size;
        const double chord = (d->next[i] - d->x[i]) / (s->h * size);
        const double shift = implicit ? s->h * d->dfdt[i] / size : 0.0;
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

/* d->off := R d->off + l by the factors of the step. */
static void carry_implicit(const bgc_model *m, bgc_data *d, const step_slopes *s, double delay) {
    const int n = m->n_state;
    const double c = d->core.c, in_last = fmax(0.0, 2.0 - 0.5 * c * s->h);
    const double *power = powers_of_step(&d->core, 1.0 / (c * s->h));
    double *v = error_vector(m, d, 5), *local = error_vector(m, d, 6), *change = error_vector(m, d, 7);

    for (int i = 0; i < n; i++) {
        local[i] = d->x[i] - d->next[i];
    }
    apply_mass_to_error(m, d, local);
    for (int i = 0; i < n; i++) {
        local[i] += integral_within(s, end_weight, i);
    }

    /* The powers of S by Horner's scheme. l is damped as the stiff parts of the step's end are. */
    memset(v, 0, (size_t)n * sizeof *v);
    for (int k = ERROR_POWERS; k >= 1; k--) {
        for (int i = 0; i < n; i++) {
            v[i] += power[k - 1] * d->off[i];
        }
        apply_mass_to_error(m, d, v);
        for (int i = 0; i < n && k <= 2; i++) {
            v[i] += (k == 1 ? in_last : 1.0 - in_last) * local[i];
            v[i] -= k == 2 ? s->h * delay * d->dfdt[i] : 0.0;
        }
        if (k == 1) {
            memcpy(local, v, (size_t)n * sizeof *v);
        }
        solve_for_error(m, d, v);
    }
    memcpy(d->off, v, (size_t)n * sizeof *v);

    /* The change of J: half of it over the step in slow parts, all of it where W is close to -J. */
    apply_mass_to_error(m, d, v);
    differentiate_along_error(m, d, s->t + s->h, d->next, s->f[3], d->off, delay, change);
    for (int i = 0; i < n; i++) {
        change[i] += delay * d->dfdt[i] - c * (v[i] - local[i]);
        v[i] = (0.5 * s->h - 1.0 / c) * change[i];
    }
    solve_for_error(m, d, v);
    apply_mass_to_error(m, d, v);
    for (int i = 0; i < n; i++) {
        v[i] += change[i] / c;
    }
    solve_for_error(m, d, v);
    for (int i = 0; i < n; i++) {
        d->off[i] += v[i];
    }
}

/* The same after an explicit step: a Runge-Kutta method of order 3 with nodes at the start, at the first inner
 * point and at the end. */
static void carry_explicit(const bgc_model *m, bgc_data *d, const step_slopes *s, double delay) {
    const int n = m->n_state;
    const double b2 = 5.0 / 6.0, b3 = 0.5 - b2 * error_node[0], a32 = 1.0 / (6.0 * b3 * error_node[0]);
    double *k1 = error_vector(m, d, 5), *k2 = error_vector(m, d, 6);
    double *k3 = error_vector(m, d, 7), *point = error_vector(m, d, 8);

    differentiate_along_error(m, d, s->t, d->x, s->f[0], d->off, delay, k1);
    for (int i = 0; i < n; i++) {
        k1[i] *= s->h * d->inverse_mass[i];
        point[i] = d->off[i] + error_node[0] * k1[i];
    }
    differentiate_along_error(m, d, s->t + error_node[0] * s->h, s->inner[0], s->f[1], point, delay, k2);
    for (int i = 0; i < n; i++) {
        k2[i] *= s->h * d->inverse_mass[i];
        point[i] = d->off[i] + (1.0 - a32) * k1[i] + a32 * k2[i];
    }
    differentiate_along_error(m, d, s->t + s->h, d->next, s->f[3], point, delay, k3);
    for (int i = 0; i < n; i++) {
        k3[i] *= s->h * d->inverse_mass[i];
        d->off[i] += (1.0 - b2 - b3) * k1[i] + b2 * k2[i] + b3 * k3[i];
        d->off[i] += d->x[i] - d->next[i] + d->inverse_mass[i] * integral_within(s, end_weight, i);
    }
}

/* Derivatives of the arguments of the switches along e to d->probe, and along the motion to d->after, before an
 * event at t; the motion to vector 8. */
static void look_at_switches(const bgc_model *m, bgc_data *d, double t, double h) {
    const double shift = difference_shift(m, d, d->next, d->off), back = 1e-6 * h;
    double *present = d->off_argument, *motion = error_vector(m, d, 8);

    m->switches(d->h, t, d->next, d->u, present, d->work);
    for (int i = 0; i < m->n_state; i++) {
        d->point[i] = d->next[i] + shift * d->off[i];
    }
    m->switches(d->h, t, d->point, d->u, d->off_along, d->work);
    bgc_interpolate_all(m, d, t - back, motion);
    m->switches(d->h, t - back, motion, d->u, d->off_rate, d->work);
    for (int k = 0; k < m->n_switch; k++) {
        d->off_along[k] = (d->off_along[k] - present[k]) / shift;
        d->off_rate[k] = (present[k] - d->off_rate[k]) / back;
    }
    for (int i = 0; i < m->n_state; i++) {
        motion[i] = (d->next[i] - motion[i]) / back;
    }
}

/* Before d->next, to which a step of the method leads, becomes the present at t: carries the error to it. */
void bgc_follow_error(const bgc_model *m, bgc_data *d, const bgc_method *method, double t) {
    const int n = m->n_state, implicit = method->family->jacobian;
    const size_t size = (size_t)n * sizeof(double);
    const bgc_counts counts = d->core.counts;
    double *f_end = error_vector(m, d, 4);
    const step_slopes s = {.t = d->core.t,
                           .h = t - d->core.t,
                           .f = {d->f, error_vector(m, d, 2), error_vector(m, d, 3), f_end},
                           .inner = {error_vector(m, d, 0), error_vector(m, d, 1)},
                           .f_inner = {error_vector(m, d, 2), error_vector(m, d, 3)}};
    double delay;

    if (d->core.off_noted != d->core.t) {
        bgc_note_errors(m, d, d->core.t, d->x, d->u, d->off);
    }
    memcpy(d->off_before, d->off, size);
    for (int k = 0; k < 2; k++) {
        bgc_interpolate_all(m, d, s.t + error_node[k] * s.h, s.inner[k]);
    }
    m->rhs(d->h, t, d->next, d->u, f_end, d->work);
    correct_error_nodes(m, d, &s, implicit);

    /* A delay stays; the rest of e is carried. */
    delay = delay_of_step(m, d, &s, implicit);
    for (int i = 0; i < n; i++) {
        d->off[i] -= delay * rate_of_state(d, s.f[0], i);
    }
    if (!implicit && d->n_block > 0) {
        d->off[0] = (double)NAN; /* explicit steps solve the algebraic equations at each stage */
    } else if (implicit) {
        carry_implicit(m, d, &s, delay);
    } else {
        carry_explicit(m, d, &s, delay);
    }
    for (int i = 0; i < n; i++) {
        d->off[i] += delay * rate_of_state(d, f_end, i);
    }
    memcpy(d->off_at_end, d->off, size);
    if (d->core.event) {
        look_at_switches(m, d, t, s.h);
    }
    d->core.counts = counts;
}

/* --- events ------------------------------------------------------------------------------------ */

/* The time by which an event comes later in the exact solution: that of the switch that is moved most. */
static double event_delay(const bgc_model *m, const bgc_data *d) {
    double most = 0.0;

    for (int k = 0; k < m->n_switch; k++) {
        const double before = d->u_step[m->n_input + k];
        const double moved = -d->off_along[k] / d->off_rate[k];
        const int left = !isnan(before) && (d->mode[k] != before || (m->n_jump > 0 && d->turned[k] != 0.0));
        if (left && d->off_rate[k] != 0.0 && fabs(moved) > fabs(most)) {
            most = moved;
        }
    }
    return most;
}

/* Derivatives along v, the change of the states up to the jumps at the present, of the values that they give. */
static void carry_through_resets(const bgc_model *m, bgc_data *d, double *v) {
    const double shift = difference_shift(m, d, d->y1, v);

    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < m->n_state; i++) {
            d->point[i] = d->next[i] + side * shift * v[i];
        }
        m->resets(d->h, d->core.t, d->point, d->u_step, side ? d->off_reset : d->reset_value, d->work);
    }
    for (int k = 0; k < m->n_jump; k++) {
        for (int r = m->jump_first[k]; d->jumped_at[k] == d->core.t && r < m->jump_first[k + 1]; r++) {
            v[m->reset_state[r]] = (d->off_reset[r] - d->reset_value[r]) / shift;
        }
    }
}

/* After an event, with the new modes: e+ = g_x (e- + f- dt) - f+ dt. d->next has the states before a jump. */
void bgc_carry_error_through(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const int n = m->n_state, implicit = method->family->jacobian;
    const double dt = event_delay(m, d);
    const double *f_before = error_vector(m, d, 4), *motion = error_vector(m, d, 8);
    double *f_after = error_vector(m, d, 0), *v = error_vector(m, d, 1);
    int jumped = 0;

    for (int k = 0; k < m->n_jump; k++) {
        jumped |= d->jumped_at[k] == d->core.t;
    }
    m->rhs(d->h, d->core.t, d->x, d->u, f_after, d->work);
    if (jumped || !implicit) {
        for (int i = 0; i < n; i++) {
            v[i] = d->off[i] + motion[i] * dt;
        }
        if (jumped) {
            carry_through_resets(m, d, v);
        }
        for (int i = 0; i < n; i++) {
            d->off[i] = v[i] - rate_of_state(d, f_after, i) * dt;
        }
        return;
    }
    for (int i = 0; i < n; i++) {
        v[i] = (f_before[i] - f_after[i]) * dt;
    }
    solve_for_error(m, d, v);
    for (int i = 0; i < n; i++) {
        d->off[i] += v[i];
    }
}

/* --- rows -------------------------------------------------------------------------------------- */

/* Enters the errors of the outputs at t, where x is off by e, into the largest since the last row. Each is at most
 * the size that its output has had: a fast change that comes late is off by no more. */
void bgc_note_errors(const bgc_model *m, bgc_data *d, double t, const double *x, const double *u,
                     const double *e) {
    double *true_state = error_vector(m, d, 9);

    for (int i = 0; i < m->n_state; i++) {
        true_state[i] = x[i] + e[i];
    }
    m->outputs(d->h, t, x, u, d->output, d->work);
    m->outputs(d->h, t, true_state, u, d->off_output, d->work);
    for (int k = 0; k < m->n_output; k++) {
        const double y = d->output[k], error = fabs(d->off_output[k] - y);
        double size;
        d->lowest[k] = fmin(d->lowest[k], y);
        d->highest[k] = fmax(d->highest[k], y);
        size = fmax(d->highest[k], 0.0) - fmin(d->lowest[k], 0.0);
        if (!(error <= d->largest_off[k])) { /* also a NaN */
            d->largest_off[k] = error > size ? size : error;
        }
    }
}

/* The correction of the dense output at a part s of the step, from those at the nodes. */
static double inside_correction(double s, double first, double second) {
    const double apart = error_node[1] - error_node[0], square = error_node[0] * error_node[1];

    return s * (1.0 - s) / (square * apart) * (first * (error_node[1] - s) + second * (s - error_node[0]));
}

/* The largest errors of the outputs since the row before, up to the row at t that bgc_evaluate_row has just
 * written, which leaves the state of a row inside the last step in d->point. */
void bgc_write_errors(const bgc_model *m, bgc_data *d, double t, int inside, double *errors) {
    const double *x = inside || d->core.algebraic > 0 ? d->point : d->x;
    const size_t count = (size_t)m->n_output * sizeof *errors;
    double *e = error_vector(m, d, 8);

    if (inside) {
        const double s = (t - d->core.t_old) / (d->core.t - d->core.t_old);
        const double *second = d->off_inside + bgc_padded(m->n_state);
        for (int i = 0; i < m->n_state; i++) {
            e[i] = d->off_before[i] + s * (d->off_at_end[i] - d->off_before[i]) +
                   inside_correction(s, d->off_inside[i], second[i]);
        }
    } else {
        memcpy(e, d->off, (size_t)m->n_state * sizeof *e);
        d->core.off_noted = d->core.t;
    }
    bgc_note_errors(m, d, inside ? t : d->core.t, x, inside ? d->u_step : d->u, e);
    memcpy(errors, d->largest_off, count);
    memset(d->largest_off, 0, count);
}
