/* alone.h: the functions that the files of a batch share. The integrator's own are in
 * integrator.h. */
#ifndef BGC_ALONE_H
#define BGC_ALONE_H

#include "lanes/batch.h"

#include "bgc_internal.h"

/* Number of doubles in a row. */
static inline size_t bgc_row_width(const bgc_batch *b) {
    return (size_t)b->m->n_output + (b->core.accounts ? 4 : 0);
}

/* --- alone.c */
void bgc_load_inputs(bgc_batch *b, int count);
void bgc_sample_all(bgc_batch *b);
void bgc_watch_switches(bgc_batch *b);
void bgc_watch_pulses(bgc_batch *b);
void bgc_step_alone(bgc_batch *b);
void bgc_rejoin(bgc_batch *b);

/* --- lane_attempt.c */
void bgc_complete_together(bgc_batch *b, double t_new);
double bgc_resolved_by_all(const bgc_batch *b, double h, unsigned *hidden);
void bgc_check_lanes(bgc_batch *b);

/* --- lockstep.c */
void bgc_attempt_together(bgc_batch *b);

#endif
