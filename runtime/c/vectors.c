/* vectors.c: sums, norms and checks of vectors of states. */
#include "bgc_internal.h"
#include "tolerance.h"

#include <math.h>

/* Loops of fixed length, which compilers vectorise at every level of optimisation. */
static inline void add_one(double *restrict out, double w, const double *restrict v) {
    for (int l = 0; l < BGC_LANES; l++) {
        out[l] += w * v[l];
    }
}

static inline void add_four(double *restrict out, double w0, double w1, double w2, double w3,
                            const double *restrict v0, const double *restrict v1,
                            const double *restrict v2, const double *restrict v3) {
    for (int l = 0; l < BGC_LANES; l++) {
        out[l] += (w0 * v0[l] + w1 * v1[l]) + (w2 * v2[l] + w3 * v3[l]);
    }
}

/* out += sum of weight[j] times vector j; the vectors are bgc_padded(n) apart. Four are added at a
 * time, so that out is loaded and stored once for them. Zero weights are skipped. */
void bgc_combine(int n, int count, const double *weight, const double *vectors, double *out) {
    const size_t length = bgc_padded(n);
    const double *v[4] = {NULL, NULL, NULL, NULL};
    double w[4] = {0.0, 0.0, 0.0, 0.0};
    int filled = 0;

    for (int j = 0; j < count; j++) {
        if (weight[j] == 0.0) {
            continue;
        }
        w[filled] = weight[j];
        v[filled++] = vectors + (size_t)j * length;
        if (filled == 4) {
            for (size_t i = 0; i < length; i += BGC_LANES) {
                add_four(out + i, w[0], w[1], w[2], w[3], v[0] + i, v[1] + i, v[2] + i, v[3] + i);
            }
            filled = 0;
        }
    }
    for (int j = 0; j < filled; j++) {
        for (size_t i = 0; i < length; i += BGC_LANES) {
            add_one(out + i, w[j], v[j] + i);
        }
    }
}

/* Root mean square of v over the tolerances of a step, at states of the larger size of a and b. */
double bgc_norm(const bgc_model *m, const bgc_data *d, const double *v, const double *a,
                const double *b) {
    const double reached = d->core.counts.scale_reached, rtol = d->core.rtol, atol = d->core.atol;
    double sum = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        const double size = number_larger(fabs(b[i]), fabs(a[i]));
        const double r = v[i] / bgc_step_tolerance(size, d->scale[i], reached, rtol, atol);
        sum += r * r;
    }
    return m->n_state > 0 ? sqrt(sum / m->n_state) : 0.0;
}

/* Index of the first entry that is not finite, or -1. x - x is 0 for finite x and a NaN otherwise, so
 * that finite vectors take one pass without branches. */
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
