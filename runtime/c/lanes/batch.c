/* batch.c: a run of a batch of instances: memory, start, rows, end. */
#include "lanes/alone.h"
#include "control.h"

#include <stdlib.h>
#include <string.h>

int bgc_lane_width(void) { return BGC_LANE_WIDTH; }

/* --- memory -------------------------------------------------------------------------------- */

/* Allocates arrays one after another in `from`; counts only where that is NULL. */
typedef struct {
    lane *from;
    size_t used;
} layout;

static lane *place(layout *at, size_t count) {
    lane *start = at->from == NULL ? NULL : at->from + at->used;

    at->used += count;
    return start;
}

/* Allocates the arrays of a batch; returns their size in lanes. */
static size_t place_all(bgc_batch *b, lane *from) {
    const bgc_model *m = b->m;
    const size_t n = (size_t)m->n_state, unknown = (size_t)bgc_unknowns(m);
    const size_t local = (size_t)bgc_local_entries(m).count, slopes = (size_t)m->n_jac;
    const size_t switches = (size_t)m->n_switch, checks = (size_t)m->n_assert;
    const size_t kernel_work = (size_t)b->kernel->n_work;
    layout at = {from, 0};

#define ARRAY(type, name, count)
#define NUMBERS(name, count) b->name = place(&at, count);
#define SCRATCH
#include "arrays.h"
#undef ARRAY
#undef NUMBERS
#undef SCRATCH
    b->spare = place(&at, n);
    b->end = place(&at, n);
    b->argument = place(&at, (BGC_SAMPLES + 1) * switches);
    b->hiding = place(&at, (BGC_SAMPLES + 1) * (size_t)m->n_watch);
    b->spare_row = (double *)place(&at, (size_t)m->n_output + 4);
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
    return b->method->family->jacobian || bgc_coupled_rate(b->m, d) < 0;
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
    bgc_load_inputs(b, count);

    /* Lanes that join, and their accounts. */
    for (int l = 0; l < count; l++) {
        lane_set(&b->account.stored0, l, b->instance[l]->core.stored0);
        b->active |= may_join(b, b->instance[l]) ? 1u << l : 0u;
    }

    /* The energy that counts as small, of each instance. */
    for (int l = 0; l < BGC_LANE_WIDTH && b->core.accounts && bgc_is_adaptive(b->method); l++) {
        bgc_data *d = b->instance[l < count ? l : count - 1];
        bgc_hold_modes(m, d);
        bgc_settle_energy_scale(m, d);
        bgc_release_modes(m, d);
        lane_set(&b->account.energy_scale, l, d->core.energy_scale);
    }
    b->account.exchanged =
        lane_max(lane_fabs(b->account.stored0), b->core.rtol * b->account.energy_scale);
    b->y0 = b->y1 = b->x;
    b->slopes = b->f;
    bgc_check_lanes(b);
}

/* The core of a batch at its start: the options and the time of the first instance. */
static bgc_core core_of(const bgc_data *first) {
    bgc_core core = first->core;

    core.counts = (bgc_counts){.worst_step_seconds = 0.0};
    core.ticks = core.sample = 0;
    core.instant = core.stop = INFINITY;
    bgc_schedule(&core);
    core.t_old = core.t_end = core.t;
    core.algebraic = core.event = core.left = 0;
    core.f_valid = core.jac_valid = core.held = core.watched = 0;
    core.dense = BGC_NO_DENSE;
    core.pivoting = BGC_STATIC;
    core.h_next = 0.0;
    core.error_old = 1.0;
    core.rejected = core.account_rejections = core.near_edge = core.unresolved = 0;
    return core;
}

/* Integrates until the present is at or beyond t, or no lane is active. */
static bgc_status advance_to(bgc_batch *b, double t) {
    bgc_data *first = b->instance[0];

    for (long attempts = 0;; attempts++) {
        if (b->core.period > 0.0 && b->core.t <= t + bgc_time_slack(b->core.t, b->core.t_old)) {
            bgc_sample_all(b);
        }
        if (b->active == 0 || b->core.t >= t - bgc_time_slack(b->core.t, b->core.t_old)) {
            return BGC_OK;
        }
        if (attempts >= b->core.max_steps) {
            b->active = 0;
            return BGC_OK;
        }
        if (atomic_exchange(&first->stop, 0) != 0) {
            return BGC_INTERRUPTED;
        }
        bgc_attempt_together(b);
        if (b->interrupted) {
            return BGC_INTERRUPTED;
        }
        first->core.t = b->core.t; /* progress, for other threads */
    }
}

/* Writes the next row of every active lane that does not have it. Lanes whose energies are not
 * finite leave the batch, and end by themselves. */
static void write_rows(bgc_batch *b) {
    const size_t width = bgc_row_width(b);
    const double t = b->times[b->row];

    bgc_evaluate_row(b->m, b, t, t < b->core.t - bgc_time_slack(b->core.t, b->core.t_old),
                     b->output);
    if (b->core.accounts) {
        b->active &= ~bgc_bad_lanes(b, 4, b->output + b->m->n_output);
    }
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        for (size_t j = 0; ((b->active & ~b->written) >> l & 1u) != 0 && j < width; j++) {
            b->rows[l][b->row * width + j] = lane_get(b->output[j], l);
        }
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
            write_rows(b);
        }
    }
    return BGC_OK;
}

/* At the end of a run: adds the corrections of lane l to those of the steps which it took by
 * itself. */
static void report_corrections(const bgc_batch *b, int l, bgc_data *d) {
    for (int i = 0; i < b->m->n_state; i++) {
        const double correction = lane_get(b->correction[i], l);
        if (correction > d->correction[i]) {
            d->correction[i] = correction;
            d->corrected_at[i] = lane_get(b->corrected_at[i], l);
        }
        d->range[i] = fmax(d->range[i], lane_get(b->range[i], l));
    }
    bgc_report_correction(b->m, d);
}

/* Gives each instance the counts of the batch. Its state is not that of the end: it has to be
 * reset. */
static void store_counts(const bgc_batch *b, int count) {
    for (int l = 0; l < count; l++) {
        bgc_core *core = &b->instance[l]->core;
        bgc_counts *counts = &core->counts;
        if ((b->active >> l & 1u) != 0) {
            const bgc_counts own = *counts;
            *counts = b->core.counts;
            counts->events = own.events;
            counts->subdivided = own.subdivided;
            counts->over_budget = own.over_budget;
            counts->most_attempts = own.most_attempts;
            counts->largest_excess = own.largest_excess;
            counts->excess_time = own.excess_time;
            counts->exchanged = lane_get(b->account.exchanged, l);
            counts->scale_reached = lane_get(b->scale_reached, l);
            counts->rounding_samples += own.rounding_samples;
            counts->rounding = own.rounding + (long)lane_get(b->rounding, l);
            counts->largest_rounding =
                fmax(own.largest_rounding, lane_get(b->largest_rounding, l));
            report_corrections(b, l, b->instance[l]);
            core->t = b->core.t;
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
        .core = core_of(instance[0]),
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
    bgc_reset_choice(m, &b);
    load_instances(&b, count);
    status = run(&b);
    store_counts(&b, count);
    *finished = b.active;
    free(allocated);
    return status;
}
