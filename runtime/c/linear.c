/* linear.c: linear systems with W = c M - J.
 *
 * W is factorised with static pivots, by code unrolled for the model, or where the model is large in
 * blocks of rows or by tables. That is fast, and does not notice small pivots. So solutions are checked by their backward
 * error: all of them while the growth of the pivots is large or a check failed recently, otherwise
 * the first one of every sixteenth factorisation. A solution that fails is refined iteratively. Where
 * that does not help, or a pivot vanishes, W is factorised densely with scaled partial pivoting.
 */
#include "bgc_internal.h"
#include "solutions.h"

#include <math.h>
#include <string.h>

/* b := W^-1 b by the static pivots, with inner unknowns. */
static void solve_static(const bgc_model *m, bgc_data *d, double *b) {
    if (m->solve != NULL && m->n_inner == 0) {
        m->solve(d->lu, b, d->work);
    } else if (m->blocks != NULL) {
        bgc_block_solve(m, d->lu, b, d->block_work);
    } else {
        bgc_sparse_solve(m, d->lu, b, d->sparse_work);
    }
}

/* Fills dense_lu with W, row after row. */
static void assemble_dense(const bgc_model *m, bgc_data *d) {
    const bgc_entries j = bgc_local_entries(m);
    const size_t n = (size_t)bgc_unknowns(m), alone = m->n_mass == 0 ? (size_t)m->n_state : 0;
    double *a = d->dense_lu;

    memset(a, 0, n * n * sizeof *a);
    for (size_t i = 0; i < alone; i++) {
        a[i * n + i] = d->core.c;
    }
    for (int k = 0; k < m->n_mass; k++) {
        a[(size_t)m->mass_row[k] * n + (size_t)m->mass_col[k]] += d->core.c * d->mass[k];
    }
    for (int k = 0; k < j.count; k++) {
        a[(size_t)j.row[k] * n + (size_t)j.col[k]] -= d->jac[k];
    }
}

/* Factorises the dense, finite n by n matrix a, stored by rows, in place: Gaussian elimination with
 * scaled partial pivoting, so that units do not choose the pivots. Returns -1, or the first state that
 * the rows do not determine. weight is scratch. */
int bgc_factorise_dense(int n, double *a, int *pivot, double *weight) {
    /* Row scales. */
    for (int i = 0; i < n; i++) {
        const double *row = a + (size_t)i * (size_t)n;
        double largest = 0.0;
        for (int j = 0; j < n; j++) {
            largest = fmax(largest, fabs(row[j]));
        }
        weight[i] = largest > 0.0 ? 1.0 / largest : 0.0;
    }
    for (int k = 0; k < n; k++) {
        double *top = a + (size_t)k * (size_t)n;
        int best = k;
        double size = -1.0;

        /* The largest scaled pivot of the column, and its row. */
        for (int i = k; i < n; i++) {
            const double candidate = fabs(a[(size_t)i * (size_t)n + (size_t)k]) * weight[i];
            if (candidate > size) {
                size = candidate;
                best = i;
            }
        }
        if (!(size > 0.0) || !isfinite(size)) {
            return k;
        }
        pivot[k] = best;
        if (best != k) {
            double *other = a + (size_t)best * (size_t)n;
            for (int j = 0; j < n; j++) {
                const double swap = top[j];
                top[j] = other[j];
                other[j] = swap;
            }
            weight[best] = weight[k];
        }

        /* Eliminate below the pivot. */
        for (int i = k + 1; i < n; i++) {
            double *row = a + (size_t)i * (size_t)n;
            if (row[k] != 0.0) {
                row[k] /= top[k];
                for (int j = k + 1; j < n; j++) {
                    row[j] -= row[k] * top[j];
                }
            }
        }
    }
    return -1;
}

/* The first pivot of the factors of bgc_factorise_dense that is at most the rounding errors of
 * the terms it is the sum of, or -1: the rows do not determine that state, whatever its sign. */
int bgc_rounded_pivot(int n, const double *lu) {
    const double noise = 2.0 * n * DBL_EPSILON;

    for (int k = 0; k < n; k++) {
        const double pivot = fabs(lu[(size_t)k * (size_t)n + (size_t)k]);
        double terms = pivot;
        for (int j = 0; j < k; j++) {
            terms += fabs(lu[(size_t)k * (size_t)n + (size_t)j] * lu[(size_t)j * (size_t)n + (size_t)k]);
        }
        if (pivot <= noise * terms) {
            return k;
        }
    }
    return -1;
}

/* b := a^-1 b, with the factors of bgc_factorise_dense. */
void bgc_solve_dense(int n, const double *lu, const int *pivot, double *b) {
    for (int k = 0; k < n; k++) {
        const double swap = b[k];
        b[k] = b[pivot[k]];
        b[pivot[k]] = swap;
    }
    /* Forward, then backward substitution. */
    for (int i = 1; i < n; i++) {
        const double *row = lu + (size_t)i * (size_t)n;
        for (int j = 0; j < i; j++) {
            b[i] -= row[j] * b[j];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        const double *row = lu + (size_t)i * (size_t)n;
        for (int j = i + 1; j < n; j++) {
            b[i] -= row[j] * b[j];
        }
        b[i] /= row[i];
    }
}

/* The state that the failure of unknown i is reported of: itself, or none. */
static int state_of(const bgc_model *m, int i) {
    return i < m->n_state ? i : -1;
}

/* Factorises the present W densely. */
bgc_status bgc_refactorise_dense(const bgc_model *m, bgc_data *d) {
    const int n = bgc_unknowns(m);
    int bad;

    if (!bgc_make_room(&d->dense_lu, &d->dense_room, (size_t)n)) {
        return BGC_NO_MEMORY;
    }
    assemble_dense(m, d);
    for (int i = 0; i < n; i++) {
        if (bgc_first_bad(n, d->dense_lu + (size_t)i * (size_t)n) >= 0) {
            d->core.failed_state = state_of(m, i);
            return BGC_NOT_FINITE;
        }
    }
    bad = bgc_factorise_dense(n, d->dense_lu, d->pivot, d->magnitude);
    if (bad >= 0) {
        d->core.failed_state = state_of(m, bad);
        return BGC_SINGULAR;
    }
    return BGC_OK;
}

/* Replaces the static factorisation by the dense one. */
static bgc_status fall_back(const bgc_model *m, bgc_data *d) {
    d->core.counts.fallbacks++;
    d->core.pivoting = BGC_DENSE;
    return bgc_refactorise_dense(m, d);
}

/* How solutions of factorisation number `count` with static pivots of this growth are checked;
 * *watched counts the factorisations whose solutions are all still to be checked. */
bgc_pivoting bgc_choose_checks(long count, double growth, int *watched) {
    if (growth > bgc_growth_limit) {
        *watched = BGC_WATCH_FOR;
    }
    if (*watched > 0) {
        (*watched)--;
        return BGC_WATCHED;
    }
    return count % BGC_CHECK_EVERY == 1 ? BGC_CHECKED_ONCE : BGC_STATIC;
}

/* Factorises W = c M - J with static pivots; returns nonzero where a pivot vanishes. */
static int factorise_static(const bgc_model *m, bgc_data *d, double c, double *growth) {
    if (m->factor != NULL) {
        return m->factor(d->mass, d->jac, c, d->lu, growth);
    }
    if (m->blocks != NULL) {
        return bgc_block_factor(m, d->scale, d->mass, d->jac, c, d->lu, growth, d->block_work);
    }
    return bgc_sparse_factor(m, d->mass, d->jac, c, d->lu, growth, d->sparse_work);
}

/* Factorises W = c M - J with the Jacobian in d->jac, and decides how solutions are checked. */
bgc_status bgc_factorise(const bgc_model *m, bgc_data *d, double c) {
    double growth = 0.0;
    const int failed = factorise_static(m, d, c, &growth);

    d->core.counts.factorisations++;
    d->core.c = c;
    if (failed != 0 || !isfinite(growth)) {
        return fall_back(m, d);
    }
    d->core.pivoting = bgc_choose_checks(d->core.counts.factorisations, growth, &d->core.watched);
    return BGC_OK;
}

/* x := W^-1 x by static pivots with iterative refinement; b is the right-hand side, a copy. Returns 1
 * where the backward error is acceptable. */
static int solve_checked(const bgc_model *m, bgc_data *d, const double *b, double *x) {
    double error;

    solve_static(m, d, x);
    error = bgc_backward_error(m, d, b, x);
    if (!(error <= bgc_acceptable)) {
        d->core.watched = BGC_WATCH_FOR;
        d->core.pivoting = BGC_WATCHED;
    }
    for (int k = 0; k < BGC_MAX_REFINEMENTS && error > bgc_acceptable; k++) {
        const double before = error;
        d->core.counts.refinements++;
        solve_static(m, d, d->residual);
        for (int i = 0; i < bgc_unknowns(m); i++) {
            x[i] += d->residual[i];
        }
        error = bgc_backward_error(m, d, b, x);
        if (!(error < 0.5 * before)) {
            break;
        }
    }
    return error <= bgc_acceptable;
}

/* b := W^-1 b, with inner unknowns. */
static bgc_status solve_all(const bgc_model *m, bgc_data *d, double *b) {
    const int n = bgc_unknowns(m);
    const size_t size = (size_t)n * sizeof *b;
    bgc_status status;

    if (d->core.pivoting == BGC_STATIC) {
        solve_static(m, d, b);
        return BGC_OK;
    }
    if (d->core.pivoting != BGC_DENSE) {
        if (bgc_first_bad(n, b) >= 0) {
            return BGC_OK;
        }
        memcpy(d->b, b, size);
        if (solve_checked(m, d, d->b, b)) {
            if (d->core.pivoting == BGC_CHECKED_ONCE) {
                d->core.pivoting = BGC_STATIC;
            }
            return BGC_OK;
        }
        memcpy(b, d->b, size);
        status = fall_back(m, d);
        if (status != BGC_OK) {
            return status;
        }
    }
    bgc_solve_dense(n, d->dense_lu, d->pivot, b);
    return BGC_OK;
}

/* b := W^-1 b with the factorisation at hand. A right-hand side that is not finite is left to the
 * caller's check. */
bgc_status bgc_solve(const bgc_model *m, bgc_data *d, double *b) {
    const size_t size = (size_t)m->n_state * sizeof *b;
    bgc_status status;

    d->core.counts.solves++;
    if (m->n_inner == 0) {
        return solve_all(m, d, b);
    }
    if (d->core.pivoting == BGC_STATIC && m->solve != NULL) {
        m->solve(d->lu, b, d->work);
        return BGC_OK;
    }
    memcpy(d->wide, b, size);
    memset(d->wide + m->n_state, 0, (size_t)m->n_inner * sizeof *b);
    status = solve_all(m, d, d->wide);
    memcpy(b, d->wide, size);
    return status;
}
