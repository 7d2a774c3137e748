/* linear_kinds.h: linear systems with W = c M - J.
 *
 * W is factorised with static pivots, by code unrolled for the model, or where the model is large in
 * blocks of rows or by tables. That is fast, and does not notice small pivots. So solutions are checked
 * by their backward error: all of them while the growth of the pivots is large or a check failed
 * recently, otherwise the first one of every sixteenth factorisation. A solution that fails is refined
 * iteratively. Where that does not help, or a pivot vanishes, W is factorised densely with scaled partial
 * pivoting.
 */
#include "kind.h"

/* --- static pivots ------------------------------------------------------------------------------ */

/* Factorises W with static pivots; returns nonzero where a pivot vanishes, and where the model, written
 * by hand, has neither code nor tables for this kind. */
static int BGC_KIND(factorise_static)(const bgc_model *m, bgc_data *d, bgc_scalar c,
                                      double *growth) {
    int failed;

    if (BGC_KIND(factorise_unrolled)(m, d, c, growth, &failed)) {
        return failed;
    }
    if (m->blocks != NULL) {
        return BGC_KIND(bgc_block_factor)(m, d->scale, d->mass, d->jac, c, d->BGC_KIND(lu), growth,
                                          d->block_work);
    }
    if (m->lu_row == NULL) {
        return 1;
    }
    return BGC_KIND(bgc_sparse_factor)(m, d->mass, d->jac, c, d->BGC_KIND(lu), growth,
                                       d->sparse_work);
}

/* b := W^-1 b with these factors, with inner unknowns. */
static void BGC_KIND(solve_static)(const bgc_model *m, bgc_data *d, bgc_scalar *b) {
    if (m->n_inner == 0 && BGC_KIND(solve_unrolled)(m, d, b)) {
        return;
    }
    if (m->blocks != NULL) {
        BGC_KIND(bgc_block_solve)(m, d->BGC_KIND(lu), b, d->block_work);
    } else {
        BGC_KIND(bgc_sparse_solve)(m, d->BGC_KIND(lu), b, d->sparse_work);
    }
}

/* --- dense factors ------------------------------------------------------------------------------ */

/* Whether one of n numbers is not finite. */
static int BGC_KIND(has_bad)(int n, const bgc_scalar *v) {
    return bgc_first_bad(n * (int)(sizeof *v / sizeof(double)), (const double *)(const void *)v) >= 0;
}

/* Fills the dense matrix with W, row after row. */
static void BGC_KIND(assemble_dense)(const bgc_model *m, bgc_data *d) {
    const bgc_entries j = bgc_local_entries(m);
    const size_t n = (size_t)bgc_unknowns(m), alone = m->n_mass == 0 ? (size_t)m->n_state : 0;
    const bgc_scalar c = d->core.BGC_KIND(c);
    bgc_scalar *a = d->BGC_KIND(dense_lu);

    memset(a, 0, n * n * sizeof *a);
    for (size_t i = 0; i < alone; i++) {
        a[i * n + i] = c;
    }
    for (int k = 0; k < m->n_mass; k++) {
        bgc_scalar *entry = a + (size_t)m->mass_row[k] * n + (size_t)m->mass_col[k];
        *entry = kind_plus_scaled(*entry, d->mass[k], c);
    }
    for (int k = 0; k < j.count; k++) {
        kind_re(a[(size_t)j.row[k] * n + (size_t)j.col[k]]) -= d->jac[k];
    }
}

/* Factorises the present W densely. The failure of an inner unknown is reported of no state. */
bgc_status BGC_KIND(bgc_refactorise_dense)(const bgc_model *m, bgc_data *d) {
    const int n = bgc_unknowns(m);
    int bad;

    if (!BGC_KIND(bgc_make_room)(&d->BGC_KIND(dense_lu), &d->BGC_KIND(dense_room), (size_t)n)) {
        return BGC_NO_MEMORY;
    }
    BGC_KIND(assemble_dense)(m, d);
    for (int i = 0; i < n; i++) {
        if (BGC_KIND(has_bad)(n, d->BGC_KIND(dense_lu) + (size_t)i * (size_t)n)) {
            d->core.failed_state = i < m->n_state ? i : -1;
            return BGC_NOT_FINITE;
        }
    }
    bad = BGC_KIND(bgc_factorise_dense)(n, d->BGC_KIND(dense_lu), d->BGC_KIND(pivot), d->magnitude);
    if (bad >= 0) {
        d->core.failed_state = bad < m->n_state ? bad : -1;
        return BGC_SINGULAR;
    }
    return BGC_OK;
}

/* Replaces the static factorisation by the dense one. */
static bgc_status BGC_KIND(fall_back)(const bgc_model *m, bgc_data *d) {
    d->core.counts.fallbacks++;
    d->core.BGC_KIND(pivoting) = BGC_DENSE;
    return BGC_KIND(bgc_refactorise_dense)(m, d);
}

/* --- checked solutions -------------------------------------------------------------------------- */

/* Factorises W = c M - J with the Jacobian in d->jac, and decides how solutions are checked. */
bgc_status BGC_KIND(bgc_factorise)(const bgc_model *m, bgc_data *d, bgc_scalar c) {
    double growth = 0.0;
    const int failed = BGC_KIND(factorise_static)(m, d, c, &growth);
    const long count = BGC_KIND(count_factorisation)(&d->core);

    d->core.BGC_KIND(c) = c;
    if (failed != 0 || !isfinite(growth)) {
        return BGC_KIND(fall_back)(m, d);
    }
    d->core.BGC_KIND(pivoting) = bgc_choose_checks(count, growth, &d->core.BGC_KIND(watched));
    return BGC_OK;
}

/* x := W^-1 x by static pivots with iterative refinement; b is the right-hand side, a copy. Returns 1
 * where the backward error is acceptable. */
static int BGC_KIND(solve_checked)(const bgc_model *m, bgc_data *d, const bgc_scalar *b,
                                   bgc_scalar *x) {
    double error;

    BGC_KIND(solve_static)(m, d, x);
    error = BGC_KIND(bgc_backward_error)(m, d, b, x);
    if (!(error <= bgc_acceptable)) {
        d->core.BGC_KIND(watched) = BGC_WATCH_FOR;
        d->core.BGC_KIND(pivoting) = BGC_WATCHED;
    }
    for (int k = 0; k < BGC_MAX_REFINEMENTS && error > bgc_acceptable; k++) {
        const double before = error;
        d->core.counts.refinements++;
        BGC_KIND(solve_static)(m, d, d->BGC_KIND(residual));
        for (int i = 0; i < bgc_unknowns(m); i++) {
            x[i] = kind_plus(x[i], d->BGC_KIND(residual)[i]);
        }
        error = BGC_KIND(bgc_backward_error)(m, d, b, x);
        if (!(error < 0.5 * before)) {
            break;
        }
    }
    return error <= bgc_acceptable;
}

/* b := W^-1 b, with inner unknowns. */
static bgc_status BGC_KIND(solve_all)(const bgc_model *m, bgc_data *d, bgc_scalar *b) {
    const int n = bgc_unknowns(m);
    const size_t size = (size_t)n * sizeof *b;
    bgc_status status;

    if (d->core.BGC_KIND(pivoting) == BGC_STATIC) {
        BGC_KIND(solve_static)(m, d, b);
        return BGC_OK;
    }
    if (d->core.BGC_KIND(pivoting) != BGC_DENSE) {
        if (BGC_KIND(has_bad)(n, b)) {
            return BGC_OK;
        }
        memcpy(d->BGC_KIND(b), b, size);
        if (BGC_KIND(solve_checked)(m, d, d->BGC_KIND(b), b)) {
            if (d->core.BGC_KIND(pivoting) == BGC_CHECKED_ONCE) {
                d->core.BGC_KIND(pivoting) = BGC_STATIC;
            }
            return BGC_OK;
        }
        memcpy(b, d->BGC_KIND(b), size);
        status = BGC_KIND(fall_back)(m, d);
        if (status != BGC_OK) {
            return status;
        }
    }
    BGC_KIND(bgc_solve_dense)(n, d->BGC_KIND(dense_lu), d->BGC_KIND(pivot), b);
    return BGC_OK;
}

/* b := W^-1 b with the factorisation at hand. A right-hand side that is not finite is left to the
 * caller's check. */
bgc_status BGC_KIND(bgc_solve)(const bgc_model *m, bgc_data *d, bgc_scalar *b) {
    const size_t size = (size_t)m->n_state * sizeof *b;
    bgc_scalar *wide = d->BGC_KIND(wide);
    bgc_status status;

    d->core.counts.solves++;
    if (m->n_inner == 0) {
        return BGC_KIND(solve_all)(m, d, b);
    }
    if (d->core.BGC_KIND(pivoting) == BGC_STATIC && BGC_KIND(solve_unrolled)(m, d, b)) {
        return BGC_OK;
    }
    memcpy(wide, b, size);
    memset(wide + m->n_state, 0, (size_t)m->n_inner * sizeof *b);
    status = BGC_KIND(solve_all)(m, d, wide);
    memcpy(b, wide, size);
    return status;
}
