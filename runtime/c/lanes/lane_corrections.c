/* lane_corrections.c: detection of fixed steps that are far too long, of a batch: corrections.c.
 *
 * Every step forms the corrections and compares them with what counts as resolved. The range of a state
 * only grows, so that the range of an earlier step serves for that. Only where a correction is larger is
 * it entered.
 */
#include "lanes/batch.h"
#include "corrections.h"

#include <string.h>

/* Where a second stage would be, a method of one stage keeps that of the step before, to compare. */
static int compares_with_step_before(const bgc_batch *b) {
    return b->method->tableau->stages == 1;
}

static void keep_stage(bgc_batch *b) {
    memcpy(b->stages + b->m->n_state, b->stages, (size_t)b->m->n_state * sizeof *b->stages);
}

/* At the start of a run, and where the method changes: which stages enter the corrections. None under error control, nor where steps
 * are subdivided by their error. */
void bgc_batch_begin_corrections(bgc_batch *b) {
    const bgc_tableau *tableau = b->method->tableau;
    const int stages = compares_with_step_before(b) ? 2 : tableau->stages;
    bgc_lane_terms *terms = &b->terms;

    terms->count = 0;
    if (bgc_is_adaptive(b->method) || b->option->substeps > 1) {
        return;
    }
    for (int j = 0; j < stages; j++) {
        if (tableau->e[j] != 0.0) {
            terms->weight[terms->count] = tableau->e[j];
            terms->stage[terms->count++] = b->stages + (size_t)j * (size_t)b->m->n_state;
        }
    }
    for (int i = 0; i < b->m->n_state; i++) {
        b->resolved[i] = bgc_resolved_correction(b->scale[i], b->range[i]);
    }
}

/* The correction of state i in the last step: `count` terms. */
static inline lane correction_of(const bgc_lane_terms *terms, int count, int i) {
    lane change = terms->weight[0] * terms->stage[0][i];

    for (int j = 1; j < count; j++) {
        change += terms->weight[j] * terms->stage[j][i];
    }
    return change;
}

/* Enters the ranges of all states; returns where the correction of one is above what counts as
 * resolved. Inlined, with a constant `count`. */
static inline lane_mask find_unresolved(bgc_batch *b, int count) {
    const bgc_lane_terms *terms = &b->terms;
    const int n = b->m->n_state;
    const lane *restrict x = b->x, *restrict resolved = b->resolved;
    lane *restrict range = b->range;
    lane_mask found = lane_of(0.0) != lane_of(0.0);

    for (int i = 0; i < n; i++) {
        found |= lane_fabs(correction_of(terms, count, i)) > resolved[i];
        range[i] = number_larger(range[i], lane_fabs(x[i]));
    }
    return found;
}

/* Enters the corrections of the lanes that have taken the last step with the batch. */
static void enter_corrections(bgc_batch *b) {
    lane together = lane_of(1.0);

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        lane_set(&together, l, (b->single >> l & 1u) != 0 ? 0.0 : 1.0);
    }
    for (int i = 0; i < b->m->n_state; i++) {
        const lane size = lane_fabs(correction_of(&b->terms, b->terms.count, i));
        const lane_mask larger = (size > b->correction[i]) & (together > lane_of(0.0));
        b->corrected_at[i] = lane_select(larger, lane_of(b->t_old), b->corrected_at[i]);
        b->correction[i] = lane_select(larger, size, b->correction[i]);
        b->resolved[i] = bgc_resolved_correction(b->scale[i], b->range[i]);
    }
}

/* After a fixed step, when single lanes have taken it by themselves. */
void bgc_batch_record_corrections(bgc_batch *b) {
    lane_mask found;

    switch (b->terms.count) { /* loops of fixed length */
    case 0:
        return;
    case 1:
        found = find_unresolved(b, 1);
        break;
    case 2:
        if (compares_with_step_before(b) && b->ticks == 0) {
            keep_stage(b);
        }
        found = find_unresolved(b, 2);
        break;
    case 4:
        found = find_unresolved(b, 4);
        break;
    default:
        found = find_unresolved(b, b->terms.count);
        break;
    }
    if (bgc_lanes_where(b, found) != 0) {
        enter_corrections(b);
    }
    if (compares_with_step_before(b)) {
        keep_stage(b);
    }
}

/* Gives lane l, which takes the last step by itself, the stage of the step before, */
void bgc_batch_give_stage(const bgc_batch *b, int l, bgc_data *d) {
    const int n = b->m->n_state;

    for (int i = 0; compares_with_step_before(b) && i < n; i++) {
        d->stages[bgc_padded(n) + (size_t)i] = lane_get(b->stages[n + i], l);
    }
}

/* and takes the stage of its own last step. */
void bgc_batch_take_stage(bgc_batch *b, int l, const bgc_data *d) {
    for (int i = 0; compares_with_step_before(b) && i < b->m->n_state; i++) {
        lane_set(b->stages + i, l, d->stages[i]);
    }
}

/* At the end of a run: adds the account of lane l to that of the steps which it took by itself, and
 * reports it. */
void bgc_batch_report_corrections(const bgc_batch *b, int l, bgc_data *d) {
    for (int i = 0; b->terms.count > 0 && i < b->m->n_state; i++) {
        const double correction = lane_get(b->correction[i], l);
        if (correction > d->correction[i]) {
            d->correction[i] = correction;
            d->corrected_at[i] = lane_get(b->corrected_at[i], l);
        }
        d->range[i] = fmax(d->range[i], lane_get(b->range[i], l));
    }
    bgc_report_correction(b->m, d);
}
