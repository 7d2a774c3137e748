/* consistent.c: states without a rate of their own put on their equations.
 *
 * Rows of M that are empty are algebraic equations. The states that are free to satisfy them are
 * those whose columns of M are empty too, and those that M ties to such a row or column: the block.
 * Of these, M times the change has to vanish. Everything else is held.
 *
 * Newton's method with the block's own part of the Jacobian, damped by the natural monotonicity
 * test, which no scaling of the equations changes: P. Deuflhard, Newton Methods for Nonlinear
 * Problems, 3.3. Where it gets stuck, the equations are deformed from ones that hold at the start.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_ITERATIONS = 100, MAX_STAGES = 60 };
static const double least_damping = 1e-6;
static const double solved = 1e-9;      /* last correction, over what the states amount to */
static const double well_within = 1e-3; /* one within tolerance by so much is as good as it gets */
static const double left_alone = 1e-3;  /* correction after a fixed step, over scale plus size */
static const double unbent = 1e-5;      /* one that says nothing of the step's length, over these */
static const double bent = 0.03;        /* any other, over how far the state went in the step */
static const double small = 0.1;        /* correction after an adaptive step, over the tolerance */
static const double too_much = 100.0;   /* so much more than that: the step was too long */
static const double near = 1e-5;        /* a correction, over what the states have been */
static const double aside = 1e-2;       /* a second start, over scale or size */
static const double negligible = 1e-9;  /* of a state's scale: smaller values are measured by that */

/* --- what there is to solve ---------------------------------------------------------------- */

/* Which rows of M are empty, which states are free for them, and 1 / m_ii of the others. */
void bgc_classify_states(const bgc_model *m, bgc_data *d) {
    const int n = m->n_state;
    int changed = 1, size = 0;

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

    /* What M ties to a state of the block belongs to it. */
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
    d->n_block = 0;
    for (int i = 0; i < n; i++) {
        if (d->place[i] == 0) {
            d->block[d->n_block] = i;
            d->place[i] = d->n_block++;
        }
    }
}

/* --- the block's linear algebra ------------------------------------------------------------ */

/* The algebraic rows of f at (t, x), less `part` of those in d->first, to `residual` in the order
 * of the block; whether all are finite. In the other rows it is what M (x - d->start) lacks to
 * zero: a second start is not on it. */
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

/* Factorises what a change of the block's states does: M where it is not empty, else -J. */
static bgc_status factorise_block(const bgc_model *m, bgc_data *d, const double *jac) {
    const size_t n = (size_t)d->n_block;
    double *a = d->block_lu;
    int bad;

    memset(a, 0, n * n * sizeof *a);
    for (int k = 0; k < m->n_mass; k++) {
        const int i = d->place[m->mass_row[k]], j = d->place[m->mass_col[k]];
        if (i >= 0 && j >= 0) {
            a[(size_t)i * n + (size_t)j] += d->mass[k];
        }
    }
    for (int k = 0; k < m->n_jac; k++) {
        const int i = d->place[m->jac_row[k]], j = d->place[m->jac_col[k]];
        if (i >= 0 && j >= 0 && d->algebraic[m->jac_row[k]] != 0.0) {
            a[(size_t)i * n + (size_t)j] -= jac[k];
        }
    }
    if (bgc_first_bad((int)(n * n), a) >= 0) {
        return BGC_NOT_FINITE;
    }
    bad = bgc_factorise_dense((int)n, a, d->block_pivot, d->magnitude);
    if (bad >= 0) {
        d->core.failed_state = d->block[bad];
        return BGC_SINGULAR;
    }
    return BGC_OK;
}

static bgc_status refresh_block(const bgc_model *m, bgc_data *d, double t, const double *x) {
    m->jacobian(d->h, t, x, d->u, d->block_jac, d->residual, d->work);
    d->core.counts.jacobians++;
    return factorise_block(m, d, d->block_jac);
}

/* Root mean square of a correction over the sizes of the states. */
static double size_of(const bgc_data *d, const double *change, const double *sizes) {
    double sum = 0.0;

    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        const double r = change[k] / fmax(fabs(sizes[i]), negligible * d->scale[i]);
        sum += r * r;
    }
    return sqrt(sum / d->n_block);
}

/* Whether a correction is within the tolerances by so much. */
static int is_within(const bgc_data *d, const double *change, const double *x, double part) {
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        if (!(fabs(change[k]) <= part * bgc_tolerance(d, i, fabs(x[i])))) {
            return 0;
        }
    }
    return 1;
}

/* to = x, moved by a part of a correction. */
static void move(const bgc_model *m, const bgc_data *d, const double *x, double part,
                 const double *change, double *to) {
    if (to != x) {
        memcpy(to, x, (size_t)m->n_state * sizeof *to);
    }
    for (int k = 0; k < d->n_block; k++) {
        to[d->block[k]] += part * change[k];
    }
}

/* --- Newton's method ----------------------------------------------------------------------- */

/* Moves x by as much of d->change as makes the next correction smaller; by how much it does, or
 * negative where no part does. */
static double correct(const bgc_model *m, bgc_data *d, double t, double part, double *x,
                      double *damping) {
    const double length = size_of(d, d->change, x);

    for (; *damping >= least_damping; *damping *= 0.5) {
        double ratio;
        move(m, d, x, *damping, d->change, d->trial);
        if (!residual_at(m, d, t, d->trial, part, d->next_change)) {
            continue;
        }
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, d->next_change);
        ratio = size_of(d, d->next_change, x) / length;
        if (ratio <= 1.0 - 0.25 * *damping) {
            memcpy(x, d->trial, (size_t)m->n_state * sizeof *x);
            return ratio;
        }
    }
    return -1.0;
}

/* Solves the algebraic rows, less a part of those in d->first, for the block's states in x. x is
 * spoilt where that fails. */
static bgc_status newton(const bgc_model *m, bgc_data *d, double t, double part, double *x) {
    double damping = 1.0;
    int slow = 0;

    memcpy(d->largest, x, (size_t)m->n_state * sizeof *x);
    for (int k = 0; k < MAX_ITERATIONS; k++) {
        bgc_status status;
        double shrunk;
        if (!residual_at(m, d, t, x, part, d->change)) {
            return BGC_INCONSISTENT;
        }
        status = refresh_block(m, d, t, x);
        if (status != BGC_OK) {
            return status;
        }
        bgc_solve_dense(d->n_block, d->block_lu, d->block_pivot, d->change);
        if (bgc_first_bad(d->n_block, d->change) >= 0) {
            return BGC_INCONSISTENT;
        }
        if (size_of(d, d->change, x) <= solved) {
            move(m, d, x, 1.0, d->change, x);
            return BGC_OK;
        }
        shrunk = correct(m, d, t, part, x, &damping);
        if (shrunk < 0.0) {
            break;
        }
        for (int j = 0; j < d->n_block; j++) {
            const int i = d->block[j];
            d->largest[i] = fmax(fabs(d->largest[i]), fabs(x[i]));
        }

        /* Near a solution corrections shrink ever faster, unless it is a double one. */
        slow = damping == 1.0 && shrunk > 0.1 && size_of(d, d->change, d->largest) < near
                   ? slow + 1 : 0;
        if (slow == 3) {
            return BGC_INCONSISTENT;
        }
        damping = fmin(1.0, shrunk < 0.5 ? 4.0 * damping : 2.0 * damping);
    }
    return is_within(d, d->change, x, well_within) ? BGC_OK : BGC_INCONSISTENT;
}

/* Goes from equations that x satisfies to those of the model: g(y) - (1 - s) g(x) = 0 for s from
 * 0 to 1, in steps as long as Newton's method follows. */
static bgc_status deform(const bgc_model *m, bgc_data *d, double t, double *x) {
    const size_t size = (size_t)m->n_state * sizeof *x;
    double done = 0.0, stride = 0.1;
    bgc_status status = BGC_INCONSISTENT;

    if (!residual_at(m, d, t, x, 0.0, d->first)) {
        return BGC_INCONSISTENT;
    }
    for (int k = 0; k < MAX_STAGES && done < 1.0; k++) {
        const double next = fmin(1.0, done + stride);
        memcpy(d->deformed, x, size);
        status = newton(m, d, t, 1.0 - next, d->deformed);
        if (status == BGC_OK) {
            memcpy(x, d->deformed, size);
            done = next;
            stride *= 2.0;
        } else {
            stride *= 0.25;
        }
    }
    return done < 1.0 && status == BGC_OK ? BGC_INCONSISTENT : status;
}

/* Leaves a point where a law may have no slope, as `f*abs(f)` has none at 0. */
static void nudge(const bgc_data *d, double *x) {
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        x[i] += (k % 2 == 0 ? aside : -0.7 * aside) * fmax(fabs(x[i]), d->scale[i]);
    }
}

enum { FROM_HERE = 2, FROM_AFAR = 4 }; /* attempts: by Newton's method, also by deformation */

/* Puts x on its algebraic equations at t, from the values it has. BGC_SINGULAR if the equations do
 * not determine the states, and BGC_INCONSISTENT where no solution is found from here: x is then
 * as it was. */
static bgc_status satisfy(const bgc_model *m, bgc_data *d, double t, double *x, int attempts) {
    const size_t size = (size_t)m->n_state * sizeof *x;
    bgc_status first = BGC_OK;

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    memcpy(d->start, x, size);
    for (int attempt = 0; attempt < attempts; attempt++) {
        bgc_status status;
        if (attempt % 2 == 1) {
            nudge(d, x);
        }
        status = attempt < FROM_HERE ? newton(m, d, t, 0.0, x) : deform(m, d, t, x);
        if (status == BGC_OK) {
            d->core.failed_state = -1;
            return BGC_OK;
        }
        first = attempt == 0 ? status : first;
        memcpy(x, d->start, size);
    }
    return first == BGC_SINGULAR ? BGC_SINGULAR : BGC_INCONSISTENT;
}

/* The same within a run, where a solution is near or lost. */
bgc_status bgc_satisfy(const bgc_model *m, bgc_data *d, double t, double *x) {
    return satisfy(m, d, t, x, FROM_HERE);
}

/* --- when ---------------------------------------------------------------------------------- */

/* Puts d->x on its algebraic equations at the present t and u. Where no solution is found from
 * here, x is as it was. */
bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d) {
    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    d->core.f_valid = d->core.jac_valid = d->core.held = 0;
    return satisfy(m, d, d->core.t, d->x, FROM_AFAR);
}

/* How far the step to d->next missed the algebraic rows, whose f is in d->error. */
typedef struct {
    double excess; /* the largest correction over what may be left alone */
    double bend;   /* the largest that is not negligible, over how far its state went in the step */
    int at_fault;  /* the state with that excess */
} distance;

/* By the correction that the step's own factorisation gives. */
static bgc_status measure(const bgc_model *m, bgc_data *d, int fixed, distance *found) {
    bgc_status status;

    for (int i = 0; i < m->n_state; i++) {
        d->right[i] = d->algebraic[i] != 0.0 ? d->error[i] : 0.0;
    }
    d->core.failed_state = bgc_first_bad(m->n_state, d->right);
    if (d->core.failed_state >= 0) {
        return BGC_NOT_FINITE;
    }
    status = bgc_solve(m, d, d->right);
    *found = (distance){0.0, 0.0, -1};
    for (int k = 0; k < d->n_block; k++) {
        const int i = d->block[k];
        const double size = fabs(d->next[i]), change = fabs(d->right[i]);
        const double allowed =
            fixed ? left_alone * (d->scale[i] + size) : small * bgc_tolerance(d, i, size);
        if (change > found->excess * allowed || isnan(change)) { /* a NaN stays */
            found->excess = change / allowed;
            found->at_fault = i;
        }
        if (change > unbent * (d->scale[i] + size)) {
            found->bend = fmax(found->bend, change / fabs(d->next[i] - d->x[i]));
        }
    }
    return status;
}

/* After a step to d->next: the algebraic rows there. What a linearly implicit method misses by
 * little is its error, and is left to the next step, which takes it up. Where the states without a
 * rate did not go where one linear iteration sends them, the step was too long; otherwise, and if it
 * cannot be shorter, d->next is corrected, or refused. Other methods leave these rows to this. */
bgc_status bgc_keep_consistent(const bgc_model *m, bgc_data *d, const bgc_method *method,
                               double t) {
    const int fixed = !bgc_is_adaptive(method);
    distance found = {0.0, 0.0, -1};

    if (d->core.algebraic == 0) {
        return BGC_OK;
    }
    if (method->family->rows == BGC_ROWS_NEARLY) {
        bgc_status status;
        m->rhs(d->h, t, d->next, d->u, d->error, d->work);
        d->core.counts.rhs++;
        status = measure(m, d, fixed, &found);
        if (status != BGC_OK) {
            return status;
        }
        if (fixed ? found.bend > bent && d->core.halvings < BGC_MAX_HALVINGS
                  : found.excess > too_much) {
            d->core.coarse = 1;
            return BGC_OK;
        }
        if (found.excess <= 1.0) {
            d->core.f_ahead = 1;
            return BGC_OK;
        }
    }
    if (bgc_satisfy(m, d, t, d->next) != BGC_OK) {
        d->core.failed_state = found.at_fault >= 0 ? found.at_fault : d->core.failed_state;
        return BGC_INCONSISTENT;
    }
    return BGC_OK;
}
