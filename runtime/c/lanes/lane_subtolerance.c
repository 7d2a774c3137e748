/* lane_subtolerance.c: states of a batch that fall below their tolerance and grow again: subtolerance.c. The phases of
 * the states are those of the instances; the batch has the multiples of the tolerances between which
 * nothing happens. */
#include "lanes/batch.h"

/* Copies these multiples of an instance to its lane. */
void bgc_batch_load_subtolerance(bgc_batch *b, int l, const bgc_data *d) {
    for (int i = 0; i < b->m->n_state; i++) {
        lane_set(b->subtol_from + i, l, d->subtol_from[i]);
        lane_set(b->subtol_to + i, l, d->subtol_to[i]);
    }
}

/* The tolerance of state i in each lane. */
static inline lane subtol_limit(const bgc_batch *b, lane part, int i) {
    return b->option->atol + part * b->scale[i];
}

/* The lanes in which something happens to state i. */
static inline lane_mask find_change(const bgc_batch *b, lane part, int i) {
    const lane size = lane_fabs(b->x[i]), limit = subtol_limit(b, part, i);

    return (size < b->subtol_from[i] * limit) | (size > b->subtol_to[i] * limit);
}

/* After a step under error control. Lanes that took it by themselves have followed their states. */
void bgc_batch_follow_subtolerance(bgc_batch *b) {
    const lane part = b->option->atol > 0.0 ? lane_of(0.0) : b->option->rtol * b->scale_reached;
    lane_mask changed = lane_of(0.0) != lane_of(0.0);

    for (int i = 0; i < b->m->n_state; i++) {
        changed |= find_change(b, part, i);
    }
    for (int l = 0; b->single != 0 && l < BGC_LANE_WIDTH; l++) {
        if ((b->single & b->active & 1u << l) != 0) {
            bgc_batch_load_subtolerance(b, l, b->instance[l]);
        }
    }
    if ((bgc_lanes_where(b, changed) & ~b->single) == 0) {
        return;
    }
    for (int i = 0; i < b->m->n_state; i++) {
        const unsigned lanes = bgc_lanes_where(b, find_change(b, part, i)) & ~b->single;
        for (int l = 0; lanes != 0 && l < BGC_LANE_WIDTH; l++) {
            if ((lanes >> l & 1u) != 0) {
                bgc_follow_subtolerance_state(b->instance[l], i, lane_get(b->x[i], l),
                                       lane_get(subtol_limit(b, part, i), l), b->t);
                bgc_batch_load_subtolerance(b, l, b->instance[l]);
            }
        }
    }
}
