/* fmi_tuning.c: parameters that change during a run.
 *
 * States keep their values, the algebraic equations are solved again, and the change of the stored energy
 * counts as supplied.
 */
#include "fmi.h"

static double stored_now(bgc_fmi *i) {
    double energy[3] = {0.0};

    if (i->d->core.accounts) {
        i->m->energy(i->d->h, i->d->core.t, i->d->x, i->d->u, energy, i->d->work);
    }
    return energy[0];
}

/* What depends on the parameters that have been set takes their values. */
static bgc_status apply_parameters(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    bgc_core *core = &d->core;
    const double stored = stored_now(i);
    bgc_status status = bgc_check_parameters(m, d);

    if (status != BGC_OK) {
        return status;
    }
    bgc_prepare_states(m, d);
    core->f_valid = core->jac_valid = core->held = 0;
    core->dense = BGC_NO_DENSE;
    core->energy_scale = -1.0;
    bgc_reset_time_windows(m, d);
    status = bgc_settle(m, d);
    if (status == BGC_OK && m->n_jump > 0) {
        status = bgc_jump(m, d, NULL, 0.0);
    }
    core->supplied += stored_now(i) - stored;
    return status;
}

/* Takes back a step that has passed the communication point, and applies the parameters there. */
bgc_fmi_status bgc_fmi_tune(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    const size_t n = (size_t)m->n_param;
    double *value = calloc(n + 1, sizeof *value);
    unsigned char *is_set = calloc(n + 1, 1);
    bgc_status status = value != NULL && is_set != NULL ? BGC_OK : BGC_NO_MEMORY;

    if (status == BGC_OK) {
        memcpy(value, d->p, n * sizeof *value);
        memcpy(is_set, d->is_set, n);
        if (i->kind == BGC_FMI_CO_SIMULATION) {
            status = bgc_fmi_return_to_point(i);
            bgc_find_modes(m, d);
        }
        memcpy(d->p, value, n * sizeof *value);
        memcpy(d->is_set, is_set, n);
    }
    free(value);
    free(is_set);
    if (status == BGC_OK) {
        status = apply_parameters(i);
        if (i->kind == BGC_FMI_MODEL_EXCHANGE) {
            bgc_find_modes(m, d);
            bgc_hold_modes(m, d);
        }
    }
    i->core.viewed = i->core.has_row = i->core.has_snapshot = 0;
    i->core.satisfied = 1;
    return status == BGC_OK ? BGC_FMI_OK : bgc_fmi_explain(i, BGC_FMI_ERROR, status);
}
