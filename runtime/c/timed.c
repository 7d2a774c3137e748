/* timed.c: limits steps so that sources in time are not skipped.
 *
 * Error control compares a few stages of a step, and a pulse between two of them stays unseen. The
 * terms of the rates that depend on time alone are looked at without integrating: interval arithmetic
 * bounds each term and its derivative over a window of times. A step of length h misses nothing where
 * h max|g'| is at most a few times the variation of g, or where g does not vary. One look ahead serves
 * the steps of a whole window; only where it does not, the step itself is looked at, in pieces from its
 * start, and ends before the first piece that a step does not resolve.
 *
 * A term that goes on to limit steps although f hardly changes over them is given more room: error
 * control has judged that its motion does not matter.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double resolution = 5.0;        /* h max|g'| over the variation of g; a parabola has 4, */
static const double fixed_resolution = 0.25; /* and a fixed step has no error estimate to help */
static const double still = 1e-9;           /* a variation below this part of the largest, before or
                                             * in a window ahead, is none */
static const double small_part = 0.01;      /* of the largest variation, that also counts as one */
static const double near_enough = 1.0 / 32; /* of a resolved stretch: where the step ends before a motion */
static const double no_effect = 0.1;        /* change of f in a limited step, over the tolerances */
enum { MOST_PIECES = 200, LEAST_WINDOW = 4, MOST_WINDOW = 1024, PATIENCE = 16, MOST_CUTS = 64, CUTS_IN_A_ROW = 8 };

/* What a piece of time allows: the longest resolved step, and the term that limits it. */
typedef struct {
    double step;
    int term, unknown;
} allowance;

/* The part of a step, at least 1, up to which the stages of a method reach: some lie beyond its end. */
static double reach_of(const bgc_method *method) {
    double reach = 1.0;

    for (int s = 0; method->tableau != NULL && s < method->tableau->stages; s++) {
        reach = fmax(reach, method->tableau->alpha[s]);
    }
    return reach;
}

void bgc_reset_terms(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;

    for (int k = 0; k < m->n_term; k++) {
        d->variation[k] = 0.0;
        d->patience[k] = 1.0;
    }
    core->timed_window = 16.0;
    core->reach = reach_of(&bgc_methods[core->method]);
    core->limited_by = -1;
    core->without_effect = core->cuts = core->cuts_in_a_row = 0;
    core->cut_tick = -1;
    bgc_reset_time_windows(m, d);
}

static void evaluate_terms(const bgc_model *m, bgc_data *d, double from, double to) {
    m->ranges(d->h_range, (bgc_range){from, to}, d->u_range, d->term_range, (bgc_range *)d->work);
}

static double variation_of(const bgc_data *d, int k) {
    return d->term_range[2 * k].high - d->term_range[2 * k].low;
}

/* What the ranges at hand allow; d->around holds the variations to compare with. */
static allowance find_allowance(const bgc_model *m, const bgc_data *d) {
    const double most = bgc_is_adaptive(&bgc_methods[d->core.method]) ? resolution : fixed_resolution;
    allowance found = {INFINITY, -1, 0};

    for (int k = 0; k < m->n_term; k++) {
        const bgc_range rate = d->term_range[2 * k + 1];
        const double fastest = fmax(-rate.low, rate.high), width = variation_of(d, k);
        const double around = isfinite(d->around[k]) ? d->around[k] : 0.0;
        const int unknown = !isfinite(width) || !isfinite(fastest);
        double step;
        if (isinf(d->patience[k]) ||
            (!unknown && width <= still * fmax(d->widest[k], d->variation[k]))) {
            continue;
        }
        step = unknown ? 0.0
                       : d->patience[k] * most * fmax(around, small_part * d->variation[k]) / fastest;
        if (step < found.step) {
            found = (allowance){step, k, unknown};
        }
    }
    return found;
}

/* Remembers the variations over a stretch that a step resolves. */
static void remember_variations(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_term; k++) {
        const double width = variation_of(d, k);
        d->variation[k] = isfinite(width) ? fmax(d->variation[k], width) : d->variation[k];
    }
}

static void compare_with_these(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_term; k++) {
        d->around[k] = variation_of(d, k);
    }
}

/* Examines many steps of length h from t at once; returns whether all of them resolve what acts within. */
static int is_window_resolved(const bgc_model *m, bgc_data *d, double t, double h) {
    bgc_core *core = &d->core;
    const double end = t + core->timed_window * core->reach * h;
    allowance allowed;

    evaluate_terms(m, d, t, end);
    compare_with_these(m, d);
    for (int k = 0; k < m->n_term; k++) {
        d->widest[k] = isfinite(d->around[k]) ? d->around[k] : 0.0;
    }
    allowed = find_allowance(m, d);
    if (allowed.step < h) {
        core->timed_window = fmax(LEAST_WINDOW, core->timed_window / 4.0);
        return 0;
    }
    remember_variations(m, d);
    core->resolved_from = t;
    core->resolved_to = end;
    core->resolved_step = allowed.step;
    core->timed_window = fmin(2.0 * core->timed_window, MOST_WINDOW);
    return 1;
}

/* The part of a step of length h from t that needs no cut, or whose motion it resolves; sets
 * core->limited_by to the term that limits it there. */
static double resolved_part(const bgc_model *m, bgc_data *d, double t, double h) {
    const double reach = d->core.reach, end = t + reach * h;
    double at = t, piece = end - t;

    evaluate_terms(m, d, t, end);
    compare_with_these(m, d);
    for (int n = 0; n < MOST_PIECES; n++) {
        allowance allowed;
        piece = fmin(piece, end - at);
        evaluate_terms(m, d, at, at + piece);
        allowed = find_allowance(m, d);
        if (allowed.step >= h) {
            at += piece;
            if (at >= end - 4.0 * DBL_EPSILON * fabs(end)) {
                remember_variations(m, d);
                return h;
            }
            piece *= 2.0;
            continue;
        }
        if (at > t && piece <= near_enough * (at - t)) {
            return (at - t) / reach;
        }
        if (at == t && allowed.step >= piece) {
            remember_variations(m, d);
            d->core.limited_by = allowed.term;
            return fmin(piece / reach, h);
        }
        if (at == t && piece < 1e-12 * h) { /* a term without bounds */
            d->patience[allowed.term] = INFINITY;
            piece = end - t;
            continue;
        }
        piece *= 0.5;
    }
    return at > t ? (at - t) / reach : h;
}

/* Under fixed steps, whether the step under way may still be cut. Cuts in many steps in a row belong to
 * an oscillation that the step is too long for altogether, which is the user's choice. */
static int may_cut(bgc_data *d) {
    bgc_core *core = &d->core;

    if (core->cut_tick != core->ticks) {
        core->cuts_in_a_row = core->cut_tick == core->ticks - 1 ? core->cuts_in_a_row + 1 : 1;
        core->cut_tick = core->ticks;
        core->cuts = 0;
        if (core->cuts_in_a_row > CUTS_IN_A_ROW && core->limited_by >= 0) {
            d->patience[core->limited_by] *= 2.0;
            core->cuts_in_a_row = 0;
        }
    }
    return core->cuts++ < MOST_CUTS;
}

/* The length of a step from t, at most h, in which nothing that depends on time alone moves unseen. */
double bgc_limit_for_time(const bgc_model *m, bgc_data *d, double t, double h) {
    bgc_core *core = &d->core;
    double part;

    core->limited_by = -1;
    if (m->n_term == 0 || !(h > 0.0) ||
        (t >= core->resolved_from && t + core->reach * h <= core->resolved_to + 1e-9 * h && h <= core->resolved_step) ||
        is_window_resolved(m, d, t, h)) {
        return h;
    }
    part = resolved_part(m, d, t, h);
    if (part < h && !bgc_is_adaptive(&bgc_methods[core->method]) && !may_cut(d)) {
        return h;
    }
    return part;
}

/* After a step with error control of length h that a term has limited, with f at its end in d->f and at
 * its start in d->f_before: where f has hardly changed so many times in a row, the term may limit steps
 * less. */
void bgc_judge_terms(const bgc_model *m, bgc_data *d, double h) {
    bgc_core *core = &d->core;
    const int k = core->limited_by;

    if (k < 0) {
        return;
    }
    for (int i = 0; i < m->n_state; i++) {
        if (d->inverse_mass[i] == 0.0 && d->algebraic[i] == 0.0) { /* coupled rates */
            return;
        }
        d->right[i] = h * d->inverse_mass[i] * (d->f[i] - d->f_before[i]);
    }
    if (bgc_norm(m, d, d->right, d->x, d->x) > no_effect) {
        core->without_effect = 0;
        d->patience[k] = 1.0;
    } else if (++core->without_effect >= PATIENCE) {
        core->without_effect = 0;
        d->patience[k] *= 2.0;
    }
}
