/* closed_start.c: the start of closed chains of rigid connections.
 *
 * Initial values seldom close a chain to the last digit, and often only some of them are given. The
 * others take the values that close it, by damped Gauss-Newton steps of least length.
 */
#include "closures.h"

#include <math.h>
#include <string.h>

enum { MAX_CLOSING = 100 };
static const double closed_gap = 1e-9; /* of a condition: m, rad */
static const double closed_flow = 1e-12; /* the last change of a momentum, relative to scale plus state */
static const double redundant_gap = 3e-6; /* of conditions that follow from others, but for rounded data */
static const double first_damping = 1e-2; /* of the normal equations at the start, to their trace */
static const double least_of_damping = 1e-4; /* after a step that did not help */
static const double rounding_of_start = 1e-3; /* m, rad: given values may be moved by this */

/* Sets the initial state from the parameters; d->next is scratch for the work of the kernel. */
static void set_start(const bgc_model *m, bgc_data *d) {
    if (m->defaults != NULL) {
        m->defaults(d->p, d->is_set, d->work);
    }
    m->prepare(d->p, d->h, d->work);
    m->initial(d->h, d->core.t, d->u, d->x, d->work);
}

/* The unknown k of the start: a parameter, or a state. */
static double *unknown_of(const bgc_model *m, bgc_data *d, int by_parameters, int k) {
    const bgc_closure_info *c = m->closure_info;

    return by_parameters ? d->p + c->start[k] : d->x + c->moved[k];
}

/* Adds part * change to the unknowns of the start. */
static void move_closed_start(const bgc_model *m, bgc_data *d, int by_parameters, double part,
                              const double *change) {
    const bgc_closure_info *c = m->closure_info;
    const int width = by_parameters ? c->n_start : c->n_moved;

    for (int k = 0; k < width; k++) {
        *unknown_of(m, d, by_parameters, k) += part * change[k];
    }
    if (by_parameters) {
        set_start(m, d);
    }
}

/* Euclidean norm of the n conditions in `list`. */
static double misfit_of(const bgc_chain_parts *p, int n, const int *list) {
    double sum = 0.0;

    for (int i = 0; i < n; i++) {
        sum += p->condition[list[i]] * p->condition[list[i]];
    }
    return sqrt(sum);
}

/* The derivatives of the conditions by parameters, in p->table: those by states, times those of
 * states by parameters. Parameters that are set stay. */
static void slopes_by_parameters(const bgc_closure_info *c, const bgc_data *d, bgc_chain_parts *p) {
    for (int j = 0; j < c->n_condition; j++) {
        for (int k = 0; k < c->n_start; k++) {
            double sum = 0.0;
            for (int l = 0; l < c->n_moved; l++) {
                sum += p->by_place[j * c->n_moved + l] * p->by_start[l * c->n_start + k];
            }
            p->table[j * c->n_start + k] = d->is_set[c->start[k]] ? 0.0 : sum;
        }
    }
}

/* Moves the parameters that may close the start, or (by_parameters 0) the states themselves, by damped
 * Gauss-Newton steps of least length (Levenberg, Marquardt). Returns whether the conditions hold. */
static int find_start(const bgc_model *m, bgc_data *d, int by_parameters, bgc_chain_parts *p) {
    const bgc_closure_info *c = m->closure_info;
    const int width = by_parameters ? c->n_start : c->n_moved;
    const int n = bgc_list_conditions(m, d);
    double damping = first_damping;

    if (!bgc_evaluate_chains(m, d, d->core.t, d->x, p)) {
        return 0;
    }
    for (int i = 0; i < MAX_CLOSING && damping < 1e6; i++) {
        const double misfit = misfit_of(p, n, d->closing_list);
        int worst = 0;

        if (bgc_chain_gap(p, n, d->closing_list, &worst) <= 0.1 * closed_gap) {
            return 1;
        }
        if (by_parameters) {
            slopes_by_parameters(c, d, p);
        }
        if (!bgc_least_chain_change(d, n, by_parameters ? p->table : p->by_place, width, damping, p)) {
            return 0;
        }

        /* Take the step if it brings the conditions nearer, else damp more. */
        move_closed_start(m, d, by_parameters, 1.0, p->change);
        if (bgc_evaluate_chains(m, d, d->core.t, d->x, p) &&
            misfit_of(p, n, d->closing_list) < misfit) {
            damping *= 0.1;
        } else {
            move_closed_start(m, d, by_parameters, -1.0, p->change);
            damping = fmax(4.0 * damping, least_of_damping);
            if (!bgc_evaluate_chains(m, d, d->core.t, d->x, p)) {
                return 0;
            }
        }
    }
    return 0;
}

/* The declared start: defaults where nothing is set. */
static void declare_start(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;

    for (int k = 0; k < c->n_start; k++) {
        if (!d->is_set[c->start[k]]) {
            d->p[c->start[k]] = m->param[c->start[k]].value;
        }
    }
    set_start(m, d);
}

/* At reset: closes the start in d->x. Parameters that give the start of a state, and that nothing
 * sets, take the values that close it; else given values are moved, by no more than their rounding. */
bgc_status bgc_close_start(const bgc_model *m, bgc_data *d) {
    const bgc_closure_info *c = m->closure_info;
    double moved = 0.0;
    int worst = 0;
    bgc_chain_parts p;

    if (c == NULL || c->n_all_conditions == 0) {
        return BGC_OK;
    }
    declare_start(m, d);
    if (!bgc_evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    if (bgc_chain_gap(&p, bgc_list_conditions(m, d), d->closing_list, &worst) > closed_gap &&
        (c->n_start == 0 || !find_start(m, d, 1, &p))) {
        declare_start(m, d);
        memcpy(d->start, d->x, (size_t)m->n_state * sizeof *d->x);
        d->core.failed_chain = worst;
        if (!find_start(m, d, 0, &p)) {
            return BGC_OPEN_CHAIN;
        }
        for (int k = 0; k < c->n_moved; k++) {
            moved = fmax(moved, fabs(d->x[c->moved[k]] - d->start[c->moved[k]]));
        }
        if (moved > rounding_of_start) {
            return BGC_OPEN_CHAIN;
        }
    }

    /* The conditions that follow from the others for the parameters' defaults. */
    if (!bgc_evaluate_chains(m, d, d->core.t, d->x, &p)) {
        return BGC_NOT_FINITE;
    }
    if (bgc_chain_gap(&p, c->n_all_conditions, NULL, &worst) > redundant_gap) {
        d->core.failed_chain = worst;
        return BGC_OPEN_CHAIN;
    }
    return BGC_OK;
}

/* d->start is scratch. */
void bgc_closing_moves(const bgc_model *m, bgc_data *d, double *move) {
    const bgc_closure_info *c = m->closure_info;

    m->initial(d->h, d->core.t, d->u, d->start, d->work);
    memset(move, 0, (size_t)m->n_state * sizeof *move);
    for (int k = 0; c != NULL && k < c->n_moved; k++) {
        move[c->moved[k]] = d->x[c->moved[k]] - d->start[c->moved[k]];
    }
}

/* Projects the start onto the closed chains, repeatedly: momenta of laws that are not linear follow from
 * the flows by Newton's method. */
bgc_status bgc_close_chains_at_start(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_state * sizeof *d->x;
    bgc_status status = BGC_OK;

    if (m->closure_info == NULL) {
        return BGC_OK;
    }
    for (int i = 0; i < MAX_CLOSING && status == BGC_OK; i++) {
        int moves = 0;
        memcpy(d->start, d->x, size);
        status = bgc_close_chains(m, d, d->core.t, d->x);
        for (int k = 0; k < m->closure_info->n_impulse; k++) {
            const int state = m->closure_info->impulse[k];
            const double change = fabs(d->x[state] - d->start[state]);
            moves |= change > closed_flow * (d->scale[state] + fabs(d->x[state]));
        }
        if (!moves) {
            break;
        }
    }
    return status;
}
