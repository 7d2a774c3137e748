/* substeps.c: subdivision of fixed steps by their error estimate, within a budget.
 *
 * A sample is the interval of one fixed step. It begins with an attempt at one step of that length.
 * Where the embedded error of an attempt is above the tolerance, the attempt is rejected and the next
 * one is shorter. After the first, a sample takes at most `substeps` attempts: no step is shorter than
 * the rest of the sample divided by the attempts that remain, and a step of that length is accepted
 * whatever its error is; the counts report it. An attempt that ends at an event is not counted.
 *
 * Nothing is carried from one sample to the next, so that a sample takes the same steps alone and in a
 * batch. A sample that is not subdivided has the same bits as without a budget.
 */
#include "bgc_internal.h"
#include "control.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A rejection is only worth its cost where the next step may be shorter than this part. */
static const double worthwhile = 0.9;
/* A rest of a sample up to this much longer than the wanted length is not divided further. */
static const double stretch = 0.1;

/* At the start of a sample. */
void bgc_begin_sample(bgc_core *core) {
    core->attempts = core->exceeded = 0;
    core->sub_step = core->step;
}

/* The end of the next attempt, at the latest `grid`, the end of the sample. Sets core->last_resort
 * where the budget leaves no shorter step. */
double bgc_plan_substep(bgc_core *core, double grid) {
    const double rest = grid - core->t;
    const int spare = core->substeps - core->attempts; /* attempts that remain after this one */
    const double h = fmax(core->sub_step, rest / fmax(spare + 1.0, 1.0));
    const double parts = fmax(ceil(rest / h - stretch), 1.0);
    const double length = rest / parts;

    core->last_resort = spare < 1 || rest / spare > worthwhile * length;
    core->attempts++;
    core->counts.most_attempts =
        core->attempts > core->counts.most_attempts ? core->attempts : core->counts.most_attempts;
    return parts > 1.0 ? core->t + length : grid;
}

/* Sums of squares of v over the tolerance at the larger size of a and b, in separate lanes, so that
 * compilers vectorise the loop. */
static inline void add_squares(double rtol, double atol, double part, const double *restrict v,
                               const double *restrict a, const double *restrict b,
                               const double *restrict scale, double *restrict sum) {
    for (int l = 0; l < BGC_LANES; l++) {
        const double one = fabs(a[l]), other = fabs(b[l]);
        const double size = one > other ? one : other;
        const double r = v[l] / (atol + part * scale[l] + rtol * size + DBL_MIN); /* 0 in padding */
        sum[l] += r * r;
    }
}

/* The embedded error of the step to d->next over the tolerances, root mean square. */
static double embedded_error(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const bgc_core *core = &d->core;
    const double part = core->sub_atol > 0.0 ? 0.0 : core->sub_rtol;
    double sum[BGC_LANES] = {0.0}, all = 0.0;

    memset(d->error, 0, (size_t)m->n_state * sizeof *d->error);
    bgc_combine(m->n_state, tableau->stages, tableau->embedded, d->stages, d->error);
    for (size_t i = 0; i < bgc_padded(m->n_state); i += BGC_LANES) {
        add_squares(core->sub_rtol, core->sub_atol, part, d->error + i, d->x + i, d->next + i,
                    d->scale + i, sum);
    }
    for (int l = 0; l < BGC_LANES; l++) {
        all += sum[l];
    }
    return m->n_state > 0 ? sqrt(all / m->n_state) : 0.0;
}

/* Rejects an attempt: the next one has the length h. */
static int try_shorter(bgc_core *core, double h) {
    core->counts.subdivided += core->attempts == 1;
    core->counts.rejected++;
    core->sub_step = h;
    return 0;
}

/* Whether to accept an attempt of length h, which ended with `status`. A status other than BGC_OK, and
 * equations that are too coarse, are left to the caller where the budget is spent. */
int bgc_accept_substep(const bgc_model *m, bgc_data *d, const bgc_method *method, bgc_status status,
                       double h) {
    bgc_core *core = &d->core;
    const double q = method->embedded_order + 1;
    double error;

    if (status != BGC_OK || core->too_coarse) {
        return core->last_resort || try_shorter(core, 0.25 * h);
    }
    error = embedded_error(m, d, method);
    if (error <= 1.0) {
        core->sub_step = bgc_next_step(h, core->sub_step, fmax(error, bgc_least_error), 1.0, q, 1);
        return 1;
    }
    if (!core->last_resort) {
        return try_shorter(core, isfinite(error) ? bgc_shorter_step(h, error, q) : 0.25 * h);
    }

    /* The budget is spent. */
    core->counts.over_budget += !core->exceeded;
    core->exceeded = 1;
    if (isfinite(error) && error > core->counts.largest_excess) {
        core->counts.largest_excess = error;
        core->counts.excess_time = core->t;
    }
    return 1;
}
