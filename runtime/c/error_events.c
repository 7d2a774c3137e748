/* error_events.c: how far the states of a run are off behind an event.
 *
 * The exact solution meets the event later by dt = -z_e / z', with the derivatives of the argument z of the switch that
 * causes it along e and along the motion. e jumps by the saltation matrix,
 *
 *   e+ = g_x (e- + f- dt) - f+ dt,
 *
 * where f- and f+ are the rates of the states before and after, and g gives the states after a jump: S. Galan,
 * W. Feehery, P. Barton, Applied Numerical Mathematics 31 (1999) 17. Switches whose edges coincide may cause several
 * events, a few rounding errors apart: each is met by the same motion, and the jumps of f add up.
 */
#include "global_error.h"
#include "interpolation.h"
#include "switches.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double near_edge = 1e-2;              /* of the way of an argument in a step, */
static const double rounded = 16.0 * DBL_EPSILON; /* of times and arguments */
static const double same_time = 1e-12;             /* relative, of two events */
static const double most_late = 0.2;               /* of the time since the event before, that is doubtful */
static const double back_part = 1e-6;              /* of a step, by which a difference along the motion goes back, */
static const double back_least = 1e-9;             /* at least so much of the time */

/* The rates of the states before an event at t, where f is `f`: states whose rates are coupled, or which have none,
 * move as the dense output. */
static void find_motion(const bgc_model *m, const bgc_data *d, double t, const double *f, double *motion) {
    const size_t width = bgc_chunked(m->n_state);
    const double whole = d->core.t_end - d->core.t_old, s = (t - d->core.t_old) / whole;

    for (int i = 0; i < m->n_state; i++) {
        const double *k = d->k + i;
        motion[i] = d->inverse_mass[i] != 0.0
                        ? bgc_rate_of_state(d, f, i)
                        : bgc_interpolated_slope(s, d->y0[i], d->y1[i], k[0], k[width], k[2 * width]) / whole;
    }
}

/* Derivatives of the arguments of the switches along e to d->off_along, and along the motion to d->off_rate, before an
 * event at t, at d->next, where f is `f`; the motion to vector 10. */
void bgc_look_at_switches(const bgc_model *m, bgc_data *d, double t, const double *f) {
    const double shift = bgc_error_shift(m, d, d->next, d->off);
    const double back = fmax(back_part * (t - d->core.t), back_least * fabs(t));
    double *present = d->off_argument, *motion = bgc_error_vector(m, d, 10);

    find_motion(m, d, t, f, motion);
    m->switches(d->h, t, d->next, d->u, present, d->work);
    for (int i = 0; i < m->n_state; i++) {
        d->point[i] = d->next[i] + shift * d->off[i];
    }
    m->switches(d->h, t, d->point, d->u, d->off_along, d->work);
    for (int i = 0; i < m->n_state; i++) {
        d->point[i] = d->next[i] - back * motion[i];
    }
    m->switches(d->h, t - back, d->point, d->u, d->off_rate, d->work);
    for (int k = 0; k < m->n_switch; k++) {
        d->off_along[k] = (d->off_along[k] - present[k]) / shift;
        d->off_rate[k] = (present[k] - d->off_rate[k]) / back;
    }
}

/* Tests that the motion of the last step has led switch k out of its mode. Where an input that jumps has done so, the
 * argument before it is not near the edge. */
static int has_crossed(const bgc_model *m, const bgc_data *d, int k) {
    const double before = d->u_step[m->n_input + k], t = d->core.t, h = t - d->core.t_old;
    const int left = !isnan(before) && (d->mode[k] != before || (m->n_jump > 0 && d->turned[k] != 0.0));
    const double near = fabs(d->off_rate[k]) * (near_edge * h + rounded * fabs(t)) + rounded * d->extent[k];

    return left && d->off_rate[k] != 0.0 &&
           fabs(bgc_depth(m->switch_info[k].operation, before, d->off_argument[k])) <= near;
}

/* The time by which an event comes later in the exact solution: that of the switch that is moved most. */
static double event_delay(const bgc_model *m, const bgc_data *d) {
    double most = 0.0;

    for (int k = 0; k < m->n_switch; k++) {
        const double moved = -d->off_along[k] / d->off_rate[k];
        if (fabs(moved) > fabs(most) && has_crossed(m, d, k)) {
            most = moved;
        }
    }
    return most;
}

/* Tests that dt is no small part of the time since the event before: the exact solution may meet others. */
static int is_far_off(bgc_core *core, double dt) {
    const double since = core->t - core->off_event;

    if (!(since > same_time * fabs(core->t))) {
        return 0;
    }
    core->off_event = core->t;
    return fabs(dt) > most_late * since;
}

/* Derivatives along v, the change of the states up to the jumps at the present, of the values that they give. */
static void carry_through_resets(const bgc_model *m, bgc_data *d, double *v) {
    const double shift = bgc_error_shift(m, d, d->y1, v);

    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < m->n_state; i++) {
            d->point[i] = d->next[i] + side * shift * v[i];
        }
        m->resets(d->h, d->core.t, d->point, d->u_step, side ? d->off_reset : d->reset_value, d->work);
    }
    for (int k = 0; k < m->n_jump; k++) {
        for (int r = m->jump_first[k]; d->jumped_at[k] == d->core.t && r < m->jump_first[k + 1]; r++) {
            v[m->reset_state[r]] = (d->off_reset[r] - d->reset_value[r]) / shift;
        }
    }
}

/* After an event, with the new modes: e+ = g_x (e- + f- dt) - f+ dt. d->next has the states before a jump. Where M
 * couples rates or has empty rows, the factors of the step stand for it. */
void bgc_carry_error_through(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const int n = m->n_state, implicit = method->family->jacobian;
    const double dt = event_delay(m, d);
    const double *f_before = bgc_error_vector(m, d, 8), *motion = bgc_error_vector(m, d, 10);
    double *f_after = bgc_error_vector(m, d, 0), *v = bgc_error_vector(m, d, 1);
    bgc_counts counts;
    int jumped = 0;

    for (int k = 0; k < m->n_jump; k++) {
        jumped |= d->jumped_at[k] == d->core.t;
    }
    d->core.counts.doubtful_errors += is_far_off(&d->core, dt);
    bgc_forget_local_error(&d->core);
    d->core.off_slope = 0.0;
    m->rhs(d->h, d->core.t, d->x, d->u, f_after, d->work);
    if (jumped || !implicit || m->n_mass == 0) {
        for (int i = 0; i < n; i++) {
            v[i] = d->off[i] + motion[i] * dt;
        }
        if (jumped) {
            carry_through_resets(m, d, v);
        }
        for (int i = 0; i < n; i++) {
            d->off[i] = v[i] - bgc_rate_of_state(d, f_after, i) * dt;
        }
        return;
    }
    for (int i = 0; i < n; i++) {
        v[i] = (f_before[i] - f_after[i]) * dt;
    }
    counts = d->core.counts;
    bgc_solve_for_error(m, d, v);
    d->core.counts = counts;
    for (int i = 0; i < n; i++) {
        d->off[i] += v[i];
    }
}
