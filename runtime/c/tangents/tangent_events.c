/* tangent_events.c: derivatives of the states at an event, by the saltation matrix: S. Galan, W.
 * Feehery, P. Barton, Applied Numerical Mathematics 31 (1999) 17.
 *
 *   x' = g_x (x-' + f- t') + g_p + g_t t' - f+ t',   t' = -(z_x x-' + z_p) / (z_x f- + z_t),
 *
 * where ' is the derivative by a parameter, t' that of the time of the event, z the argument of the
 * switch that causes it, f- and f+ the rates of the states before and after, and g gives the states after
 * a jump. */
#include "switches.h"
#include "tangents/sensitivities.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double near_edge = 1e-2;      /* of the way of an argument in a step, */
static const double rounded = 16.0 * DBL_EPSILON; /* of times and arguments */
static const double same_time = 1e-12;     /* relative, of two events */
static const double same_speed = 1e-9;     /* relative, */
static const double same_rate = 1e-12;
static const double same_effect = 1e-6;    /* of events at a time, relative to the derivatives */

/* --- rates of the states ----------------------------------------------------------------------- */

/* The rates of the states there: M rate = f, and f_x rate = -df/dt in rows without a rate. */
bgc_status bgc_find_rate(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, const bgc_moment *at,
                         double *rate) {
    const int n = m->n_state;
    const size_t width = (size_t)n;
    double *present = d->u;
    int coupled = 0;

    m->rhs(d->h, at->t, at->x, at->u, rate, d->work);
    for (int i = 0; i < n; i++) {
        coupled |= d->inverse_mass[i] == 0.0;
    }
    for (int i = 0; i < n && !coupled; i++) {
        rate[i] *= d->inverse_mass[i];
    }
    if (!coupled) {
        return BGC_OK;
    }
    memset(s->dense_mass, 0, width * width * sizeof *s->dense_mass);
    for (int k = 0; k < m->n_mass; k++) {
        s->dense_mass[(size_t)m->mass_row[k] * width + (size_t)m->mass_col[k]] += d->mass[k];
    }
    if (d->core.algebraic > 0) {
        d->u = at->u;
        bgc_differentiate(m, d, at->t, at->x, d->block_jac, d->residual);
        d->u = present;
        for (int k = 0; k < m->n_jac; k++) {
            const size_t i = (size_t)m->jac_row[k];
            s->dense_mass[i * width + (size_t)m->jac_col[k]] +=
                d->algebraic[i] != 0.0 ? d->block_jac[k] : 0.0;
        }
        for (int i = 0; i < n; i++) {
            rate[i] = d->algebraic[i] != 0.0 ? -d->residual[i] : rate[i];
        }
    }
    if (bgc_factorise_dense(n, s->dense_mass, s->pivot, d->magnitude) >= 0) {
        return BGC_SINGULAR;
    }
    bgc_solve_dense(n, s->dense_mass, s->pivot, rate);
    return BGC_OK;
}

/* The derivatives of the arguments of the switches by time along the motion, in every lane of out. */
static void find_speeds(const bgc_model *m, bgc_sensitivities *s, const bgc_moment *at,
                        const double *rate, lane *out) {
    bgc_spread(m->n_state, at->x, s->x);
    bgc_spread(m->n_input + m->n_switch, at->u, s->u);
    bgc_spread(m->n_state, rate, s->change);
    s->change[m->n_state] = lane_of(1.0);
    s->kernel->switches(s->h, lane_of(at->t), s->x, s->u, s->change, s->no_change, out, s->work);
}

/* --- the switches that have caused the event --------------------------------------------------- */

/* Tests that the motion, at this speed of its argument, has led switch k out of its mode: others have
 * followed a jump. */
static int has_crossed(const bgc_model *m, const bgc_data *d, const double *z, double speed, int k) {
    const double before = d->u_step[m->n_input + k], way = d->core.t - d->core.t_old;
    const int left = d->mode[k] != before || (m->n_jump > 0 && d->turned[k] != 0.0);
    const double near = speed * (near_edge * way + rounded * fabs(d->core.t)) + rounded * d->extent[k];

    return !isnan(before) && left &&
           fabs(bgc_depth(m->switch_info[k].operation, before, z[k])) <= near;
}

/* Tests that an argument turns so near to its edge that the time of the event is no function of the
 * parameters: it moves at `speed`, which was `earlier` at the start of the step. */
static int grazes(const bgc_data *d, int k, double speed, double earlier) {
    const double change = fabs(speed - earlier) - same_speed * fabs(speed);
    const double bend = fmax(change, 0.0) / (d->core.t - d->core.t_old);

    return !(speed * speed > 2.0 * bend * d->core.rtol * d->extent[k]);
}

/* Tests that derivatives of the time of the event by two switches differ by what matters. */
static int differ(const bgc_model *m, const bgc_data *d, const bgc_sensitivities *s,
                  const bgc_sensitivity_block *b, lane first, lane second) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        const double delay = lane_get(first, l) - lane_get(second, l);
        double moved = 0.0, all = 0.0;
        for (int i = 0; i < m->n_state; i++) {
            const double change = s->rate[i] / d->scale[i], v = lane_get(b->now[i], l) / d->scale[i];
            moved += change * change;
            all += v * v;
        }
        if (fabs(delay) * sqrt(moved) > same_effect * sqrt(all)) {
            return 1;
        }
    }
    return 0;
}

/* The derivatives of the time of the event, 0 where no switch has crossed its edge. `found` where *out is
 * that of an event just before. */
static bgc_status differentiate_time(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                     bgc_sensitivity_block *b, const double *z, const lane *speed,
                                     const lane *earlier, int found, lane *out) {
    lane *change = s->result;

    bgc_spread(m->n_state, d->next, s->x);
    bgc_spread(m->n_input + m->n_switch, d->u_step, s->u);
    memcpy(s->change, b->now, (size_t)m->n_state * sizeof *b->now);
    s->change[m->n_state] = lane_of(0.0);
    s->kernel->switches(s->h, lane_of(d->core.t), s->x, s->u, s->change, b->q, change, s->work);
    *out = found ? *out : lane_of(0.0);
    for (int k = 0; k < m->n_switch; k++) {
        const double now = lane_get(speed[k], 0), before = lane_get(earlier[k], 0);
        lane moved = lane_of(0.0);
        if (!m->switch_info[k].jumps ||
            !has_crossed(m, d, z, fmax(fabs(now), fabs(before)), k)) {
            continue;
        }
        if (lane_bits(change[k] != lane_of(0.0)) != 0) {
            if (grazes(d, k, now, before)) {
                d->core.failed_switch = k;
                return BGC_GRAZING;
            }
            moved = -change[k] / now;
        }
        if (found && differ(m, d, s, b, moved, *out)) {
            d->core.failed_switch = k;
            return BGC_SIMULTANEOUS;
        }
        *out = found ? *out : moved;
        found = 1;
    }
    return BGC_OK;
}

/* --- the states after it ----------------------------------------------------------------------- */

/* The jumps at a time, one behind the other: of each the states and inputs before it, and the conditions that
 * have become true. */
static size_t jump_size(const bgc_model *m) {
    return (size_t)(m->n_state + m->n_input + m->n_switch + m->n_jump);
}

bgc_status bgc_note_jump(const bgc_model *m, bgc_data *d, void *of) {
    bgc_sensitivities *s = of;
    const size_t inputs = (size_t)(m->n_input + m->n_switch), size = jump_size(m);
    double *grown, *at;

    if (s->jumps == s->jump_room) {
        grown = realloc(s->jump, (size_t)(s->jump_room + 4) * size * sizeof *grown);
        if (grown == NULL) {
            return BGC_NO_MEMORY;
        }
        s->jump = grown;
        s->jump_room += 4;
    }
    at = s->jump + (size_t)s->jumps++ * size;
    memcpy(at, d->x, (size_t)m->n_state * sizeof *at);
    memcpy(at + m->n_state, d->u, inputs * sizeof *at);
    memcpy(at + (size_t)m->n_state + inputs, d->condition, (size_t)m->n_jump * sizeof *at);
    return BGC_OK;
}

/* Jump k; behind the last one, the moment after the event. */
static bgc_moment before_jump(const bgc_model *m, const bgc_sensitivities *s, int k,
                              const bgc_moment *behind) {
    double *at = s->jump + (size_t)k * jump_size(m);

    return k < s->jumps ? (bgc_moment){behind->t, at, at + m->n_state} : *behind;
}

/* Derivatives along v of the values that a jump gives to states, to v, and these values to s->reset. */
static void carry_through_resets(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 const bgc_sensitivity_block *b, const bgc_moment *at, lane *v) {
    const double *condition = at->u + m->n_input + m->n_switch;

    bgc_spread(m->n_state, at->x, s->x);
    bgc_spread(m->n_input + m->n_switch, at->u, s->u);
    s->kernel->resets(s->h, lane_of(at->t), s->x, s->u, v, b->q, s->result, s->work);
    m->resets(d->h, at->t, at->x, at->u, d->off_reset, d->work);
    memcpy(s->reset, at->x, (size_t)m->n_state * sizeof *at->x);
    for (int k = 0; k < m->n_jump; k++) {
        for (int r = m->jump_first[k]; condition[k] != 0.0 && r < m->jump_first[k + 1]; r++) {
            v[m->reset_state[r]] = s->result[r];
            s->reset[m->reset_state[r]] = d->off_reset[r];
        }
    }
}

/* Tests that rates or states have changed at the event, by more than rounding. */
static int changes_motion(const bgc_model *m, const bgc_sensitivities *s) {
    const double *before = s->rate, *after = s->rate_after;
    int changed = s->jumps > 0;

    for (int i = 0; i < m->n_state; i++) {
        changed |= !(fabs(after[i] - before[i]) <= same_rate * (fabs(before[i]) + fabs(after[i])));
    }
    return changed;
}

bgc_status bgc_carry_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 bgc_sensitivity_block *b, const double *ahead, const bgc_moment *behind,
                                 lane *v) {
    const lane delay = v[m->n_state];
    bgc_status status = BGC_OK;

    memcpy(s->reset, ahead, (size_t)m->n_state * sizeof *ahead);
    for (int k = 0; k <= s->jumps && status == BGC_OK; k++) {
        const bgc_moment at = before_jump(m, s, k, behind), next = before_jump(m, s, k + 1, behind);
        status = bgc_satisfy_sensitivity(m, d, s, b, &at, s->reset, delay, v);
        if (status == BGC_OK && k < s->jumps) {
            carry_through_resets(m, d, s, b, &at, v);
            bgc_project_sensitivity(m, s, b, next.t, s->reset, v);
            status = bgc_close_sensitivity(m, d, s, b, &next, s->reset, delay, v);
        }
    }
    for (int i = 0; i < m->n_state; i++) {
        b->now[i] = v[i] - s->rate_after[i] * delay;
    }
    return status;
}

/* After an event, with the new modes; d->next has the states before a jump, d->u_step their modes. */
bgc_status bgc_differentiate_event(const bgc_model *m, bgc_data *d, void *of) {
    bgc_sensitivities *s = of;
    const int n = m->n_state;
    const double t = d->core.t;
    const int again = t - s->event_at <= same_time * fabs(t);
    const bgc_moment start = {d->core.t_old, d->y0, d->u_step}, ahead = {t, d->next, d->u_step};
    const bgc_moment behind = {t, d->x, d->u};
    double *before = s->rate, *after = s->rate_after;
    int moves;
    lane *speed = s->speed, *earlier = s->speed + m->n_switch;
    bgc_status status;

    bgc_follow_chosen_rows(m, d, s);
    status = bgc_find_rate(m, d, s, &start, before);
    if (status != BGC_OK) {
        return status;
    }
    find_speeds(m, s, &start, before, earlier);
    status = bgc_find_rate(m, d, s, &ahead, before);
    find_speeds(m, s, &ahead, before, speed);
    if (status == BGC_OK) {
        status = bgc_find_rate(m, d, s, &behind, after);
    }
    moves = changes_motion(m, s);
    if (moves) {
        m->switches(d->h, t, d->next, d->u_step, d->off_argument, d->work);
    }
    for (int k = 0; k < s->blocks && status == BGC_OK; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        lane *v = s->along;
        status = moves ? differentiate_time(m, d, s, b, d->off_argument, speed, earlier, again, b->delay)
                       : BGC_OK;
        for (int i = 0; i < n; i++) {
            v[i] = b->now[i] + before[i] * (moves ? *b->delay : lane_of(0.0));
        }
        v[n] = moves ? *b->delay : lane_of(0.0);
        if (status == BGC_OK) {
            status = bgc_carry_sensitivity(m, d, s, b, d->next, &behind, v);
        }
    }
    s->event_at = moves ? t : s->event_at;
    return status;
}
