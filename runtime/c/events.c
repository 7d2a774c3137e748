/* events.c: events of discontinuous laws: detection, location, and the new modes.
 *
 * Within a step every comparison, sign and rounding of the model is held at its mode, so that f is
 * smooth and the method keeps its order. The dense output of the step shows whether an argument has
 * left the range of its mode, at the end or within. The first time at which one has is located by
 * bracketing, the step is cut there, and the next step starts in the new modes.
 *
 * Invariant: between steps each mode is the result of its operation at the present time and state; a
 * NaN where that is undefined, or where the switch is left to error control.
 */
#include "bgc_internal.h"
#include "modes.h"
#include "tolerance.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Points of a step at which arguments are evaluated, its end last; spaced unevenly, so that an
 * oscillation does not fit between them. */
const double bgc_sample_at[BGC_SAMPLES] = {0.17, 0.41, 0.63, 0.86, 1.0};

/* Weights of the arguments at 0, 0.17, 0.86 and 1 in the values at 0.41 and 0.63 of the cubic through
 * them. */
static const double cubic_weight[2][4] = {
    {-0.4358413132694938, 1.1180784519150777, 0.6988299869998555, -0.3810671256454388},
    {-0.2677564979480164, 0.5506732813607370, 1.2906976744186045, -0.5736144578313251},
};
static const double cubic_tolerance = 0.005; /* deviation from the cubic, relative to the range */

static const double noise_factor = 4.0; /* changes below this many state tolerances are noise */
static const double immediate_return = 1e-3; /* part of a step between an event and the next */
enum { MOST_RETURNS = 50, MOST_UNRESOLVED = 8, MOST_ROUNDS = 10 };

/* --- modes --------------------------------------------------------------------------------- */

/* The result of an operation; a NaN of an undefined argument: kernels compare then, and an undefined
 * law that is not guarded makes f undefined. */
static double value_of(int operation, double z) {
    return isnan(z) ? z : bgc_result(operation, z);
}

/* Whether switch k is left to error control until the run ends. */
static int is_given_up(const bgc_data *d, int k) { return isinf(d->returns[k]); }

/* Whether the argument z is outside the range of the mode of switch k. */
static int has_left(const bgc_model *m, const bgc_data *d, int k, double z) {
    const double mode = d->mode[k];

    return !isnan(mode) && !isnan(z) && value_of(m->switch_info[k].operation, z) != mode;
}

static double depth_of(const bgc_model *m, const bgc_data *d, int k, double z) {
    return bgc_depth(m->switch_info[k].operation, d->mode[k], z);
}

/* Kernels take the modes for the results of the operations. */
void bgc_hold_modes(const bgc_model *m, bgc_data *d) {
    if (m->n_switch > 0) {
        memcpy(d->u + m->n_input, d->mode, (size_t)m->n_switch * sizeof *d->mode);
    }
}

/* Kernels evaluate the operations. */
void bgc_release_modes(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_switch; k++) {
        d->u[m->n_input + k] = (double)NAN;
    }
}

/* Sets the modes by the arguments at the present; returns 1 where one of them changes. */
static int update_modes(const bgc_model *m, bgc_data *d) {
    int changed = 0;

    m->switches(d->h, d->core.t, d->x, d->u, d->argument, d->work);
    for (int k = 0; k < m->n_switch; k++) {
        const double mode = value_of(m->switch_info[k].operation, d->argument[k]);
        d->extent[k] = fmax(d->extent[k], fabs(d->argument[k]));
        if (!is_given_up(d, k)) {
            changed |= d->mode[k] != mode && !(isnan(d->mode[k]) && isnan(mode));
            d->mode[k] = mode;
        }
    }
    return changed;
}

/* Finds the modes at the present, and leaves them released. Arguments that contain operations differ
 * by rounding between released and held modes. Steps see held ones, so the modes are iterated on
 * them. */
void bgc_find_modes(const bgc_model *m, bgc_data *d) {
    if (m->n_switch == 0) {
        return;
    }
    bgc_release_modes(m, d);
    update_modes(m, d);
    for (int round = 0; round < MOST_ROUNDS; round++) {
        bgc_hold_modes(m, d);
        if (!update_modes(m, d)) {
            break;
        }
    }
    bgc_release_modes(m, d);
}

/* At the start of a run: no modes yet, and no switch left to error control. */
void bgc_reset_modes(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_switch; k++) {
        d->mode[k] = 0.0;
        d->extent[k] = d->returns[k] = d->change_of_mode[k] = 0.0;
    }
    bgc_release_modes(m, d);
    d->core.unresolved = 0;
    d->core.event_at = (double)NAN;
}

/* moved = x with every state perturbed by about its tolerance. Sizes and signs follow low-discrepancy
 * sequences, so that perturbations do not cancel in differences of states. */
static void perturb_by_tolerances(const bgc_model *m, const bgc_data *d, const double *x,
                               double *moved) {
    const double size_stride = 0.6180339887498949, sign_stride = 0.7548776662466927;
    const bgc_core *core = &d->core;
    double size = 0.0, sign = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        const double tolerance = bgc_step_tolerance(fabs(x[i]), d->scale[i],
                                                    core->counts.scale_reached, core->rtol,
                                                    core->atol);
        const double off = (0.5 + 0.5 * size) * tolerance;
        moved[i] = x[i] + (sign < 0.5 ? off : -off);
        size = fmod(size + size_stride, 1.0);
        sign = fmod(sign + sign_stride, 1.0);
    }
}

/* --- location of the first event of a step --------------------------------------------------- */

/* Arguments are evaluated along the dense output of the step to d->next, or, for switches that depend
 * on time alone, with the present state. */
typedef enum { ALONG_STEP, TIME_ALONE } route;

static void evaluate(const bgc_model *m, bgc_data *d, route way, double t, double *z) {
    const double *x = d->x;

    if (way == ALONG_STEP && m->n_timed < m->n_switch) {
        bgc_interpolate(m, d, t, d->point);
        x = d->point;
    }
    m->switches(d->h, t, x, d->u, z, d->work);
}

/* Locates a time in (low, high] at which switch k leaves its mode, by the ITP method, whose worst case
 * is that of bisection and whose order is that of the secant method: I. F. D. Oliveira, R. H. C.
 * Takahashi, ACM Transactions on Mathematical Software 47 (2020) 5. The switch has left its mode at
 * `high`. Returns the end of a bracket of the width of the rounding of times, or of one bit where
 * only time matters. */
static double locate(const bgc_model *m, bgc_data *d, route way, int k, double low, double high,
                     double z_low, double z_high) {
    const double resolution =
        (way == TIME_ALONE ? 0.25 : 2.0) * DBL_EPSILON * fmax(fabs(low), fabs(high));
    const double width = high - low, bend = 0.2 / width;
    double at_low = depth_of(m, d, k, z_low), at_high = depth_of(m, d, k, z_high);
    double most = ceil(log2(fmax(width / (2.0 * resolution), 1.0))) + 1.0;

    for (double j = 0.0; high - low > 2.0 * resolution; j += 1.0) {
        /* Interpolate by regula falsi, truncate towards the middle, project on its neighbourhood. */
        const double half = 0.5 * (low + high), length = high - low;
        const double reach = resolution * exp2(most - j) - 0.5 * length;
        const double falsi = at_low > at_high ? (at_low * high - at_high * low) / (at_low - at_high)
                                              : half;
        const double side = half >= falsi ? 1.0 : -1.0;
        const double shift = fmin(bend * length * length, fabs(half - falsi));
        const double moved = falsi + side * shift;
        double t = fabs(moved - half) <= reach ? moved : half - side * fmax(reach, 0.0);
        if (!(t > low && t < high)) {
            t = half;
            if (!(t > low && t < high)) {
                break;
            }
        }

        /* Keep the half with the change of mode. */
        evaluate(m, d, way, t, d->probe);
        if (has_left(m, d, k, d->probe[k])) {
            high = t;
            at_high = depth_of(m, d, k, d->probe[k]);
        } else {
            low = t;
            at_low = depth_of(m, d, k, d->probe[k]);
        }
    }
    return high;
}

/* The first time in (low, high] at which any switch leaves its mode; some have left it at `high`.
 * z_low and z_high are the arguments at both ends; on return z_high are those at the time returned.
 * Switches of time alone are not located along a step, which ends at their event already. */
static double locate_first(const bgc_model *m, bgc_data *d, route way, double low, double high,
                           const double *z_low, double *z_high) {
    for (int k = 0; k < m->n_switch; k++) {
        const int timed = m->switch_info[k].timed;
        if ((way == TIME_ALONE && !timed) || (way == ALONG_STEP && timed && high == d->core.t_end) ||
            !has_left(m, d, k, z_high[k])) {
            continue;
        }
        high = locate(m, d, way, k, low, high, z_low[k], z_high[k]);
        evaluate(m, d, way, high, z_high);
    }
    return high;
}

/* Whether any switch has left its mode. */
static int any_left(const bgc_model *m, const bgc_data *d, const double *z, int only_timed) {
    for (int k = 0; k < m->n_switch; k++) {
        if ((m->switch_info[k].timed || !only_timed) && has_left(m, d, k, z[k])) {
            return 1;
        }
    }
    return 0;
}

/* The end of a step: `end`, or the first event before it of a switch that depends on time alone. */
double bgc_stop_for_switch(const bgc_model *m, bgc_data *d, double end) {
    if (m->n_timed == 0) {
        return end;
    }
    evaluate(m, d, TIME_ALONE, end, d->after);
    if (!any_left(m, d, d->after, 1)) {
        return end;
    }
    return locate_first(m, d, TIME_ALONE, d->core.t, end, d->argument, d->after);
}

/* The minimum of the parabola through three depths, if it is between the outer two and near the edge:
 * there the switch may leave its mode and return. Else a NaN. */
static double closest_approach(const double t[3], const double inside[3]) {
    const double left = (inside[1] - inside[0]) / (t[1] - t[0]);
    const double right = (inside[2] - inside[1]) / (t[2] - t[1]);
    const double curvature = (right - left) / (t[2] - t[0]);
    const double at = 0.5 * (t[0] + t[1] - left / curvature);
    const double least = inside[0] + (at - t[0]) * (left + curvature * (at - t[1]));

    return curvature > 0.0 && at > t[0] && at < t[2] && least < 0.1 * fmax(inside[0], inside[2])
               ? at
               : (double)NAN;
}

/* Whether an argument near the edge of its mode varies too fast for the samples of this step, z[0] at
 * its start and z[1 + i] at the points: a smooth one is close to a cubic. */
static int is_unresolved(const bgc_model *m, const bgc_data *d, int k, const double *const *z) {
    double low = z[0][k], high = low, nearest = depth_of(m, d, k, low), off = 0.0;

    /* Range, and least distance from the edge. */
    for (int i = 1; i <= BGC_SAMPLES; i++) {
        low = fmin(low, z[i][k]);
        high = fmax(high, z[i][k]);
        nearest = fmin(nearest, depth_of(m, d, k, z[i][k]));
    }

    /* Deviation from the cubic through four of the values. */
    for (int i = 0; i < 2; i++) {
        const double *w = cubic_weight[i];
        const double cubic = w[0] * z[0][k] + w[1] * z[1][k] + w[2] * z[4][k] + w[3] * z[5][k];
        off = fmax(off, fabs(cubic - z[2 + i][k]));
    }
    return off > cubic_tolerance * (high - low) && nearest < high - low &&
           high - low > d->core.rtol * d->extent[k];
}

/* Whether an argument changes in this step by more than the tolerances of the states change it: a
 * smaller change is noise, which no shorter step resolves. */
static int is_beyond_tolerances(const bgc_model *m, bgc_data *d, int k, const double *const *z) {
    double low = z[0][k], high = low;

    for (int i = 1; i <= BGC_SAMPLES; i++) {
        low = fmin(low, z[i][k]);
        high = fmax(high, z[i][k]);
    }
    perturb_by_tolerances(m, d, d->next, d->point);
    m->switches(d->h, d->core.t_end, d->point, d->u, d->after, d->work);
    return !(high - low <= noise_factor * fabs(d->after[k] - z[BGC_SAMPLES][k]));
}

/* Searches between samples i - 2 and i for a switch that leaves its mode and returns. If there is one,
 * returns 1, sets *found to the time of its event, and d->after to the arguments there. */
static int find_between(const bgc_model *m, bgc_data *d, int i, const double *t,
                        const double *const *z, double *found) {
    for (int k = 0; k < m->n_switch; k++) {
        double inside[3], at;
        for (int j = 0; j < 3; j++) {
            inside[j] = depth_of(m, d, k, z[i - 2 + j][k]);
        }
        at = closest_approach(t + i - 2, inside);
        if (isfinite(at)) {
            evaluate(m, d, ALONG_STEP, at, d->after);
            if (has_left(m, d, k, d->after[k])) {
                const int low = at < t[i - 1] ? i - 2 : i - 1;
                *found = locate_first(m, d, ALONG_STEP, t[low], at, z[low], d->after);
                return 1;
            }
        }
    }
    return 0;
}

/* BGC_NOT_FINITE where an argument becomes undefined at d->next and no other switch guards it: then f
 * is undefined too. z are the arguments there. */
static bgc_status check_defined(const bgc_model *m, bgc_data *d, double t, const double *z) {
    int undefined = 0, bad;

    for (int k = 0; k < m->n_switch; k++) {
        undefined |= isnan(z[k]) && (!isnan(d->mode[k]) || d->core.event);
    }
    if (!undefined) {
        return BGC_OK;
    }
    bgc_release_modes(m, d);
    m->rhs(d->h, t, d->next, d->u, d->right, d->work);
    d->core.counts.rhs++;
    bgc_hold_modes(m, d);
    bad = bgc_first_bad(m->n_state, d->right);
    if (bad < 0) {
        return BGC_OK;
    }
    d->core.failed_state = bad;
    return BGC_NOT_FINITE;
}

/* After a step to d->next at `end`, with its dense output stored: sets *found to the time of its first
 * event and d->next to the state there; to `end` where there is none. BGC_STEP_TOO_SMALL asks for a
 * shorter step, if `may_shorten`. */
bgc_status bgc_find_event(const bgc_model *m, bgc_data *d, double end, int may_shorten,
                          double *found) {
    const double start = d->core.t;
    const double *z[BGC_SAMPLES + 1] = {d->argument};
    double t[BGC_SAMPLES + 1] = {start};

    /* Arguments at the samples. */
    *found = end;
    d->core.event = 0;
    for (int i = 1; i <= BGC_SAMPLES; i++) {
        double *here = d->samples + (size_t)(i - 1) * bgc_padded(m->n_switch);
        t[i] = i == BGC_SAMPLES ? end : start + bgc_sample_at[i - 1] * (end - start);
        evaluate(m, d, ALONG_STEP, t[i], here);
        z[i] = here;
    }

    /* An argument that the samples do not resolve. */
    for (int k = 0; k < m->n_switch && may_shorten && d->core.unresolved < MOST_UNRESOLVED; k++) {
        if (is_unresolved(m, d, k, z) && is_beyond_tolerances(m, d, k, z)) {
            d->core.unresolved++;
            return BGC_STEP_TOO_SMALL;
        }
    }

    /* The first sample interval with an event: a mode left and regained, or left at its end. */
    for (int i = 1; i <= BGC_SAMPLES && !d->core.event; i++) {
        d->core.event = i > 1 && find_between(m, d, i, t, z, found);
        if (!d->core.event && any_left(m, d, z[i], 0)) {
            memcpy(d->after, z[i], (size_t)m->n_switch * sizeof *d->after);
            *found = locate_first(m, d, ALONG_STEP, t[i - 1], t[i], z[i - 1], d->after);
            d->core.event = 1;
        }
    }
    if (d->core.event) {
        bgc_interpolate(m, d, *found, d->next);
    }
    return check_defined(m, d, *found, d->core.event ? d->after : z[BGC_SAMPLES]);
}

/* --- after an event ------------------------------------------------------------------------- */

/* Whether f jumps with the mode of switch k, from `before`, by more than the tolerances of the states
 * change it. */
static int jumps_here(const bgc_model *m, bgc_data *d, int k, double before) {
    double *mode = d->u + m->n_input + k;
    int jumps = 0;

    bgc_hold_modes(m, d);
    m->rhs(d->h, d->core.t, d->x, d->u, d->right, d->work);
    perturb_by_tolerances(m, d, d->x, d->point);
    m->rhs(d->h, d->core.t, d->point, d->u, d->magnitude, d->work);
    *mode = before;
    m->rhs(d->h, d->core.t, d->x, d->u, d->point, d->work);
    d->core.counts.rhs += 3;
    bgc_release_modes(m, d);
    for (int i = 0; i < m->n_state && !jumps; i++) {
        const double off = fabs(d->magnitude[i] - d->right[i]);
        const double rounding = 16.0 * DBL_EPSILON * fabs(d->right[i]);
        jumps = !(fabs(d->point[i] - d->right[i]) <= noise_factor * off + rounding);
    }
    return jumps;
}

/* Counts the consecutive immediate returns of each switch. Where one returns without end, its law
 * drives the state to the edge from both sides: BGC_CHATTERING if f jumps there; if f is continuous,
 * the switch is left to error control. */
static bgc_status count_returns(const bgc_model *m, bgc_data *d, const double *before,
                                int in_a_row) {
    bgc_status status = BGC_OK;

    for (int k = 0; k < m->n_switch; k++) {
        const double change = d->mode[k] - before[k];
        if (is_given_up(d, k)) {
            continue;
        }
        d->returns[k] = in_a_row ? d->returns[k] : 0.0;
        if (change == 0.0 || isnan(change)) {
            continue;
        }
        d->returns[k] += change * d->change_of_mode[k] < 0.0;
        d->change_of_mode[k] = change;
        if (d->returns[k] < MOST_RETURNS) {
            continue;
        }
        if (m->switch_info[k].jumps && jumps_here(m, d, k, before[k])) {
            d->core.failed_switch = k;
            status = BGC_CHATTERING;
        } else {
            d->mode[k] = (double)NAN;
            d->returns[k] = (double)INFINITY;
        }
    }
    return status;
}

/* Iterates modes and algebraic equations until they agree: a jump of the states without a rate may
 * change other modes. Modes are held in the equations, which are smooth then. Where that does not
 * converge, the equations are solved with released modes. Leaves the modes released. */
bgc_status bgc_settle(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_switch * sizeof *d->mode;
    bgc_status status;

    if (m->n_switch == 0) {
        return bgc_make_consistent(m, d);
    }
    bgc_find_modes(m, d);
    for (int round = 0; round < MOST_ROUNDS && d->core.algebraic > 0; round++) {
        bgc_hold_modes(m, d);
        memcpy(d->after, d->mode, size);
        status = bgc_make_consistent(m, d);
        bgc_find_modes(m, d);
        if (status == BGC_OK && memcmp(d->after, d->mode, size) == 0) {
            return BGC_OK;
        }
    }
    status = bgc_make_consistent(m, d);
    bgc_find_modes(m, d);
    return status;
}

/* Sets the modes of switches whose arguments are no longer undefined. */
static void find_missing_modes(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_switch; k++) {
        if (isnan(d->mode[k]) && !is_given_up(d, k)) {
            d->mode[k] = value_of(m->switch_info[k].operation, d->argument[k]);
        }
    }
}

/* After an accepted step. Where it ended at an event: the new modes, and the states that jump with
 * them. `whole` is the length of the attempted step. */
bgc_status bgc_handle_event(const bgc_model *m, bgc_data *d, double whole) {
    bgc_core *core = &d->core;
    const int in_a_row =
        core->event_at == core->t_old && core->t - core->t_old <= immediate_return * whole;
    bgc_status status;

    core->unresolved = 0;
    if (!core->event) {
        m->switches(d->h, core->t, d->x, d->u, d->argument, d->work);
        find_missing_modes(m, d);
        return BGC_OK;
    }

    /* New modes and consistent states; f and the factors of W are those of the old modes. */
    core->event = 0;
    core->event_at = core->t;
    core->counts.events++;
    core->f_valid = core->jac_valid = core->held = 0;
    memcpy(d->probe, d->mode, (size_t)m->n_switch * sizeof *d->mode);
    status = bgc_settle(m, d);
    if (status == BGC_OK) {
        status = count_returns(m, d, d->probe, in_a_row);
    }
    bgc_hold_modes(m, d);
    return status;
}
