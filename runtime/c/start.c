/* start.c: initial values without a closed form, by Newton's method; and whether given values hold.
 *
 * The compiler has solved the equations with the parameters at their defaults. From that solution
 * s0, Newton's method with the natural monotonicity test (Deuflhard 1974) solves them for the present
 * parameters; where it fails, the homotopy r(s) - (1 - c) r(s0) = 0 is followed from c = 0 to 1.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_START_ITERATIONS = 60, MAX_START_STRIDES = 200 };

static const double start_converged = 1e-9;       /* correction, relative to the unknowns */
static const double start_floor = 1e-9;      /* of an unknown, for the relative correction */
static const double start_rounding = 64.0;        /* roundings in a residual */
static const double least_start_damping = 1e-8;
static const double least_start_stride = 1e-6;    /* of the homotopy */
static const double missed_part = 1e-6;           /* of a given value: less is rounding */
static const double rounded_part = 1e-3;          /* the same of a value that counts as rounded */
static const double missed_in_rounded_chain = 1e-2; /* the same where its positions were moved */
static const double moved_position = 1e-9;        /* of a closed chain, m or rad */
static const double part_of_state = 1e-9;         /* within which a start is the one that is given */
static const double part_of_scale = 1e-10;

/* Root mean square of a correction relative to the unknowns in `sizes`. */
static double start_norm(int n, const double *change, const double *sizes) {
    double sum = 0.0;

    for (int k = 0; k < n; k++) {
        const double r = change[k] / fmax(fabs(sizes[k]), start_floor);
        sum += r * r;
    }
    return sqrt(sum / n);
}

/* The residual at s, less `part` of that at the start of the homotopy, with its Jacobian in
 * d->start_jac; returns whether all is finite. */
static int start_residual(const bgc_model *m, bgc_data *d, const double *s, double part, double *residual) {
    const int n = m->n_start;

    m->start(d->h, d->core.t, d->u, s, residual, d->start_jac, d->work);
    for (int k = 0; k < n; k++) {
        residual[k] -= part != 0.0 ? part * d->start_first[k] : 0.0;
    }
    return bgc_first_bad(n, residual) < 0 && bgc_first_bad(n * n, d->start_jac) < 0;
}

/* Whether each residual is within the rounding of its terms, |r| <= c eps |J| |s|: s then solves
 * equations that differ by rounding (Oettli and Prager 1964). Corrections of unknowns that are zero
 * but for rounding stop shrinking there. */
static int is_start_rounded(const bgc_data *d, int n, const double *s) {
    for (int i = 0; i < n; i++) {
        double terms = 0.0;
        for (int k = 0; k < n; k++) {
            terms += fabs(d->start_jac[i * n + k] * s[k]);
        }
        if (!(fabs(d->start_change[i]) <= start_rounding * DBL_EPSILON * terms)) {
            return 0;
        }
    }
    return 1;
}

/* s := s + damping * correction, to `to`. */
static void move_start(int n, const double *s, double damping, const double *change, double *to) {
    for (int k = 0; k < n; k++) {
        to[k] = s[k] - damping * change[k];
    }
}

/* Solves r(s) - part r(s0) = 0 from s, which it overwrites. Returns whether it succeeds. */
static int solve_start_from(const bgc_model *m, bgc_data *d, double part, double *s) {
    const int n = m->n_start;
    double damping = 1.0;

    for (int k = 0; k < MAX_START_ITERATIONS; k++) {
        double length;
        int is_rounded;

        /* Newton correction. */
        if (!start_residual(m, d, s, part, d->start_change)) {
            return 0;
        }
        is_rounded = is_start_rounded(d, n, s);
        memcpy(d->start_lu, d->start_jac, (size_t)n * (size_t)n * sizeof *d->start_lu);
        if (bgc_factorise_dense(n, d->start_lu, d->start_pivot, d->start_magnitude) >= 0) {
            return 0;
        }
        bgc_solve_dense(n, d->start_lu, d->start_pivot, d->start_change);
        if (bgc_first_bad(n, d->start_change) >= 0) {
            return 0;
        }
        length = start_norm(n, d->start_change, s);
        if (length <= start_converged || is_rounded) {
            move_start(n, s, 1.0, d->start_change, s);
            return 1;
        }

        /* The largest part of it after which the next correction, by the same factors, is shorter. */
        for (;; damping *= 0.5) {
            if (damping < least_start_damping) {
                return 0;
            }
            move_start(n, s, damping, d->start_change, d->start_trial);
            if (!start_residual(m, d, d->start_trial, part, d->start_next)) {
                continue;
            }
            bgc_solve_dense(n, d->start_lu, d->start_pivot, d->start_next);
            if (start_norm(n, d->start_next, s) <= (1.0 - 0.25 * damping) * length) {
                break;
            }
        }
        memcpy(s, d->start_trial, (size_t)n * sizeof *s);
        damping = fmin(1.0, 4.0 * damping);
    }
    return 0;
}

/* Follows the homotopy from s0 in strides as long as Newton's method converges. */
static int follow_start(const bgc_model *m, bgc_data *d, double *s) {
    const size_t size = (size_t)m->n_start * sizeof *s;
    double reached = 0.0, stride = 0.1;

    if (!start_residual(m, d, s, 0.0, d->start_first)) {
        return 0;
    }
    for (int k = 0; k < MAX_START_STRIDES && reached < 1.0 && stride > least_start_stride; k++) {
        const double next = fmin(1.0, reached + stride);
        memcpy(d->start_from, s, size);
        if (solve_start_from(m, d, 1.0 - next, d->start_from)) {
            memcpy(s, d->start_from, size);
            reached = next;
            stride *= 2.0;
        } else {
            stride *= 0.25;
        }
    }
    return reached >= 1.0;
}

/* Solves the equations of the start at the present t and u, and sets the states that follow. */
bgc_status bgc_solve_start(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_start * sizeof *d->start_at;

    if (m->n_start == 0) {
        return BGC_OK;
    }
    memcpy(d->start_at, m->start_guess, size);
    if (!solve_start_from(m, d, 0.0, d->start_at)) {
        memcpy(d->start_at, m->start_guess, size);
        if (!follow_start(m, d, d->start_at)) {
            d->core.failed_parameter = m->n_param + m->n_check;
            return BGC_BAD_PARAMETER;
        }
    }
    m->started(d->h, d->core.t, d->u, d->start_at, d->x, d->work);
    return BGC_OK;
}

/* By how much given value k is missed at a state, which is evaluated. */
static double missed_at(const bgc_model *m, bgc_data *d, const double *x, int k) {
    m->given(d->h, d->core.t, x, d->u, d->check, d->work);
    return d->check[2 * k] - d->check[2 * k + 1];
}

/* By how much value k changes where each state changes by its rounding, which is more in a chain that
 * was closed by moving positions. d->start is scratch. */
static double rounding_of_given(const bgc_model *m, bgc_data *d, int k, const double *moves) {
    const double missed = missed_at(m, d, d->x, k);
    double sum = 0.0;

    memcpy(d->start, d->x, (size_t)m->n_state * sizeof *d->start);
    for (int i = 0; i < m->n_state; i++) {
        d->start[i] += part_of_state * fabs(d->x[i]) + part_of_scale * d->scale[i] + moves[i];
        sum += fabs(missed_at(m, d, d->start, k) - missed);
        d->start[i] = d->x[i];
    }
    return sum;
}

/* After a reset: whether the values that the user gives hold at the start. A value that is missed is
 * one that no state has within the rounding of this one. d->next and d->start are scratch. */
bgc_status bgc_check_given(const bgc_model *m, bgc_data *d) {
    double part = missed_part, *moves = d->next;

    if (m->n_given == 0) {
        return BGC_OK;
    }

    /* Positions that close a chain differ from their given values by the rounding of these. */
    bgc_closing_moves(m, d, moves);
    for (int i = 0; i < m->n_state; i++) {
        part = fabs(moves[i]) > moved_position ? missed_in_rounded_chain : part;
    }

    for (int k = 0; k < m->n_given; k++) {
        const double missed = fabs(missed_at(m, d, d->x, k));
        const double value = d->check[2 * k], wanted = d->check[2 * k + 1];

        const int kind = m->given_kind[k];
        const double allowed = kind == BGC_GIVEN_ROUNDED ? fmax(part, rounded_part) : part;

        if ((kind == BGC_GIVEN_BY_DEFAULT && wanted == 0.0) ||
            missed <= allowed * fmax(fabs(value), fabs(wanted))) {
            continue;
        }
        if (!(missed <= rounding_of_given(m, d, k, moves))) {
            d->core.failed_parameter = m->n_param + m->n_check + 1 + k;
            return BGC_BAD_PARAMETER;
        }
    }
    return BGC_OK;
}
