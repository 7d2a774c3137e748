/* fmi_instance.c: instances of an FMU: creation and release, messages, and saved states. */
#include "fmi.h"

/* --- messages ------------------------------------------------------------------------------ */

/* Logs a text, and returns its status. */
bgc_fmi_status bgc_fmi_report(bgc_fmi *i, bgc_fmi_status as, const char *text) {
    const char *category = as >= BGC_FMI_ERROR     ? "logStatusError"
                           : as == BGC_FMI_DISCARD ? "logStatusDiscard"
                                                   : "logStatusWarning";

    if (i->hooks.log != NULL && (as >= BGC_FMI_DISCARD || i->logs)) {
        i->hooks.log(i, as, category, text);
    }
    return as;
}

bgc_fmi_status bgc_fmi_refuse(bgc_fmi *i, const char *text) { return bgc_fmi_report(i, BGC_FMI_ERROR, text); }

/* Refuses n variables of a type that this FMU does not have: all of its variables are of the type `type`. */
bgc_fmi_status bgc_fmi_refuse_variables(bgc_fmi *i, size_t n, const char *name, const char *type) {
    char text[200];

    if (n == 0) {
        return BGC_FMI_OK;
    }
    snprintf(text, sizeof text, "%s: all variables of this FMU are of type %s", name, type);
    return bgc_fmi_refuse(i, text);
}

/* The part of a model at which a call failed, and in which role; NULL where there is none. */
static const char *part_at_fault(const bgc_fmi *i, bgc_status status, const char **role) {
    const bgc_model *m = i->m;
    const bgc_data *d = i->d;
    int k;

    switch (status) {
    case BGC_ASSERTION:
        *role = "assertion";
        k = bgc_failed_assertion(d);
        return k >= 0 && k < m->n_assert ? m->assertion[k] : NULL;
    case BGC_BAD_PARAMETER:
        k = bgc_failed_parameter(d);
        *role = k < m->n_param                   ? "parameter"
                : k > m->n_param + m->n_check ? "initial value"
                                              : "condition";
        return k < 0                         ? NULL
               : k < m->n_param              ? m->param[k].name
               : k < m->n_param + m->n_check ? m->param_check[k - m->n_param]
               : k > m->n_param + m->n_check ? m->given_name[k - m->n_param - m->n_check - 1]
                                             : "initial values exist";
    case BGC_VANISHING:
        *role = "divisor of";
        k = bgc_failed_divisor(d);
        return k >= 0 && k < m->n_divisor ? m->divisor[k] : NULL;
    case BGC_SINGULAR_CHAIN:
        *role = "closed chain";
        return bgc_chain_name(m, bgc_failed_chain(d));
    case BGC_OPEN_CHAIN:
        *role = "condition";
        return bgc_condition_name(m, bgc_failed_chain(d));
    default:
        *role = "state";
        k = bgc_failed_state(d);
        return k >= 0 && k < m->n_state ? m->state[k].name : NULL;
    }
}

/* Logs a failure of the model with the name of its state or other part. */
bgc_fmi_status bgc_fmi_explain(bgc_fmi *i, bgc_fmi_status as, bgc_status status) {
    const char *role = "", *part = part_at_fault(i, status, &role);
    char text[1000];

    if (part != NULL) {
        snprintf(text, sizeof text, "at t = %.9g s: %s (%s `%s`)", i->d->core.t, bgc_status_text(status),
                 role, part);
    } else {
        snprintf(text, sizeof text, "at t = %.9g s: %s", i->d->core.t, bgc_status_text(status));
    }
    return bgc_fmi_report(i, as, text);
}

/* --- creation and release ------------------------------------------------------------------ */

static double *zeros(size_t n) { return calloc(n + 1, sizeof(double)); }

/* Options of the scene, with the importer's tolerance. Inputs act when they are set, not at samples. */
static bgc_status set_options(bgc_fmi *i) {
    bgc_options options = i->info->options;
    bgc_status status;

    if (i->core.rtol > 0.0) {
        bgc_method_info method;
        for (int k = 0; bgc_get_method(k, &method) == BGC_OK; k++) {
            if (options.name != NULL && strcmp(method.name, options.name) == 0 && method.error_order > 0) {
                options.rtol = i->core.rtol;
            }
        }
    }
    status = bgc_set_options(i->m, i->d, &options);
    i->d->core.period = 0.0;
    bgc_schedule(&i->d->core);
    return status;
}

/* Values at the start of an instance and after a reset. */
static bgc_status take_defaults(bgc_fmi *i) {
    memset(&i->core, 0, sizeof i->core);
    bgc_set_param(i->m, i->d, -1, 0.0);
    for (int k = 0; k < i->info->n_input; k++) {
        i->given[k] = bgc_input(i->d)[k] = i->info->input_start[k];
    }
    return set_options(i);
}

bgc_fmi *bgc_fmi_new(bgc_fmi_kind kind, const char *name, const char *token, int logs,
                     const bgc_fmi_hooks *hooks, void *environment, void (*logger)(void)) {
    const bgc_model *m = bgc_get_model();
    const bgc_fmi_info *info = bgc_fmi_get_info();
    const size_t n = (size_t)m->n_state;
    bgc_fmi *i = calloc(1, sizeof *i);
    int complete;

    if (i == NULL) {
        return NULL;
    }
    i->m = m;
    i->info = info;
    i->kind = kind;
    i->logs = logs;
    i->hooks = *hooks;
    i->environment = environment;
    i->logger = logger;
    i->name = calloc(strlen(name != NULL ? name : "") + 1, 1);
    if (i->name != NULL && name != NULL) {
        memcpy(i->name, name, strlen(name));
    }
    if (token == NULL || strcmp(token, info->token) != 0) {
        bgc_fmi_report(i, BGC_FMI_ERROR,
                       "the model description belongs to another build of this FMU: its token differs");
        bgc_fmi_free(i);
        return NULL;
    }

    /* The instance of the model, and the arrays that calls of the importer need. */
    i->d = bgc_new(m);
    i->view_x = zeros(n);
    i->view_u = zeros((size_t)m->n_input + (size_t)m->n_switch);
    i->inputs = zeros((size_t)m->n_input + (size_t)m->n_switch);
    i->given = zeros((size_t)info->n_input);
    i->row = zeros((size_t)m->n_output + 4);
    i->command = zeros((size_t)m->n_command);
    i->rate = zeros(n + 3);
    i->indicator = zeros((size_t)m->n_switch);
    i->n_partial = m->n_jac + info->n_partial;
    i->partial = zeros((size_t)i->n_partial);
    i->partial_row = calloc((size_t)i->n_partial + 1, sizeof *i->partial_row);
    i->partial_col = calloc((size_t)i->n_partial + 1, sizeof *i->partial_col);
    i->seed = zeros(n + (size_t)m->n_input + 2);
    i->result = zeros(n + (size_t)m->n_output + (size_t)m->n_command + 3);
    i->matrix = zeros(m->n_mass > 0 ? n * n : 0);
    i->pivot = calloc(n + 1, sizeof *i->pivot);
    i->snapshot = calloc(bgc_save_size(m) + 1, 1);
    complete = i->name != NULL && i->d != NULL && i->view_x != NULL && i->view_u != NULL && i->inputs != NULL &&
               i->given != NULL && i->row != NULL && i->command != NULL && i->rate != NULL &&
               i->indicator != NULL && i->partial != NULL &&
               i->partial_row != NULL && i->partial_col != NULL && i->seed != NULL && i->result != NULL &&
               i->matrix != NULL && i->pivot != NULL && i->snapshot != NULL;
    if (!complete || take_defaults(i) != BGC_OK) {
        bgc_fmi_report(i, BGC_FMI_ERROR, "out of memory");
        bgc_fmi_free(i);
        return NULL;
    }

    /* The pattern of partial derivatives: that of df/dx, then that of outputs and inputs. */
    for (int e = 0; e < i->n_partial; e++) {
        const int k = e - m->n_jac;
        i->partial_row[e] = k < 0 ? m->jac_row[e] : info->partial_row[k];
        i->partial_col[e] = k < 0 ? m->jac_col[e] : info->partial_col[k];
    }
    return i;
}

void bgc_fmi_free(bgc_fmi *i) {
    if (i == NULL) {
        return;
    }
    bgc_free(i->m, i->d);
    free(i->view_x);
    free(i->view_u);
    free(i->inputs);
    free(i->given);
    free(i->row);
    free(i->command);
    free(i->rate);
    free(i->indicator);
    free(i->partial);
    free(i->partial_row);
    free(i->partial_col);
    free(i->seed);
    free(i->result);
    free(i->matrix);
    free(i->pivot);
    free(i->snapshot);
    free(i->name);
    free(i);
}

/* Computes the start for the present parameters and inputs, unless that is done. */
bgc_fmi_status bgc_fmi_start(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_status status;

    if (i->core.started) {
        return BGC_FMI_OK;
    }
    i->core.viewed = i->core.has_row = i->core.has_snapshot = 0;
    if (i->info->start != NULL) {
        status = bgc_reset_unchecked(m, i->d, i->core.start_time);
        status = status == BGC_OK ? bgc_restart_at(m, i->d, i->info->start) : status;
    } else {
        status = bgc_reset(m, i->d, i->core.start_time);
    }
    if (status != BGC_OK) {
        return bgc_fmi_explain(i, BGC_FMI_ERROR, status);
    }
    if (i->kind == BGC_FMI_MODEL_EXCHANGE) {
        bgc_find_modes(m, i->d);
        bgc_hold_modes(m, i->d);
    }
    i->core.t = i->core.start_time;
    i->core.started = i->core.satisfied = 1;
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_enter_initialisation(bgc_fmi *i, double rtol, double start) {
    if (i->core.phase != BGC_FMI_INSTANTIATED) {
        return bgc_fmi_report(i, BGC_FMI_ERROR, "initialisation begins after instantiation or a reset");
    }
    i->core.phase = BGC_FMI_INITIALISING;
    i->core.start_time = start;
    i->core.rtol = rtol > 0.0 ? rtol : 0.0;
    i->core.started = 0;
    i->d->core.t = start;
    return set_options(i) == BGC_OK ? BGC_FMI_OK
                                    : bgc_fmi_report(i, BGC_FMI_ERROR, "the solver refuses its options");
}

bgc_fmi_status bgc_fmi_exit_initialisation(bgc_fmi *i) {
    bgc_fmi_status status;

    if (i->core.phase != BGC_FMI_INITIALISING) {
        return bgc_fmi_report(i, BGC_FMI_ERROR, "initialisation ends where it has begun");
    }
    i->core.started = 0;
    status = bgc_fmi_start(i);
    if (status == BGC_FMI_OK) {
        const bgc_status held = bgc_check_asserts(i->m, i->d, i->d->core.t, i->d->x);
        status = held == BGC_OK ? BGC_FMI_OK : bgc_fmi_explain(i, BGC_FMI_ERROR, held);
    }
    if (status == BGC_FMI_OK) {
        i->core.phase = i->kind == BGC_FMI_MODEL_EXCHANGE || i->event_mode ? BGC_FMI_EVENTS : BGC_FMI_STEPS;
    }
    return status;
}

bgc_fmi_status bgc_fmi_enter(bgc_fmi *i, bgc_fmi_phase phase) {
    i->core.phase = phase;
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_set_logging(bgc_fmi *i, int logs) {
    i->logs = logs;
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_reset(bgc_fmi *i) {
    return take_defaults(i) == BGC_OK ? BGC_FMI_OK : BGC_FMI_ERROR;
}

/* --- saving ---------------------------------------------------------------------------------- */

/* The vectors of an instance that are saved behind its core. */
enum { SAVED_VECTORS = 3 };

static double *saved_vector(const bgc_fmi *i, int k, size_t *size) {
    const bgc_model *m = i->m;

    switch (k) {
    case 0:
        *size = (size_t)m->n_state;
        return i->view_x;
    case 1:
        *size = (size_t)m->n_input + (size_t)m->n_switch;
        return i->view_u;
    default:
        *size = (size_t)i->info->n_input;
        return i->given;
    }
}

size_t bgc_fmi_state_size(const bgc_fmi *i) {
    size_t all = sizeof i->core + 2 * bgc_save_size(i->m);

    for (int k = 0; k < SAVED_VECTORS; k++) {
        size_t size;
        saved_vector(i, k, &size);
        all += size * sizeof(double);
    }
    return all;
}

static void save(bgc_fmi *i, void *memory) {
    unsigned char *to = memory;

    memcpy(to, &i->core, sizeof i->core);
    to += sizeof i->core;
    for (int k = 0; k < SAVED_VECTORS; k++) {
        size_t size;
        const double *from = saved_vector(i, k, &size);
        memcpy(to, from, size * sizeof *from);
        to += size * sizeof *from;
    }
    memcpy(to, i->snapshot, bgc_save_size(i->m));
    bgc_save(i->m, i->d, to + bgc_save_size(i->m));
}

bgc_fmi_status bgc_fmi_restore(bgc_fmi *i, const void *memory) {
    const unsigned char *from = memory, *vectors, *rest;

    if (memory == NULL) {
        return bgc_fmi_refuse(i, "there is no FMU state to go back to");
    }
    vectors = from + sizeof i->core;
    rest = from + bgc_fmi_state_size(i) - 2 * bgc_save_size(i->m);
    if (bgc_restore(i->m, i->d, rest + bgc_save_size(i->m)) != BGC_OK) {
        return bgc_fmi_report(i, BGC_FMI_ERROR, "the FMU state belongs to another model");
    }
    memcpy(&i->core, from, sizeof i->core);
    for (int k = 0; k < SAVED_VECTORS; k++) {
        size_t size;
        double *to = saved_vector(i, k, &size);
        memcpy(to, vectors, size * sizeof *to);
        vectors += size * sizeof *to;
    }
    memcpy(i->snapshot, rest, bgc_save_size(i->m));
    i->core.has_row = 0;
    return BGC_FMI_OK;
}

/* The memory of a state, new where there is none yet. */
static bgc_fmi_status allocate(bgc_fmi *i, void **state) {
    if (*state == NULL) {
        *state = malloc(bgc_fmi_state_size(i));
    }
    return *state != NULL ? BGC_FMI_OK : bgc_fmi_refuse(i, "out of memory");
}

bgc_fmi_status bgc_fmi_get_state(bgc_fmi *i, void **state) {
    const bgc_fmi_status status = allocate(i, state);

    if (status == BGC_FMI_OK) {
        save(i, *state);
    }
    return status;
}

bgc_fmi_status bgc_fmi_free_state(bgc_fmi *i, void **state) {
    (void)i;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return BGC_FMI_OK;
}

/* A state as bytes, and back: it holds no pointers. */
bgc_fmi_status bgc_fmi_copy_state(bgc_fmi *i, const void *state, void *bytes, size_t size) {
    if (size < bgc_fmi_state_size(i)) {
        return bgc_fmi_refuse(i, "too little memory for the FMU state");
    }
    memcpy(bytes, state, bgc_fmi_state_size(i));
    return BGC_FMI_OK;
}

bgc_fmi_status bgc_fmi_take_state(bgc_fmi *i, const void *bytes, size_t size, void **state) {
    bgc_fmi_status status = BGC_FMI_OK;

    if (size != bgc_fmi_state_size(i)) {
        return bgc_fmi_refuse(i, "the FMU state belongs to another model");
    }
    status = allocate(i, state);
    if (status == BGC_FMI_OK) {
        memcpy(*state, bytes, size);
    }
    return status;
}
