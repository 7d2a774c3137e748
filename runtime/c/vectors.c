/* vectors.c: sums, norms and products with M of vectors of states. */
#include "bgc_internal.h"
#include "tolerance.h"

#include <string.h>

/* Loops of fixed length, which compilers vectorise at every level of optimisation. */
static inline void add_one(number *restrict out, double w, const number *restrict v) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] += w * v[l];
    }
}

static inline void add_four(number *restrict out, double w0, double w1, double w2, double w3,
                            const number *restrict v0, const number *restrict v1,
                            const number *restrict v2, const number *restrict v3) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] += (w0 * v0[l] + w1 * v1[l]) + (w2 * v2[l] + w3 * v3[l]);
    }
}

/* out += sum of weight[j] times vector j; the vectors are bgc_chunked(n) apart. Four are added at a
 * time, so that out is loaded and stored once for them. Zero weights are skipped. */
void bgc_combine(int n, int count, const double *weight, const number *vectors, number *out) {
    const size_t length = bgc_chunked(n);
    const number *v[4] = {NULL, NULL, NULL, NULL};
    double w[4] = {0.0, 0.0, 0.0, 0.0};
    int filled = 0;

    for (int j = 0; j < count; j++) {
        if (weight[j] == 0.0) {
            continue;
        }
        w[filled] = weight[j];
        v[filled++] = vectors + (size_t)j * length;
        if (filled == 4) {
            for (size_t i = 0; i < length; i += BGC_CHUNK) {
                add_four(out + i, w[0], w[1], w[2], w[3], v[0] + i, v[1] + i, v[2] + i, v[3] + i);
            }
            filled = 0;
        }
    }
    for (int j = 0; j < filled; j++) {
        for (size_t i = 0; i < length; i += BGC_CHUNK) {
            add_one(out + i, w[j], v[j] + i);
        }
    }
}

/* Root mean square of v over tolerances at states of the larger size of a and b. */
number bgc_norm_within(const bgc_model *m, const bgc_ivp *d, const number *v, const number *a,
                       const number *b, double rtol, double atol, number reached) {
    number sum = number_of(0.0);

    for (int i = 0; i < m->n_state; i++) {
        const number size = number_larger(number_fabs(b[i]), number_fabs(a[i]));
        const number r = v[i] / bgc_step_tolerance(size, d->scale[i], reached, rtol, atol);
        sum += r * r;
    }
    return m->n_state > 0 ? number_sqrt(sum / (double)m->n_state) : sum;
}

/* The same over the tolerances of steps with error control. */
number bgc_norm(const bgc_model *m, const bgc_ivp *d, const number *v, const number *a,
                const number *b) {
    return bgc_norm_within(m, d, v, a, b, d->core.rtol, d->core.atol, bgc_reached(d));
}

/* out = M v. */
void bgc_multiply_mass(const bgc_model *m, const bgc_ivp *d, const number *v, number *out) {
    memset(out, 0, (size_t)m->n_state * sizeof *out);
    for (int k = 0; k < m->n_mass; k++) {
        out[m->mass_row[k]] += d->mass[k] * v[m->mass_col[k]];
    }
}
