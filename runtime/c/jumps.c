/* jumps.c: jumps of the states, `when condition { reset .. }`.
 *
 * The operations of a condition are switches, so the instant at which it becomes true is an event
 * (events.c). There the resets of all conditions that have become true are evaluated at the states before
 * the jump and applied together; then the algebraic equations are solved, and conditions that have become
 * true by that follow, until none does.
 *
 * The argument of a switch lies beyond its edge by rounding where its event is located. A jump that turns
 * it back, as the bounce of a ball does, therefore leaves the switch in its mode before the event: the
 * condition is false again at once, and the next event is found however short the bounce is. Otherwise a
 * bounce lower than that rounding would have no end, and the ball would fall through the floor.
 *
 * Jumps may follow each other in ever shorter intervals, whose sum is finite (Zeno's paradox). Where the
 * intervals sink to the resolution of time, the run ends with BGC_ENDLESS_JUMPS.
 */
#include "accounts.h"
#include "switches.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double quick = 1e-9;    /* interval between two jumps, relative to the time */
static const double last_places = 16.0; /* of an argument, in units of its last place */
enum { MOST_CLOSE_JUMPS = 20 };   /* that follow each other so quickly */

/* --- conditions ------------------------------------------------------------------------------ */

/* Evaluates the conditions in held modes. An undefined condition does not hold. */
static void evaluate_conditions(const bgc_model *m, bgc_data *d) {
    bgc_hold_modes(m, d);
    m->conditions(d->h, d->core.t, d->x, d->u, d->condition, d->work);
    for (int k = 0; k < m->n_jump; k++) {
        d->condition[k] = d->condition[k] != 0.0 && !isnan(d->condition[k]) ? 1.0 : 0.0;
    }
}

/* At the start of a run: a condition that holds has not become true. */
void bgc_reset_jumps(const bgc_model *m, bgc_data *d) {
    if (m->n_jump == 0) {
        return;
    }
    memset(d->turned, 0, (size_t)m->n_switch * sizeof *d->turned);
    bgc_find_modes(m, d);
    evaluate_conditions(m, d);
    bgc_release_modes(m, d);
    memcpy(d->holds, d->condition, (size_t)m->n_jump * sizeof *d->holds);
    for (int k = 0; k < m->n_jump; k++) {
        d->jumped_at[k] = -INFINITY;
        d->close_jumps[k] = 0.0;
    }
}

/* Leaves 1 in d->condition where a condition has become true; returns their number. */
static int find_rising(const bgc_model *m, bgc_data *d) {
    int count = 0;

    evaluate_conditions(m, d);
    for (int k = 0; k < m->n_jump; k++) {
        const double holds = d->condition[k];
        d->condition[k] = holds > d->holds[k] ? 1.0 : 0.0;
        d->holds[k] = holds;
        count += d->condition[k] != 0.0;
    }
    return count;
}

/* --- arguments that turn back ------------------------------------------------------------------ */

/* The rates of the states at the present to d->right: M r = f, and J r = -df/dt in rows without a rate.
 * Returns 0 where they are not determined. */
static int find_rates(const bgc_model *m, bgc_data *d) {
    const int n = m->n_state;

    m->rhs(d->h, d->core.t, d->x, d->u, d->right, d->work);
    d->core.counts.rhs++;
    if (m->n_mass == 0) {
        return bgc_first_bad(n, d->right) < 0;
    }
    bgc_differentiate(m, d, d->core.t, d->x, d->jac, d->dfdt);
    memset(d->dense_lu, 0, (size_t)n * (size_t)n * sizeof *d->dense_lu);
    for (int k = 0; k < m->n_mass; k++) {
        d->dense_lu[(size_t)m->mass_row[k] * (size_t)n + (size_t)m->mass_col[k]] = d->mass[k];
    }
    for (int k = 0; k < m->n_jac; k++) {
        if (d->algebraic[m->jac_row[k]] != 0.0) {
            d->dense_lu[(size_t)m->jac_row[k] * (size_t)n + (size_t)m->jac_col[k]] = d->jac[k];
        }
    }
    for (int i = 0; i < n; i++) {
        d->right[i] = d->algebraic[i] != 0.0 ? -d->dfdt[i] : d->right[i];
    }
    if (bgc_factorise_dense(n, d->dense_lu, d->pivot, d->magnitude) >= 0) {
        return 0;
    }
    bgc_solve_dense(n, d->dense_lu, d->pivot, d->right);
    return bgc_first_bad(n, d->right) < 0;
}

/* The rates of the arguments of the edges to d->edge_rate; 0 where they are not determined. */
static void find_edge_rates(const bgc_model *m, bgc_data *d) {
    memset(d->edge_rate, 0, (size_t)m->n_edge * sizeof *d->edge_rate);
    bgc_hold_modes(m, d);
    if (find_rates(m, d)) {
        m->edge_rates(d->h, d->core.t, d->x, d->u, d->right, d->edge_rate, d->work);
    }
    d->core.f_valid = d->core.jac_valid = 0;
}

/* Whether the argument of edge e moves into the range of `mode`; that of the mode 0 of a comparison is below
 * its edge. */
static int moves_into(const bgc_data *d, int e, double mode) {
    return mode != 0.0 ? d->edge_rate[e] > 0.0 : d->edge_rate[e] < 0.0;
}

static int is_comparison(const bgc_model *m, int k) {
    return m->switch_info[k].operation == BGC_ABOVE || m->switch_info[k].operation == BGC_NOT_BELOW;
}

/* At the start of a search for events. An argument that has come back is as any other; until then the
 * rounding by which it lies beyond its edge is not an event. */
static const double turned_back = 3.0; /* in d->ignored */

void bgc_ignore_turned(const bgc_model *m, bgc_data *d) {
    for (int e = 0; e < m->n_edge; e++) {
        const int k = m->edge_switch[e];
        if (d->turned[k] != 0.0 && bgc_depth_of(m, d, k, d->argument[k]) > 0.0) {
            d->turned[k] = 0.0;
        }
        d->ignored[k] = d->turned[k] != 0.0 ? turned_back : 0.0;
    }
}

/* With the arguments z at the start and the samples of a step: one that lies farther beyond its edge than
 * by rounding has left its mode. */
void bgc_judge_turned(const bgc_model *m, bgc_data *d, const double *const *z) {
    for (int e = 0; e < m->n_edge; e++) {
        const int k = m->edge_switch[e];
        for (int i = 1; i <= BGC_SAMPLES && d->ignored[k] == turned_back; i++) {
            d->ignored[k] = bgc_depth_of(m, d, k, z[i][k]) < -d->turned[k] ? 0.0 : turned_back;
        }
    }
}

static int last_jump(const bgc_model *m, const bgc_data *d) {
    int last = 0;

    for (int k = 1; k < m->n_jump; k++) {
        last = d->jumped_at[k] > d->jumped_at[last] ? k : last;
    }
    return last;
}

/* The distance by which the argument of switch k may lie beyond its edge without having left its mode. */
static double allowance_of(const bgc_model *m, const bgc_data *d, int k, double z) {
    return fmax(-bgc_depth_of(m, d, k, z), 0.0) +
           last_places * DBL_EPSILON * fmax(d->extent[k], DBL_MIN);
}

/* At an event, before the new modes are found. An argument beyond its edge that moves back has not left its
 * mode: it has turned in a jump, or the motion of a method of low order contradicts its own rate.
 * BGC_ENDLESS_JUMPS where a turned one has not come back within its mode: a bounce below rounding. */
bgc_status bgc_meet_edges(const bgc_model *m, bgc_data *d) {
    if (d->core.unreturned) {
        d->core.unreturned = 0;
        d->core.failed_jump = last_jump(m, d);
        return BGC_ENDLESS_JUMPS;
    }
    find_edge_rates(m, d);
    m->switches(d->h, d->core.t, d->x, d->u, d->argument, d->work);
    for (int e = 0; e < m->n_edge; e++) {
        const int k = m->edge_switch[e];
        if (is_comparison(m, k) && bgc_is_outside(m, d, k, d->argument[k])) {
            const int back = moves_into(d, e, d->mode[k]);
            d->turned[k] = back ? allowance_of(m, d, k, d->argument[k]) : 0.0;
        }
    }
    bgc_release_modes(m, d);
    return BGC_OK;
}

/* After the jumps of an event: switches that had left the modes `before` by motion, and whose arguments now
 * move back, return to them. */
static int turn_back(const bgc_model *m, bgc_data *d, const double *before) {
    int turned = 0;

    find_edge_rates(m, d);
    for (int e = 0; e < m->n_edge; e++) {
        const int k = m->edge_switch[e];
        if (is_comparison(m, k) && d->moved[e] != 0.0 && !isnan(before[k]) &&
            d->mode[k] != before[k] && moves_into(d, e, before[k])) {
            d->mode[k] = before[k];
            d->turned[k] = allowance_of(m, d, k, d->argument[k]);
            turned = 1;
        }
    }
    return turned;
}

/* --- the jump itself --------------------------------------------------------------------------- */

static double stored_energy(const bgc_model *m, bgc_data *d) {
    double energy[3];

    m->energy(d->h, d->core.t, d->x, d->u, energy, d->work);
    return energy[0];
}

/* Enters the energy that a jump takes into the accounts: as dissipated, or as supplied where it adds some. */
static void account_for(bgc_core *core, double before, double after) {
    core->supplied += fmax(after - before, 0.0);
    core->dissipated += fmax(before - after, 0.0);
    core->largest_account = bgc_largest_account(core->largest_account, after - core->stored0,
                                                core->supplied, core->dissipated);
    core->counts.exchanged = fmax(core->counts.exchanged, fmax(core->largest_account, fabs(after)));
}

/* Applies the resets of the conditions in d->condition, evaluated before all of them. */
static bgc_status apply_resets(const bgc_model *m, bgc_data *d) {
    m->resets(d->h, d->core.t, d->x, d->u, d->reset_value, d->work);
    for (int k = 0; k < m->n_jump; k++) {
        for (int r = m->jump_first[k]; d->condition[k] != 0.0 && r < m->jump_first[k + 1]; r++) {
            const int i = m->reset_state[r];
            if (!isfinite(d->reset_value[r])) {
                d->core.failed_state = i;
                return BGC_NOT_FINITE;
            }
            d->x[i] = d->reset_value[r];
            d->subtol_phase[i] = 0.0; /* a value that is given is not the rest of a decay */
        }
    }
    return BGC_OK;
}

/* Counts jumps in quick succession; `whole` is the length of the step under way. */
static bgc_status count_close_jumps(const bgc_model *m, bgc_data *d, double whole) {
    const double t = d->core.t, interval = quick * fmax(fabs(t), whole);

    for (int k = 0; k < m->n_jump; k++) {
        if (d->condition[k] == 0.0) {
            continue;
        }
        d->close_jumps[k] = t - d->jumped_at[k] <= interval ? d->close_jumps[k] + 1.0 : 0.0;
        d->jumped_at[k] = t;
        if (d->close_jumps[k] >= MOST_CLOSE_JUMPS) {
            d->core.failed_jump = k;
            return BGC_ENDLESS_JUMPS;
        }
    }
    return BGC_OK;
}

/* One jump: the resets, and the states that follow from them. Leaves the modes released. */
static bgc_status jump_once(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;
    const double before = core->accounts ? stored_energy(m, d) : 0.0;
    bgc_status status = BGC_OK;

    if (d->follower != NULL) {
        status = d->follower->jump(m, d, d->follower->of);
    }
    if (status == BGC_OK) {
        status = apply_resets(m, d);
    }
    core->f_valid = core->jac_valid = core->held = 0;
    bgc_release_modes(m, d);
    if (status == BGC_OK && m->project != NULL) {
        m->project(d->h, core->t, d->x, d->work);
    }
    if (status == BGC_OK) {
        status = bgc_close_chains(m, d, core->t, d->x);
    }
    if (status == BGC_OK) {
        status = bgc_watch_chains(m, d, core->t, d->x);
    }
    if (status == BGC_OK) {
        bgc_enter_chains(m, d);
        status = bgc_settle(m, d);
    }
    if (status == BGC_OK && core->accounts) {
        bgc_hold_modes(m, d);
        account_for(core, before, stored_energy(m, d));
        bgc_release_modes(m, d);
    }
    return status;
}

/* At the present, with consistent states and their modes: applies the resets of the conditions that have
 * become true. `before` are the modes before the event, NULL where inputs have changed; `whole` is the
 * length of the step that the event ended. */
bgc_status bgc_jump(const bgc_model *m, bgc_data *d, const double *before, double whole) {
    int jumped = 0, turned = 0;

    for (int e = 0; e < m->n_edge; e++) {
        const int k = m->edge_switch[e];
        d->moved[e] = before != NULL && d->mode[k] != before[k] ? 1.0 : 0.0;
    }
    for (;;) {
        bgc_status status;

        if (find_rising(m, d) == 0) {
            if (jumped && !turned && before != NULL) {
                turned = 1;
                if (turn_back(m, d, before)) {
                    continue;
                }
            }
            bgc_release_modes(m, d);
            return jumped ? bgc_check_asserts(m, d, d->core.t, d->x) : BGC_OK;
        }
        jumped = 1;
        status = count_close_jumps(m, d, whole);
        if (status == BGC_OK) {
            status = jump_once(m, d);
        }
        if (status != BGC_OK) {
            bgc_release_modes(m, d);
            return status;
        }
    }
}
