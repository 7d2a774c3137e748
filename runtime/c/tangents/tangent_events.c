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
static bgc_status find_rate(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, const bgc_moment *at,
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

/* Derivatives along v (with time in its last element) of the values that jumps give to states, to v, and
 * these values to s->before_satisfied. */
static void carry_through_resets(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 bgc_sensitivity_block *b, lane *v) {
    bgc_spread(m->n_state, d->next, s->x);
    bgc_spread(m->n_input + m->n_switch, d->u_step, s->u);
    s->kernel->resets(s->h, lane_of(d->core.t), s->x, s->u, v, b->q, s->result, s->work);
    m->resets(d->h, d->core.t, d->next, d->u_step, d->off_reset, d->work);
    for (int k = 0; k < m->n_jump; k++) {
        for (int r = m->jump_first[k]; d->jumped_at[k] == d->core.t && r < m->jump_first[k + 1]; r++) {
            v[m->reset_state[r]] = s->result[r];
            s->before_satisfied[m->reset_state[r]] = d->off_reset[r];
        }
    }
}

/* Tests that states have jumped at the present. */
static int jumps(const bgc_model *m, const bgc_data *d) {
    int found = 0;

    for (int k = 0; k < m->n_jump; k++) {
        found |= d->jumped_at[k] == d->core.t;
    }
    return found;
}

/* Tests that rates or states have changed at the event, by more than rounding. */
static int changes_motion(const bgc_model *m, const bgc_data *d, const double *before,
                          const double *after) {
    int changed = jumps(m, d);

    for (int i = 0; i < m->n_state; i++) {
        changed |= !(fabs(after[i] - before[i]) <= same_rate * (fabs(before[i]) + fabs(after[i])));
    }
    return changed;
}

/* Carries the derivatives of block b through the event, which is delayed by the parameters: s->rate and
 * s->rate_after are the rates of the states ahead of it and behind. */
static bgc_status carry(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, bgc_sensitivity_block *b,
                        const bgc_moment *behind, lane delay) {
    const int n = m->n_state;
    lane *v = s->along;
    bgc_status status = BGC_OK;

    for (int i = 0; i < n; i++) {
        v[i] = b->now[i] + s->rate[i] * delay;
    }
    v[n] = delay;
    memcpy(s->before_satisfied, d->next, (size_t)n * sizeof *d->next);
    if (m->n_jump > 0) {
        carry_through_resets(m, d, s, b, v);
    }
    if (jumps(m, d)) {
        bgc_project_sensitivity(m, s, b, behind->t, s->before_satisfied, v);
        status = bgc_close_sensitivity(m, d, s, b, behind, s->before_satisfied, delay, v);
    }
    if (status == BGC_OK) {
        status = bgc_satisfy_sensitivity(m, d, s, b, behind, s->before_satisfied, delay, v);
    }
    for (int i = 0; i < n; i++) {
        b->now[i] = v[i] - s->rate_after[i] * delay;
    }
    return status;
}

/* After an event, with the new modes; d->next has the states before a jump, d->u_step their modes. */
bgc_status bgc_differentiate_event(const bgc_model *m, bgc_data *d, void *of) {
    bgc_sensitivities *s = of;
    const double t = d->core.t;
    const int again = t - s->event_at <= same_time * fabs(t);
    const bgc_moment start = {d->core.t_old, d->y0, d->u_step}, ahead = {t, d->next, d->u_step};
    const bgc_moment behind = {t, d->x, d->u};
    double *before = s->rate, *after = s->rate_after;
    int moves;
    lane *speed = s->speed, *earlier = s->speed + m->n_switch;
    bgc_status status;

    bgc_follow_chosen_rows(m, d, s);
    status = find_rate(m, d, s, &start, before);
    if (status != BGC_OK) {
        return status;
    }
    find_speeds(m, s, &start, before, earlier);
    status = find_rate(m, d, s, &ahead, before);
    find_speeds(m, s, &ahead, before, speed);
    if (status == BGC_OK) {
        status = find_rate(m, d, s, &behind, after);
    }
    moves = changes_motion(m, d, before, after);
    if (moves) {
        m->switches(d->h, t, d->next, d->u_step, d->off_argument, d->work);
    }
    for (int k = 0; k < s->blocks && status == BGC_OK; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        status = moves ? differentiate_time(m, d, s, b, d->off_argument, speed, earlier, again, b->delay)
                       : BGC_OK;
        if (status == BGC_OK) {
            status = carry(m, d, s, b, &behind, moves ? *b->delay : lane_of(0.0));
        }
    }
    s->event_at = moves ? t : s->event_at;
    return status;
}
