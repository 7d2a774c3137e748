/* checks.c: checks of one instance: finite numbers, states that explicit methods can integrate, and
 * fixed steps that were far too long. */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

/* Index of the first entry that is not finite, or -1. x - x is 0 for finite x and a NaN otherwise,
 * so that finite vectors take one pass without branches. */
int bgc_first_bad(int n, const double *v) {
    double sum[BGC_LANES] = {0.0}, all = 0.0;
    int i = 0;

    for (; i + BGC_LANES <= n; i += BGC_LANES) {
        for (int l = 0; l < BGC_LANES; l++) {
            sum[l] += v[i + l] - v[i + l];
        }
    }
    for (; i < n; i++) {
        all += v[i] - v[i];
    }
    for (int l = 0; l < BGC_LANES; l++) {
        all += sum[l];
    }
    if (all == 0.0) {
        return -1;
    }
    for (i = 0; i < n; i++) {
        if (!isfinite(v[i])) {
            return i;
        }
    }
    return -1;
}

/* The first state whose rate is coupled to others by M, so that explicit methods do not serve; or
 * -1. */
int bgc_coupled_rate(const bgc_model *m, const bgc_data *d) {
    for (int i = 0; i < m->n_state; i++) {
        if (d->inverse_mass[i] == 0.0 && d->algebraic[i] == 0.0) {
            return i;
        }
    }
    return -1;
}

/* At the start of a run: no corrections yet (corrections.c). */
void bgc_reset_corrections(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;

    memset(d->correction, 0, size);
    memset(d->corrected_at, 0, size);
    memset(d->range, 0, size);
}

/* Reports in the counts the largest correction that shows too long a step. States without a rate
 * may jump, and do not count. */
void bgc_report_correction(const bgc_model *m, bgc_data *d) {
    bgc_counts *counts = &d->core.counts;

    counts->largest_correction = 0.0;
    for (int i = 0; i < m->n_state; i++) {
        const double part = d->correction[i] / fmax(d->scale[i], d->range[i]);
        if (d->algebraic[i] == 0.0 &&
            part > fmax(bgc_unresolved_part, counts->largest_correction)) {
            counts->largest_correction = part;
            counts->correction_time = d->corrected_at[i];
            counts->correction_state = i;
        }
    }
}
