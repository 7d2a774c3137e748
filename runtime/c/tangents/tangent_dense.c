/* tangent_dense.c: derivatives of the dense output of the last step. */
#include "tangents/sensitivities.h"
#include "interpolation.h"

#include <string.h>

/* The derivatives of the cubic Hermite polynomials of dense.c, whose own coefficients are in d->k. */
static void complete_dense(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                           bgc_sensitivity_block *b) {
    const int n = m->n_state;
    const double h = d->core.t_end - d->core.t_old;
    const double *own = d->k, *own2 = d->k + bgc_chunked(n);
    lane *k1 = b->k, *k2 = k1 + n;

    for (int end = 0; end < 2; end++) {
        const bgc_moment at = {end ? d->core.t_end : d->core.t_old, end ? d->y1 : d->y0, d->u_step};
        bgc_slope_sensitivity(m, s, b, &at, end ? b->end : b->start, lane_of(0.0));
        for (int j = 0; j < m->n_mass; j++) { /* (M^-1 f)' = M^-1 (f' - M' M^-1 f) */
            const int i = m->mass_row[j];
            if (i == m->mass_col[j] && d->inverse_mass[i] != 0.0) {
                const double rise = d->y1[i] - d->y0[i];
                const double slope = end ? rise - own2[i] - own[i] : rise + own[i];
                s->right[i] -= b->mass[j] * (slope / h);
            }
        }
        for (int i = 0; i < n; i++) {
            const lane off = h * d->inverse_mass[i] * s->right[i] - (b->end[i] - b->start[i]);
            const int smooth = own[i] != 0.0 || own2[i] != 0.0;
            if (end) {
                k2[i] = smooth ? -(k1[i] + off) : lane_of(0.0);
            } else {
                k1[i] = smooth ? off : lane_of(0.0);
            }
        }
    }
    memset(k2 + n, 0, (size_t)n * sizeof *k2);
    b->has_dense = 1;
}

bgc_status bgc_interpolate_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                       bgc_sensitivity_block *b, double t, const double *x, lane *out) {
    const int n = m->n_state;
    const double part = (t - d->core.t_old) / (d->core.t_end - d->core.t_old), r = 1.0 - part;
    const size_t width = bgc_chunked(n);
    const double *own = d->k;
    const lane *k1 = b->k, *k2 = k1 + n, *k3 = k2 + n;
    const bgc_moment at = {t, x, d->u_step};
    bgc_status status = BGC_OK;

    if (!b->has_dense) {
        complete_dense(m, d, s, b);
    }
    for (int i = 0; i < n; i++) {
        out[i] = r * b->start[i] + part * (b->end[i] + r * (k1[i] + part * (k2[i] + part * k3[i])));
    }
    if (m->project != NULL || m->closure_info != NULL) {
        for (int i = 0; i < n; i++) {
            s->rate[i] = bgc_interpolated(part, d->y0[i], d->y1[i], own[i], own[width + (size_t)i],
                                          own[2 * width + (size_t)i]);
        }
        bgc_project_sensitivity(m, s, b, t, s->rate, out);
        status = bgc_close_sensitivity(m, d, s, b, &at, s->rate, lane_of(0.0), out);
    }
    return status != BGC_OK ? status : bgc_satisfy_sensitivity(m, d, s, b, &at, NULL, lane_of(0.0), out);
}
