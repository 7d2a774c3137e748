/* batch.c: a run of a batch of instances: memory, start, rows, end. */
#include "lanes/batch.h"

#include <stdlib.h>
#include <string.h>

int bgc_lane_width(void) { return BGC_LANE_WIDTH; }

/* --- memory -------------------------------------------------------------------------------- */

/* Allocates arrays one after another in `from`; counts only where that is NULL. */
typedef struct {
    lane *from;
    size_t used;
} layout;

static lane *place(layout *at, int count) {
    lane *start = at->from == NULL ? NULL : at->from + at->used;

    at->used += (size_t)count;
    return start;
}

/* Allocates the arrays of a batch; returns their size in lanes. */
static size_t place_all(bgc_batch *b, lane *from) {
    const bgc_model *m = b->m;
    const int n = m->n_state, unknowns = bgc_unknowns(m);
    layout at = {from, 0};

    /* The equations: inputs, f, df/dx and the factors of W. */
    b->h = place(&at, m->n_hoist);
    b->x = place(&at, n);
    b->u = place(&at, m->n_input + m->n_switch);
    b->mass = place(&at, m->n_mass);
    b->scale = place(&at, unknowns);
    b->inverse_mass = place(&at, n);
    b->jac = place(&at, bgc_local_entries(m).count);
    b->dfdt = place(&at, n);
    b->lu = place(&at, m->n_lu);
    b->f = place(&at, n);
    b->f_last = place(&at, n);

    /* A step: dense output, stages, error, and right-hand sides with inner unknowns. */
    b->y0 = place(&at, n);
    b->k = place(&at, BGC_MAX_DENSE * n);
    b->stages = place(&at, BGC_MAX_STAGES * n);
    b->direction = place(&at, n);
    b->image = place(&at, n);
    b->next = place(&at, n);
    b->error = place(&at, n);
    b->point = place(&at, n);
    b->b = place(&at, n);
    b->wide = place(&at, unknowns);
    b->residual = place(&at, unknowns);
    b->reach = place(&at, unknowns);
    b->magnitude = place(&at, unknowns);

    /* Results of kernels, and switches and pulses within a step. */
    b->output = place(&at, m->n_output + 4);
    b->check = place(&at, m->n_assert);
    b->argument = place(&at, (BGC_SAMPLES + 1) * m->n_switch);
    b->extent = place(&at, m->n_switch);
    b->hiding = place(&at, (BGC_SAMPLES + 1) * m->n_watch);

    /* Warnings about accuracy: corrections, rounding, states below their tolerances. */
    b->correction = place(&at, n);
    b->corrected_at = place(&at, n);
    b->range = place(&at, n);
    b->resolved = place(&at, n);
    b->shifted = place(&at, n);
    b->shifted_f = place(&at, n);
    b->noise = place(&at, n);
    b->subtol_from = place(&at, n);
    b->subtol_to = place(&at, n);
    b->spare_row = (double *)place(&at, m->n_output + 4);
    b->work = place(&at, b->kernel->n_work);
    return at.used;
}

/* Gathers n entries of an array of bgc_data, given by its offset there, from all instances. */
static void gather(const bgc_batch *b, int count, size_t n, lane *to, size_t offset) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        const bgc_data *d = b->instance[l < count ? l : count - 1];
        const double *from;
        memcpy(&from, (const char *)d + offset, sizeof from);
        for (size_t i = 0; i < n; i++) {
            lane_set(to + i, l, from[i]);
        }
    }
}

/* --- a run --------------------------------------------------------------------------------- */

/* Whether batches serve this model under this method. */
static int is_served(const bgc_model *m, const bgc_lane_model *kernel, const bgc_method *method) {
    return m->n_state > 0 && method->family->lanes &&
           (!method->family->jacobian || kernel->factor != NULL);
}

/* Whether an instance can join a batch: every state has a rate and, for an explicit method, M is
 * diagonal. */
static int may_join(const bgc_batch *b, const bgc_data *d) {
    if (!d->core.ready || d->core.algebraic > 0) {
        return 0;
    }
    for (int i = 0; !b->method->family->jacobian && i < b->m->n_state; i++) {
        if (d->inverse_mass[i] == 0.0) {
            return 0;
        }
    }
    return 1;
}

/* Loads the instances at their initial states. Lanes beyond the last instance copy it. */
static void load_instances(bgc_batch *b, int count) {
    const bgc_model *m = b->m;
    const size_t n = (size_t)m->n_state;

    gather(b, count, (size_t)m->n_hoist, b->h, offsetof(bgc_data, h));
    gather(b, count, n, b->x, offsetof(bgc_data, x));
    gather(b, count, (size_t)m->n_mass, b->mass, offsetof(bgc_data, mass));
    gather(b, count, (size_t)bgc_unknowns(m), b->scale, offsetof(bgc_data, scale));
    gather(b, count, n, b->inverse_mass, offsetof(bgc_data, inverse_mass));
    gather(b, count, n, b->subtol_from, offsetof(bgc_data, subtol_from));
    gather(b, count, n, b->subtol_to, offsetof(bgc_data, subtol_to));
    bgc_batch_load_inputs(b, count);

    /* Lanes that join, and their accounts. */
    b->stored0 = lane_of(0.0);
    for (int l = 0; l < count; l++) {
        lane_set(&b->stored0, l, b->instance[l]->core.stored0);
        b->active |= may_join(b, b->instance[l]) ? 1u << l : 0u;
    }
    b->supplied = b->dissipated = b->imbalance = lane_of(0.0);
    b->t = b->t_old = b->option->t;
    bgc_batch_forget_f(b);
    b->error_old = 1.0;
    b->largest_account = b->energy_scale = b->scale_reached = lane_of(0.0);
    b->rounding = b->largest_rounding = lane_of(0.0);
    bgc_batch_begin_choice(b);
    bgc_batch_begin_corrections(b);

    /* The energy that counts as small, of each instance. */
    for (int l = 0; l < BGC_LANE_WIDTH && b->option->accounts && bgc_is_adaptive(b->method); l++) {
        bgc_data *d = b->instance[l < count ? l : count - 1];
        bgc_hold_modes(m, d);
        bgc_settle_energy_scale(m, d);
        bgc_release_modes(m, d);
        lane_set(&b->energy_scale, l, d->core.energy_scale);
    }
    b->exchanged = lane_max(lane_fabs(b->stored0), b->option->rtol * b->energy_scale);
    bgc_batch_check(b, b->t, b->x);
}

/* Integrates until the present is at or beyond t, or no lane is active. */
static bgc_status advance_to(bgc_batch *b, double t) {
    bgc_data *first = b->instance[0];

    for (long attempts = 0;; attempts++) {
        if (b->option->period > 0.0 && b->t <= t + bgc_batch_slack(b)) {
            bgc_batch_sample(b);
        }
        if (b->active == 0 || b->t >= t - bgc_batch_slack(b)) {
            return BGC_OK;
        }
        if (attempts >= b->option->max_steps) {
            b->active = 0;
            return BGC_OK;
        }
        if (atomic_exchange(&first->stop, 0) != 0) {
            return BGC_INTERRUPTED;
        }
        bgc_batch_attempt(b);
        if (b->interrupted) {
            return BGC_INTERRUPTED;
        }
        first->core.t = b->t; /* progress, for other threads */
    }
}

/* All rows, as long as lanes are active. */
static bgc_status run(bgc_batch *b) {
    for (; b->row < b->n_rows && b->active != 0; b->row++) {
        const bgc_status status = advance_to(b, b->times[b->row]);
        if (status != BGC_OK) {
            return status;
        }
        if (b->active != 0) {
            bgc_batch_row(b);
        }
    }
    return BGC_OK;
}

/* Gives each instance the counts of the batch. Its state is not that of the end: it has to be reset. */
static void store_counts(const bgc_batch *b, int count) {
    for (int l = 0; l < count; l++) {
        bgc_core *core = &b->instance[l]->core;
        if ((b->active >> l & 1u) != 0) {
            const bgc_counts own = core->counts;
            core->counts = b->counts;
            core->counts.events = own.events;
            core->counts.subdivided = own.subdivided;
            core->counts.over_budget = own.over_budget;
            core->counts.most_attempts = own.most_attempts;
            core->counts.largest_excess = own.largest_excess;
            core->counts.excess_time = own.excess_time;
            core->counts.exchanged = lane_get(b->exchanged, l);
            core->counts.scale_reached = lane_get(b->scale_reached, l);
            core->counts.rounding_samples = own.rounding_samples;
            core->counts.rounding = own.rounding;
            core->counts.largest_rounding = own.largest_rounding;
            bgc_batch_report_rounding(b, l, &core->counts);
            bgc_batch_report_corrections(b, l, b->instance[l]);
            core->t = b->t;
            core->ready = 0;
        }
    }
}

bgc_status bgc_run_lanes(const bgc_model *m, bgc_data *const *instance, int count,
                         const double *times, size_t n, double *const *rows, unsigned *finished) {
    bgc_batch b = {
        .m = m,
        .kernel = bgc_get_lane_model(),
        .instance = instance,
        .option = &instance[0]->core,
        .method = &bgc_methods[instance[0]->core.method],
        .times = times,
        .rows = rows,
        .n_rows = n,
    };
    size_t size;
    lane *memory;
    void *allocated;
    bgc_status status;

    *finished = 0;
    if (!is_served(m, b.kernel, b.method)) {
        return BGC_OK;
    }
    size = place_all(&b, NULL) * sizeof(lane);
    memory = bgc_aligned_zeros(size, &allocated);
    if (memory == NULL) {
        return BGC_NO_MEMORY;
    }
    place_all(&b, memory);
    load_instances(&b, count);
    status = run(&b);
    store_counts(&b, count);
    *finished = b.active;
    free(allocated);
    return status;
}
