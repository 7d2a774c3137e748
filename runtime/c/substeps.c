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

#include <math.h>

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
    double spare, h, parts, length;

    if (core->attempts++ == 0 && !core->step_cut) {
        core->last_resort = 0;
        return grid;
    }
    spare = core->substeps + 1 - core->attempts; /* attempts that remain after this one */
    h = fmax(core->sub_step, rest / fmax(spare + 1.0, 1.0));
    parts = fmax(ceil(rest / h - stretch), 1.0);
    length = rest / parts;
    core->last_resort = spare < 1.0 || rest / spare > worthwhile * length;
    if (core->attempts > core->counts.most_attempts) {
        core->counts.most_attempts = core->attempts;
    }
    return parts > 1.0 ? core->t + length : grid;
}

/* --- the embedded error ------------------------------------------------------------------------ */

enum { MOST_STAGES = 4 }; /* of methods whose steps are divided */

/* By how much any error, sum w_j u_j, is above its tolerance: a loop of fixed length, which compilers
 * vectorise. */
static inline void find_excess(const double *restrict w, const double *restrict u0,
                               const double *restrict u1, const double *restrict u2,
                               const double *restrict u3, const double *restrict a,
                               const double *restrict b, const double *restrict scale, double rtol,
                               double atol, double part, double *restrict most) {
    for (int l = 0; l < BGC_LANES; l++) {
        const double error = (w[0] * u0[l] + w[1] * u1[l]) + (w[2] * u2[l] + w[3] * u3[l]);
        const double one = fabs(a[l]), other = fabs(b[l]), before = most[l];
        const double size = one > other ? one : other;
        const double excess = fabs(error) - (atol + part * scale[l] + rtol * size);
        most[l] = excess > before ? excess : before;
    }
}

/* Whether the embedded error of every state is within its tolerance. Takes a third of the time of
 * bgc_embedded_error, which most steps do without. */
static int is_within_everywhere(const bgc_model *m, const bgc_data *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const bgc_core *core = &d->core;
    const double part = core->sub_atol > 0.0 ? 0.0 : core->sub_rtol;
    const double *u[MOST_STAGES];
    double most[BGC_LANES] = {0.0}, all = 0.0;

    for (int s = 0; s < MOST_STAGES; s++) {
        u[s] = d->stages + (s < tableau->stages ? (size_t)s * bgc_padded(m->n_state) : 0);
    }
    for (size_t i = 0; i < bgc_padded(m->n_state); i += BGC_LANES) {
        find_excess(tableau->embedded, u[0] + i, u[1] + i, u[2] + i, u[3] + i, d->x + i,
                    d->next + i, d->scale + i, core->sub_rtol, core->sub_atol, part, most);
    }
    for (int l = 0; l < BGC_LANES; l++) {
        all += most[l];
    }
    return all == 0.0;
}

/* --- acceptance -------------------------------------------------------------------------------- */

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
    if (core->attempts == 1 && !core->step_cut && is_within_everywhere(m, d, method)) {
        return 1;
    }
    error = bgc_embedded_error(m, d, method);
    if (error <= 1.0) {
        core->sub_step = bgc_next_step(h, core->sub_step, fmax(error, bgc_least_error), 1.0, q, 1);
        return 1;
    }
    if (!core->last_resort) {
        if (core->held < core->keep) { /* with kept factors: try the same length with new ones */
            return try_shorter(core, h);
        }
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
