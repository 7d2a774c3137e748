/* accounts.h: formulas of the energy accounts of a step, of one instance and of a batch.
 *
 * The accounts are the stored energy since the start, and the integrals of the supplied and the
 * dissipated power; their residual is stored - supplied + dissipated.
 */
#ifndef BGC_ACCOUNTS_H
#define BGC_ACCOUNTS_H

#include "number.h"

/* Lobatto quadrature with four points over the unit interval, of degree 5. */
static const double bgc_lobatto_node[4] = {0.0, 0.27639320225002103, 0.72360679774997897, 1.0};
static const double bgc_lobatto_weight[4] = {1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0};

/* The integral of a power's absolute value over a step, by its values at the Lobatto points. */
static inline number bgc_moved(double length, number p0, number p1, number p2, number p3) {
    const number inner = number_fabs(p1) + number_fabs(p2);

    return length / 12.0 * (number_fabs(p0) + 5.0 * inner + number_fabs(p3));
}

/* The error of an integral over a step: the difference from Simpson's rule, which falls with the
 * fifth power of the step. */
static inline number bgc_quadrature_error(double length, number integral, number first,
                                          number middle, number last) {
    const number ends = first + last;
    const number simpson = length / 6.0 * (ends + 4.0 * middle);

    return number_fabs(integral - simpson);
}

/* The error of a step's energies over their tolerance: relative to the largest account so far, and
 * above rounding. An overflow in the accounts alone does not reject the step. */
static inline number bgc_account_error(number error, number moved, number largest_account,
                                       number energy_scale, double rtol) {
    const double rounding = 1e-12;
    const number tolerance =
        rounding * energy_scale + rtol * number_larger(largest_account, moved);

    return number_select(number_is_finite(error) & (error > number_of(0.0)), error / tolerance,
                         number_of(0.0));
}

/* The largest of the accounts so far. */
static inline number bgc_largest_account(number before, number stored, number supplied,
                                         number dissipated) {
    return number_larger(number_larger(number_larger(before, number_fabs(stored)),
                                       number_fabs(supplied)),
                         number_fabs(dissipated));
}

/* How strongly the drift of the residual asks for a shorter next step. Each step is within its
 * tolerance, but errors of one sign add up over a long run. So the residual `added` by a step, over
 * the tolerance of an average step's share of the energy, is multiplied by the part of the tolerance
 * of all the energy that the residual has used up: a small residual does not shorten the step. */
static inline number bgc_drift_error(number residual, number added, number exchanged,
                                     number stored, number moved, double steps, double rtol) {
    const double weight = 4.0; /* keeps the residual below half of its tolerance */
    const number energy = number_larger(number_larger(exchanged, number_fabs(stored)), moved);
    const number share = number_larger(energy / steps, moved);
    const number used = weight * residual / (rtol * energy);
    const number drift = used * added / (rtol * share);

    return number_select(number_is_finite(drift), drift, number_of(0.0));
}

/* The four accounts of a row. */
static inline void bgc_account_row(number stored, number supplied, number dissipated,
                                   number account[4]) {
    account[0] = stored;
    account[1] = supplied;
    account[2] = dissipated;
    account[3] = stored - supplied + dissipated;
}

#endif
