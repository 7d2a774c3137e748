/* switch_margins.c: switches that stay far from the edge of their mode during a step.
 *
 * Most steps come near to no edge. An argument that is farther from the edge than it varies between a few
 * samples of the step needs no closer look. Where it is much farther away than it has varied in the steps
 * before, its value at the end of the step is enough; every few steps all arguments are looked at within
 * the step nevertheless: every 8th, or up to every 32nd where the distance is so large that a variation within
 * the steps, unseen at their ends, would have to grow as fast to reach the edge.
 *
 * Where a body or a valve rests on the edge of a kink, the argument crosses it by rounding in most steps.
 * Once f has shown that the effect of this is far from mattering, the value at the end is enough too, as long
 * as the argument stays near the edge: the effect grows with the distance from it. Switches at which f jumps
 * never count as resting.
 */
#include "switches.h"

#include <math.h>

static const double far_margins[] = {0x1p4, 0x1p8, 0x1p12, 0x1p16}; /* times the variation of steps before */
static const double rounding_part = 1e-10; /* of the largest argument so far: less is rounding */
enum { END_CHECKS = 31 }; /* steps that are examined at their end only, before one is examined within */

/* fmin and fmax of numbers, without a call. */
static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

/* The next step is to be examined within. */
void bgc_check_within(bgc_data *d) { d->core.end_checks = 0; }

/* Whether the argument of switch k, now z, rests on the edge of a kink. `growth` is the length of the step
 * over that of the step before, if it is longer. */
static inline int rests_on_edge(const bgc_data *d, int k, double z, double growth) {
    const double reach = d->rest[k];

    return reach > 0.0 && growth * fabs(d->argument[k]) <= reach && growth * fabs(z) <= reach;
}

/* The kinks that rest on their edges, by the arguments z at the end of the step, are released in it. */
static void release_resting(const bgc_model *m, bgc_data *d, const double *z, double growth) {
    for (int k = 0; k < m->n_switch; k++) {
        if (rests_on_edge(d, k, z[k], growth)) {
            d->ignored[k] = bgc_released;
        }
    }
    d->core.near_edge = 1;
}

/* Switch k is a kink that has left its mode in a step with arguments z, and f hardly changed: it rests on its
 * edge if it moved by rounding alone. */
void bgc_note_rest(bgc_data *d, int k, const double *const *z) {
    const double rounding = rounding_part * d->extent[k];
    double most = 0.0;

    d->rest[k] = 0.0;
    for (int i = 0; i <= BGC_SAMPLES; i++) {
        if (!(fabs(z[i][k]) <= rounding)) {
            return;
        }
        most = larger(most, fabs(z[i][k]));
    }
    d->rest[k] = bgc_rest_margin * most;
}

/* Whether every argument is far from the edge of its mode, by the arguments z at the end of a step of
 * length h, or constant within its mode, or rests on the edge of a kink. Counts the steps that
 * are examined at their end only. */
int bgc_are_all_far(const bgc_model *m, bgc_data *d, const double *z, double h) {
    const double last = d->core.counts.last_step, growth = h > last ? h / last : 1.0;
    const int eights = (END_CHECKS - d->core.end_checks) / 8; /* of steps since the last look within */
    const double far = far_margins[eights];
    int resting = 0;

    if (d->core.end_checks == 0 || !(last > 0.0)) {
        return 0;
    }
    d->core.end_checks--;
    for (int k = d->core.skipped ? m->n_timed : 0; k < m->n_switch; k++) {
        const int operation = m->switch_info[k].operation;
        const double mode = d->mode[k], before = d->argument[k], change = fabs(z[k] - before);
        const double swing = larger(growth * d->swing[k], change);
        const double nearest = bgc_lesser_depth(operation, mode, before, z[k]);
        if (isnan(mode) ||
            (!(nearest > far * swing) && (swing != 0.0 || bgc_is_outside(m, d, k, z[k])))) {
            if (isnan(mode) || eights > 0 || !rests_on_edge(d, k, z[k], growth)) {
                return 0;
            }
            resting = 1;
            continue;
        }
        d->swing[k] = swing;
    }
    if (resting) {
        release_resting(m, d, z, growth);
    }
    return 1;
}

/* Marks the switches that are far from the edge of their mode, by the arguments z at the start of a step and
 * its first samples: farther away than they vary, or constant within their mode, be it on the edge (a
 * valve that rests on its seat); and those of time alone that stay within their modes (time_events.c). Returns
 * whether all are. */
int bgc_mark_far(const bgc_model *m, bgc_data *d, const double *const *z) {
    const double *z1 = z[bgc_first_sample[0]], *z2 = z[bgc_first_sample[1]];
    const double *z3 = z[bgc_first_sample[2]];
    const int first = d->core.skipped ? m->n_timed : 0;
    int all_far = 1;

    for (int k = 0; k < first; k++) {
        d->ignored[k] = bgc_marked_far;
    }
    for (int k = first; k < m->n_switch; k++) {
        const int operation = m->switch_info[k].operation;
        const double mode = d->mode[k], all = z[0][k] + z1[k] + z2[k] + z3[k];
        const double low = smaller(smaller(z[0][k], z1[k]), smaller(z2[k], z3[k]));
        const double high = larger(larger(z[0][k], z1[k]), larger(z2[k], z3[k]));
        const double nearest = bgc_lesser_depth(operation, mode, low, high);
        const int far = !isnan(all) && !isnan(mode) &&
                          (nearest > bgc_far_from_edge * (high - low) ||
                           (low == high && !bgc_is_outside(m, d, k, high)));
        if (!far) {
            all_far = 0;
        } else if (d->ignored[k] == 0.0) {
            d->ignored[k] = bgc_marked_far;
        }
        d->swing[k] = high - low;
        d->rest[k] = 0.0;
    }
    d->core.end_checks = END_CHECKS;
    return all_far;
}
