/* stiffness.c: a bound on the spectral radius of M^-1 J along a run, by which a run knows whether an
 * explicit method would have done.
 *
 * The spectral radius of a matrix is at most that of its entries' absolute values, and for a matrix B
 * without negative entries and any v > 0 it is at most max_i (B v)_i / v_i (Collatz and Wielandt):
 * R. S. Varga, Matrix Iterative Analysis, 2.1. Power iterations make the bound sharp. The first bound of a
 * run starts from the scales of the states, each other from the vector of the one before, so that one
 * or two iterations are usually enough.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

/* Steps between two bounds: of adaptive ones, and of fixed ones, which are cheaper, or where df/dx
 * has to be made for it. */
enum { ADAPTIVE_INTERVAL = 64, FIXED_INTERVAL = 512, POWER_ITERATIONS = 10 };
enum { SECOND_BOUND = 16 }; /* step of the second; from it on also at powers of two */
static const double identity = 0.1;    /* its multiple in the iterations, over the bound */
static const double settled = 0.95;    /* ratio of two bounds, or its inverse, that ends iterations */
static const double smallest = 1e-100; /* entry of v: an uncoupled slow state does not underflow */

/* At the start of a run. */
void bgc_reset_stiffness(const bgc_model *m, bgc_data *d) {
    d->core.spectral_bound = 0.0;
    memcpy(d->dominant, d->scale, (size_t)m->n_state * sizeof *d->dominant);
}

/* image = |M^-1 J| v. Returns the largest ratio image_i / v_i. Entries of a row are
 * contiguous. */
static double iterate(const bgc_model *m, const bgc_data *d, const double *entry, const double *v,
                      double *restrict image) {
    const int *row_of = m->jac_row, *column = m->jac_col, count = m->n_jac;
    double most = 0.0;

    memset(image, 0, (size_t)m->n_state * sizeof *image);
    for (int k = 0; k < count;) {
        const int row = row_of[k];
        double sum = 0.0;
        for (; k < count && row_of[k] == row; k++) {
            sum += fabs(entry[k]) * v[column[k]];
        }
        image[row] = sum * fabs(d->inverse_mass[row]);
        most = image[row] <= most * v[row] ? most : image[row] / v[row];
    }
    return most;
}

/* An upper bound on the spectral radius of M^-1 J, of the Jacobian at hand; INFINITY where M is not
 * diagonal and regular. The Jacobian is finite: W could be factorised. */
static double spectral_bound(const bgc_model *m, bgc_data *d) {
    const int n = m->n_state;
    const double *entry;
    double *v = d->dominant, *image = d->right, least = INFINITY;
    double before = d->core.spectral_bound;

    for (int i = 0; i < n; i++) {
        if (d->inverse_mass[i] == 0.0) {
            return INFINITY;
        }
    }
    entry = bgc_slopes(m, d);
    for (int round = 0; round < POWER_ITERATIONS; round++) {
        const double most = iterate(m, d, entry, v, image);
        if (most == 0.0) {
            return 0.0;
        }

        /* Iterate with a multiple of the identity, which keeps every entry positive. */
        for (int i = 0; i < n; i++) {
            const double next = (image[i] + identity * most * v[i]) / ((1.0 + identity) * most);
            v[i] = next > smallest ? next : smallest;
        }
        least = most < least ? most : least;
        if (least >= settled * before && before >= settled * least) {
            break;
        }
        before = least;
    }
    return least;
}

/* After a step of length h of a method with a Jacobian, which is still that of the step. */
void bgc_watch_stiffness(const bgc_model *m, bgc_data *d, double h) {
    bgc_core *core = &d->core;
    const long steps = core->counts.steps;
    const int cheap = bgc_is_adaptive(bgc_present_method(core)) && m->n_inner == 0;
    const long often = cheap ? ADAPTIVE_INTERVAL : FIXED_INTERVAL;
    const int power = (steps & (steps - 1)) == 0; /* of two */

    if (steps % often == 0 || (power && steps >= SECOND_BOUND)) {
        core->spectral_bound = spectral_bound(m, d);
        if (!(core->spectral_bound <= core->counts.fastest)) {
            core->counts.fastest = core->spectral_bound;
        }
    }
    core->counts.stiffness += h * core->spectral_bound;
}
