/* fmi_present.c: what holds at the time of the importer: algebraic states, rates, event indicators. */
#include "fmi.h"
#include "switches.h"

static const double hysteresis = 64.0 * DBL_EPSILON; /* relative to the largest argument */
enum { MOST_CORRECTIONS = 8 };

/* --- algebraic equations ----------------------------------------------------------------------- */

/* Solves with i->matrix, which is overwritten as right is. */
bgc_fmi_status bgc_fmi_solve_matrix(bgc_fmi *i, double *right) {
    const int n = i->m->n_state;
    const int bad = bgc_factorise_dense(n, i->matrix, i->pivot, i->d->magnitude);

    if (bad >= 0) {
        i->d->core.failed_state = bad;
        return bgc_fmi_explain(i, BGC_FMI_ERROR, BGC_SINGULAR);
    }
    bgc_solve_dense(n, i->matrix, i->pivot, right);
    return BGC_FMI_OK;
}

/* Solves with g_z, or its transpose, in the rows and columns of the states that are not free: right is
 * overwritten; entries of free states are zero. i->partial holds df/dx. */
bgc_fmi_status bgc_fmi_solve_algebraic(bgc_fmi *i, double *right, int transposed) {
    const int n = i->m->n_state;

    memset(i->matrix, 0, (size_t)n * (size_t)n * sizeof *i->matrix);
    for (int e = 0; e < i->n_partial; e++) {
        const int row = i->partial_row[e], column = i->partial_col[e];
        if (row < n && column < n && !bgc_fmi_is_free(i, row) && !bgc_fmi_is_free(i, column)) {
            const int r = transposed ? column : row, c = transposed ? row : column;
            i->matrix[(size_t)r * (size_t)n + (size_t)c] = i->partial[e];
        }
    }
    for (int k = 0; k < n; k++) {
        if (bgc_fmi_is_free(i, k)) {
            i->matrix[(size_t)k * (size_t)(n + 1)] = 1.0;
            right[k] = 0.0;
        }
    }
    return bgc_fmi_solve_matrix(i, right);
}

/* One correction by Newton's method of the states that are not free; returns its size, the largest over the
 * tolerance of a state, or INFINITY where it is undefined. */
static double correct_states(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    double *change = i->result, size = 0.0;

    m->rhs(d->h, d->core.t, d->x, d->u, change, d->work);
    bgc_differentiate(m, d, d->core.t, d->x, i->partial, d->dfdt);
    d->core.jac_valid = 0;
    memset(i->partial + m->n_jac, 0, (size_t)(i->n_partial - m->n_jac) * sizeof *i->partial);
    if (bgc_first_bad(m->n_state, change) >= 0 || bgc_first_bad(m->n_jac, i->partial) >= 0 ||
        bgc_fmi_solve_algebraic(i, change, 0) != BGC_FMI_OK || bgc_first_bad(m->n_state, change) >= 0) {
        return (double)INFINITY;
    }
    for (int k = 0; k < m->n_state; k++) {
        d->x[k] -= change[k];
        size = fmax(size, fabs(change[k]) / bgc_tolerance(d, k, fabs(d->x[k])));
    }
    return size;
}

/* Newton's method up to a part of the tolerances: rounding keeps a state near zero from converging relative
 * to itself, as the runtime has it. */
static int is_nearly_satisfied(bgc_fmi *i) {
    for (int k = 0; k < MOST_CORRECTIONS; k++) {
        const double size = correct_states(i);
        if (size <= bgc_fmi_allowed_drift) {
            return 1;
        }
        if (isinf(size)) {
            return 0;
        }
    }
    return 0;
}

/* Solves the algebraic equations for the states that are not free: at the present modes, or, where these
 * have no solution there, with every operation evaluated. The importer tries times beyond an event. */
static bgc_status solve_algebraic_states(bgc_fmi *i) {
    bgc_data *d = i->d;
    const size_t size = (size_t)i->m->n_state * sizeof *d->x;
    bgc_status status;

    memcpy(i->seed, d->x, size);
    status = bgc_satisfy(i->m, d, d->core.t, d->x);
    if (status != BGC_OK) {
        memcpy(d->x, i->seed, size);
        if (is_nearly_satisfied(i)) {
            return BGC_OK;
        }
    }
    if (status != BGC_OK && i->m->n_switch > 0) {
        bgc_release_modes(i->m, d);
        status = bgc_satisfy(i->m, d, d->core.t, d->x);
        bgc_hold_modes(i->m, d);
    }
    return status;
}

bgc_fmi_status bgc_fmi_satisfy(bgc_fmi *i) {
    bgc_data *d = i->d;
    bgc_status status;

    if (i->core.satisfied) {
        return BGC_FMI_OK;
    }
    i->core.has_row = 0;
    d->core.f_valid = d->core.jac_valid = 0;
    if (d->core.algebraic > 0 && i->info->n_free < i->m->n_state) {
        status = solve_algebraic_states(i);
        if (status != BGC_OK) {
            return bgc_fmi_explain(i, BGC_FMI_DISCARD, status);
        }
    }
    i->core.satisfied = 1;
    return BGC_FMI_OK;
}

/* --- state and inputs --------------------------------------------------------------------------- */

/* Sets view_x and view_u to the state and the inputs, with modes, at core.t. */
bgc_fmi_status bgc_fmi_view(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    const size_t inputs = (size_t)m->n_input + (size_t)m->n_switch;

    if (i->kind == BGC_FMI_MODEL_EXCHANGE || !i->core.viewed) {
        const bgc_fmi_status status =
            i->core.started && i->kind == BGC_FMI_MODEL_EXCHANGE ? bgc_fmi_satisfy(i) : bgc_fmi_start(i);
        if (status != BGC_FMI_OK) {
            return status;
        }
        memcpy(i->view_x, d->x, (size_t)m->n_state * sizeof(double));
        if (i->kind == BGC_FMI_CO_SIMULATION) {
            bgc_find_modes(m, d);
            bgc_hold_modes(m, d);
        }
        memcpy(i->view_u, d->u, inputs * sizeof(double));
        if (i->kind == BGC_FMI_CO_SIMULATION) {
            bgc_release_modes(m, d);
        }
        i->core.viewed = 1;
        i->core.has_row = 0;
    }
    return BGC_FMI_OK;
}

/* --- rates and event indicators ---------------------------------------------------------------- */

/* The rates of the free states at the view: M r = f, without the rows and columns of the others. In
 * a model in which M couples the others too, with J r = -df/dt in the algebraic rows. */
bgc_fmi_status bgc_fmi_rates(bgc_fmi *i, double *rate) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    const int n = m->n_state, whole = i->info->n_free == n;
    int bad, coupled = 0;

    m->rhs(d->h, i->core.t, i->view_x, i->view_u, rate, d->work);
    if (m->n_switch > 0 && bgc_first_bad(n, rate) >= 0) { /* undefined beyond an event in held modes */
        for (int k = 0; k < m->n_switch; k++) {
            i->view_u[m->n_input + k] = (double)NAN;
        }
        m->rhs(d->h, i->core.t, i->view_x, i->view_u, rate, d->work);
    }
    for (int k = 0; k < n; k++) {
        const int skipped = !whole && d->algebraic[k] != 0.0;
        coupled |= d->inverse_mass[k] == 0.0 && !skipped;
    }
    if (coupled) {
        memset(i->matrix, 0, (size_t)n * (size_t)n * sizeof *i->matrix);
        for (int k = 0; k < m->n_mass; k++) {
            i->matrix[(size_t)m->mass_row[k] * (size_t)n + (size_t)m->mass_col[k]] += d->mass[k];
        }
        if (whole && d->core.algebraic > 0) {
            bgc_differentiate(m, d, i->core.t, i->view_x, i->partial, d->dfdt);
            d->core.jac_valid = 0;
        }
        for (int k = 0; k < m->n_jac && whole; k++) {
            if (d->algebraic[m->jac_row[k]] != 0.0) {
                i->matrix[(size_t)m->jac_row[k] * (size_t)n + (size_t)m->jac_col[k]] = i->partial[k];
            }
        }
        for (int k = 0; k < n; k++) {
            if (d->algebraic[k] != 0.0) {
                rate[k] = whole ? -d->dfdt[k] : 0.0;
                i->matrix[(size_t)k * (size_t)(n + 1)] += whole ? 0.0 : 1.0;
            }
        }
        bad = bgc_factorise_dense(n, i->matrix, i->pivot, d->magnitude);
        if (bad >= 0) {
            d->core.failed_state = bad;
            return bgc_fmi_explain(i, BGC_FMI_DISCARD, BGC_SINGULAR);
        }
        bgc_solve_dense(n, i->matrix, i->pivot, rate);
    } else {
        for (int k = 0; k < n; k++) {
            rate[k] *= d->inverse_mass[k];
        }
    }
    bad = bgc_first_bad(n, rate);
    if (bad >= 0) {
        d->core.failed_state = bad;
        return bgc_fmi_explain(i, BGC_FMI_DISCARD, BGC_NOT_FINITE);
    }
    return BGC_FMI_OK;
}

/* Whether the changes of switch k are time events, which no input moves. */
static int is_time_event(const bgc_fmi *i, int k) {
    return i->m->switch_info[k].timed && i->info->n_input == 0;
}

/* The indicator of switch k: positive while its mode lasts. */
static double indicator_of(const bgc_fmi *i, int k, double z) {
    const bgc_data *d = i->d;
    const double extent = fmax(d->extent[k], fabs(d->argument[k]));
    double depth;

    if (isnan(d->mode[k]) || isnan(z) || bgc_is_given_up(d, k) || is_time_event(i, k)) {
        return 1.0;
    }
    depth = bgc_depth_of(i->m, d, k, z) + fmax(hysteresis * extent, DBL_MIN);
    return i->m->n_jump > 0 && d->turned[k] != 0.0 ? depth + d->turned[k] : depth;
}

bgc_fmi_status bgc_fmi_indicators(bgc_fmi *i, double *z) {
    const bgc_model *m = i->m;
    const bgc_fmi_status status = m->n_switch > 0 ? bgc_fmi_view(i) : BGC_FMI_OK;

    if (m->n_switch > 0 && status == BGC_FMI_OK) {
        m->switches(i->d->h, i->core.t, i->view_x, i->view_u, i->d->probe, i->d->work);
        for (int k = 0; k < m->n_switch; k++) {
            z[k] = indicator_of(i, k, i->d->probe[k]);
        }
    }
    return status;
}
