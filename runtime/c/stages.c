/* stages.c: the result of a step from its stages, by the formulas of bgc_internal.h: solution, error
 * estimate, dense output, and the quadrature of energies. */
#include "bgc_internal.h"

#include <string.h>

/* --- Rosenbrock and explicit Runge-Kutta methods ---------------------------------------------- */

/* d->next = x + sum m_i U_i; the error estimate, where the method has one, to d->error. */
void bgc_sum_stages(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);

    memcpy(d->next, d->x, size);
    bgc_combine(n, tableau->stages, tableau->m, d->stages, d->next);
    if (bgc_is_adaptive(method)) {
        memset(d->error, 0, size);
        bgc_combine(n, tableau->stages, tableau->e, d->stages, d->error);
    }
}

/* The method's own dense output to d->k, where it has one. */
int bgc_interpolate_stages(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const size_t width = bgc_padded(m->n_state);

    if (tableau->dense == 0) {
        return 0;
    }
    memset(d->k, 0, BGC_MAX_DENSE * width * sizeof *d->k);
    for (int l = 0; l < tableau->dense; l++) {
        double *k = d->k + (size_t)l * width;
        bgc_combine(m->n_state, tableau->stages, tableau->h[l], d->stages, k);
    }
    return 1;
}

/* A method of one stage is compared with the step before, whose stage is kept where a second stage
 * would be. */
static void keep_stage(int n, bgc_data *d) {
    memcpy(d->stages + bgc_padded(n), d->stages, (size_t)n * sizeof *d->stages);
}

/* change += sum e_i U_i. */
void bgc_correction_of_stages(const bgc_model *m, bgc_data *d, const bgc_method *method,
                              double *change) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state;

    if (tableau->stages == 1 && d->core.ticks == 0) {
        keep_stage(n, d);
    }
    bgc_combine(n, tableau->stages > 1 ? tableau->stages : 2, tableau->e, d->stages, change);
    if (tableau->stages == 1) {
        keep_stage(n, d);
    }
}

/* --- collocation methods --------------------------------------------------------------------- */

/* Dense output of a method of three stages, the last of which is y1: the polynomial of degree 3
 * through y and the stages. */
int bgc_interpolate_radau(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const int n = m->n_state;
    const size_t width = bgc_padded(n);
    const double *z1 = d->stages, *z2 = z1 + width, *z3 = z2 + width;
    const double c1 = method->collocation->node[0], c2 = method->collocation->node[1];

    memset(d->k, 0, BGC_MAX_DENSE * width * sizeof *d->k);
    for (int i = 0; i < n; i++) {
        const double at1 = (z1[i] - c1 * z3[i]) / (c1 * (1.0 - c1));
        const double at2 = (z2[i] - c2 * z3[i]) / (c2 * (1.0 - c2));
        const double slope = (at2 - at1) / (c2 - c1);
        d->k[i] = at1 - c1 * slope;
        d->k[width + (size_t)i] = slope;
    }
    return 1;
}

/* Half the difference between h f at the start of the step and the slope of the collocation
 * polynomial there. */
void bgc_correction_of_slope(const bgc_model *m, bgc_data *d, const bgc_method *method,
                             double *change) {
    const bgc_collocation *c = method->collocation;
    const double h = d->core.t_end - d->core.t_old;

    bgc_combine(m->n_state, c->stages, c->e, d->stages, change);
    for (int i = 0; i < m->n_state; i++) {
        const double slope = h * d->inverse_mass[i];
        change[i] = slope != 0.0 ? 0.5 * (slope * d->f[i] + change[i]) : 0.0;
    }
}

/* Energy accounts by the method's own quadrature balance as exactly as the method conserves
 * energy. */
void bgc_collocation_quadrature(const bgc_model *m, bgc_data *d, const bgc_method *method,
                                double power[2]) {
    const bgc_collocation *c = method->collocation;
    const double h = d->core.t_end - d->core.t_old;

    power[0] = power[1] = 0.0;
    for (int s = 0; s < c->stages; s++) {
        const double *z = d->stages + (size_t)s * bgc_padded(m->n_state);
        double energy[3];
        for (int i = 0; i < m->n_state; i++) {
            d->point[i] = d->y0[i] + z[i];
        }
        m->energy(d->h, d->core.t_old + c->node[s] * h, d->point, d->u_step, energy, d->work);
        power[0] += c->weight[s] * h * energy[1];
        power[1] += c->weight[s] * h * energy[2];
    }
}
