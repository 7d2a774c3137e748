/* consistent.c: consistent values of the states without a rate, which algebraic equations determine.
 *
 * Empty rows of M are algebraic equations. The states that are free to satisfy them are those whose
 * columns of M are empty too, and those that M couples to such a row or column: the block. M times
 * the change of the block has to vanish. All other states are held.
 *
 * Newton's method with the block's part of the Jacobian, damped by the natural monotonicity test,
 * which is invariant under scaling of the equations: P. Deuflhard, Newton Methods for Nonlinear
 * Problems, 3.3. Where it does not converge, a homotopy leads from equations that hold at the start
 * to those of the model.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_ITERATIONS = 100, LAST_CORRECTIONS = 4, ROUNDED_STARTS = 4 };
enum { MAX_HOMOTOPY = 60, MAX_SEARCH = 64 };
static const double least_damping = 1e-6;
static const double converged = 1e-9;        /* last correction, relative to the states */
static const double nearly_converged = 1e-3; /* the same over the tolerance, where it stagnates */
static const double last_digits = 4.0 * DBL_EPSILON; /* what rounding may make of a state */
static const double near_solution = 1e-5;    /* relative corrections that must shrink fast */
static const double perturbation = 1e-2;     /* of a second start, relative to scale or state */
static const double size_floor = 1e-9;       /* of the scale: smaller states count as this */

/* --- the block ----------------------------------------------------------------------------- */

/* Finds the empty rows of M, the block of states that are free to satisfy them, and 1 / m_ii of rows
 * with a diagonal entry alone. */
void bgc_classify_states(const bgc_model *m, bgc_data *d) {
    const int n = m->n_state;
    int changed = 1, size = 0;

    /* Each row: its diagonal, and the number of other entries in row and column. */
    for (int i = 0; i < n; i++) {
        double diagonal = m->n_mass == 0 ? 1.0 : 0.0;
        int others = 0, column = 0;
        for (int k = 0; k < m->n_mass; k++) {
            const int nonzero = d->mass[k] != 0.0;
            if (m->mass_row[k] == i && m->mass_col[k] == i) {
                diagonal += d->mass[k];
            } else {
                others += nonzero && m->mass_row[k] == i;
                column += nonzero && m->mass_col[k] == i;
            }
        }
        d->inverse_mass[i] = diagonal != 0.0 && others == 0 ? 1.0 / diagonal : 0.0;
        d->algebraic[i] = diagonal == 0.0 && others == 0 ? 1.0 : 0.0;
        d->place[i] = diagonal == 0.0 && (others == 0 || column == 0) ? 0 : -1;
        size += d->algebraic[i] != 0.0;
    }
    d->core.algebraic = size;

    /* States that M couples to the block belong to it: repeat until none is added. */
    while (changed) {
        changed = 0;
        for (int k = 0; k < m->n_mass; k++) {
            int *row = d->place + m->mass_row[k], *column = d->place + m->mass_col[k];
            if (d->mass[k] != 0.0 && *row != *column) {
                *row = *column = 0;
                changed = 1;
            }
        }
    }

    /* Number the block. */
    d->n_block = 0;
    for (int i = 0; i < n; i++) {
        if (d->place[i] == 0) {
            d->block[d->n_block] = i;
            d->place[i] = d->n_block++;
        }
    }
}

/* --- linear algebra of the block ---------------------------------------------------------- */

/* The residual of the block at (t, x), in its order; returns whether it is finite. In algebraic rows it
 * is f less `part` of d->first, in the others -M (x - d->start). */
static int residual_at(const bgc_model *m, bgc_data *d, double t, const double *x, double part,
                       double *residual) {
    m->rhs(d->h, t, x, d->u, d->right, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        d->right[i] = d->algebraic[i] != 0.0 ? d->right[i] : 0.0;
    }
    for (int k = 0; k < m->n_mass; k++) {
        const int i = m->mass_row[k], j = m->mass_col[k];
        d->right[i] -= d->algebraic[i] != 0.0 ? 0.0 : d->mass[k] * (x[j] - d->start[j]);
    }
    for (int k = 0; k < d->n_block; k++) {
        residual[k] = d->right[d->block[k]];
        residual[k] -= part != 0.0 ? part * d->first[k] : 0.0;
    }
    return bgc_first_bad(d->n_block, residual) < 0;
}

/* The matrix of the block: rows of M where they are not empty, else of -J, times `sign`. */
static void assemble_block(const bgc_model *m, const bgc_data *d, const double *jac, double sign,
                           double *a) {
    const size_t n = (size_t)d->n_block;

    memset(a, 0, n * n * sizeof *a);
    for (int k = 0; k < m->n_mass; k++) {
        const int i = d->place[m->mass_row[k]], j = d->place[m->mass_col[k]];
        if (i >= 0 && j >= 0) {
            a[(size_t)i * n + (size_t)j] += sign * d->mass[k];
        }
    }
    for (int k = 0; k < m->n_jac; k++) {
        const int i = d->place[m->jac_row[k]], j = d->place[m->jac_col[k]];
        if (i >= 0 && j >= 0 && d->algebraic[m->jac_row[k]] != 0.0) {
            a[(size_t)i * n + (size_t)j] -= sign * jac[k];
        }
    }
}

/* Factorises the matrix of the block. */
static bgc_status factorise_block(const bgc_model *m, bgc_data *d, const double *jac) {
    const size_t n = (size_t)d->n_block;
    double *a;
    int bad;

    if (!bgc_make_room(&d->block_lu, &d->block_room, n)) {
        return BGC_NO_MEMORY;
    }
    a = d->block_lu;
    assemble_block(m, d, jac, 1.0, a);
    if (bgc_first_bad((int)(n * n), a) >= 0) {
        return BGC_NOT_FINITE;
    }
    bad = bgc_factorise_dense((int)n, a, d->block_pivot, d->magnitude);
    if (bad < 0) {
        bad = bgc_rounded_pivot((int)n, a);
    }
    if (bad >= 0) {
        d->core.failed_state = d->block[bad];
        return BGC_SINGULAR;
    }
    return BGC_OK;
}

/* The same with the Jacobian at (t, x), to d->block_lu. */
bgc_status bgc_refresh_block(const bgc_model *m, bgc_data *d, double t, const double *x) {
    bgc_differentiate(m, d, t, x, d->block_jac, d->residual);
    d->core.counts.jacobians++;
    return factorise_block(m, d, d->block_jac);
}

/* Root mean square of a correction relative to the states in `sizes`. */
static double norm_of(const bgc_data *d, const double *change, const double *sizes) {
    double sum = 0.0;

    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        const double r = change[k] / fmax(fabs(sizes[i]), size_floor * d->scale[i]);
        sum += r * r;
    }
    return sqrt(sum / d->n_block);
}

/* Whether a correction is below `part` of the tolerances. */
static int is_within(const bgc_data *d, const double *change, const double *x, double part) {
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        if (!(fabs(change[k]) <= part * bgc_tolerance(d, i, fabs(x[i])))) {
            return 0;
        }
    }
    return 1;
}

/* to = x + part * correction. */
static void add_correction(const bgc_model *m, const bgc_data *d, const double *x, double part,
                 const double *change, double *to) {
    if (to != x) {
        memcpy(to, x, (size_t)m->n_state * sizeof *to);
    }
    for (int k = 0; k < d->n_block; k++) {
        to[d->block[k]] += part * change[k];
    }
}

/* --- Newton's method ----------------------------------------------------------------------- */

/* Adds the largest part of the correction d->change that passes the monotonicity test. Returns the
 * ratio of the next correction to this one, or -1 where no part passes. */
static double correct(const bgc_model *m, bgc_data *d, double t, double part, double *x,
                      double *damping) {
    const double length = norm_of(d, d->change, x);

    for (; *damping >= least_damping; *damping *= 0.5) {
        double ratio;

        /* The next correction, with the same factors: it has to be shorter. */
        add_correction(m, d, x, *damping, d->change, d->trial);
        if (!residual_at(m, d, t, d->trial, part, d->next_change)) {
            continue;
        }
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, d->next_change);
        ratio = norm_of(d, d->next_change, x) / length;
        if (ratio <= 1.0 - 0.25 * *damping) {
            memcpy(x, d->trial, (size_t)m->n_state * sizeof *x);
            return ratio;
        }
    }
    return -1.0;
}

/* Whether the correction d->change at x is no larger than what it changes by where the states change in
 * their last digits: then rounding makes it, and no values near x satisfy the equations better. */
static int is_rounding(const bgc_model *m, bgc_data *d, double t, double part, const double *x) {
    double share = 0.25;

    memset(d->largest, 0, (size_t)d->n_block * sizeof *d->largest);
    for (int attempt = 0; attempt < ROUNDED_STARTS; attempt++) {
        for (int i = 0; i < m->n_state; i++) { /* by a low-discrepancy sequence */
            d->trial[i] = x[i] + (2.0 * share - 1.0) * last_digits * fabs(x[i]);
            share += 0.6180339887498949;
            share -= share >= 1.0 ? 1.0 : 0.0;
        }
        if (!residual_at(m, d, t, d->trial, part, d->next_change)) {
            return 0;
        }
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, d->next_change);
        for (int k = 0; k < d->n_block; k++) {
            d->largest[k] = fmax(d->largest[k], fabs(d->next_change[k] - d->change[k]));
        }
    }
    for (int k = 0; k < d->n_block; k++) {
        if (!(fabs(d->change[k]) <= d->largest[k])) {
            return 0;
        }
    }
    return 1;
}

/* Whole corrections where none shortens the next one: beside one that rounding makes, others may be
 * left. On failure x is undefined. */
static bgc_status settle(const bgc_model *m, bgc_data *d, double t, double part, double *x) {
    for (int k = 0; k < LAST_CORRECTIONS && residual_at(m, d, t, x, part, d->change); k++) {
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, d->change);
        if (is_rounding(m, d, t, part, x)) {
            return BGC_OK;
        }
        add_correction(m, d, x, 1.0, d->change, x);
    }
    return BGC_INCONSISTENT;
}

/* Solves the algebraic rows, less `part` of d->first, for the block's states in x. On failure x is
 * undefined. */
static bgc_status newton(const bgc_model *m, bgc_data *d, double t, double part, double *x) {
    double damping = 1.0;
    int slow = 0;

    memcpy(d->largest, x, (size_t)m->n_state * sizeof *x);
    for (int k = 0; k < MAX_ITERATIONS; k++) {
        bgc_status status;
        double ratio;

        /* Newton correction. */
        if (!residual_at(m, d, t, x, part, d->change)) {
            return BGC_INCONSISTENT;
        }
        status = bgc_refresh_block(m, d, t, x);
        if (status != BGC_OK) {
            return status;
        }
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, d->change);
        if (bgc_first_bad(d->n_block, d->change) >= 0) {
            return BGC_INCONSISTENT;
        }

        /* Converged, or a damped correction. */
        if (norm_of(d, d->change, x) <= converged) {
            add_correction(m, d, x, 1.0, d->change, x);
            return BGC_OK;
        }
        ratio = correct(m, d, t, part, x, &damping);
        if (ratio < 0.0) {
            break;
        }
        for (int j = 0; j < d->n_block; j++) {
            const int i = d->block[j];
            d->largest[i] = fmax(fabs(d->largest[i]), fabs(x[i]));
        }

        /* Convergence is quadratic near a simple solution. If it is slow there, the solution is
         * multiple, or there is none. */
        slow = damping == 1.0 && ratio > 0.1 && norm_of(d, d->change, d->largest) < near_solution
                   ? slow + 1 : 0;
        if (slow == 3) {
            return settle(m, d, t, part, x);
        }
        damping = fmin(1.0, ratio < 0.5 ? 4.0 * damping : 2.0 * damping);
    }
    if (is_within(d, d->change, x, nearly_converged)) {
        return BGC_OK;
    }
    return settle(m, d, t, part, x);
}

/* Follows the homotopy g(y) - (1 - s) g(x) = 0 from s = 0, where x satisfies it, to s = 1, in steps
 * as long as Newton's method converges. */
static bgc_status follow_homotopy(const bgc_model *m, bgc_data *d, double t, double *x) {
    const size_t size = (size_t)m->n_state * sizeof *x;
    double s = 0.0, stride = 0.1;
    bgc_status status = BGC_INCONSISTENT;

    if (!residual_at(m, d, t, x, 0.0, d->first)) {
        return BGC_INCONSISTENT;
    }
    for (int k = 0; k < MAX_HOMOTOPY && s < 1.0; k++) {
        const double next = fmin(1.0, s + stride);
        memcpy(d->homotopy, x, size);
        status = newton(m, d, t, 1.0 - next, d->homotopy);
        if (status == BGC_OK) {
            memcpy(x, d->homotopy, size);
            s = next;
            stride *= 2.0;
        } else {
            stride *= 0.25;
        }
    }
    return s < 1.0 && status == BGC_OK ? BGC_INCONSISTENT : status;
}

/* Perturbs the start: the Jacobian may be singular there, as that of `f*abs(f)` is at 0. */
static void perturb(const bgc_data *d, double *x) {
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        x[i] += (k % 2 == 0 ? perturbation : -0.7 * perturbation) * fmax(fabs(x[i]), d->scale[i]);
    }
}

/* --- search from other starts --------------------------------------------------------------- */

/* The block at time t, as a system in its own unknowns. */
typedef struct {
    const bgc_model *m;
    bgc_data *d;
    double t;
} block_at;

/* The states x = d->start with the block's unknowns replaced, in d->homotopy. */
static const double *with_unknowns(bgc_data *d, const double *y) {
    for (int k = 0; k < d->n_block; k++) {
        d->homotopy[d->block[k]] = y[k];
    }
    return d->homotopy;
}

static int block_residual(void *of, const double *y, double *residual) {
    const block_at *at = of;

    return residual_at(at->m, at->d, at->t, with_unknowns(at->d, y), 0.0, residual);
}

static int block_matrix(void *of, const double *y, double *a) {
    const block_at *at = of;
    bgc_data *d = at->d;

    bgc_differentiate(at->m, d, at->t, with_unknowns(d, y), d->block_jac, d->residual);
    d->core.counts.jacobians++;
    assemble_block(at->m, d, d->block_jac, -1.0, a);
    return bgc_first_bad(d->n_block * d->n_block, a) < 0;
}

/* A number in [-1, 1], from a congruential generator (Knuth, MMIX). */
static double next_number(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) / 4503599627370496.0 - 1.0;
}

/* Newton's method from other starts, and where it fails from the nearest approach by least squares.
 * A law may be flat, or overflow, where the unknowns have their values: the first start is near
 * zero, the others have random signs and sizes from 1e-4 to 100 times the scales. */
static bgc_status search(const bgc_model *m, bgc_data *d, double t, double *x) {
    const int n = d->n_block;
    const size_t size = (size_t)m->n_state * sizeof *x;
    double *y = d->block_search, *scale = y + n;
    block_at at = {m, d, t};
    const bgc_dense_system block = {n, block_residual, block_matrix, &at, scale + n};
    uint64_t seed = 1;

    if (n > BGC_MAX_SEARCHED) {
        return BGC_INCONSISTENT;
    }
    for (int attempt = 0; attempt < MAX_SEARCH; attempt++) {
        for (int k = 0; k < n; k++) {
            const double sign = next_number(&seed), part = next_number(&seed);
            scale[k] = d->scale[d->block[k]];
            y[k] = attempt == 0 ? (k % 2 == 0 ? perturbation : -0.7 * perturbation)
                                : copysign(pow(10.0, 3.0 * part - 1.0), sign);
            y[k] *= scale[k];
        }
        for (int method = 0; method < 2; method++) {
            memcpy(x, d->start, size);
            memcpy(d->homotopy, d->start, size);
            if (method == 1 && !bgc_least_squares(&block, y, scale)) {
                break;
            }
            for (int k = 0; k < n; k++) {
                x[d->block[k]] = y[k];
            }
            if (newton(m, d, t, 0.0, x) == BGC_OK) {
                return BGC_OK;
            }
        }
    }
    return BGC_INCONSISTENT;
}

/* Attempts by Newton's method alone, with the homotopy, and from other starts; every second one of
 * the first is perturbed. */
enum { NEWTON_ATTEMPTS = 2, NEAR_ATTEMPTS = 4, ALL_ATTEMPTS = 5 };

/* The state of the block whose equation is farthest from satisfied at x, relative to the terms that
 * its derivatives give. */
static int worst_row(const bgc_model *m, bgc_data *d, double t, const double *x) {
    const int n = d->n_block;
    double largest = -1.0;
    int worst = -1;

    (void)residual_at(m, d, t, x, 0.0, d->change);
    bgc_differentiate(m, d, t, x, d->block_jac, d->residual);
    assemble_block(m, d, d->block_jac, -1.0, d->block_lu);
    for (int i = 0; i < n; i++) {
        double terms = 0.0, size;
        for (int j = 0; j < n; j++) {
            const int state = d->block[j];
            terms += fabs(d->block_lu[i * n + j]) * fmax(fabs(x[state]), d->scale[state]);
        }
        size = fabs(d->change[i]) / (terms > 0.0 ? terms : 1.0);
        if (!isfinite(size) || size > largest) {
            worst = d->block[i];
            largest = isfinite(size) ? size : (double)INFINITY;
        }
    }
    return worst;
}

/* Solves the algebraic equations at t for the block's states in x, from the values it has.
 * BGC_SINGULAR where they do not determine the states, BGC_INCONSISTENT where no solution is found:
 * then x does not change. */
static bgc_status satisfy(const bgc_model *m, bgc_data *d, double t, double *x, int from, int attempts) {
    const size_t size = (size_t)m->n_state * sizeof *x;
    bgc_status first = BGC_OK;

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    memcpy(d->start, x, size);
    for (int attempt = from; attempt < attempts; attempt++) {
        bgc_status status;
        if (attempt % 2 == 1) {
            perturb(d, x);
        }
        status = attempt < NEWTON_ATTEMPTS  ? newton(m, d, t, 0.0, x)
                 : attempt < NEAR_ATTEMPTS ? follow_homotopy(m, d, t, x)
                                           : search(m, d, t, x);
        if (status == BGC_OK) {
            d->core.failed_state = -1;
            return BGC_OK;
        }
        first = attempt == from ? status : first;
        memcpy(x, d->start, size);
    }
    if (first != BGC_SINGULAR) {
        d->core.failed_state = worst_row(m, d, t, x);
        return BGC_INCONSISTENT;
    }
    return BGC_SINGULAR;
}

/* Within a run, where the present values are near a solution. */
bgc_status bgc_satisfy(const bgc_model *m, bgc_data *d, double t, double *x) {
    return satisfy(m, d, t, x, 0, NEWTON_ATTEMPTS);
}

/* The same from perturbed values alone: at the present ones a law has no finite slope. */
bgc_status bgc_satisfy_beside(const bgc_model *m, bgc_data *d, double t, double *x) {
    return satisfy(m, d, t, x, 1, NEWTON_ATTEMPTS);
}

/* --- calls of a run ------------------------------------------------------------------------ */

/* Solves the algebraic equations at the present t and u for the block's states in d->x. Where no
 * solution is found, d->x does not change. */
bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d) {
    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    d->core.f_valid = d->core.jac_valid = d->core.held = 0;
    return satisfy(m, d, d->core.t, d->x, 0, ALL_ATTEMPTS);
}
