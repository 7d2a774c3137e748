/* fmi_variables.c: values of variables by their references. */
#include "fmi.h"

/* --- references ------------------------------------------------------------------------------ */

static int group_size(const bgc_fmi *i, int group) {
    const bgc_model *m = i->m;

    switch (group) {
    case BGC_FMI_PARAMETERS:
        return m->n_param;
    case BGC_FMI_INPUTS:
        return i->info->n_input;
    case BGC_FMI_OUTPUTS:
        return m->n_output;
    case BGC_FMI_COMMANDS:
        return m->n_command;
    case BGC_FMI_ACCOUNTS:
        return 4;
    case BGC_FMI_POWERS:
        return 2;
    case BGC_FMI_INDICATORS:
        return m->n_switch;
    default: /* states, rates */
        return m->n_state;
    }
}

/* The first reference of a group; time is reference 0. */
int bgc_fmi_place(const bgc_fmi *i, int group) {
    int place = 1;

    for (int g = 0; g < group; g++) {
        place += group_size(i, g);
    }
    return place;
}

int bgc_fmi_references(const bgc_fmi *i) { return bgc_fmi_place(i, BGC_FMI_END); }

/* The group of a reference above 0, and its place in it. */
static int group_of(const bgc_fmi *i, unsigned ref, int *k) {
    int rest = (int)ref - 1, g = 0;

    while (g < BGC_FMI_END && rest >= group_size(i, g)) {
        rest -= group_size(i, g++);
    }
    *k = rest;
    return g;
}

static bgc_fmi_status refuse(bgc_fmi *i, unsigned ref, const char *why) {
    char text[200];

    snprintf(text, sizeof text, "value reference %u %s", ref, why);
    return bgc_fmi_report(i, BGC_FMI_ERROR, text);
}

/* The numbers behind n references; 0 where one is unknown, which is reported. */
static size_t count_numbers(bgc_fmi *i, const unsigned *ref, size_t n) {
    size_t all = 0;

    for (size_t k = 0; k < n; k++) {
        const int known = ref[k] < (unsigned)bgc_fmi_references(i);
        if (!known || i->info->count[ref[k]] == 0) {
            refuse(i, ref[k], "does not exist");
            return 0;
        }
        all += (size_t)i->info->count[ref[k]];
    }
    return all;
}

/* --- get --------------------------------------------------------------------------------------- */

/* Outputs and accounts at the view. */
static void fill_row(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;

    if (i->core.has_row) {
        return;
    }
    if (i->kind == BGC_FMI_CO_SIMULATION && i->core.phase != BGC_FMI_INITIALISING) {
        bgc_hold_modes(m, d);
        bgc_write_row(m, d, i->core.t, i->row);
        bgc_release_modes(m, d);
    } else {
        double energy[3] = {d->core.stored0, 0.0, 0.0}, *account = i->row + m->n_output;
        m->outputs(d->h, i->core.t, i->view_x, i->view_u, i->row, d->work);
        if (d->core.accounts) {
            m->energy(d->h, i->core.t, i->view_x, i->view_u, energy, d->work);
        }
        account[0] = energy[0] - d->core.stored0;
        account[1] = d->core.supplied;
        account[2] = d->core.dissipated;
        account[3] = account[0] - account[1] + account[2];
    }
    i->core.has_row = 1;
}

/* Arrays that a call of `bgc_fmi_get` has evaluated. */
typedef struct {
    int rates, commands, powers, indicators;
    double energy[3];
} evaluated;

static bgc_fmi_status evaluate_group(bgc_fmi *i, int group, evaluated *have) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    bgc_fmi_status status = BGC_FMI_OK;

    switch (group) {
    case BGC_FMI_OUTPUTS:
    case BGC_FMI_ACCOUNTS:
        fill_row(i);
        break;
    case BGC_FMI_COMMANDS:
        if (!have->commands) {
            m->commands(d->h, i->core.t, i->view_x, i->view_u, i->command, d->work);
        }
        have->commands = 1;
        break;
    case BGC_FMI_RATES:
        if (!have->rates) {
            status = bgc_fmi_rates(i, i->rate);
        }
        have->rates = 1;
        break;
    case BGC_FMI_POWERS:
        if (!have->powers) {
            m->energy(d->h, i->core.t, i->view_x, i->view_u, have->energy, d->work);
        }
        have->powers = 1;
        break;
    case BGC_FMI_INDICATORS:
        if (!have->indicators) {
            status = bgc_fmi_indicators(i, i->indicator);
        }
        have->indicators = 1;
        break;
    default:
        break;
    }
    return status;
}

static double value_of(const bgc_fmi *i, int group, int k, const evaluated *have) {
    switch (group) {
    case BGC_FMI_PARAMETERS:
        return i->d->p[k];
    case BGC_FMI_INPUTS:
        return i->given[k];
    case BGC_FMI_OUTPUTS:
        return i->row[k];
    case BGC_FMI_COMMANDS:
        return i->command[k];
    case BGC_FMI_ACCOUNTS:
        return i->row[i->m->n_output + k];
    case BGC_FMI_STATES:
        return i->view_x[k];
    case BGC_FMI_RATES:
        return i->rate[k];
    case BGC_FMI_POWERS:
        return have->energy[1 + k];
    default:
        return i->indicator[k];
    }
}

bgc_fmi_status bgc_fmi_get(bgc_fmi *i, const unsigned *ref, size_t n, double *value, size_t n_value) {
    evaluated have = {0};
    const size_t all = count_numbers(i, ref, n);
    int viewed = 0;

    if (all != n_value) {
        return n > 0 && all == 0 ? BGC_FMI_ERROR
                                 : bgc_fmi_report(i, BGC_FMI_ERROR, "the number of values is wrong");
    }
    for (size_t r = 0; r < n; r++) {
        for (int c = 0; c < i->info->count[ref[r]]; c++) {
            const unsigned at = ref[r] + (unsigned)c;
            int k, group;
            if (at == 0) {
                *value++ = i->core.t;
                continue;
            }
            group = group_of(i, at, &k);
            if (group > BGC_FMI_INPUTS && !viewed) {
                const bgc_fmi_status status = bgc_fmi_view(i);
                if (status != BGC_FMI_OK) {
                    return status;
                }
                viewed = 1;
            }
            if (evaluate_group(i, group, &have) != BGC_FMI_OK) {
                return BGC_FMI_ERROR;
            }
            *value++ = value_of(i, group, k, &have);
        }
    }
    return BGC_FMI_OK;
}

/* --- set --------------------------------------------------------------------------------------- */

static int is_before_start(const bgc_fmi *i) {
    return i->core.phase == BGC_FMI_INSTANTIATED || i->core.phase == BGC_FMI_INITIALISING;
}

static bgc_fmi_status set_one(bgc_fmi *i, unsigned ref, double value, int *tuned) {
    int k, group;

    if (ref == 0) {
        return refuse(i, ref, "is the time, which is not set so");
    }
    group = group_of(i, ref, &k);
    if (group == BGC_FMI_PARAMETERS) {
        if (!is_before_start(i) && !i->info->tunable[k]) {
            return refuse(i, ref, "is a fixed parameter: it is set before the end of initialisation");
        }
        if (i->d->p[k] != value || !i->d->is_set[k]) {
            bgc_set_param(i->m, i->d, k, value);
            *tuned = 1;
        }
        return BGC_FMI_OK;
    }
    if (group == BGC_FMI_INPUTS) {
        if (!isfinite(value)) {
            return refuse(i, ref, "is an input, whose value is not finite");
        }
        i->given[k] = value;
        return BGC_FMI_OK;
    }
    return refuse(i, ref, "is neither a parameter nor an input");
}

/* Inputs that have been set reach the model: at once in Model Exchange and before the start, else with
 * the next step. */
static void pass_inputs(bgc_fmi *i) {
    const size_t size = (size_t)i->info->n_input * sizeof(double);

    if ((is_before_start(i) || i->kind == BGC_FMI_MODEL_EXCHANGE) &&
        memcmp(i->d->u, i->given, size) != 0) {
        memcpy(i->d->u, i->given, size);
        i->core.satisfied = i->core.has_row = 0;
        if (is_before_start(i)) {
            i->core.started = 0;
        }
    }
}

bgc_fmi_status bgc_fmi_set(bgc_fmi *i, const unsigned *ref, size_t n, const double *value,
                           size_t n_value) {
    const size_t all = count_numbers(i, ref, n);
    bgc_fmi_status status = BGC_FMI_OK;
    int tuned = 0;

    if (all != n_value) {
        return n > 0 && all == 0 ? BGC_FMI_ERROR
                                 : bgc_fmi_report(i, BGC_FMI_ERROR, "the number of values is wrong");
    }
    for (size_t r = 0; r < n && status == BGC_FMI_OK; r++) {
        for (int c = 0; c < i->info->count[ref[r]] && status == BGC_FMI_OK; c++) {
            status = set_one(i, ref[r] + (unsigned)c, *value++, &tuned);
        }
    }
    pass_inputs(i);
    if (tuned && is_before_start(i)) {
        i->core.started = 0;
    } else if (tuned && status == BGC_FMI_OK) {
        status = bgc_fmi_tune(i);
    }
    return status;
}
