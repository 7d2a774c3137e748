/* complex.c: linear systems with W = c M - J for a complex c, of collocation methods.
 *
 * W is factorised with static pivots by the tables of sparse.c, and densely with scaled partial
 * pivoting where these fail: solutions are checked, refined and given up as in linear.c.
 */
#include "bgc_internal.h"
#include "complex_numbers.h"
#include "solutions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- dense, with partial pivoting -------------------------------------------------------------- */

/* Makes room for dense factors; returns 0 where the memory does not suffice. */
static int make_complex_room(bgc_data *d, size_t n) {
    if (d->dense_complex == NULL) {
        d->dense_complex = calloc(n * n + 1, sizeof *d->dense_complex);
    }
    return d->dense_complex != NULL;
}

/* Reserves memory for dense factors, where the method has complex stages; of a large model for their
 * pivots alone. */
bgc_status bgc_reserve_complex(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const size_t n = (size_t)bgc_unknowns(m);

    if (method->collocation == NULL || method->collocation->stages < 2) {
        return BGC_OK;
    }
    if (d->complex_pivot == NULL) {
        d->complex_pivot = calloc(n + 1, sizeof *d->complex_pivot);
    }
    if (d->complex_pivot == NULL || (n <= BGC_RESERVED_STATES && !make_complex_room(d, n))) {
        return BGC_NO_MEMORY;
    }
    return BGC_OK;
}

/* Fills dense_complex with W, row after row. */
static void assemble_rows(const bgc_model *m, bgc_data *d) {
    const bgc_entries j = bgc_local_entries(m);
    const size_t n = (size_t)bgc_unknowns(m), alone = m->n_mass == 0 ? (size_t)m->n_state : 0;
    const bgc_complex c = d->core.complex_c;
    bgc_complex *a = d->dense_complex;

    memset(a, 0, n * n * sizeof *a);
    for (size_t i = 0; i < alone; i++) {
        a[i * n + i] = c;
    }
    for (int k = 0; k < m->n_mass; k++) {
        bgc_complex *at = a + (size_t)m->mass_row[k] * n + (size_t)m->mass_col[k];
        at->re += c.re * d->mass[k];
        at->im += c.im * d->mass[k];
    }
    for (int k = 0; k < j.count; k++) {
        a[(size_t)j.row[k] * n + (size_t)j.col[k]].re -= d->jac[k];
    }
}

/* The row with the largest scaled pivot of column k, or -1. weight: 1 / the largest entry of a row. */
static int find_pivot(size_t n, const bgc_complex *a, const double *weight, size_t k) {
    double largest = 0.0;
    int best = -1;

    for (size_t i = k; i < n; i++) {
        const double candidate = bgc_size_of(a[i * n + k]) * weight[i];
        if (candidate > largest && isfinite(candidate)) {
            largest = candidate;
            best = (int)i;
        }
    }
    return best;
}

/* Factorises the present W densely, as bgc_factorise_dense does. */
bgc_status bgc_refactorise_complex(const bgc_model *m, bgc_data *d) {
    const size_t n = (size_t)bgc_unknowns(m);
    bgc_complex *a;
    double *weight = d->magnitude;

    if (!make_complex_room(d, n)) {
        return BGC_NO_MEMORY;
    }
    a = d->dense_complex;

    /* Row scales; a sum that is not finite shows an entry that is not. */
    assemble_rows(m, d);
    for (size_t i = 0; i < n; i++) {
        double largest = 0.0, sum = 0.0;
        for (size_t j = 0; j < n; j++) {
            const double size = bgc_size_of(a[i * n + j]);
            largest = fmax(largest, size);
            sum += size;
        }
        if (!isfinite(sum)) {
            d->core.failed_state = i < (size_t)m->n_state ? (int)i : -1;
            return BGC_NOT_FINITE;
        }
        weight[i] = largest > 0.0 ? 1.0 / largest : 0.0;
    }
    for (size_t k = 0; k < n; k++) {
        bgc_complex *top = a + k * n, inverse;
        const int best = find_pivot(n, a, weight, k);

        /* The row of the pivot comes to row k. */
        if (best < 0) {
            d->core.failed_state = k < (size_t)m->n_state ? (int)k : -1;
            return BGC_SINGULAR;
        }
        d->complex_pivot[k] = best;
        for (size_t j = 0; (size_t)best != k && j < n; j++) {
            bgc_complex *other = a + (size_t)best * n + j;
            const bgc_complex swap = top[j];
            top[j] = *other;
            *other = swap;
        }
        weight[best] = weight[k];

        /* Eliminate below the pivot, whose reciprocal is stored. */
        inverse = top[k] = bgc_reciprocal(top[k]);
        for (size_t i = k + 1; i < n; i++) {
            bgc_complex *row = a + i * n;
            if (row[k].re != 0.0 || row[k].im != 0.0) {
                row[k] = bgc_times(row[k], inverse);
                for (size_t j = k + 1; j < n; j++) {
                    row[j] = bgc_minus(row[j], bgc_times(row[k], top[j]));
                }
            }
        }
    }
    return BGC_OK;
}

/* b := W^-1 b with the dense factors. */
static void solve_by_rows(const bgc_model *m, const bgc_data *d, bgc_complex *b) {
    const size_t n = (size_t)bgc_unknowns(m);
    const bgc_complex *lu = d->dense_complex;

    for (size_t k = 0; k < n; k++) {
        const bgc_complex swap = b[k];
        b[k] = b[d->complex_pivot[k]];
        b[d->complex_pivot[k]] = swap;
    }
    /* Forward, then backward substitution. */
    for (size_t i = 1; i < n; i++) {
        for (size_t j = 0; j < i; j++) {
            b[i] = bgc_minus(b[i], bgc_times(lu[i * n + j], b[j]));
        }
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; j++) {
            b[i] = bgc_minus(b[i], bgc_times(lu[i * n + j], b[j]));
        }
        b[i] = bgc_times(b[i], lu[i * n + i]);
    }
}

/* Replaces the static factorisation by the dense one. */
static bgc_status pivot_densely(const bgc_model *m, bgc_data *d) {
    d->core.counts.fallbacks++;
    d->core.complex_pivoting = BGC_DENSE;
    return bgc_refactorise_complex(m, d);
}

/* --- static pivots ------------------------------------------------------------------------------ */

/* Factorises W with static pivots; returns nonzero where a pivot vanishes. */
static int factorise_fixed(const bgc_model *m, bgc_data *d, bgc_complex c, double *growth) {
    if (m->blocks != NULL) {
        return bgc_complex_block_factor(m, d->scale, d->mass, d->jac, c, d->complex_lu, growth,
                                        d->block_work);
    }
    return bgc_complex_factor(m, d->mass, d->jac, c, d->complex_lu, growth, d->complex_work);
}

/* b := W^-1 b with these factors. */
static void solve_fixed(const bgc_model *m, const bgc_data *d, bgc_complex *b) {
    double *work = m->blocks != NULL ? d->block_work : d->complex_work;

    (m->blocks != NULL ? bgc_complex_block_solve : bgc_complex_solve)(
        m, d->complex_lu, b, (bgc_complex *)(void *)work);
}

/* --- checked solutions -------------------------------------------------------------------------- */

/* d->complex_residual = b - W x; returns the componentwise backward error of x, as in linear.c. */
static double residual_of(const bgc_model *m, bgc_data *d, const bgc_complex *b,
                          const bgc_complex *x) {
    const bgc_entries entries = bgc_local_entries(m);
    const bgc_complex c = d->core.complex_c;
    const double size = bgc_size_of(c), *reach = d->reach;
    const int n = bgc_unknowns(m);
    bgc_complex *r = d->complex_residual;
    double worst = 0.0;

    for (int i = 0; i < n; i++) {
        d->reach[i] = bgc_size_of(x[i]);
    }
    bgc_raise_to_least_part(m, d);
    for (int i = 0; i < n; i++) {
        const int alone = m->n_mass == 0 && i < m->n_state;
        r[i] = alone ? bgc_minus(b[i], bgc_times(c, x[i])) : b[i];
        d->magnitude[i] = bgc_size_of(b[i]) + (alone ? size * reach[i] : 0.0);
    }
    for (int k = 0; k < m->n_mass; k++) {
        const int i = m->mass_row[k], j = m->mass_col[k];
        r[i] = bgc_minus(r[i], bgc_scaled(d->mass[k], bgc_times(c, x[j])));
        d->magnitude[i] += fabs(d->mass[k]) * size * reach[j];
    }
    for (int k = 0; k < entries.count; k++) {
        const int i = entries.row[k], j = entries.col[k];
        r[i] = bgc_minus(r[i], bgc_scaled(-d->jac[k], x[j]));
        d->magnitude[i] += fabs(d->jac[k]) * reach[j];
    }
    for (int i = 0; i < n; i++) {
        if (d->magnitude[i] > bgc_underflow) {
            const double error = bgc_size_of(r[i]) / d->magnitude[i];
            worst = error <= worst ? worst : error; /* a NaN stays */
        }
    }
    return worst;
}

/* x := W^-1 x by static pivots with iterative refinement; b is the right-hand side, a copy. Returns 1
 * where the backward error is acceptable. */
static int solve_refined(const bgc_model *m, bgc_data *d, const bgc_complex *b, bgc_complex *x) {
    double error;

    solve_fixed(m, d, x);
    error = residual_of(m, d, b, x);
    if (!(error <= bgc_acceptable)) {
        d->core.complex_watched = BGC_WATCH_FOR;
        d->core.complex_pivoting = BGC_WATCHED;
    }
    for (int k = 0; k < BGC_MAX_REFINEMENTS && error > bgc_acceptable; k++) {
        const double before = error;
        d->core.counts.refinements++;
        solve_fixed(m, d, d->complex_residual);
        for (int i = 0; i < bgc_unknowns(m); i++) {
            x[i].re += d->complex_residual[i].re;
            x[i].im += d->complex_residual[i].im;
        }
        error = residual_of(m, d, b, x);
        if (!(error < 0.5 * before)) {
            break;
        }
    }
    return error <= bgc_acceptable;
}

/* Factorises W = c M - J with the Jacobian in d->jac, and decides how solutions are checked. */
bgc_status bgc_factorise_complex(const bgc_model *m, bgc_data *d, bgc_complex c) {
    double growth;
    int failed;

    d->core.counts.factorisations++;
    d->core.complex_c = c;
    failed = factorise_fixed(m, d, c, &growth);
    if (failed != 0) {
        return pivot_densely(m, d);
    }
    d->core.complex_pivoting = bgc_choose_checks(++d->core.complex_factorisations, growth,
                                                 &d->core.complex_watched);
    return BGC_OK;
}

/* b := W^-1 b, with inner unknowns. */
static bgc_status solve_all_complex(const bgc_model *m, bgc_data *d, bgc_complex *b) {
    const int n = bgc_unknowns(m);
    const size_t size = (size_t)n * sizeof *b;

    if (d->core.complex_pivoting == BGC_STATIC) {
        solve_fixed(m, d, b);
        return BGC_OK;
    }
    if (d->core.complex_pivoting != BGC_DENSE) {
        bgc_status status;
        if (bgc_first_bad(2 * n, (const double *)(const void *)b) >= 0) {
            return BGC_OK;
        }
        memcpy(d->complex_b, b, size);
        if (solve_refined(m, d, d->complex_b, b)) {
            if (d->core.complex_pivoting == BGC_CHECKED_ONCE) {
                d->core.complex_pivoting = BGC_STATIC;
            }
            return BGC_OK;
        }
        memcpy(b, d->complex_b, size);
        status = pivot_densely(m, d);
        if (status != BGC_OK) {
            return status;
        }
    }
    solve_by_rows(m, d, b);
    return BGC_OK;
}

/* b := W^-1 b with the factorisation at hand. A right-hand side that is not finite is left to the
 * caller's check. */
bgc_status bgc_solve_complex(const bgc_model *m, bgc_data *d, bgc_complex *b) {
    const size_t size = (size_t)m->n_state * sizeof *b;
    bgc_status status;

    d->core.counts.solves++;
    if (m->n_inner == 0) {
        return solve_all_complex(m, d, b);
    }
    memcpy(d->complex_wide, b, size);
    memset(d->complex_wide + m->n_state, 0, (size_t)m->n_inner * sizeof *b);
    status = solve_all_complex(m, d, d->complex_wide);
    memcpy(b, d->complex_wide, size);
    return status;
}
