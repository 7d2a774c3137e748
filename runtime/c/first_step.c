/* first_step.c: the length of the first step with error control. */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

static const double no_length = 1e20; /* a step over one that is so short that J does not matter in it */

/* The first step of a method whose error estimate has this order: E. Hairer, S. P. Norsett, G. Wanner,
 * Solving Ordinary Differential Equations I, II.4. States without a rate do not count. */
double bgc_first_step(const bgc_model *m, bgc_data *d, int order) {
    const int n = m->n_state;
    const double t = d->core.t;
    const double d0 = bgc_norm(m, d, d->x, d->x, d->x);
    double d1, d2, h0, h1;

    /* A first guess, by which an explicit Euler step changes the state by 1 %. */
    for (int i = 0; i < n; i++) {
        d->point[i] = d->f[i] * d->inverse_mass[i];
    }
    d1 = bgc_norm(m, d, d->point, d->x, d->x);
    h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    if (d->core.given.max_step > 0.0) {
        h0 = fmin(h0, d->core.given.max_step);
    }

    /* The second derivative, by a difference of f over that step. */
    for (int i = 0; i < n; i++) {
        d->next[i] = d->x[i] + h0 * d->point[i];
    }
    m->rhs(d->h, t + h0, d->next, d->u, d->error, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < n; i++) {
        d->error[i] = d->error[i] * d->inverse_mass[i] - d->point[i];
    }
    d2 = bgc_norm(m, d, d->error, d->x, d->x) / h0;
    if (!isfinite(d2)) {
        return 1e-3 * h0;
    }

    /* The length at which the leading error is about 1 % of the tolerance. */
    h1 = fmax(d1, d2) <= 1e-15 ? fmax(1e-6, 1e-3 * h0)
                               : pow(0.01 / fmax(d1, d2), 1.0 / (order + 1));
    return fmin(100.0 * h0, h1);
}

/* out = J v at (t, x); returns whether it is finite. Overwrites the Jacobian at the present. */
static int multiply_jacobian(const bgc_model *m, bgc_data *d, double t, const double *x,
                             const double *v, double *out) {
    bgc_differentiate(m, d, t, x, d->jac, d->dfdt);
    d->core.counts.jacobians++;
    d->core.jac_valid = 0;
    memset(out, 0, (size_t)m->n_state * sizeof *out);
    for (int k = 0; k < m->n_jac; k++) {
        out[m->jac_row[k]] += d->jac[k] * v[m->jac_col[k]];
    }
    return bgc_first_bad(m->n_state, out) < 0;
}

/* The rates of all states at the present: those of algebraic ones follow from the others. Returns whether they
 * were found. */
static int find_tangent(const bgc_model *m, bgc_data *d, double h, double *tangent) {
    const double shift = no_length / h; /* W = shift M - J */

    if (d->core.algebraic == 0) {
        for (int i = 0; i < m->n_state; i++) {
            tangent[i] = d->f[i] * d->inverse_mass[i];
        }
        return 1;
    }
    memcpy(tangent, d->f, (size_t)m->n_state * sizeof *tangent);
    bgc_evaluate_jacobian(m, d);
    if (bgc_factorise(m, d, shift) != BGC_OK || bgc_solve(m, d, tangent) != BGC_OK) {
        return 0;
    }
    for (int i = 0; i < m->n_state; i++) {
        tangent[i] *= shift;
    }
    return 1;
}

/* Shortens the first step h of an implicit method at a singular start, where J decreases at once, as
 * 2/t does. The error estimate is filtered by (M/(h gamma) - J)^-1 with J at the start, and ignores
 * components that are stiff there alone. */
double bgc_limit_first_step(const bgc_model *m, bgc_data *d, double h) {
    double *tangent = d->next, *before = d->right, *after = d->magnitude;

    if (!find_tangent(m, d, h, tangent) || !multiply_jacobian(m, d, d->core.t, d->x, tangent, before)) {
        return h;
    }
    while (h * bgc_norm(m, d, before, d->x, d->x) > bgc_norm(m, d, tangent, d->x, d->x)) {
        for (int i = 0; i < m->n_state; i++) {
            d->point[i] = d->x[i] + h * tangent[i];
        }
        if (!multiply_jacobian(m, d, d->core.t + h, d->point, tangent, after) ||
            bgc_norm(m, d, after, d->x, d->x) > 0.5 * bgc_norm(m, d, before, d->x, d->x)) {
            break;
        }
        h *= 0.1;
    }
    return h;
}

/* The first step of an instance at its initial state, in the modes there. */
double bgc_first_step_alone(const bgc_model *m, bgc_data *d) {
    const bgc_method *method = &bgc_methods[d->core.method];
    double h;

    d->core.f_valid = 0;
    bgc_hold_modes(m, d);
    bgc_evaluate_f(m, d);
    h = d->core.step > 0.0 ? d->core.step : bgc_first_step(m, d, method->error_order);
    if (method->family->jacobian) {
        h = bgc_limit_first_step(m, d, h);
    }
    bgc_release_modes(m, d);
    return h;
}

/* Computes, once in a run, the energy that tolerances regard as small: the largest that a state of the
 * size of its scale stores; 0 where none stores any. */
void bgc_settle_energy_scale(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;
    double present[3], energy[3];

    if (core->energy_scale >= 0.0) {
        return;
    }
    core->energy_scale = 0.0;
    memcpy(d->point, d->x, (size_t)m->n_state * sizeof *d->x);
    m->energy(d->h, core->t, d->point, d->u, present, d->work);
    for (int i = 0; i < m->n_state; i++) {
        double change;
        d->point[i] = d->x[i] + d->scale[i];
        m->energy(d->h, core->t, d->point, d->u, energy, d->work);
        d->point[i] = d->x[i];
        change = fabs(energy[0] - present[0]);
        core->energy_scale = isfinite(change) ? fmax(core->energy_scale, change)
                                              : core->energy_scale;
    }
    core->counts.exchanged = fmax(core->counts.exchanged, core->rtol * core->energy_scale);
}
