/* accounts.c: the energy accounts: the energies of a step, their error, and the drift of their
 * balance. */
#include "bgc_internal.h"
#include "accounts.h"

#include <math.h>

/* Lobatto quadrature with four points over the unit interval, of degree 5. */
static const double lobatto_node[4] = {0.0, 0.27639320225002103, 0.72360679774997897, 1.0};
static const double lobatto_weight[4] = {1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0};

/* The integral of a power's absolute value over a step, by its values at the Lobatto points. */
static number absolute_integral(double length, number p0, number p1, number p2, number p3) {
    const number inner = number_fabs(p1) + number_fabs(p2);

    return length / 12.0 * (number_fabs(p0) + 5.0 * inner + number_fabs(p3));
}

/* The error of an integral over a step: the difference from Simpson's rule, which falls with the
 * fifth power of the step. */
static number quadrature_error(double length, number integral, number first, number middle,
                               number last) {
    const number ends = first + last;
    const number simpson = length / 6.0 * (ends + 4.0 * middle);

    return number_fabs(integral - simpson);
}

/* --- integrals over a step -------------------------------------------------------------------- */

/* Stored energy, supplied and dissipated power at a time inside the last step. */
static void energy_at(const bgc_model *m, bgc_ivp *d, double t, number energy[3]) {
    const number *x = d->point;

    if (t == d->core.t_old) {
        x = d->y0;
    } else if (t == d->core.t_end) {
        x = d->y1;
    } else {
        bgc_interpolate(m, d, t, d->point);
    }
    bgc_functions(m, d)->energy(d->h, number_of(t), x, d->u_step, energy, d->work);
}

/* Lobatto quadrature of the powers from the start of the last step to t inside it. Its degree is
 * above the order of the dense output. energy[k] are the energies at its points. */
static void lobatto(const bgc_model *m, bgc_ivp *d, double t, number energy[4][3],
                    number power[2]) {
    const double start = d->core.t_old, length = t - start;

    power[0] = power[1] = number_of(0.0);
    for (int k = 0; k < 4; k++) {
        energy_at(m, d, k == 3 ? t : start + lobatto_node[k] * length, energy[k]);
        power[0] += lobatto_weight[k] * length * energy[k][1];
        power[1] += lobatto_weight[k] * length * energy[k][2];
    }
}

/* Supplied and dissipated energy from the start of the last step to t inside it. */
void bgc_integrate_energy(const bgc_model *m, bgc_ivp *d, double t, number power[2]) {
    number energy[4][3];

    lobatto(m, d, t, energy, power);
}

/* The energies of a step to t, before or after that becomes the present, and under error control
 * their error. */
void bgc_balance_step(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double t,
                      bgc_balance *balance) {
    const double start = d->core.t_old, length = t - start;
    number energy[4][3], power[2];

    /* Lobatto quadrature. */
    lobatto(m, d, t, energy, power);
    balance->error = balance->moved = number_of(0.0);
    for (int k = 1; k < 3; k++) {
        balance->moved = number_larger(balance->moved,
                                       absolute_integral(length, energy[0][k], energy[1][k],
                                                         energy[2][k], energy[3][k]));
    }
    balance->stored = energy[3][0];

    /* Error: Simpson's rule on the same step. */
    if (bgc_is_adaptive(method)) {
        number middle[3];
        energy_at(m, d, start + 0.5 * length, middle);
        for (int k = 1; k < 3; k++) {
            const number error = quadrature_error(length, power[k - 1], energy[0][k], middle[k],
                                                  energy[3][k]);
            balance->error = number_larger(balance->error, error);
        }
    }

    /* The quadrature of the method itself, where it has one. */
    if (method->family->quadrature != NULL && !d->core.event) {
        bgc_integrate_by(m, d, method, power);
    }
    balance->supplied = power[0];
    balance->dissipated = power[1];
}

/* --- accounts --------------------------------------------------------------------------------- */

/* The residual of the accounts at the end of a step. */
static number residual_after(const bgc_accounts *a, const bgc_balance *balance) {
    return balance->stored - a->stored0 - (a->supplied + balance->supplied) +
           (a->dissipated + balance->dissipated) - a->created;
}

/* The error by which the drift of the accounts shortens the next step, at most to half. Each step
 * is within its tolerance, but errors of one sign add up over a long run. So the residual added by
 * a step, over the tolerance of an average step's share of the energy, is multiplied by the part of
 * the tolerance of all the energy that the residual has used up: a small residual does not shorten
 * the step. */
double bgc_drift_error(bgc_ivp *d, const bgc_balance *balance, double q, double error) {
    const double weight = 4.0; /* keeps the residual below half of its tolerance */
    const double steps = (double)(d->core.counts.steps + 1), rtol = d->core.rtol;
    const bgc_accounts *a = bgc_accounts_of(d);
    const number residual = residual_after(a, balance), stored = number_fabs(balance->stored);
    const number energy = number_larger(number_larger(*bgc_exchanged(d), stored), balance->moved);
    const number share = number_larger(energy / steps, balance->moved);
    const number used = weight * residual / (rtol * energy);
    const number drift = used * (residual - a->imbalance) / (rtol * share);
    const number finite = number_select(number_is_finite(drift), drift, number_of(0.0));

    return fmin(bgc_largest(d, finite), error * pow(2.0, q));
}

/* Enters a step into the accounts. */
void bgc_enter_balance(bgc_ivp *d, const bgc_balance *balance) {
    bgc_accounts *a = bgc_accounts_of(d);
    number *exchanged = bgc_exchanged(d);

    a->imbalance = residual_after(a, balance);
    a->supplied_old = a->supplied;
    a->dissipated_old = a->dissipated;
    a->supplied += balance->supplied;
    a->dissipated += balance->dissipated;
    a->largest_account = bgc_largest_account(a->largest_account, balance->stored - a->stored0,
                                             a->supplied, a->dissipated);
    *exchanged = number_larger(number_larger(*exchanged, a->largest_account),
                               number_fabs(balance->stored));
}
