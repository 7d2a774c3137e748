/* stiffness.c: a bound on the spectral radius of M^-1 J along a run, by which a run knows whether an
 * explicit method would have done.
 *
 * The spectral radius of a matrix is at most that of its entries' absolute values, and for a matrix B
 * without negative entries and any v > 0 it is at most max_i (B v)_i / v_i (Collatz and Wielandt):
 * R. S. Varga, Matrix Iterative Analysis, 2.1. A few power iterations make the bound sharp; scales of
 * states do not matter.
 */
#include "bgc_internal.h"

#include <math.h>

/* Steps between two bounds: of adaptive ones, and of fixed ones, which are cheaper. */
enum { ADAPTIVE_INTERVAL = 32, FIXED_INTERVAL = 256, POWER_ITERATIONS = 10 };
static const double identity = 0.1; /* its multiple in the iterations, over the bound */

/* An upper bound on the spectral radius of M^-1 J, of the Jacobian at hand; INFINITY where M is not
 * diagonal and regular. */
static double spectral_bound(const bgc_model *m, bgc_data *d) {
    const int n = m->n_state;
    double *v = d->point, *image = d->right, least = INFINITY;

    for (int i = 0; i < n; i++) {
        v[i] = 1.0;
        if (d->inverse_mass[i] == 0.0) {
            return INFINITY;
        }
    }
    for (int round = 0; round < POWER_ITERATIONS && least > 0.0; round++) {
        double most = 0.0;
        for (int i = 0; i < n; i++) {
            image[i] = 0.0;
        }
        for (int k = 0; k < m->n_jac; k++) {
            const int row = m->jac_row[k];
            image[row] += fabs(d->jac[k] * d->inverse_mass[row]) * v[m->jac_col[k]];
        }
        for (int i = 0; i < n; i++) {
            most = image[i] / v[i] > most ? image[i] / v[i] : most;
        }
        least = most < least ? most : least;

        /* Iterate with a multiple of the identity, which keeps every entry positive. */
        for (int i = 0; i < n; i++) {
            v[i] = (image[i] + identity * most * v[i]) / ((1.0 + identity) * most);
        }
    }
    return least;
}

/* After a step of length h of a method with a Jacobian, which is still that of the step. */
void bgc_watch_stiffness(const bgc_model *m, bgc_data *d, double h) {
    bgc_core *core = &d->core;
    const long steps = core->counts.steps;
    const int adaptive = bgc_is_adaptive(&bgc_methods[core->method]);

    if (steps % (adaptive ? ADAPTIVE_INTERVAL : FIXED_INTERVAL) == 0 || (steps & (steps - 1)) == 0) {
        core->spectral_bound = spectral_bound(m, d);
        if (!(core->spectral_bound <= core->counts.fastest)) {
            core->counts.fastest = core->spectral_bound;
        }
    }
    core->counts.stiffness += h * core->spectral_bound;
}
