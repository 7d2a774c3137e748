/* accounts.h: formulas of the energy accounts of a step, of one instance and of a batch.
 *
 * The accounts are the stored energy since the start, and the integrals of the supplied and the
 * dissipated power; their residual is stored - supplied + dissipated.
 */
#ifndef BGC_ACCOUNTS_H
#define BGC_ACCOUNTS_H

#include "number.h"

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

/* The four accounts of a row. */
static inline void bgc_account_row(number stored, number supplied, number dissipated,
                                   number account[4]) {
    account[0] = stored;
    account[1] = supplied;
    account[2] = dissipated;
    account[3] = stored - supplied + dissipated;
}

#endif
