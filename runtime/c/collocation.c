/* collocation.c: one step of an implicit Runge-Kutta method by simplified Newton iteration.
 *
 * With Z_i the stages less y and (left, right, lambda) the eigenvectors and eigenvalues of A^-1,
 *     M Z = h (A x I) F(y + Z)   becomes   (lambda / h M - J) dw = left F - lambda / h M w
 * for each w = left Z: one real system, and one complex system for a pair of eigenvalues.
 * E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_NEWTON = 12, MAX_NEWTON_FIXED = 50 };
static const double to_rounding = 1e-14; /* without a tolerance: relative to the state's scale */
static const double good_enough = 1e-10; /* a correction that rounding keeps from shrinking */
static const double kappa = 0.03;        /* of an adaptive step: a part of its tolerance */

/* Factorises for the real and the complex eigenvalue. */
static bgc_status factorise_stages(const bgc_model *m, bgc_data *d, const bgc_collocation *method,
                            double h) {
    bgc_status status = BGC_OK;

    bgc_evaluate_jacobian(m, d);
    if (method->stages % 2 == 1) {
        status = bgc_factorise(m, d, method->lambda / h);
    }
    if (status == BGC_OK && method->stages > 1) {
        const bgc_complex c = {method->lambda2[0] / h, method->lambda2[1] / h};
        d->core.counts.factorisations++;
        if (bgc_complex_factor(m, d->mass, d->jac, c, d->complex_lu, d->complex_work)) {
            d->core.failed_state = -1;
            status = BGC_SINGULAR;
        }
    }
    return status;
}

/* out = sum of weight[i] times vector i. */
static void weigh(int n, int count, const double *weight, const double *vectors, double *out) {
    memset(out, 0, (size_t)n * sizeof *out);
    bgc_combine(n, count, weight, vectors, out);
}

/* out = left F - lambda M (left Z), for one row of left and a real lambda. */
static void stage_residual(const bgc_model *m, bgc_data *d, const double *left, int stages,
                     double lambda, const double *z, const double *f, double *out) {
    const int n = m->n_state;

    weigh(n, stages, left, f, out);
    weigh(n, stages, left, z, d->point);
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, d->point, d->magnitude);
    }
    for (int i = 0; i < n; i++) {
        out[i] -= lambda * (m->n_mass > 0 ? d->magnitude[i] : d->point[i]);
    }
}

/* z += the correction of the real part of the system; `change` gathers the corrections. */
static bgc_status correct_real(const bgc_model *m, bgc_data *d, const bgc_collocation *method,
                               double h, const double *z, const double *f, double *change) {
    const int n = m->n_state;
    bgc_status status;

    stage_residual(m, d, method->left, method->stages, method->lambda / h, z, f, d->right);
    status = bgc_solve(m, d, d->right);
    for (int s = 0; s < method->stages; s++) {
        double *at = change + (size_t)s * bgc_padded(n);
        for (int i = 0; i < n; i++) {
            at[i] += method->right[s] * d->right[i];
        }
    }
    return status;
}

/* The same for the pair of complex eigenvalues, which give twice the real part. */
static void correct_complex(const bgc_model *m, bgc_data *d, const bgc_collocation *method,
                            double h, const double *z, const double *f, double *change) {
    const int n = m->n_state, stages = method->stages;
    const double re = method->lambda2[0] / h, im = method->lambda2[1] / h;
    bgc_complex *b = d->complex_right;

    /* left F - (re + i im) M (u + i v), with u + i v = left Z. */
    stage_residual(m, d, method->left2[0], stages, re, z, f, d->right);
    stage_residual(m, d, method->left2[1], stages, re, z, f, d->error);
    for (int i = 0; i < n; i++) {
        b[i] = (bgc_complex){d->right[i], d->error[i]};
    }
    for (int part = 0; part < 2; part++) {
        weigh(n, stages, method->left2[1 - part], z, d->point);
        if (m->n_mass > 0) {
            bgc_multiply_mass(m, d, d->point, d->magnitude);
        }
        for (int i = 0; i < n; i++) {
            const double term = im * (m->n_mass > 0 ? d->magnitude[i] : d->point[i]);
            if (part == 0) {
                b[i].re += term;
            } else {
                b[i].im -= term;
            }
        }
    }
    d->core.counts.solves++;
    bgc_complex_solve(m, d->complex_lu, b, d->complex_work);
    for (int s = 0; s < stages; s++) {
        double *at = change + (size_t)s * bgc_padded(n);
        for (int i = 0; i < n; i++) {
            at[i] += 2.0 * (method->right2[0][s] * b[i].re - method->right2[1][s] * b[i].im);
        }
    }
}

/* Stages to begin with: the last step's polynomial continued, or no change where there is none, or
 * an event has ended it. */
static void predict_stages(const bgc_model *m, const bgc_data *d, const bgc_collocation *method,
                           double h, double *z) {
    const int n = m->n_state;
    const size_t width = bgc_padded(n);
    const double *k1 = d->k, *k2 = k1 + width;
    const double before = d->core.t - d->core.t_old;

    memset(z, 0, (size_t)method->stages * width * sizeof *z);
    if (d->core.dense != BGC_DENSE_READY || !(before > 0.0) || method->embedded == 0 ||
        d->core.t != d->core.t_end) {
        return;
    }
    for (int s = 0; s < method->stages; s++) {
        const double at = 1.0 + method->node[s] * h / before, rest = 1.0 - at;
        for (int i = 0; i < n; i++) {
            const double y =
                rest * d->y0[i] + at * (d->y1[i] + rest * (k1[i] + at * k2[i]));
            z[(size_t)s * width + (size_t)i] = y - d->y1[i];
        }
    }
}

/* f at every stage; BGC_NOT_FINITE where there is none. */
static bgc_status evaluate_stages(const bgc_model *m, bgc_data *d, const bgc_collocation *method,
                                  double h, const double *z, double *f) {
    const int n = m->n_state;

    for (int s = 0; s < method->stages; s++) {
        double *at = f + (size_t)s * bgc_padded(n);
        for (int i = 0; i < n; i++) {
            d->point[i] = d->x[i] + z[(size_t)s * bgc_padded(n) + (size_t)i];
        }
        m->rhs(d->h, d->core.t + method->node[s] * h, d->point, d->u, at, d->work);
        d->core.counts.rhs++;
        d->core.failed_state = bgc_first_bad(n, at);
        if (d->core.failed_state >= 0) {
            return BGC_NOT_FINITE;
        }
    }
    return BGC_OK;
}

/* The largest norm of the stages' corrections, in units of the tolerance. */
static double largest_norm(const bgc_model *m, const bgc_data *d, int stages,
                           const double *change) {
    double largest = 0.0;

    for (int s = 0; s < stages; s++) {
        const double norm = bgc_norm(m, d, change + (size_t)s * bgc_padded(m->n_state), d->x, d->x);
        largest = norm <= largest ? largest : norm; /* a NaN stays */
    }
    return largest;
}

/* Solves for the stages in d->stages: to a part of the tolerance, or to rounding where there is
 * none, as in fixed steps. */
static bgc_status solve_stages(const bgc_model *m, bgc_data *d, const bgc_collocation *method,
                               double h) {
    const size_t width = bgc_padded(m->n_state), all = (size_t)method->stages * width;
    double *z = d->stages, *f = d->implicit, *change = f + BGC_MAX_IMPLICIT * width;
    const int fixed = method->embedded == 0 || d->core.rtol >= 1.0;
    const int most = fixed ? MAX_NEWTON_FIXED : MAX_NEWTON;
    const double rtol = d->core.rtol;
    const double target =
        fixed ? to_rounding / rtol : fmax(10.0 * DBL_EPSILON / rtol, fmin(kappa, sqrt(rtol)));
    double before = 0.0;

    for (int k = 0; k < most; k++) {
        double norm, rate;
        bgc_status status = evaluate_stages(m, d, method, h, z, f);
        if (status != BGC_OK) {
            return status;
        }
        memset(change, 0, all * sizeof *change);
        if (method->stages % 2 == 1) {
            status = correct_real(m, d, method, h, z, f, change);
            if (status != BGC_OK) {
                return status;
            }
        }
        if (method->stages > 1) {
            correct_complex(m, d, method, h, z, f, change);
        }
        for (size_t i = 0; i < all; i++) {
            z[i] += change[i];
        }
        norm = largest_norm(m, d, method->stages, change);
        if (!isfinite(norm)) {
            return BGC_NOT_CONVERGED;
        }
        rate = k > 0 ? norm / before : 0.0;
        if (norm <= target || (k > 0 && rate < 1.0 && rate / (1.0 - rate) * norm <= target)) {
            return BGC_OK;
        }
        if (k > 0 && rate > 0.5 && norm * rtol <= good_enough) {
            return BGC_OK; /* what is left is rounding */
        }
        if (k > 1 && rate > 2.0) {
            return BGC_NOT_CONVERGED;
        }
        before = norm;
    }
    return BGC_NOT_CONVERGED;
}

/* d->error := (lambda / h M - J)^-1 (f(t, at) + M sum e_i Z_i / h). */
static bgc_status estimate_error(const bgc_model *m, bgc_data *d, const bgc_collocation *method,
                           double h, const double *f) {
    const int n = m->n_state;
    double weight[BGC_MAX_IMPLICIT];

    for (int s = 0; s < method->stages; s++) {
        weight[s] = method->e[s] / h;
    }
    weigh(n, method->stages, weight, d->stages, d->point);
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, d->point, d->magnitude);
    }
    for (int i = 0; i < n; i++) {
        d->error[i] = f[i] + (m->n_mass > 0 ? d->magnitude[i] : d->point[i]);
    }
    return bgc_solve(m, d, d->error);
}

/* From x at t to d->next, with f(t, x) in d->f; the error estimate of an embedded method goes to
 * d->error. BGC_NOT_CONVERGED where the iteration finds no solution. */
bgc_status bgc_collocate(const bgc_model *m, bgc_data *d, const bgc_collocation *method, double h) {
    const int n = m->n_state;
    bgc_status status = d->core.held == 0 ? factorise_stages(m, d, method, h) : BGC_OK;

    if (status == BGC_OK) {
        predict_stages(m, d, method, h, d->stages);
        status = solve_stages(m, d, method, h);
    }
    if (status == BGC_NOT_CONVERGED && d->core.held > 0) { /* with a Jacobian of this step */
        status = factorise_stages(m, d, method, h);
        if (status == BGC_OK) {
            predict_stages(m, d, method, h, d->stages);
            status = solve_stages(m, d, method, h);
        }
    }
    if (status == BGC_OK && method->embedded > 0) {
        status = estimate_error(m, d, method, h, d->f);
    }
    if (status == BGC_OK && method->embedded > 0 &&
        bgc_norm(m, d, d->error, d->x, d->x) > 1.0) {
        /* Once more where it is large: stiff parts drop out of it. */
        for (int i = 0; i < n; i++) {
            d->point[i] = d->x[i] + d->error[i];
        }
        m->rhs(d->h, d->core.t, d->point, d->u, d->implicit, d->work);
        d->core.counts.rhs++;
        if (bgc_first_bad(n, d->implicit) < 0) {
            status = estimate_error(m, d, method, h, d->implicit);
        }
    }
    memcpy(d->next, d->x, (size_t)n * sizeof *d->next);
    bgc_combine(n, method->stages, method->last, d->stages, d->next);
    return status;
}
