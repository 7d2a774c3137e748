/* dense.c: dense output: the solution inside the last step.
 *
 * It has the form of bgc_internal.h, with coefficients of the method itself, or those of the cubic
 * Hermite polynomial through the states and slopes at both ends.
 */
#include "bgc_internal.h"
#include "interpolation.h"

#include <string.h>

/* Stores the dense output of a step to d->next at `end`, before that becomes the present. Hermite
 * polynomials need f at the end, which is evaluated when they are used. */
void bgc_store_dense(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double end) {
    d->core.t_old = d->core.t;
    d->core.t_end = end;
    memcpy(d->u_step, d->u, (size_t)(m->n_input + m->n_switch) * sizeof(number));
    bgc_keep_ends(m, d);
    if (!d->core.left && bgc_interpolate_by(m, d, method)) {
        d->core.dense = BGC_DENSE_READY;
    } else {
        d->core.dense = BGC_SLOPES_PENDING;
    }
}

/* --- loops of fixed length, which compilers vectorise at every level of optimisation -------- */

/* Cubic Hermite polynomials with the slopes k1 at the start and f_end at the end, or chords. */
static inline void make_cubics(double h, const number *restrict y0, const number *restrict y1,
                               const number *restrict inverse_mass, const number *restrict f_end,
                               number *restrict k1, number *restrict k2) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        const number scale = h * inverse_mass[l];
        bgc_hermite(y1[l] - y0[l], scale * k1[l], scale * f_end[l], scale != number_of(0.0),
                    k1 + l, k2 + l);
    }
}

/* x = y(s). */
static inline void evaluate_cubics(double s, const number *restrict y0, const number *restrict y1,
                                   const number *restrict k1, const number *restrict k2,
                                   const number *restrict k3, number *restrict x) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        x[l] = bgc_interpolated(s, y0[l], y1[l], k1[l], k2[l], k3[l]);
    }
}

/* --- the solution --------------------------------------------------------------------------- */

/* f at the end of the last step. Before that is the present, d->f is f at its start, and f at the end
 * goes to d->error. */
static const number *slope_at_end(const bgc_model *m, bgc_ivp *d) {
    bgc_core *core = &d->core;
    const size_t size = (size_t)m->n_state * sizeof *d->x;

    if (core->t == core->t_old) {
        if (!core->f_at_end) {
            bgc_functions(m, d)->rhs(d->h, number_of(core->t_end), d->y1, d->u_step, d->error,
                                     d->work);
            core->counts.rhs++;
            core->f_at_end = 1;
        }
        return d->error;
    }
    bgc_functions(m, d)->rhs(d->h, number_of(core->t_end), d->y1, d->u_step, d->f, d->work);
    core->counts.rhs++;
    core->f_valid = memcmp(d->x, d->y1, size) == 0 &&
                    memcmp(d->u, d->u_step, (size_t)m->n_input * sizeof *d->u) == 0;
    return d->f;
}

/* Makes Hermite polynomials from the slopes at the start, in d->k, and those at the end. */
static void complete_slopes(const bgc_model *m, bgc_ivp *d) {
    const size_t width = bgc_chunked(m->n_state);
    const double h = d->core.t_end - d->core.t_old;
    const number *f_end;
    number *k1 = d->k, *k2 = k1 + width, *k3 = k2 + width;

    bgc_load_slopes(m, d);
    f_end = slope_at_end(m, d);
    for (size_t i = 0; i < width; i += BGC_CHUNK) {
        make_cubics(h, d->y0 + i, d->y1 + i, d->inverse_mass + i, f_end + i, k1 + i, k2 + i);
    }
    memset(k3, 0, width * sizeof *k3);
    d->core.dense = BGC_DENSE_READY;
}

/* The part of the last step at time t inside it, with the coefficients of its dense output at hand. */
static double part_at(const bgc_model *m, bgc_ivp *d, double t) {
    if (d->core.dense == BGC_SLOPES_PENDING) {
        complete_slopes(m, d);
    }
    return (t - d->core.t_old) / (d->core.t_end - d->core.t_old);
}

/* The dense output alone at time t inside the last step. */
static void evaluate_polynomial(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    const size_t width = bgc_chunked(m->n_state);
    const number *k1 = d->k, *k2 = k1 + width, *k3 = k2 + width;
    const double s = part_at(m, d, t);

    for (size_t i = 0; i < width; i += BGC_CHUNK) {
        evaluate_cubics(s, d->y0 + i, d->y1 + i, k1 + i, k2 + i, k3 + i, x + i);
    }
}

/* x at time t inside the last step. States without a rate follow from the algebraic equations, in the
 * modes and inputs of that step; where no solution is found, they are interpolated. */
void bgc_interpolate(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    number *present = d->u;

    evaluate_polynomial(m, d, t, x);
    d->u = d->u_step;
    if (d->core.algebraic > 0) {
        bgc_satisfy_rows(m, d, t, x);
    }
    if (m->project != NULL) {
        bgc_functions(m, d)->project(d->h, number_of(t), x, d->work);
    }
    if (m->closure_info != NULL) {
        bgc_close_inside(m, d, t, x);
    }
    d->u = present;
}

/* The same with the states without a rate interpolated: a step that jumps to other roots of the
 * algebraic equations has a large defect there. */
void bgc_interpolate_all(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    evaluate_polynomial(m, d, t, x);
    if (m->project != NULL) {
        bgc_functions(m, d)->project(d->h, number_of(t), x, d->work);
    }
}

/* The same for some states, neither projected nor algebraic; the others in x stay as they are. */
void bgc_interpolate_some(const bgc_model *m, bgc_ivp *d, double t, int count, const int *state,
                          number *x) {
    const size_t width = bgc_chunked(m->n_state);
    const number *k1 = d->k, *k2 = k1 + width, *k3 = k2 + width;
    const double s = part_at(m, d, t);

    for (int j = 0; j < count; j++) {
        const int i = state[j];
        x[i] = bgc_interpolated(s, d->y0[i], d->y1[i], k1[i], k2[i], k3[i]);
    }
}

/* The rate of the dense output in the middle of the last step. */
void bgc_dense_slope(const bgc_model *m, const bgc_ivp *d, number *slope) {
    const double h = d->core.t_end - d->core.t_old;
    const number *k2 = d->k + bgc_chunked(m->n_state), *k3 = k2 + bgc_chunked(m->n_state);

    for (int i = 0; i < m->n_state; i++) {
        slope[i] = bgc_middle_slope(d->y0[i], d->y1[i], k2[i], k3[i]) / h;
    }
}
