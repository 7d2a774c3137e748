/* acceptance.c: the end of a step that is accepted. */
#include "bgc_internal.h"

#include <string.h>

/* Makes d->next the present at t_new, and enters the step into the counts and the accounts. f at the end of the
 * step is kept where it has been evaluated. */
void bgc_accept(const bgc_model *m, bgc_ivp *d, const bgc_balance *balance, double t_new) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;
    bgc_core *core = &d->core;

    core->counts.last_step = t_new - core->t;
    core->counts.steps++;
    memcpy(d->x, d->next, size);
    core->t = t_new;
    core->jac_valid = 0;
    core->f_valid = (core->f_at_end || core->f_last_at == t_new) && !core->event;
    if (core->f_valid) {
        memcpy(d->f, core->f_at_end ? d->error : d->f_last, size);
    }
    if (core->accounts) {
        bgc_enter_balance(d, balance);
    }
}
