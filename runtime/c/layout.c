/* layout.c: the arrays of an instance, one after another in one block of memory. */
#include "bgc_internal.h"

/* Allocates the arrays of an instance one after another in `from`, each in cache lines of its own;
 * counts only where `from` is NULL. */
typedef struct {
    double *from;
    size_t used;
} layout;

static double *place(layout *l, size_t count) {
    double *at = l->from == NULL ? NULL : l->from + l->used;

    l->used += (count + BGC_LANES - 1) / BGC_LANES * BGC_LANES;
    return at;
}

static bgc_range *place_ranges(layout *l, int count) {
    return (bgc_range *)(void *)place(l, 2 * (size_t)count);
}

static const bgc_closure_info no_closures = {0};

/* Allocates all arrays, those that are saved first. Returns their size in doubles. */
size_t bgc_place_all(const bgc_model *m, bgc_data *d, double *from) {
    const size_t n = (size_t)m->n_state, unknown = (size_t)bgc_unknowns(m);
    const size_t local = (size_t)bgc_local_entries(m).count, slopes = (size_t)m->n_jac;
    const int given = 2 * m->n_given, tested = m->n_assert > m->n_check ? m->n_assert : m->n_check;
    const size_t checks = (size_t)(tested > given ? tested : given);
    const size_t switches = (size_t)m->n_switch;
    const size_t unknowns = (size_t)m->n_start;
    const bgc_closure_info *c = m->closure_info == NULL ? &no_closures : m->closure_info;
    const size_t responses = 2 * (size_t)c->n_row * (size_t)c->n_impulse;
    const size_t choices = (size_t)c->n_row + (size_t)c->n_condition;
    layout l = {from, 0};

    /* Parameters, states and inputs. */
    d->p = place(&l, (size_t)m->n_param + (size_t)c->n_selector);
    d->h = place(&l, (size_t)m->n_hoist);
    d->x = place(&l, n);
    d->u = place(&l, (size_t)m->n_input + switches);
    d->u_step = place(&l, (size_t)m->n_input + switches);

    /* Switches, sampled parts and jumps. */
    d->mode = place(&l, switches);
    d->argument = place(&l, switches);
    d->extent = place(&l, switches);
    d->swing = place(&l, switches);
    d->rest = place(&l, switches);
    d->returns = place(&l, switches);
    d->change_of_mode = place(&l, switches);
    d->sampling = place(&l, 2 * (size_t)m->n_rate);
    d->instants = place(&l, (size_t)m->n_rate);
    d->turned = place(&l, m->n_jump > 0 ? switches : 0);
    d->holds = place(&l, (size_t)m->n_jump);
    d->jumped_at = place(&l, (size_t)m->n_jump);
    d->close_jumps = place(&l, (size_t)m->n_jump);

    /* States below their tolerances, and divisors. */
    d->subtol_phase = place(&l, n);
    d->subtol_from = place(&l, n);
    d->subtol_to = place(&l, n);
    d->subtol_low = place(&l, n);
    d->subtol_at = place(&l, n);
    d->subtol_entered = place(&l, n);
    d->subtol_left = place(&l, n);
    d->subtol = (bgc_subtolerance_state *)(void *)place(&l, n * sizeof *d->subtol / sizeof(double));
    d->divisor_extent = place(&l, (size_t)m->n_divisor);
    d->divisor_slope = place(&l, (size_t)m->n_divisor);

    /* The mass matrix with its scales, and ranges of terms of time. */
    d->u_seen = place(&l, (size_t)m->n_input);
    d->scale = place(&l, unknown);
    d->mass = place(&l, (size_t)m->n_mass);
    d->h_range = bgc_has_ranges(m) ? place_ranges(&l, m->n_hoist) : NULL;
    d->u_range = bgc_has_ranges(m) ? place_ranges(&l, m->n_input + m->n_switch) : NULL;
    d->variation = place(&l, (size_t)m->n_term);
    d->patience = place(&l, (size_t)m->n_term);
    d->f_before = m->n_term > 0 ? place(&l, n) : NULL;
    d->inverse_mass = place(&l, n);
    d->algebraic = place(&l, n);

    /* df/dx, the factors of W, and what estimates keep from step to step. */
    d->jac = place(&l, local > slopes ? local : slopes);
    d->dfdt = place(&l, n);
    d->lu = place(&l, (size_t)m->n_lu);
    d->f = place(&l, n);
    d->correction = place(&l, n);
    d->corrected_at = place(&l, n);
    d->range = place(&l, n);
    d->dominant = place(&l, n);
    d->direction = place(&l, n);
    d->image = place(&l, n);

    /* The ends of the last step, its dense output, and the rows of closed chains. */
    d->y0 = place(&l, n);
    d->y1 = place(&l, n);
    d->k = place(&l, BGC_MAX_DENSE * bgc_padded(m->n_state));
    d->lu_complex = (bgc_complex *)(void *)place(&l, 2 * (size_t)m->n_lu);
    d->closed_before = place(&l, responses);
    d->response_size = place(&l, (size_t)c->n_row);
    d->chosen = place(&l, choices);
    d->off = place(&l, n);
    d->off_before = place(&l, n);
    d->off_at_end = place(&l, n);
    d->off_inside = place(&l, 2 * bgc_padded(m->n_state));
    d->largest_off = place(&l, (size_t)m->n_output);
    d->lowest = place(&l, (size_t)m->n_output);
    d->highest = place(&l, (size_t)m->n_output);
    d->n_saved = l.used;

    /* Arrays that are not saved. First the stages and right-hand sides of a step. */
    d->stages = place(&l, BGC_MAX_STAGES * bgc_padded(m->n_state));
    d->implicit = place(&l, 2 * BGC_MAX_IMPLICIT * bgc_padded(m->n_state));
    d->complex_right = (bgc_complex *)(void *)place(&l, 2 * n);
    d->b_complex = (bgc_complex *)(void *)place(&l, 2 * unknown);
    d->residual_complex = (bgc_complex *)(void *)place(&l, 2 * unknown);
    d->next = place(&l, n);
    d->error = place(&l, n);
    d->noise = place(&l, n);
    d->f_last = place(&l, n);
    d->point = place(&l, n);
    d->right = place(&l, n);
    d->residual = place(&l, unknown);
    d->magnitude = place(&l, unknown);
    d->b = place(&l, unknown);

    /* Results of kernels. */
    d->output = place(&l, (size_t)m->n_output);
    d->command = place(&l, (size_t)m->n_command);
    d->check = place(&l, checks);

    /* Switches, divisors, jumps, pulses and terms of time within a step. */
    d->samples = place(&l, BGC_SAMPLES * bgc_padded(m->n_switch));
    d->divisors = place(&l, (BGC_SAMPLES + 1) * bgc_padded(m->n_divisor));
    d->probe = place(&l, switches);
    d->after = place(&l, switches);
    d->ignored = place(&l, switches);
    d->held_value = place(&l, (size_t)m->n_held);
    d->condition = place(&l, (size_t)m->n_jump);
    d->reset_value = place(&l, m->n_jump > 0 ? (size_t)m->jump_first[m->n_jump] : 0);
    d->edge_rate = place(&l, (size_t)m->n_edge);
    d->moved = place(&l, (size_t)m->n_edge);
    d->watch_sample = place(&l, (BGC_SAMPLES + 1) * (size_t)m->n_watch);
    d->watch_probe = place(&l, (size_t)m->n_watch);
    d->term_range = place_ranges(&l, 2 * m->n_term);
    d->timed_range = place_ranges(&l, m->timed_ranges != NULL ? 2 * m->n_timed : 0);
    d->around = place(&l, (size_t)m->n_term);
    d->widest = place(&l, (size_t)m->n_term);

    /* Errors of the states. */
    d->off_work = place(&l, 10 * bgc_padded(m->n_state));
    d->off_output = place(&l, (size_t)m->n_output);
    d->off_reset = place(&l, m->n_jump > 0 ? (size_t)m->jump_first[m->n_jump] : 0);
    d->off_argument = place(&l, switches);
    d->off_along = place(&l, switches);
    d->off_rate = place(&l, switches);

    /* Newton's method for consistent values. */
    d->first = place(&l, n);
    d->start = place(&l, n);
    d->largest = place(&l, n);
    d->trial = place(&l, n);
    d->homotopy = place(&l, n);
    d->change = place(&l, n);
    d->next_change = place(&l, n);

    /* Scratch of kernels and of linear algebra, with inner unknowns. */
    d->block_jac = place(&l, (size_t)m->n_jac);
    d->work = place(&l, (size_t)m->n_work);
    d->sparse_work = place(&l, 3 * unknown);
    d->block_work = place(&l, m->blocks == NULL ? 0 : 18 * (size_t)m->blocks->n_place);
    d->wide = place(&l, m->n_inner > 0 ? unknown : 0);
    d->wide_complex = (bgc_complex *)(void *)place(&l, m->n_inner > 0 ? 2 * unknown : 0);
    d->local = place(&l, m->n_inner > 0 ? local : 0);
    d->slopes = place(&l, m->n_inner > 0 ? slopes : 0);
    d->reach = place(&l, unknown);

    /* Newton's method for the initial state, and closed chains. */
    d->start_at = place(&l, unknowns);
    d->start_from = place(&l, unknowns);
    d->start_trial = place(&l, unknowns);
    d->start_change = place(&l, unknowns);
    d->start_next = place(&l, unknowns);
    d->start_first = place(&l, unknowns);
    d->start_magnitude = place(&l, unknowns);
    d->start_jac = place(&l, unknowns * unknowns);
    d->start_lu = place(&l, unknowns * unknowns);
    d->closing = place(&l, bgc_closing_size(m));
    d->closed_after = place(&l, responses);
    d->next_chosen = place(&l, choices);
    return l.used;
}

/* Number of doubles that bgc_save stores. */
size_t bgc_saved_count(const bgc_model *m) {
    bgc_data counted;

    bgc_place_all(m, &counted, NULL);
    return counted.n_saved;
}
