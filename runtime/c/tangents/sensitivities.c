/* sensitivities.c: memory of the derivatives of a run, and what they depend on. */
#include "tangents/sensitivities.h"

#include <math.h>
#include <string.h>

enum { DENSE = 3 }; /* coefficients of the dense output */

/* --- memory ------------------------------------------------------------------------------------ */

/* Places one array behind another; counts alone where `at` is NULL. */
static lane *take(lane **at, size_t *size, size_t count) {
    lane *here = *at;

    *size += count;
    *at = here != NULL ? here + count : NULL;
    return here;
}

/* Numbers of the multipliers of closed chains and of the momenta that they act on. */
static size_t rows_and_impulses(const bgc_model *m) {
    return m->closure_info == NULL ? 0 : (size_t)(m->closure_info->n_row + m->closure_info->n_impulse);
}

/* The arrays of lanes; returns their size. */
static size_t place_lanes(const bgc_model *m, bgc_sensitivities *s, lane *at) {
    const size_t n = (size_t)m->n_state, held = (size_t)m->n_held;
    const size_t hoisted = (size_t)s->kernel->n_hoist, changes = (size_t)m->n_hoist + held;
    const size_t inputs = (size_t)(m->n_input + m->n_switch), moving = n + 1 + (size_t)m->n_start;
    const size_t pairs = (size_t)s->count * BGC_MAX_STAGES + BGC_LANE_WIDTH - 1;
    const size_t groups = pairs / BGC_LANE_WIDTH;
    size_t result = n, size = 0;

    result = (size_t)m->n_output > result ? (size_t)m->n_output : result;
    result = (size_t)m->n_switch > result ? (size_t)m->n_switch : result;
    result = (size_t)m->n_start > result ? (size_t)m->n_start : result;
    result = rows_and_impulses(m) > result ? rows_and_impulses(m) : result;
    result = held > result ? held : result;
    result = 2 * (size_t)m->n_rate > result ? 2 * (size_t)m->n_rate : result;
    for (int k = 0; k < m->n_jump; k++) {
        const size_t resets = (size_t)m->jump_first[k + 1];
        result = resets > result ? resets : result;
    }
    s->h = take(&at, &size, hoisted);
    s->x = take(&at, &size, n);
    s->u = take(&at, &size, inputs);
    s->points = take(&at, &size, BGC_MAX_STAGES * n);
    s->x_jac = take(&at, &size, n);
    s->u_jac = take(&at, &size, inputs);
    s->stages = take(&at, &size, BGC_MAX_STAGES * n);
    s->pair_d = take(&at, &size, groups * (n + 1));
    s->pair_q = take(&at, &size, groups * changes);
    s->pair_r = take(&at, &size, n + 1);
    s->right = take(&at, &size, result);
    s->change = take(&at, &size, moving);
    s->along = take(&at, &size, moving);
    s->no_change = take(&at, &size, changes > n ? changes : n + 1);
    s->result = take(&at, &size, result);
    s->speed = take(&at, &size, 2 * (size_t)m->n_switch);
    s->work = take(&at, &size, (size_t)s->kernel->n_work);
    s->solve_work = take(&at, &size, (size_t)s->kernel->n_solve_work);
    s->closing = take(&at, &size, bgc_closing_tangents(m));
    for (int k = 0; k < s->blocks; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        b->q = take(&at, &size, changes);
        b->mass = take(&at, &size, (size_t)m->n_mass);
        b->now = take(&at, &size, n);
        b->start = take(&at, &size, n);
        b->end = take(&at, &size, n);
        b->k = take(&at, &size, DENSE * n);
        b->products = take(&at, &size, BGC_MAX_STAGES * n);
        b->delay = take(&at, &size, 1);
    }
    return size;
}

/* The arrays of doubles; returns whether there is memory for them. */
static int place_doubles(const bgc_model *m, bgc_sensitivities *s) {
    const size_t n = (size_t)m->n_state, count = (size_t)s->kernel->first_change + 2 * (size_t)m->n_param;
    const size_t prepared = (size_t)s->kernel->n_hoist + (size_t)m->n_hoist;
    const size_t work = (size_t)s->kernel->n_prepare_work, unknowns = (size_t)bgc_unknowns(m);
    const size_t matrix = m->n_mass > 0 ? n * n : 0, rates = 6 * n;
    const size_t directions = (size_t)s->count * (size_t)m->n_param, chains = rows_and_impulses(m);
    const size_t inputs = (size_t)(m->n_input + m->n_switch), instants = (size_t)m->n_rate;

    s->p = calloc(count + prepared + work + unknowns + rates + matrix + directions + chains + inputs +
                      instants + 1,
                  sizeof *s->p);
    s->pivot = calloc(n + 1, sizeof *s->pivot);
    if (s->p == NULL || s->pivot == NULL) {
        return 0;
    }
    s->prepared = s->p + count;
    s->prepare_work = s->prepared + prepared;
    s->column = s->prepare_work + work;
    s->rate = s->column + unknowns;
    s->rate_after = s->rate + n;
    s->reset = s->rate_after + n;
    s->before_flows = s->reset + n;
    s->before_inputs = s->before_flows + n;
    s->inputs_before = s->before_inputs + n;
    s->instants_before = s->inputs_before + inputs;
    s->parameter = s->instants_before + m->n_rate;
    s->multiplier = s->parameter + directions;
    s->dense_mass = s->multiplier + chains;
    return 1;
}

bgc_sensitivities *bgc_new_sensitivities(const bgc_model *m, int count) {
    bgc_sensitivities *s = calloc(1, sizeof *s);
    lane *memory = NULL;

    if (s == NULL) {
        return NULL;
    }
    s->kernel = bgc_get_tangent_model();
    s->count = count;
    s->blocks = (count + BGC_LANE_WIDTH - 1) / BGC_LANE_WIDTH;
    s->block = calloc((size_t)s->blocks + 1, sizeof *s->block);
    if (s->block != NULL && place_doubles(m, s)) {
        memory = bgc_aligned_zeros((place_lanes(m, s, NULL) + 1) * sizeof *memory, &s->allocated);
    }
    if (memory == NULL) {
        bgc_free_sensitivities(s);
        return NULL;
    }
    place_lanes(m, s, memory);
    return s;
}

void bgc_free_sensitivities(bgc_sensitivities *s) {
    if (s != NULL) {
        free(s->block);
        free(s->jump);
        free(s->p);
        free(s->pivot);
        free(s->allocated);
        free(s);
    }
}

/* --- derivatives of f ---------------------------------------------------------------------------- */

void bgc_slope_sensitivity(const bgc_model *m, bgc_sensitivities *s, const bgc_sensitivity_block *b,
                           const bgc_moment *at, const lane *v, lane delay) {
    bgc_spread(m->n_state, at->x, s->x);
    bgc_spread(m->n_input + m->n_switch, at->u, s->u);
    memcpy(s->change, v, (size_t)m->n_state * sizeof *v);
    s->change[m->n_state] = delay;
    s->kernel->rhs(s->h, lane_of(at->t), s->x, s->u, s->change, b->q, s->right, s->work);
}

/* --- what depends on parameters alone ------------------------------------------------------------ */

void bgc_prepare_sensitivities(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s) {
    const int hoisted = s->kernel->n_hoist;
    double *change = s->p + s->kernel->first_change, *follows = change + m->n_param;
    const double *changes = s->prepared + hoisted;

    memcpy(s->p, d->p, (size_t)s->kernel->first_change * sizeof *s->p);
    for (int k = 0; k < s->count; k++) {
        lane *q = s->block[k / BGC_LANE_WIDTH].q;
        for (int i = 0; i < m->n_param; i++) {
            change[i] = s->parameter[(size_t)k * (size_t)m->n_param + (size_t)i];
            follows[i] = d->is_set[i] || change[i] != 0.0 ? 0.0 : 1.0;
        }
        memset(s->prepared, 0, (size_t)(hoisted + m->n_hoist) * sizeof *s->prepared);
        memcpy(s->prepared, d->h, (size_t)m->n_hoist * sizeof *d->h);
        s->kernel->prepare(s->p, s->prepared, s->prepare_work);
        for (int j = 0; j < m->n_hoist; j++) {
            lane_set(&q[j], k % BGC_LANE_WIDTH, changes[j]);
        }
    }
    bgc_spread(hoisted, s->prepared, s->h);
    s->pair_stages = 0;
}

void bgc_follow_chosen_rows(const bgc_model *m, bgc_data *d, bgc_sensitivities *s) {
    const size_t selectors = (size_t)(s->kernel->first_change - m->n_param) * sizeof *d->p;

    if (memcmp(d->p + m->n_param, s->p + m->n_param, selectors) != 0) {
        bgc_prepare_sensitivities(m, d, s);
    }
}
