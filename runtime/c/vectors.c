/* vectors.c: sums, norms and products with M of vectors of states. */
#include "bgc_internal.h"
#include "tolerance.h"

#include <string.h>

/* Loops of fixed length, which compilers vectorise at every level of optimisation: out = base + sum
 * of w_j v_j, and the same in place. */
static inline void add_one(number *restrict out, const number *restrict base, double w,
                           const number *restrict v) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] = base[l] + w * v[l];
    }
}

static inline void add_two(number *restrict out, const number *restrict base, const double *w,
                           const number *restrict v0, const number *restrict v1) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] = (base[l] + w[0] * v0[l]) + w[1] * v1[l];
    }
}

static inline void add_three(number *restrict out, const number *restrict base, const double *w,
                             const number *restrict v0, const number *restrict v1,
                             const number *restrict v2) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] = ((base[l] + w[0] * v0[l]) + w[1] * v1[l]) + w[2] * v2[l];
    }
}

static inline void add_one_more(number *restrict out, double w, const number *restrict v) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] += w * v[l];
    }
}

static inline void add_four(number *restrict out, const number *restrict base, const double *w,
                            const number *restrict v0, const number *restrict v1,
                            const number *restrict v2, const number *restrict v3) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] = base[l] + ((w[0] * v0[l] + w[1] * v1[l]) + (w[2] * v2[l] + w[3] * v3[l]));
    }
}

static inline void add_four_more(number *restrict out, const double *w, const number *restrict v0,
                                 const number *restrict v1, const number *restrict v2,
                                 const number *restrict v3) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        out[l] += (w[0] * v0[l] + w[1] * v1[l]) + (w[2] * v2[l] + w[3] * v3[l]);
    }
}

/* out = base + sum of weight[j] times vector j; the vectors are bgc_chunked(n) apart. `base` may be
 * out itself, or NULL for zeros. Zero weights are skipped. Up to four vectors are added at a time,
 * so that out is loaded and stored once for them. */
void bgc_combine(int n, int count, const double *weight, const number *vectors, const number *base,
                 number *out) {
    const size_t length = bgc_chunked(n);
    const number *v[BGC_MAX_STAGES], *from = base;
    double w[BGC_MAX_STAGES];
    number zeros[BGC_CHUNK];
    size_t stride = BGC_CHUNK;
    int filled = 0, done = 0;

    for (int j = 0; j < count; j++) {
        if (weight[j] != 0.0) {
            w[filled] = weight[j];
            v[filled++] = vectors + (size_t)j * length;
        }
    }
    if (BGC_CHUNK == 1) { /* in lanes: the sum of a state stays in a register */
        for (size_t i = 0; i < length; i++) {
            number sum = base != NULL ? base[i] : number_of(0.0);
            for (int j = 0; j < filled; j++) {
                sum += w[j] * v[j][i];
            }
            out[i] = sum;
        }
        return;
    }
    if (base == NULL) {
        memset(zeros, 0, sizeof zeros);
        from = zeros;
        stride = 0;
    }

    /* The first vectors onto the base, the others onto the sum. */
    if (base != out && filled >= 4) {
        for (size_t i = 0, k = 0; i < length; i += BGC_CHUNK, k += stride) {
            add_four(out + i, from + k, w, v[0] + i, v[1] + i, v[2] + i, v[3] + i);
        }
        done = 4;
    } else if (base != out && filled == 3) {
        for (size_t i = 0, k = 0; i < length; i += BGC_CHUNK, k += stride) {
            add_three(out + i, from + k, w, v[0] + i, v[1] + i, v[2] + i);
        }
        done = 3;
    } else if (base != out && filled == 2) {
        for (size_t i = 0, k = 0; i < length; i += BGC_CHUNK, k += stride) {
            add_two(out + i, from + k, w, v[0] + i, v[1] + i);
        }
        done = 2;
    } else if (base != out && filled == 1) {
        for (size_t i = 0, k = 0; i < length; i += BGC_CHUNK, k += stride) {
            add_one(out + i, from + k, w[0], v[0] + i);
        }
        done = 1;
    } else if (base != out) {
        for (size_t i = 0, k = 0; i < length; i += BGC_CHUNK, k += stride) {
            memcpy(out + i, from + k, sizeof zeros);
        }
    }
    for (; filled - done >= 4; done += 4) {
        const number *const *u = v + done;
        for (size_t i = 0; i < length; i += BGC_CHUNK) {
            add_four_more(out + i, w + done, u[0] + i, u[1] + i, u[2] + i, u[3] + i);
        }
    }
    for (; done < filled; done++) {
        for (size_t i = 0; i < length; i += BGC_CHUNK) {
            add_one_more(out + i, w[done], v[done] + i);
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
