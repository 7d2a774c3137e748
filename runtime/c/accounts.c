/* accounts.c: the energy accounts of an instance: the energies of a step and their error. */
#include "bgc_internal.h"
#include "accounts.h"

#include <math.h>
#include <string.h>

/* --- integrals over a step -------------------------------------------------------------------- */

/* Stored energy, supplied and dissipated power at a time inside the last step. */
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

/* Lobatto quadrature of the powers from the start of the last step to t inside it. Its degree is above
 * the order of the dense output. energy[k] are the energies at its points. */
static void lobatto(const bgc_model *m, bgc_data *d, double t, double energy[4][3],
                    double power[2]) {
    const double start = d->core.t_old, length = t - start;

    power[0] = power[1] = 0.0;
    for (int k = 0; k < 4; k++) {
        energy_at(m, d, k == 3 ? t : start + bgc_lobatto_node[k] * length, energy[k]);
        power[0] += bgc_lobatto_weight[k] * length * energy[k][1];
        power[1] += bgc_lobatto_weight[k] * length * energy[k][2];
    }
}

/* Supplied and dissipated energy from the start of the last step to t inside it. */
void bgc_integrate_energy(const bgc_model *m, bgc_data *d, double t, double power[2]) {
    double energy[4][3];

    lobatto(m, d, t, energy, power);
}

/* The energies of a step to t, before or after that becomes the present, and under error control their
 * error. */
void bgc_balance_step(const bgc_model *m, bgc_data *d, const bgc_method *method, double t,
                      bgc_balance *balance) {
    const double start = d->core.t_old, length = t - start;
    double energy[4][3], power[2], moved[2];

    /* Lobatto quadrature. */
    lobatto(m, d, t, energy, power);
    balance->error = 0.0;
    for (int k = 0; k < 2; k++) {
        moved[k] = bgc_moved(length, energy[0][k + 1], energy[1][k + 1], energy[2][k + 1],
                             energy[3][k + 1]);
    }
    balance->moved = fmax(moved[0], moved[1]);
    balance->stored = energy[3][0];

    /* Error: Simpson's rule on the same step. */
    if (bgc_is_adaptive(method)) {
        double middle[3];
        energy_at(m, d, start + 0.5 * length, middle);
        for (int k = 0; k < 2; k++) {
            const double error = bgc_quadrature_error(length, power[k], energy[0][k + 1],
                                                      middle[k + 1], energy[3][k + 1]);
            balance->error = fmax(balance->error, error);
        }
    }

    /* The quadrature of the method itself, where it has one. */
    if (method->family->quadrature != NULL && !d->core.event) {
        method->family->quadrature(m, d, method, power);
    }
    balance->supplied = power[0];
    balance->dissipated = power[1];
}

/* --- accounts --------------------------------------------------------------------------------- */

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

/* The residual of the accounts at the end of a step. */
double bgc_residual_after(const bgc_core *core, const bgc_balance *balance) {
    return balance->stored - core->stored0 - (core->supplied + balance->supplied) +
           (core->dissipated + balance->dissipated) - core->created;
}

/* Enters a step into the accounts. */
void bgc_enter_balance(bgc_core *core, const bgc_balance *balance) {
    core->imbalance = bgc_residual_after(core, balance);
    core->supplied += balance->supplied;
    core->dissipated += balance->dissipated;
    core->largest_account =
        bgc_largest_account(core->largest_account, balance->stored - core->stored0,
                            core->supplied, core->dissipated);
    core->counts.exchanged =
        fmax(core->counts.exchanged, fmax(core->largest_account, fabs(balance->stored)));
}
