/* dense.c: the solution inside the last step, and the energy integrals over it.
 *
 * Both kinds of dense output have the form of bgc_internal.h: the method's own, and the cubic of
 * Hermite through the states and slopes at both ends.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

/* After a step to d->next at `end` and before it is made the present: keeps what interpolation
 * needs. */
void bgc_store_dense(const bgc_model *m, bgc_data *d, const bgc_method *method, double end) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);

    d->core.t_old = d->core.t;
    d->core.t_end = end;
    memcpy(d->u_step, d->u, (size_t)(m->n_input + m->n_switch) * sizeof(double));
    memcpy(d->y0, d->x, size);
    memcpy(d->y1, d->next, size);
    if (method->family->interpolate != NULL && method->family->interpolate(m, d, method)) {
        d->core.dense = BGC_DENSE_READY;
    } else {
        memcpy(d->k, d->f, size);
        d->core.dense = BGC_SLOPES_PENDING;
    }
}

/* --- loops of a fixed length, which compilers vectorise at every level of optimisation ------ */

/* The cubics of Hermite through y0, y1 and the slopes at both ends, that at the start in k1; the
 * chord where the cubic is not to be trusted, or a state has no derivative. That is seen from the
 * slopes' departures from the chord. Where the solution is smooth the two are opposite and equal up
 * to the third order. One that is much the larger belongs to a transient that is over within the
 * step: it would swing the cubic wide. */
static inline void make_cubics(double h, const double *restrict y0, const double *restrict y1,
                               const double *restrict inverse_mass, const double *restrict f_end,
                               double *restrict k1, double *restrict k2) {
    const double most = 10.0;

    for (int l = 0; l < BGC_LANES; l++) {
        const double rise = y1[l] - y0[l], scale = h * inverse_mass[l];
        const double start = scale * k1[l] - rise, end = scale * f_end[l] - rise;
        const int smooth = (scale != 0.0) & (fabs(start) <= most * fabs(end)) &
                           (fabs(end) <= most * fabs(start));
        k1[l] = smooth ? start : 0.0;
        k2[l] = smooth ? -(start + end) : 0.0;
    }
}

static inline void evaluate_cubics(double s, const double *restrict y0, const double *restrict y1,
                                   const double *restrict k1, const double *restrict k2,
                                   const double *restrict k3, double *restrict x) {
    const double r = 1.0 - s;

    for (int l = 0; l < BGC_LANES; l++) {
        x[l] = r * y0[l] + s * (y1[l] + r * (k1[l] + s * (k2[l] + s * k3[l])));
    }
}

/* --- the solution --------------------------------------------------------------------------- */

/* f at the end of the last step, or of the one that is being looked at: there d->f is still f at
 * its start. */
static const double *slope_at_end(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;
    const size_t size = (size_t)m->n_state * sizeof *d->x;

    if (core->t == core->t_old) {
        if (!core->f_ahead) {
            m->rhs(d->h, core->t_end, d->y1, d->u_step, d->error, d->work);
            core->counts.rhs++;
            core->f_ahead = 1;
        }
        return d->error;
    }
    m->rhs(d->h, core->t_end, d->y1, d->u_step, d->f, d->work);
    core->counts.rhs++;
    core->f_valid = memcmp(d->x, d->y1, size) == 0 &&
                    memcmp(d->u, d->u_step, (size_t)m->n_input * sizeof *d->u) == 0;
    return d->f;
}

/* Makes the cubics of Hermite out of the slopes at the start, in k, and those at the end. */
static void complete_slopes(const bgc_model *m, bgc_data *d) {
    const size_t width = bgc_padded(m->n_state);
    const double h = d->core.t_end - d->core.t_old;
    const double *f_end = slope_at_end(m, d);
    double *k1 = d->k, *k2 = k1 + width, *k3 = k2 + width;

    for (size_t i = 0; i < width; i += BGC_LANES) {
        make_cubics(h, d->y0 + i, d->y1 + i, d->inverse_mass + i, f_end + i, k1 + i, k2 + i);
    }
    memset(k3, 0, width * sizeof *k3);
    d->core.dense = BGC_DENSE_READY;
}

/* x at time t inside the last step; states without a rate by their equations. */
void bgc_interpolate(const bgc_model *m, bgc_data *d, double t, double *x) {
    const size_t width = bgc_padded(m->n_state);
    const double *k1 = d->k, *k2 = k1 + width, *k3 = k2 + width;
    double s;

    if (d->core.dense == BGC_SLOPES_PENDING) {
        complete_slopes(m, d);
    }
    s = (t - d->core.t_old) / (d->core.t_end - d->core.t_old);
    for (size_t i = 0; i < width; i += BGC_LANES) {
        evaluate_cubics(s, d->y0 + i, d->y1 + i, k1 + i, k2 + i, k3 + i, x + i);
    }
    if (d->core.algebraic > 0) { /* in the modes and inputs of that step */
        double *present = d->u;
        d->u = d->u_step;
        bgc_satisfy(m, d, t, x); /* where no solution is found, what was interpolated is kept */
        d->u = present;
    }
    if (m->project != NULL) {
        m->project(d->h, t, x, d->work);
    }
}

/* The rate of the dense output in the middle of the last step. */
void bgc_dense_slope(const bgc_model *m, const bgc_data *d, double *slope) {
    const double h = d->core.t_end - d->core.t_old;
    const double *k2 = d->k + bgc_padded(m->n_state), *k3 = k2 + bgc_padded(m->n_state);

    for (int i = 0; i < m->n_state; i++) {
        slope[i] = (d->y1[i] - d->y0[i] + 0.25 * (k2[i] + k3[i])) / h;
    }
}

/* --- energies ----------------------------------------------------------------------------- */

/* Stored energy, and supplied and dissipated power, at a time inside the last step. */
static void energy_at(const bgc_model *m, bgc_data *d, double t, double energy[3]) {
    const double *x = d->point;

    if (t == d->core.t_old) {
        x = d->y0;
    } else if (t == d->core.t_end) {
        x = d->y1;
    } else {
        bgc_interpolate(m, d, t, d->point);
    }
    m->energy(d->h, t, x, d->u_step, energy, d->work);
}

/* The rule of Lobatto with four points (degree 5) from the start of the last step to t inside it,
 * which is exact beyond the order of the dense output. */
static void lobatto(const bgc_model *m, bgc_data *d, double t, double energy[4][3],
                    double power[2]) {
    static const double node[4] = {0.0, 0.27639320225002103, 0.72360679774997897, 1.0};
    static const double weight[4] = {1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0};
    const double start = d->core.t_old, length = t - start;

    power[0] = power[1] = 0.0;
    for (int k = 0; k < 4; k++) {
        energy_at(m, d, k == 3 ? t : start + node[k] * length, energy[k]);
        power[0] += weight[k] * length * energy[k][1];
        power[1] += weight[k] * length * energy[k][2];
    }
}

/* Supplied and dissipated energy from the start of the last step to t inside it. */
void bgc_integrate_energy(const bgc_model *m, bgc_data *d, double t, double power[2]) {
    double energy[4][3];

    lobatto(m, d, t, energy, power);
}

/* The energies of a step to t, before or after it is made the present. Its error is the difference
 * from Simpson's rule, which falls with the fifth power of the step; fixed steps do without. */
void bgc_balance_step(const bgc_model *m, bgc_data *d, const bgc_method *method, double t,
                      bgc_balance *balance) {
    const double start = d->core.t_old, length = t - start;
    double energy[4][3], power[2], moved[2];

    lobatto(m, d, t, energy, power);
    balance->error = 0.0;
    for (int k = 0; k < 2; k++) {
        const double first = energy[0][k + 1], last = energy[3][k + 1];
        const double inner = fabs(energy[1][k + 1]) + fabs(energy[2][k + 1]);
        moved[k] = length / 12.0 * (fabs(first) + 5.0 * inner + fabs(last));
    }
    balance->moved = fmax(moved[0], moved[1]);
    balance->stored = energy[3][0];
    if (bgc_is_adaptive(method)) {
        double middle[3];
        energy_at(m, d, start + 0.5 * length, middle);
        for (int k = 0; k < 2; k++) {
            const double ends = energy[0][k + 1] + energy[3][k + 1];
            const double simpson = length / 6.0 * (ends + 4.0 * middle[k + 1]);
            balance->error = fmax(balance->error, fabs(power[k] - simpson));
        }
    }
    if (method->family->quadrature != NULL && !d->core.event) {
        method->family->quadrature(m, d, method, power);
    }
    balance->supplied = power[0];
    balance->dissipated = power[1];
}
