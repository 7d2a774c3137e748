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
static const double fixed_target = 1e-14;   /* of a fixed step: relative to the state's scale */
static const double adaptive_target = 0.03; /* of an adaptive step: a part of its tolerance */
static const double stagnation = 1e-10;     /* relative: rounding, if corrections stop shrinking */

/* --- linear systems -------------------------------------------------------------------------- */

/* Factorises lambda / h M - J for the real eigenvalue and for one of the complex pair. */
static bgc_status factorise_stages(const bgc_model *m, bgc_data *d, const bgc_collocation *c,
                                   double h) {
    bgc_status status = BGC_OK;

    bgc_evaluate_jacobian(m, d);
    if (c->stages % 2 == 1) {
        status = bgc_factorise(m, d, c->lambda / h);
    }
    if (status == BGC_OK && c->stages > 1) {
        const bgc_complex shift = {c->lambda2[0] / h, c->lambda2[1] / h};
        status = bgc_factorise_complex(m, d, shift);
    }
    return status;
}

/* out = left F - lambda M (left Z), for one row of left and a real lambda. */
static void stage_residual(const bgc_model *m, bgc_data *d, const double *left, int stages,
                           double lambda, const double *z, const double *f, double *out) {
    const int n = m->n_state;

    bgc_combine(n, stages, left, f, NULL, out);
    bgc_combine(n, stages, left, z, NULL, d->point);
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, d->point, d->magnitude);
    }
    for (int i = 0; i < n; i++) {
        out[i] -= lambda * (m->n_mass > 0 ? d->magnitude[i] : d->point[i]);
    }
}

/* --- Newton iteration ------------------------------------------------------------------------ */

/* Adds the correction of the stages by the real system to `change`. */
static bgc_status correct_real(const bgc_model *m, bgc_data *d, const bgc_collocation *c, double h,
                               const double *z, const double *f, double *change) {
    const int n = m->n_state;
    bgc_status status;

    stage_residual(m, d, c->left, c->stages, c->lambda / h, z, f, d->right);
    status = bgc_solve(m, d, d->right);

    /* Back from w to the stages. */
    for (int s = 0; s < c->stages; s++) {
        double *at = change + (size_t)s * bgc_padded(n);
        for (int i = 0; i < n; i++) {
            at[i] += c->right[s] * d->right[i];
        }
    }
    return status;
}

/* The same by the complex system, whose conjugate doubles the real part. */
static bgc_status correct_complex(const bgc_model *m, bgc_data *d, const bgc_collocation *c,
                                  double h, const double *z, const double *f, double *change) {
    const int n = m->n_state, stages = c->stages;
    const double re = c->lambda2[0] / h, im = c->lambda2[1] / h;
    bgc_complex *b = d->complex_right;
    bgc_status status;

    /* Right-hand side left F - (re + i im) M (u + i v), with u + i v = left Z. */
    stage_residual(m, d, c->left2[0], stages, re, z, f, d->right);
    stage_residual(m, d, c->left2[1], stages, re, z, f, d->error);
    for (int i = 0; i < n; i++) {
        b[i] = (bgc_complex){d->right[i], d->error[i]};
    }
    for (int part = 0; part < 2; part++) {
        bgc_combine(n, stages, c->left2[1 - part], z, NULL, d->point);
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

    /* Solve, and back from w to the stages. */
    status = bgc_solve_complex(m, d, b);
    for (int s = 0; s < stages; s++) {
        double *at = change + (size_t)s * bgc_padded(n);
        for (int i = 0; i < n; i++) {
            at[i] += 2.0 * (c->right2[0][s] * b[i].re - c->right2[1][s] * b[i].im);
        }
    }
    return status;
}

/* First iterate of the stages: the dense output of the last step extrapolated, where that is the
 * method's own and no event cut it; else zero. */
static void predict_stages(const bgc_model *m, const bgc_data *d, const bgc_method *method,
                           double h, double *z) {
    const bgc_collocation *c = method->collocation;
    const int n = m->n_state;
    const size_t width = bgc_padded(n);
    const double *k1 = d->k, *k2 = k1 + width;
    const double before = d->core.t - d->core.t_old;

    memset(z, 0, (size_t)c->stages * width * sizeof *z);
    if (d->core.dense != BGC_DENSE_READY || !(before > 0.0) || !bgc_is_adaptive(method) ||
        d->core.t != d->core.t_end) {
        return;
    }
    for (int s = 0; s < c->stages; s++) {
        const double at = 1.0 + c->node[s] * h / before, rest = 1.0 - at;
        for (int i = 0; i < n; i++) {
            const double y =
                rest * d->y0[i] + at * (d->y1[i] + rest * (k1[i] + at * k2[i]));
            z[(size_t)s * width + (size_t)i] = y - d->y1[i];
        }
    }
}

/* f at every stage; BGC_NOT_FINITE where it is undefined. */
static bgc_status evaluate_stages(const bgc_model *m, bgc_data *d, const bgc_collocation *c,
                                  double h, const double *z, double *f) {
    const int n = m->n_state;

    for (int s = 0; s < c->stages; s++) {
        double *at = f + (size_t)s * bgc_padded(n);
        for (int i = 0; i < n; i++) {
            d->point[i] = d->x[i] + z[(size_t)s * bgc_padded(n) + (size_t)i];
        }
        m->rhs(d->h, d->core.t + c->node[s] * h, d->point, d->u, at, d->work);
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

/* Solves for the stages in d->stages: to a part of the tolerance, or to rounding in fixed steps. */
static bgc_status solve_stages(const bgc_model *m, bgc_data *d, const bgc_method *method,
                               double h) {
    const bgc_collocation *c = method->collocation;
    const size_t width = bgc_padded(m->n_state), all = (size_t)c->stages * width;
    double *z = d->stages, *f = d->implicit, *change = f + BGC_MAX_IMPLICIT * width;
    const int fixed = !bgc_is_adaptive(method) || d->core.rtol >= 1.0;
    const int most = fixed ? MAX_NEWTON_FIXED : MAX_NEWTON;
    const double rtol = d->core.rtol;
    const double target =
        fixed ? fixed_target / rtol
              : fmax(10.0 * DBL_EPSILON / rtol, fmin(adaptive_target, sqrt(rtol)));
    double before = 0.0;

    predict_stages(m, d, method, h, z);
    for (int k = 0; k < most; k++) {
        double norm, rate;

        /* Newton correction by the real and the complex system. */
        bgc_status status = evaluate_stages(m, d, c, h, z, f);
        if (status != BGC_OK) {
            return status;
        }
        memset(change, 0, all * sizeof *change);
        if (c->stages % 2 == 1) {
            status = correct_real(m, d, c, h, z, f, change);
            if (status != BGC_OK) {
                return status;
            }
        }
        if (c->stages > 1) {
            status = correct_complex(m, d, c, h, z, f, change);
            if (status != BGC_OK) {
                return status;
            }
        }
        for (size_t i = 0; i < all; i++) {
            z[i] += change[i];
        }

        /* Converged: the remaining error, rate / (1 - rate) times the correction, is below target,
         * or the correction is rounding. Divergent: corrections grow. */
        norm = largest_norm(m, d, c->stages, change);
        if (!isfinite(norm)) {
            return BGC_NOT_CONVERGED;
        }
        rate = k > 0 ? norm / before : 0.0;
        if (norm <= target || (k > 0 && rate < 1.0 && rate / (1.0 - rate) * norm <= target)) {
            return BGC_OK;
        }
        if (k > 0 && rate > 0.5 && norm * rtol <= stagnation) {
            return BGC_OK;
        }
        if (k > 1 && rate > 2.0) {
            return BGC_NOT_CONVERGED;
        }
        before = norm;
    }
    return BGC_NOT_CONVERGED;
}

/* --- the step -------------------------------------------------------------------------------- */

/* d->error := (lambda / h M - J)^-1 (f + M sum e_i Z_i / h). */
static bgc_status estimate_error(const bgc_model *m, bgc_data *d, const bgc_collocation *c,
                                 double h, const double *f) {
    const int n = m->n_state;
    double weight[BGC_MAX_IMPLICIT];

    for (int s = 0; s < c->stages; s++) {
        weight[s] = c->e[s] / h;
    }
    bgc_combine(n, c->stages, weight, d->stages, NULL, d->point);
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, d->point, d->magnitude);
    }
    for (int i = 0; i < n; i++) {
        d->error[i] = f[i] + (m->n_mass > 0 ? d->magnitude[i] : d->point[i]);
    }
    return bgc_solve(m, d, d->error);
}

/* The error estimate to d->error. Where it is beyond the tolerance it is filtered once more, with f
 * at y + error in the place of f at y, which damps stiff components. */
static bgc_status filter_error(const bgc_model *m, bgc_data *d, const bgc_collocation *c,
                               double h) {
    bgc_status status = estimate_error(m, d, c, h, d->f);

    if (status == BGC_OK && bgc_norm(m, d, d->error, d->x, d->x) > 1.0) {
        for (int i = 0; i < m->n_state; i++) {
            d->point[i] = d->x[i] + d->error[i];
        }
        m->rhs(d->h, d->core.t, d->point, d->u, d->implicit, d->work);
        d->core.counts.rhs++;
        if (bgc_first_bad(m->n_state, d->implicit) < 0) {
            status = estimate_error(m, d, c, h, d->implicit);
        }
    }
    return status;
}

/* BGC_NOT_CONVERGED where Newton's iteration fails with a Jacobian of this step. */
bgc_status bgc_collocate(const bgc_model *m, bgc_data *d, const bgc_method *method, double h) {
    const bgc_collocation *c = method->collocation;
    const int n = m->n_state;
    bgc_status status = d->core.held == 0 ? factorise_stages(m, d, c, h) : BGC_OK;

    /* Stages; once more with a fresh Jacobian where a kept one does not converge. */
    if (status == BGC_OK) {
        status = solve_stages(m, d, method, h);
    }
    if (status == BGC_NOT_CONVERGED && d->core.held > 0) {
        status = factorise_stages(m, d, c, h);
        if (status == BGC_OK) {
            status = solve_stages(m, d, method, h);
        }
    }

    if (status == BGC_OK && bgc_is_adaptive(method)) {
        status = filter_error(m, d, c, h);
    }
    bgc_combine(n, c->stages, c->last, d->stages, d->x, d->next);
    return status;
}

/* --- the result of a step from its stages ----------------------------------------------------- */

/* Dense output of a method of three stages, the last of which is y1: the polynomial of degree 3
 * through y and the stages. */
int bgc_interpolate_radau(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const int n = m->n_state;
    const size_t width = bgc_padded(n);
    const double *z1 = d->stages, *z2 = z1 + width, *z3 = z2 + width;
    const double c1 = method->collocation->node[0], c2 = method->collocation->node[1];

    memset(d->k, 0, BGC_MAX_DENSE * width * sizeof *d->k);
    for (int i = 0; i < n; i++) {
        const double at1 = (z1[i] - c1 * z3[i]) / (c1 * (1.0 - c1));
        const double at2 = (z2[i] - c2 * z3[i]) / (c2 * (1.0 - c2));
        const double slope = (at2 - at1) / (c2 - c1);
        d->k[i] = at1 - c1 * slope;
        d->k[width + (size_t)i] = slope;
    }
    return 1;
}

/* Half the difference between h f at the start of the step and the slope of the collocation
 * polynomial there. */
void bgc_correction_of_slope(const bgc_model *m, bgc_data *d, const bgc_method *method,
                             double *change) {
    const bgc_collocation *c = method->collocation;
    const double h = d->core.t_end - d->core.t_old;

    bgc_combine(m->n_state, c->stages, c->e, d->stages, NULL, change);
    for (int i = 0; i < m->n_state; i++) {
        const double slope = h * d->inverse_mass[i];
        change[i] = slope != 0.0 ? 0.5 * (slope * d->f[i] + change[i]) : 0.0;
    }
}

/* Energy accounts by the method's own quadrature balance as exactly as the method conserves
 * energy. */
void bgc_collocation_quadrature(const bgc_model *m, bgc_data *d, const bgc_method *method,
                                double power[2]) {
    const bgc_collocation *c = method->collocation;
    const double h = d->core.t_end - d->core.t_old;

    power[0] = power[1] = 0.0;
    for (int s = 0; s < c->stages; s++) {
        const double *z = d->stages + (size_t)s * bgc_padded(m->n_state);
        double energy[3];
        for (int i = 0; i < m->n_state; i++) {
            d->point[i] = d->y0[i] + z[i];
        }
        m->energy(d->h, d->core.t_old + c->node[s] * h, d->point, d->u_step, energy, d->work);
        power[0] += c->weight[s] * h * energy[1];
        power[1] += c->weight[s] * h * energy[2];
    }
}
