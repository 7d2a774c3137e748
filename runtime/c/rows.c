/* rows.c: outputs and energy accounts at a time: a row. */
#include "bgc_internal.h"
#include "accounts.h"

#include <string.h>

/* The row at t inside the last step, or at the present; without dense output where t is not
 * inside. */
void bgc_evaluate_row(const bgc_model *m, bgc_ivp *d, double t, int inside, number *row) {
    const bgc_accounts *a = bgc_accounts_of(d);
    const number *x = d->x, *u = d->u;
    number power[2] = {number_of(0.0), number_of(0.0)};

    /* The state at t: dense output, or the present one with its algebraic equations solved
     * exactly. */
    if (inside) {
        if (d->core.accounts) {
            bgc_integrate_energy(m, d, t, power);
        }
        bgc_interpolate(m, d, t, d->point);
        x = d->point;
        u = d->u_step;
    } else {
        t = d->core.t; /* the same but for the rounding of multiples, which callers do differently */
        if (d->core.algebraic > 0) {
            memcpy(d->point, d->x, (size_t)m->n_state * sizeof *d->x);
            bgc_satisfy_rows(m, d, t, d->point);
            x = d->point;
        }
    }

    /* Outputs, then accounts. */
    bgc_functions(m, d)->outputs(d->h, number_of(t), x, u, row, d->work);
    if (d->core.accounts) {
        number *account = row + m->n_output, energy[3];
        bgc_functions(m, d)->energy(d->h, number_of(t), x, u, energy, d->work);
        bgc_account_row(energy[0] - a->stored0, inside ? a->supplied_old + power[0] : a->supplied,
                        inside ? a->dissipated_old + power[1] : a->dissipated, account);
        account[3] -= a->created;
    }
}
