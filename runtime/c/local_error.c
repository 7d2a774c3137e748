/* local_error.c: the error that a step adds.
 *
 * Before a solution with W it is what is missing in M (y_new - y) = integral of f, by Lobatto's quadrature of order 6
 * with f at two points inside the step. The dense output there is corrected by sweeps of the collocation equations
 * first, since its error would count: one that is of the order before the method's, two for Radau's cubic. K. Dutt,
 * L. Greengard, V. Rokhlin, BIT 40 (2000) 241.
 *
 * That costs a good part of the step, so it is not done in each. In smooth motion the local error is that of the last
 * measurement times the power of the step's length that the order of the method gives. It is taken for the steps
 * between, twice as many each time that the next measurement confirms it, and that corrects their sum by the
 * trapezoidal rule. At an event, and where it is not foreseen, each step is measured.
 */
#include "global_error.h"
#include "interpolation.h"

#include <math.h>
#include <string.h>

enum { LONGEST_UNMEASURED = 8 };         /* steps to the next measurement */
static const double least_scale = 0.5;  /* of the local error by the length of the step */
static const double foreseen = 0.05;    /* difference between a local error and its prediction, relative */
static const double inside_node[2] = {0.27639320225002103, 0.72360679774997897}; /* Lobatto's */
static const double node_weight[2][4] = { /* integrals from the start to the nodes */
    {0.11030056647916491, 0.18969943352083510, -0.033907364229143883, 0.010300566479164914},
    {0.073032766854168419, 0.45057403089581055, 0.22696723314583160, -0.026967233145831604}};
static const double end_weight[4] = {1.0 / 12, 5.0 / 12, 5.0 / 12, 1.0 / 12};

/* The next step is measured, and nothing is known of it. */
void bgc_forget_local_error(bgc_core *core) {
    core->off_every = 1;
    core->off_since = 0;
    core->off_step = core->off_scale = core->off_size = 0.0;
}

/* --- solutions --------------------------------------------------------------------------------- */

/* v := M v. */
void bgc_apply_mass_to_error(const bgc_model *m, bgc_data *d, double *v) {
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, v, d->magnitude);
        memcpy(v, d->magnitude, (size_t)m->n_state * sizeof *v);
    }
}

/* v := W^-1 c v. A vector that cannot be solved for becomes NaN, and so do the errors. */
void bgc_solve_for_error(const bgc_model *m, bgc_data *d, double *v) {
    for (int i = 0; i < m->n_state; i++) {
        v[i] *= d->core.c;
    }
    if (bgc_solve(m, d, v) != BGC_OK) {
        v[0] = (double)NAN;
    }
}

/* --- measurement ------------------------------------------------------------------------------- */

/* The integral of f from the start of the step with these weights, in entry i. */
static double integral_within(const bgc_error_step *s, const double *w, int i) {
    return s->h * (w[0] * s->f[0][i] + w[1] * s->f[1][i] + w[2] * s->f[2][i] + w[3] * s->f[3][i]);
}

static void evaluate_nodes(const bgc_model *m, bgc_data *d, const bgc_error_step *s) {
    for (int k = 0; k < 2; k++) {
        m->rhs(d->h, s->t + inside_node[k] * s->h, s->inner[k], d->u, s->f_inner[k], d->work);
    }
}

/* The integral of f from the start of the step less M (y - y_start), with y at a node or at the end. */
static void find_residual(const bgc_model *m, bgc_data *d, const bgc_error_step *s, const double *y,
                          const double *w, double *out) {
    for (int i = 0; i < m->n_state; i++) {
        out[i] = d->x[i] - y[i];
    }
    if (s->implicit) {
        bgc_apply_mass_to_error(m, d, out);
    }
    for (int i = 0; i < m->n_state && s->implicit; i++) {
        out[i] += integral_within(s, w, i);
    }
    for (int i = 0; i < m->n_state && !s->implicit; i++) {
        out[i] += d->inverse_mass[i] * integral_within(s, w, i);
    }
}

/* Sweeps that make the states at the nodes exact to one order more than the step's end, from the dense output. */
static int needed_sweeps(const bgc_method *method) {
    const int quartic = method->tableau != NULL && method->tableau->dense == BGC_MAX_DENSE;
    const int needed = method->order - (quartic ? 4 : 3);

    return needed > 1 ? needed : 1;
}

/* One sweep: the states at the nodes, with f there, after one simplified Newton iteration of their equations. */
static void sweep_nodes(const bgc_model *m, bgc_data *d, const bgc_error_step *s) {
    for (int k = 0; k < 2; k++) {
        double *change = bgc_error_vector(m, d, 6 + k);
        find_residual(m, d, s, s->inner[k], node_weight[k], change);
        if (s->implicit) {
            bgc_solve_for_error(m, d, change);
        }
    }
    for (int k = 0; k < 2; k++) {
        const double *change = bgc_error_vector(m, d, 6 + k);
        double *inside = d->off_inside + (size_t)k * bgc_padded(m->n_state);
        for (int i = 0; i < m->n_state; i++) {
            s->inner[k][i] += change[i];
            inside[i] += change[i];
        }
    }
    evaluate_nodes(m, d, s);
}

/* f at the nodes of the step, where the dense output is corrected by d->off_inside. */
static void correct_nodes(const bgc_model *m, bgc_data *d, const bgc_error_step *s) {
    for (int k = 0; k < 2; k++) {
        bgc_interpolate_all(m, d, s->t + inside_node[k] * s->h, s->inner[k]);
    }
    evaluate_nodes(m, d, s);
    memset(d->off_inside, 0, 2 * bgc_padded(m->n_state) * sizeof *d->off_inside);
    for (int sweep = needed_sweeps(s->method); sweep > 0; sweep--) {
        sweep_nodes(m, d, s);
    }
}

/* --- between measurements ---------------------------------------------------------------------- */

/* By how much the local error of the measured step is multiplied in one of length h. */
static double scale_by_length(const bgc_core *core, int order, double h) {
    const double ratio = core->off_step > 0.0 ? h / core->off_step : 0.0;
    double power = ratio;

    for (int k = 0; k < order; k++) {
        power *= ratio;
    }
    return power;
}

/* After a measurement of `local`: adds to it what it says of the steps since the last one, and plans the next. Whether
 * it was foreseen is judged by what it makes of the states, S local. */
static void enter_measurement(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double *local) {
    bgc_core *core = &d->core;
    const size_t size = (size_t)m->n_state * sizeof *local;
    const int unmeasured = core->off_since - 1, twice = 2 * core->off_since;
    double *solved = bgc_error_vector(m, d, 5), *gap = bgc_error_vector(m, d, 6);
    double apart, now;

    memcpy(solved, local, size);
    if (s->implicit) {
        bgc_solve_for_error(m, d, solved);
    }
    for (int i = 0; i < m->n_state; i++) {
        gap[i] = solved[i] - core->off_scale * d->off_solved[i];
    }
    apart = bgc_norm(m, d, gap, d->x, d->next);
    now = bgc_norm(m, d, solved, d->x, d->next);
    core->off_every = !(apart <= foreseen * fmax(now, core->off_scale * core->off_size)) ? 1
                      : twice < LONGEST_UNMEASURED                                       ? twice
                                                                                         : LONGEST_UNMEASURED;
    core->off_size = now;

    for (int i = 0; i < m->n_state; i++) {
        const double measured = local[i];
        local[i] += 0.5 * unmeasured * (measured - core->off_scale * d->off_local[i]);
        d->off_local[i] = measured;
    }
    memcpy(d->off_solved, solved, size);
    core->off_since = 0;
}

/* The error that this step adds, to `local`, and with a measurement what it says of the steps before. Returns
 * whether it has been measured. */
int bgc_local_error(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double *local) {
    bgc_core *core = &d->core;

    core->off_since++;
    core->off_scale = scale_by_length(core, s->method->order, s->h);
    if (core->off_since < core->off_every && !core->event && core->off_scale > least_scale &&
        core->off_scale * least_scale < 1.0) {
        for (int i = 0; i < m->n_state; i++) {
            local[i] = core->off_scale * d->off_local[i];
        }
        return 0;
    }
    correct_nodes(m, d, s);
    find_residual(m, d, s, d->next, end_weight, local);
    enter_measurement(m, d, s, local);
    core->off_step = s->h;
    core->off_scale = 1.0;
    return 1;
}

/* The correction of the dense output at a part s of the step, from those at the nodes. */
double bgc_inside_correction(double s, double first, double second) {
    const double apart = inside_node[1] - inside_node[0], square = inside_node[0] * inside_node[1];

    return s * (1.0 - s) / (square * apart) * (first * (inside_node[1] - s) + second * (s - inside_node[0]));
}
