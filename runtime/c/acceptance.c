/* acceptance.c: the end of a step that is accepted. */
#include "bgc_internal.h"

/* Makes d->next the present at t_new, and enters the step into the counts and the accounts. f at
 * the end of the step is kept where it has been evaluated. */
void bgc_accept(const bgc_model *m, bgc_ivp *d, const bgc_balance *balance, double t_new) {
    bgc_core *core = &d->core;

    core->counts.last_step = t_new - core->t;
    core->counts.steps++;
    bgc_replace_present(m, d);
    core->t = t_new;
    core->jac_valid = 0;
    core->f_valid = (core->f_at_end || core->f_last_at == t_new) && !core->event;
    if (core->f_valid) {
        bgc_take_slopes(m, d, core->f_at_end ? &d->error : &d->f_last);
    }
    if (core->accounts) {
        bgc_enter_balance(d, balance);
    }
}
