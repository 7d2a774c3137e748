/* instance.c: an instance of a model: parameters, reset, evaluation at the present. */
#include "bgc_internal.h"
#include "accounts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- memory ------------------------------------------------------------------------------ */

bgc_data *bgc_new(const bgc_model *m) {
    const size_t n = (size_t)m->n_state;
    const size_t searched = m->n_mass == 0 ? 0 : n < BGC_MAX_SEARCHED ? n : BGC_MAX_SEARCHED;
    bgc_data *d;
    size_t size;

    if (m->abi != BGC_ABI) {
        return NULL;
    }
    d = calloc(1, sizeof *d);
    if (d == NULL) {
        return NULL;
    }

    size = (bgc_place_all(m, d, NULL) + 8) * sizeof(double);
    d->memory = bgc_aligned_zeros(size, &d->allocated);
    d->is_set = calloc((size_t)m->n_param + 1, 1);
    d->device = calloc((size_t)m->n_device + 1, sizeof *d->device);
    d->block_search = calloc((8 + 3 * searched) * searched + 1, sizeof *d->block_search);
    d->pivot = calloc((size_t)bgc_unknowns(m) + 1, sizeof *d->pivot);
    d->closing_pivot = calloc(2 * bgc_closing_size(m) + 1, sizeof *d->closing_pivot);
    d->block = calloc(3 * n + 1, sizeof *d->block);
    d->start_pivot = calloc((size_t)m->n_start + 1, sizeof *d->start_pivot);
    if (d->memory == NULL || d->is_set == NULL || d->device == NULL || !bgc_reserve_dense(m, d) ||
        d->pivot == NULL || d->block == NULL || d->start_pivot == NULL || d->block_search == NULL ||
        d->closing_pivot == NULL) {
        bgc_free(m, d);
        return NULL;
    }

    /* Defaults. */
    bgc_place_all(m, d, d->memory);
    d->place = d->block + n;
    d->block_pivot = d->place + n;
    d->closing_list = d->closing_pivot + bgc_closing_size(m);
    atomic_init(&d->stop, 0);

    d->core.failed_parameter = d->core.failed_assertion = d->core.failed_state = -1;
    d->core.failed_switch = d->core.failed_divisor = d->core.failed_chain = d->core.failed_jump = -1;
    d->core.failed_held = d->failed_device = d->failed_fmu = -1;
    d->core.instant = (double)INFINITY;
    bgc_default_inputs(m, d->u);
    bgc_reset_modes(m, d);
    bgc_set_param(m, d, -1, 0.0);
    bgc_set_options(m, d, &(bgc_options){0});
    return d;
}

void bgc_free(const bgc_model *m, bgc_data *d) {
    if (d == NULL) {
        return;
    }
    if (d->device != NULL) {
        bgc_close_devices(m, d);
    }
    bgc_close_fmus(m, d);
    free(d->allocated);
    free(d->is_set);
    free(d->device);
    free(d->dense_lu);
    free(d->inner);
    free(d->dense_lu_complex);
    free(d->pivot_complex);
    free(d->block_lu);
    free(d->block_search);
    free(d->pivot);
    free(d->closing_pivot);
    free(d->block);
    free(d->start_pivot);
    free(d);
}

/* --- parameters -------------------------------------------------------------------------- */

bgc_status bgc_set_param(const bgc_model *m, bgc_data *d, int k, double value) {
    if (k >= m->n_param) {
        return BGC_BAD_ARGUMENT;
    }
    if (k < 0) {
        for (int i = 0; i < m->n_param; i++) {
            d->p[i] = m->param[i].value;
            d->is_set[i] = 0;
        }
    } else {
        d->p[k] = value;
        d->is_set[k] = 1;
    }
    if (m->defaults != NULL) {
        m->defaults(d->p, d->is_set, d->work);
    }
    return BGC_OK;
}

double bgc_get_param(const bgc_model *m, const bgc_data *d, int k) {
    return k >= 0 && k < m->n_param ? d->p[k] : (double)NAN;
}

/* Checks that parameters are in range, that those that must be positive are, and the assertions on them;
 * evaluates what depends on them alone. A start with wrong parameters may not exist, so they come first. */
bgc_status bgc_check_parameters(const bgc_model *m, bgc_data *d) {
    bgc_status status;

    for (int k = 0; k < m->n_param; k++) {
        if (d->p[k] < m->param[k].low || d->p[k] > m->param[k].high) {
            d->core.failed_parameter = k;
            return BGC_BAD_PARAMETER;
        }
    }

    /* Expressions of parameters; an assertion says why a default is not a number. */
    m->prepare(d->p, d->h, d->work);
    status = bgc_check_first_asserts(m, d, m->n_given_assert, d->core.t, d->x);
    if (status != BGC_OK) {
        return status;
    }
    for (int k = 0; k < m->n_param; k++) {
        if (isnan(d->p[k])) {
            d->core.failed_parameter = k;
            return BGC_BAD_PARAMETER;
        }
    }
    if (m->n_check > 0) {
        m->positive(d->p, d->h, d->check, d->work);
    }
    for (int k = 0; k < m->n_check; k++) {
        if (!(d->check[k] > 0.0)) {
            d->core.failed_parameter = m->n_param + k;
            return BGC_BAD_PARAMETER;
        }
    }
    return BGC_OK;
}

/* --- reset ------------------------------------------------------------------------------- */

/* Clears the state of a run; options and parameters stay. */
static void clear_run(bgc_core *core, double t) {
    core->counts = (bgc_counts){0};
    core->failed_parameter = core->failed_assertion = -1;
    core->failed_state = core->failed_switch = core->failed_divisor = -1;
    core->failed_chain = core->failed_jump = core->failed_held = -1;
    core->watches_chains = core->passes_singular = 0;
    core->chain_pivot = core->next_chain_pivot = 1.0;
    core->t = core->t_old = core->t_end = core->origin = t;
    core->sampled_at = (double)NAN;
    core->ticks = core->sample = core->step_cut = core->event = 0;
    core->stop = INFINITY;
    bgc_schedule(core);
    core->f_valid = core->jac_valid = core->held = core->rejected = core->watched = 0;
    core->watched_complex = 0;
    core->factorisations_complex = 0;
    core->halvings = core->unreturned = 0;
    core->dense = BGC_NO_DENSE;
    bgc_begin_sample(core);
    core->h_next = 0.0;
    core->error_old = 1.0;
    core->stored0 = core->largest_account = 0.0;
    core->energy_scale = -1.0;
    core->account_rejections = 0;
    core->imbalance = 0.0;
    core->limited_by = -1;
    core->hidden = 0;
    core->supplied = core->dissipated = core->created = core->supplied_old = core->dissipated_old = 0.0;
}

/* The scales of the states, M, and its structure, by the present parameters. */
void bgc_prepare_states(const bgc_model *m, bgc_data *d) {
    m->scale(d->h, d->scale, d->work);
    for (int i = 0; i < m->n_state; i++) {
        d->scale[i] = d->scale[i] > 0.0 ? d->scale[i] : 1.0;
    }
    if (m->n_mass > 0) {
        m->mass(d->h, d->mass, d->work);
    }
    bgc_classify_states(m, d);
}

/* Starts a run from the present state, made consistent. */
static bgc_status start_from_present(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;
    bgc_status status;

    core->failed_state = bgc_first_bad(m->n_state, d->x);
    if (core->failed_state >= 0) {
        return BGC_NOT_FINITE;
    }
    if (m->project != NULL) {
        m->project(d->h, core->t, d->x, d->work);
    }
    status = bgc_choose_chain_rows(m, d);
    if (status == BGC_OK) {
        status = bgc_close_chains_at_start(m, d);
    }
    if (status == BGC_OK) {
        status = bgc_watch_chains(m, d, core->t, d->x);
    }
    if (status == BGC_OK) {
        bgc_enter_chains(m, d);
        status = bgc_make_consistent(m, d);
    }
    if (status != BGC_OK) {
        return status;
    }

    /* Stored energy and counts at the start. */
    memcpy(d->u_seen, d->u, (size_t)m->n_input * sizeof *d->u);
    if (m->energy != NULL) {
        double energy[3];
        m->energy(d->h, core->t, d->x, d->u, energy, d->work);
        core->stored0 = energy[0];
    }
    core->counts = (bgc_counts){0};
    core->counts.scale_reached = bgc_is_adaptive(&bgc_methods[core->method]) ? 0.0 : 1.0;
    core->counts.exchanged = fabs(core->stored0);
    bgc_reset_corrections(m, d);
    bgc_reset_divisors(m, d);
    bgc_reset_stiffness(m, d);
    bgc_reset_choice(m, d);
    bgc_reset_terms(m, d);
    bgc_reset_subtolerance(m, d);
    bgc_reset_jumps(m, d);
    bgc_reset_errors(m, d);
    bgc_scale_inner(m, d);
    core->ready = core->restarts = 1;
    return BGC_OK;
}

bgc_status bgc_reset_unchecked(const bgc_model *m, bgc_data *d, double t) {
    bgc_core *core = &d->core;
    bgc_status status;

    core->ready = core->restarts = 0;
    if (!isfinite(t)) {
        return BGC_BAD_ARGUMENT;
    }

    /* Parameters and devices. */
    clear_run(core, t);
    bgc_reset_chains(m, d);
    bgc_reset_modes(m, d);
    atomic_store(&d->stop, 0);
    status = bgc_check_parameters(m, d);
    if (status == BGC_OK) {
        status = bgc_read_devices(m, d);
    }
    if (status == BGC_OK && m->n_rate > 0) {
        bgc_start_sampled(m, d);
    }
    if (status != BGC_OK) {
        return status;
    }

    /* Initial state, closed, scales, and the structure of M. */
    m->initial(d->h, t, d->u, d->x, d->work);
    status = bgc_close_start(m, d);
    if (status == BGC_OK) {
        status = bgc_solve_start(m, d);
    }
    if (status != BGC_OK) {
        return status;
    }
    bgc_prepare_states(m, d);
    return start_from_present(m, d);
}

bgc_status bgc_reset(const bgc_model *m, bgc_data *d, double t) {
    const bgc_status status = bgc_reset_unchecked(m, d, t);

    return status == BGC_OK ? bgc_check_given(m, d) : status;
}

bgc_status bgc_restart(const bgc_model *m, bgc_data *d) {
    if (!d->core.restarts) {
        return BGC_BAD_ARGUMENT;
    }
    clear_run(&d->core, d->core.t);
    d->core.ready = 0;
    return start_from_present(m, d);
}

bgc_status bgc_restart_at(const bgc_model *m, bgc_data *d, const double *start) {
    memcpy(d->x, start, (size_t)m->n_state * sizeof *start);
    for (int k = 0; k < m->n_held; k++) {
        d->u[m->held_input[k]] = start[m->n_state + k];
    }
    return bgc_restart(m, d);
}

/* --- queries ------------------------------------------------------------------------------- */

int bgc_failed_parameter(const bgc_data *d) { return d->core.failed_parameter; }
int bgc_failed_assertion(const bgc_data *d) { return d->core.failed_assertion; }
int bgc_failed_state(const bgc_data *d) { return d->core.failed_state; }
int bgc_failed_switch(const bgc_data *d) { return d->core.failed_switch; }
int bgc_failed_divisor(const bgc_data *d) { return d->core.failed_divisor; }
double bgc_failed_time(const bgc_data *d) { return d->core.failed_time; }
int bgc_failed_chain(const bgc_data *d) { return d->core.failed_chain; }
int bgc_count_jumps(const bgc_model *m) { return m->n_jump; }
int bgc_count_rates(const bgc_model *m) { return m->n_rate; }
int bgc_has_lane_factors(const bgc_model *m) {
    return m->factor != NULL || (m->blocks != NULL && m->blocks->in_lanes);
}
int bgc_count_held(const bgc_model *m) { return m->n_held; }
int bgc_held_input(const bgc_model *m, int k) { return m->held_input[k]; }
int bgc_failed_held(const bgc_data *d) { return d->core.failed_held; }
int bgc_failed_fmu(const bgc_data *d) { return d->failed_fmu; }
int bgc_failed_jump(const bgc_data *d) { return d->core.failed_jump; }
double bgc_time(const bgc_data *d) { return d->core.t; }
double *bgc_state(bgc_data *d) { return d->x; }
const double *bgc_scale(const bgc_data *d) { return d->scale; }
double *bgc_input(bgc_data *d) { return d->u; }
const bgc_counts *bgc_get_counts(const bgc_data *d) { return &d->core.counts; }
void bgc_stop(bgc_data *d) { atomic_store(&d->stop, 1); }

const char *bgc_chain_name(const bgc_model *m, int k) {
    const bgc_closure_info *c = m->closure_info;

    return c != NULL && k >= 0 && k < c->n_chain ? c->chain[k] : NULL;
}

int bgc_chain_state(const bgc_model *m, int k) {
    const bgc_closure_info *c = m->closure_info;

    return c != NULL && k >= 0 && k < c->n_moved ? c->moved[k] : -1;
}

const char *bgc_condition_name(const bgc_model *m, int k) {
    const bgc_closure_info *c = m->closure_info;

    return c != NULL && k >= 0 && k < c->n_all_conditions ? c->condition[k] : NULL;
}

const char *bgc_status_text(bgc_status s) {
    switch (s) {
    case BGC_OK:
        return "done";
    case BGC_STEP_TOO_SMALL:
        return "the error stays above the tolerance however small the step";
    case BGC_TOO_MANY_STEPS:
        return "too many steps between two rows of the result";
    case BGC_NOT_FINITE:
        return "an overflow or an undefined operation in the equations";
    case BGC_SINGULAR:
        return "the equations of a step have no unique solution: a singular matrix";
    case BGC_ASSERTION:
        return "an assertion of the model does not hold";
    case BGC_DEVICE:
        return "a device reported a fault; its forces were set to zero";
    case BGC_BAD_PARAMETER:
        return "a parameter is out of its range";
    case BGC_BAD_ARGUMENT:
        return "wrong arguments of a call";
    case BGC_INTERRUPTED:
        return "interrupted";
    case BGC_NO_MEMORY:
        return "out of memory";
    case BGC_NOT_EXPLICIT:
        return "an explicit method cannot solve equations that couple rates";
    case BGC_INCONSISTENT:
        return "no values near the given ones satisfy the algebraic equations";
    case BGC_NOT_CONVERGED:
        return "the Newton iteration of an implicit step does not converge";
    case BGC_CHATTERING:
        return "a law switches back and forth without end";
    case BGC_VANISHING:
        return "a divisor of the equations vanishes";
    case BGC_SINGULAR_CHAIN:
        return "a closed chain of rigid connections is at a singular position";
    case BGC_OPEN_CHAIN:
        return "the start does not close a chain of rigid connections";
    case BGC_ENDLESS_JUMPS:
        return "jumps of the states follow each other ever faster";
    case BGC_BAD_SAMPLE:
        return "a sampled value is not finite";
    case BGC_GRAZING:
        return "an event has no derivative: an argument touches the edge of its mode";
    case BGC_SIMULTANEOUS:
        return "an event has no derivative: several switches change at a time";
    case BGC_FMU:
        return "an FMU of another tool failed";
    }
    return "unknown status";
}

/* --- evaluation at the present time and state ---------------------------------------------- */

bgc_status bgc_rhs(const bgc_model *m, bgc_data *d, double *f) {
    m->rhs(d->h, d->core.t, d->x, d->u, f, d->work);
    d->core.failed_state = bgc_first_bad(m->n_state, f);
    return d->core.failed_state < 0 ? BGC_OK : BGC_NOT_FINITE;
}

void bgc_switch_arguments(const bgc_model *m, bgc_data *d, double *argument) {
    if (m->n_switch > 0) {
        m->switches(d->h, d->core.t, d->x, d->u, argument, d->work);
    }
}

bgc_status bgc_jacobian(const bgc_model *m, bgc_data *d, double *jac, double *dfdt) {
    bgc_differentiate(m, d, d->core.t, d->x, jac, dfdt);
    return bgc_first_bad(m->n_jac, jac) < 0 && bgc_first_bad(m->n_state, dfdt) < 0
               ? BGC_OK
               : BGC_NOT_FINITE;
}

bgc_status bgc_mass(const bgc_model *m, bgc_data *d, double *mass) {
    if (m->n_mass > 0) {
        memcpy(mass, d->mass, (size_t)m->n_mass * sizeof *mass);
    }
    return bgc_first_bad(m->n_mass, mass) < 0 ? BGC_OK : BGC_NOT_FINITE;
}

bgc_status bgc_outputs(const bgc_model *m, bgc_data *d, double *y) {
    m->outputs(d->h, d->core.t, d->x, d->u, y, d->work);
    return bgc_first_bad(m->n_output, y) < 0 ? BGC_OK : BGC_NOT_FINITE;
}

bgc_status bgc_next_held(const bgc_model *m, bgc_data *d, double *value, double *period) {
    if (m->n_held > 0) {
        m->held(d->h, d->core.t, d->x, d->u, value, d->work);
    }
    for (int k = 0; k < m->n_held; k++) {
        period[k] = d->sampling[2 * m->held_rate[k]];
    }
    return bgc_first_bad(m->n_held, value) < 0 ? BGC_OK : BGC_NOT_FINITE;
}

bgc_status bgc_energy(const bgc_model *m, bgc_data *d, double account[4]) {
    double energy[3] = {d->core.stored0, 0.0, 0.0};

    if (m->energy != NULL) {
        m->energy(d->h, d->core.t, d->x, d->u, energy, d->work);
    }
    bgc_account_row(energy[0] - d->core.stored0, d->core.supplied, d->core.dissipated, account);
    account[3] -= d->core.created;
    return BGC_OK;
}
