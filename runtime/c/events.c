/* events.c: events of piecewise laws.
 *
 * Within a step every comparison, sign, rounding and kink of the model is held at its mode, so that f
 * is smooth and the method keeps its order. The dense output of the step shows whether an argument has
 * left the range of its mode, at the end or within. The first time at which one has is located
 * (event_location.c), the step is cut there, and the next step starts in the new modes (modes.c).
 */
#include "control.h"
#include "switches.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double negligible = 1e-3; /* effect of a kink on a step, relative to the tolerances */
static const double near_part = 0.1;     /* depth of a minimum over those around it: it may be outside */
static const double lower_part = 0.5;    /* depth of a minimum over that of a point: it is elsewhere */
static const double least_part = 0.01; /* of a step, that has to be more than the rounding of times */
enum { MOST_UNRESOLVED = 8, MOST_PROBES = 4 };

/* Whether any switch has left its mode. */
static int any_left(const bgc_model *m, const bgc_data *d, const double *z) {
    for (int k = 0; k < m->n_switch; k++) {
        if (bgc_has_left(m, d, k, z[k])) {
            return 1;
        }
    }
    return 0;
}

/* The place of the arguments at sample i of a step. */
static double *sample_place(const bgc_model *m, const bgc_data *d, int i) {
    return d->samples + (size_t)(i - 1) * bgc_padded(m->n_switch);
}

/* After steps without a look at the switches of time alone: their arguments at the present. */
static void catch_up(const bgc_model *m, bgc_data *d) {
    d->core.skipped = 0;
    bgc_check_within(d);
    if (m->n_timed == m->n_switch) {
        bgc_evaluate_arguments(m, d, BGC_TIME_ALONE, d->core.t, d->argument);
    }
}

/* Whether a switch of time alone has left its mode at `end`, with its arguments in z: a bracket of the event. */
static int leaves_by_end(const bgc_model *m, bgc_data *d, double end, double *inside, double *outside) {
    double *z = sample_place(m, d, BGC_SAMPLES);

    bgc_evaluate_arguments(m, d, BGC_TIME_ALONE, end, z);
    *inside = d->core.t;
    *outside = end;
    for (int k = 0; k < m->n_timed; k++) {
        if (bgc_is_outside(m, d, k, z[k])) {
            return 1;
        }
    }
    return 0;
}

/* The end of a step: `end`, or the first event before it of a switch that depends on time alone. Events at an
 * instant of sampled parts, but for rounding, are before it: the step ends behind them all, a few bits after both
 * `time >= 0.6` and `time > 0.6` have changed, and sample 2 of 0.3 s comes next. */
double bgc_stop_for_switch(const bgc_model *m, bgc_data *d, double end) {
    const double rounding = 8.0 * DBL_EPSILON * fabs(end);
    const int at_instant = end >= d->core.instant - bgc_time_slack(end, d->core.t);
    const double last = at_instant ? end + rounding : end;
    double *z = sample_place(m, d, BGC_SAMPLES), inside, outside, first;
    bgc_outlook outlook;

    if (m->n_timed == 0) {
        return end;
    }
    outlook = bgc_find_time_event(m, d, d->core.t, last, &inside, &outside);
    if (outlook == BGC_STAYS) {
        d->core.skipped = 1;
        d->core.event = d->core.near_edge = 0;
        return end;
    }
    if (d->core.skipped) {
        catch_up(m, d);
    }
    if (outlook == BGC_UNDECIDED && !leaves_by_end(m, d, last, &inside, &outside)) {
        return end;
    }
    memset(d->ignored, 0, (size_t)m->n_switch * sizeof *d->ignored);
    bgc_evaluate_arguments(m, d, BGC_TIME_ALONE, inside, d->after);
    bgc_evaluate_arguments(m, d, BGC_TIME_ALONE, outside, z);
    first = bgc_locate_first(m, d, BGC_TIME_ALONE, inside, outside, d->after, z);
    if (at_instant && first >= end - rounding) {
        bgc_evaluate_arguments(m, d, BGC_TIME_ALONE, last, z);
        return last;
    }
    return first;
}

/* Whether f at the end of the step under way, at time t, is that of the next step as far as is known, and has
 * not been evaluated. Inputs may change at a sample of devices or parts, all that f reads between calls. */
static int is_next_f(const bgc_model *m, const bgc_data *d, double t) {
    const bgc_core *core = &d->core;
    const double known = m->n_input > 0 ? fmin(core->due, core->until) : core->until;

    return !core->f_at_end && core->f_last_at != t && t < known - bgc_time_slack(t, core->t_old);
}

/* Evaluates the arguments at d->next, the end of the step under way, at time t; behind f, if the next step
 * begins with that. */
static void evaluate_end(const bgc_model *m, bgc_data *d, double t, double *z) {
    if (m->switches_after_rhs != NULL && is_next_f(m, d, t)) {
        m->rhs(d->h, t, d->next, d->u, d->error, d->work);
        m->switches_after_rhs(d->h, t, d->next, d->u, z, d->work);
        d->core.counts.rhs++;
        d->core.f_at_end = 1;
    } else {
        m->switches(d->h, t, d->next, d->u, z, d->work);
    }
}

/* Evaluates the arguments at sample i of the step under way, at time t, in the place of that sample. Where
 * all depend on time alone, those at its end are known. */
static const double *evaluate_sample(const bgc_model *m, bgc_data *d, int i, double t) {
    double *here = sample_place(m, d, i);

    if (i == BGC_SAMPLES && m->n_timed == m->n_switch) {
        return here;
    }
    if (i == BGC_SAMPLES && d->core.algebraic == 0) {
        evaluate_end(m, d, t, here);
    } else {
        bgc_evaluate_arguments(m, d, BGC_ALONG_STEP, t, here);
    }
    return here;
}

/* d->ignored: a kink is compared. */
static const double entering = 1.0;

/* Holds the modes, but releases switches whose change is negligible in the step under way. */
static void hold_watched(const bgc_model *m, bgc_data *d) {
    bgc_hold_modes(m, d);
    for (int k = 0; k < m->n_switch; k++) {
        if (d->ignored[k] == bgc_released) {
            d->u[m->n_input + k] = (double)NAN;
        }
    }
}

/* Rows within the step under way compare the kinks whose change is negligible for f: outputs may depend
 * on them more. */
static void release_in_step(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_switch; k++) {
        if (d->ignored[k] == bgc_released) {
            d->u_step[m->n_input + k] = (double)NAN;
        }
    }
}

/* Whether kinks of states, and nothing else, have left their modes by the arguments z. */
static int only_kinks_left(const bgc_model *m, const bgc_data *d, const double *z) {
    int kinks = 0;

    for (int k = 0; k < m->n_switch; k++) {
        if (bgc_has_left(m, d, k, z[k])) {
            if (m->switch_info[k].jumps || m->switch_info[k].timed) {
                return 0;
            }
            kinks = 1;
        }
    }
    return kinks;
}

/* The effect on the step under way, over the tolerances, of the change of f by the kinks marked `entering`:
 * that at time t, over the whole step. */
static double effect_of_kinks(const bgc_model *m, bgc_data *d, double t) {
    const double h = d->core.t_end - d->core.t;

    bgc_interpolate(m, d, t, d->point);
    m->rhs(d->h, t, d->point, d->u, d->right, d->work);
    for (int k = 0; k < m->n_switch; k++) {
        if (d->ignored[k] == entering) {
            d->u[m->n_input + k] = (double)NAN;
        }
    }
    m->rhs(d->h, t, d->point, d->u, d->magnitude, d->work);
    hold_watched(m, d);
    d->core.counts.rhs += 2;
    for (int j = 0; j < m->n_state; j++) {
        const double change = d->magnitude[j] - d->right[j];
        if (change != 0.0 && d->inverse_mass[j] == 0.0) { /* rates are coupled, or there is none */
            return (double)INFINITY;
        }
        d->right[j] = h * d->inverse_mass[j] * change;
    }
    return bgc_norm(m, d, d->right, d->x, d->next);
}

/* Evaluates the arguments z at the samples from i on, at times t, on the new pieces of kinks that have been
 * released. An argument that contains such a kink, as abs(v) > v does, may have been constant on the old
 * piece: no switch is far from its edge any more, and none rests where others leave their modes with it. */
static void look_again(const bgc_model *m, bgc_data *d, int i, const double *t, const double *const *z) {
    for (int k = 0; k < m->n_switch; k++) {
        d->ignored[k] = d->ignored[k] == bgc_marked_far ? 0.0 : d->ignored[k];
    }
    for (int j = i; j <= BGC_SAMPLES; j++) {
        evaluate_sample(m, d, j, t[j]);
        if (any_left(m, d, z[j])) {
            memset(d->rest, 0, (size_t)m->n_switch * sizeof *d->rest);
        }
    }
}

/* Where kinks have left their modes at time `at`, with arguments `left`, ignores them in this step if f
 * on their new pieces differs too little to matter until its end: the rounding of a body at rest is no
 * reason to end a step. They are released, so that the arguments z of other switches at the samples from
 * i on, at times t, are right on the new pieces too. */
static void ignore_negligible(const bgc_model *m, bgc_data *d, const double *left, double at, int i,
                              const double *t, const double *const *z) {
    double deepest = 0.0, farthest = at, effect;
    int matter;

    if (!only_kinks_left(m, d, left)) {
        return;
    }

    /* They are compared there, and where one of them is farthest outside. */
    for (int k = 0; k < m->n_switch; k++) {
        if (bgc_has_left(m, d, k, left[k])) {
            for (int j = i; j <= BGC_SAMPLES; j++) {
                const double depth = bgc_depth_of(m, d, k, z[j][k]);
                farthest = depth < deepest ? t[j] : farthest;
                deepest = depth < deepest ? depth : deepest;
            }
            d->ignored[k] = entering;
        }
    }
    effect = effect_of_kinks(m, d, at);
    if (farthest != at && effect <= negligible) {
        effect = fmax(effect, effect_of_kinks(m, d, farthest));
    }
    matter = !(effect <= negligible);
    for (int k = 0; k < m->n_switch; k++) {
        if (d->ignored[k] == entering) {
            d->ignored[k] = matter ? 0.0 : bgc_released;
            if (effect * bgc_rest_margin <= negligible) {
                bgc_note_rest(d, k, z);
            }
        }
    }
    if (!matter) {
        hold_watched(m, d);
        release_in_step(m, d);
        look_again(m, d, i, t, z);
    }
}

/* Whether switch k leaves its mode and returns between three times, by the arguments there, and this before
 * *found. If so, sets *found to the time of the event, which is after `from[0]`, and d->after to the arguments
 * there. Sample i is the first behind the three. */
static int finds_return(const bgc_model *m, bgc_data *d, int k, const double from[3],
                        const double *const arguments[3], int i, const double *t,
                        const double *const *z, double *found) {
    double times[3], inside[3], least, at, depth;
    int low;

    if (d->ignored[k] != 0.0) {
        return 0;
    }
    for (int j = 0; j < 3; j++) {
        times[j] = from[j];
        inside[j] = bgc_depth_of(m, d, k, arguments[j][k]);
    }
    at = bgc_parabola_minimum(times, inside, &least);
    if (!(least < near_part * fmax(inside[0], inside[2]))) {
        return 0;
    }
    at = bgc_point_within(times, at, t);
    for (int probes = 0; at < *found && probes < MOST_PROBES; probes++) {
        bgc_evaluate_arguments(m, d, BGC_ALONG_STEP, at, d->probe);
        depth = bgc_depth_of(m, d, k, d->probe[k]);
        if (bgc_has_left(m, d, k, d->probe[k])) {
            ignore_negligible(m, d, d->probe, at, i, t, z);
        }
        if (bgc_has_left(m, d, k, d->probe[k])) {
            low = at < from[1] ? 0 : 1;
            memcpy(d->after, d->probe, (size_t)m->n_switch * sizeof *d->after);
            *found = bgc_locate_first(m, d, BGC_ALONG_STEP, from[low], at, arguments[low], d->after);
            return 1;
        }

        /* The depth has a minimum elsewhere between these times if the parabola through this point falls far
         * below it. */
        bgc_narrow(times, inside, at, depth);
        at = bgc_parabola_minimum(times, inside, &least);
        if (d->ignored[k] != 0.0 || !(at > times[0] && at < times[2]) || !(least < lower_part * depth)) {
            return 0;
        }
    }
    return 0;
}

/* Searches between samples i - 2 and i for switches that leave their modes and return. If there is one,
 * returns 1, sets *found to the time of the first event, and d->after to the arguments there. */
static int find_between(const bgc_model *m, bgc_data *d, int i, const double *t,
                        const double *const *z, double *found) {
    const double *const arguments[3] = {z[i - 2], z[i - 1], z[i]};
    int event = 0;

    for (int k = 0; k < m->n_switch; k++) {
        event |= finds_return(m, d, k, t + i - 2, arguments, i, t, z, found);
    }
    return event;
}

/* The step ends at *found, between samples i - 1 and i: searches for switches that leave their modes and
 * return before. */
static void find_before(const bgc_model *m, bgc_data *d, int i, const double *t,
                        const double *const *z, double *found) {
    const double *const arguments[3] = {z[i - 1], d->after, z[i]};

    for (int k = 0; k < m->n_switch && *found < t[i]; k++) {
        const double times[3] = {t[i - 1], *found, t[i]};
        finds_return(m, d, k, times, arguments, i, t, z, found);
    }
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
    double t[BGC_SAMPLES + 1];

    /* Arguments at the samples: at the end and at a few first. */
    *found = end;
    d->core.event = d->core.near_edge = 0;
    memset(d->ignored, 0, (size_t)m->n_switch * sizeof *d->ignored);
    if (m->n_jump > 0) {
        bgc_ignore_turned(m, d);
    }
    z[BGC_SAMPLES] = evaluate_sample(m, d, BGC_SAMPLES, end);
    if (bgc_are_all_far(m, d, z[BGC_SAMPLES], end - start)) {
        if (d->core.near_edge) {
            release_in_step(m, d);
        }
        return BGC_OK;
    }
    t[0] = start;
    for (int i = 1; i <= BGC_SAMPLES; i++) {
        t[i] = i == BGC_SAMPLES ? end : start + bgc_sample_at[i - 1] * (end - start);
    }
    for (int j = 0; j < BGC_FIRST_SAMPLES; j++) {
        const int i = bgc_first_sample[j];
        z[i] = z[i] != NULL ? z[i] : evaluate_sample(m, d, i, t[i]);
    }
    if (bgc_mark_far(m, d, z)) {
        return BGC_OK;
    }
    d->core.near_edge = 1;
    for (int i = 1; i < BGC_SAMPLES; i++) {
        z[i] = z[i] != NULL ? z[i] : evaluate_sample(m, d, i, t[i]);
    }

    if (m->n_jump > 0) {
        bgc_judge_turned(m, d, z);
    }

    /* An argument that the samples do not resolve; those of a step of a few bits of the time are
     * rounded to its ends. */
    may_shorten = may_shorten && d->core.unresolved < MOST_UNRESOLVED &&
                  !bgc_is_too_short(start, least_part * (end - start));
    for (int k = 0; k < m->n_switch && may_shorten; k++) {
        if (d->ignored[k] == 0.0 && bgc_is_unresolved(m, d, k, z) &&
            bgc_is_beyond_tolerances(m, d, k, z)) {
            d->core.unresolved++;
            return BGC_STEP_TOO_SMALL;
        }
    }

    /* The first sample interval with an event: a mode left and regained, or left at its end. */
    for (int i = 1; i <= BGC_SAMPLES && !d->core.event; i++) {
        d->core.event = i > 1 && find_between(m, d, i, t, z, found);
        if (!d->core.event && any_left(m, d, z[i])) {
            memcpy(d->after, z[i], (size_t)m->n_switch * sizeof *d->after);
            ignore_negligible(m, d, d->after, t[i], i, t, z);
        }
        if (!d->core.event && any_left(m, d, z[i])) {
            memcpy(d->after, z[i], (size_t)m->n_switch * sizeof *d->after);
            *found = bgc_locate_first(m, d, BGC_ALONG_STEP, t[i - 1], t[i], z[i - 1], d->after);
            d->core.event = 1;
        }
        if (d->core.event) {
            find_before(m, d, *found > t[i - 1] ? i : i - 1, t, z, found);
        }
    }
    if (d->core.event) {
        bgc_interpolate(m, d, *found, d->next);
    }
    return check_defined(m, d, *found, d->core.event ? d->after : z[BGC_SAMPLES]);
}
