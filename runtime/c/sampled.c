/* sampled.c: sampled parts, `sample period { .. }`: values that change at instants and are held in between.
 *
 * A held value is an input of the kernels. At an instant all values of the rates that are due are evaluated
 * with the states and held values before it, and then change together; what follows from them is settled as
 * after a change of any input (run.c). Instants are multiples of the period, never sums, so they do not
 * drift; steps end at them. FMUs of other tools take their communication steps there (fmus.c).
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>

/* Instant number i of a rate. */
static double instant_of(const bgc_data *d, int rate, double i) {
    return d->sampling[2 * rate + 1] + i * d->sampling[2 * rate];
}

/* Whether an instant of a rate is due. Times that differ by less than `slack`, which is small against the
 * step that ends there, are equal. */
static int is_due(const bgc_data *d, int rate, double slack) {
    const double equal = fmin(slack, 1e-6 * d->sampling[2 * rate]);

    return instant_of(d, rate, d->instants[rate]) <= d->core.t + equal;
}

/* The next instant of all rates. */
static void find_next_instant(const bgc_model *m, bgc_data *d) {
    d->core.instant = (double)INFINITY;
    for (int r = 0; r < m->n_rate; r++) {
        d->core.instant = fmin(d->core.instant, instant_of(d, r, d->instants[r]));
    }
    bgc_schedule(&d->core);
}

/* At a reset, with the parameters evaluated: the values at the start, and the first instants at or after
 * the present. */
void bgc_start_sampled(const bgc_model *m, bgc_data *d) {
    const double t = d->core.t, rounding_of_time = 1e-9;

    m->sampling(d->h, d->sampling, d->work);
    m->held_start(d->h, t, d->u, d->held_value, d->work);
    for (int k = 0; k < m->n_held; k++) {
        d->u[m->held_input[k]] = d->held_value[k];
    }
    for (int r = 0; r < m->n_rate; r++) {
        const double passed = (t - d->sampling[2 * r + 1]) / d->sampling[2 * r];
        d->instants[r] = fmax(ceil(passed - rounding_of_time), 0.0);
    }
    bgc_renew_fmus(m, d);
    find_next_instant(m, d);
}

/* Enters the changes of the books of the sampled ports into the accounts, before they become the present. */
static void enter_books(const bgc_model *m, bgc_data *d, double slack) {
    bgc_core *core = &d->core;

    for (int k = 0; k < 3 * m->n_port; k++) {
        const int held = m->book[k];
        double *account = k % 3 == 0   ? &core->supplied
                          : k % 3 == 1 ? &core->dissipated
                                       : &core->created;
        if (is_due(d, m->held_rate[held], slack)) {
            *account += d->held_value[held] - d->u[m->held_input[held]];
        }
    }
}

/* At an instant: evaluates the held values of the rates that are due, a few bits behind it, so that comparisons with
 * its time see it as reached however it is rounded. */
bgc_status bgc_take_sampled(const bgc_model *m, bgc_data *d, double slack) {
    const double behind = d->core.t + 4.0 * DBL_EPSILON * fabs(d->core.t);

    m->held(d->h, behind, d->x, d->u, d->held_value, d->work);
    for (int r = 0; m->n_fmu > 0 && r < m->n_rate; r++) {
        const bgc_status status =
            is_due(d, r, slack) ? bgc_take_fmus(m, d, r, instant_of(d, r, d->instants[r])) : BGC_OK;
        if (status != BGC_OK) {
            return status;
        }
    }
    enter_books(m, d, slack);
    for (int k = 0; k < m->n_held; k++) {
        if (!is_due(d, m->held_rate[k], slack)) {
            continue;
        }
        if (!isfinite(d->held_value[k])) {
            d->core.failed_held = k;
            return BGC_BAD_SAMPLE;
        }
        d->u[m->held_input[k]] = d->held_value[k];
    }
    for (int r = 0; r < m->n_rate; r++) {
        if (d->sampling[2 * r] <= 16.0 * DBL_EPSILON * fabs(d->core.t)) {
            return BGC_TOO_MANY_STEPS; /* instants closer than the resolution of time */
        }
        while (is_due(d, r, slack)) {
            d->instants[r] += 1.0;
        }
    }
    find_next_instant(m, d);
    return BGC_OK;
}
