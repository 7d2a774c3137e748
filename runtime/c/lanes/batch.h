/* batch.h: instances that take their steps together, one in each lane of a vector register.
 *
 * The integrator is compiled a second time with lanes for numbers (integrator.h). The files of this
 * folder have what is different for a batch: batch.c its memory, start, rows and end; lockstep.c
 * and lane_attempt.c an attempt at a step; alone.c the inputs, devices and events of single
 * instances; lane_stages.c linear systems.
 */
#ifndef BGC_BATCH_H
#define BGC_BATCH_H

#define BGC_IN_LANES /* numbers are lanes */

#include "instance.h"
#include "bgc_lanes.h"
#include "number.h"

/* The accounts of bgc_core on lanes, with `exchanged` of bgc_counts. */
typedef struct {
    lane stored0, supplied, dissipated, supplied_old, dissipated_old, created;
    lane imbalance, energy_scale, largest_account, exchanged;
} bgc_lane_accounts;

/* A member of a batch has the name and meaning of that of an instance (bgc_data), with a lane in
 * the place of each double. */
typedef struct {
    bgc_core core; /* options, times, step control and counts, which are the same for all instances */
    const bgc_model *m;
    const bgc_lane_model *kernel;
    const bgc_method *method; /* of the last step, or of the attempt under way */
    bgc_data *const *instance;

    /* Sets of lanes: bit k is instance k. */
    unsigned active;         /* still in the batch */
    unsigned single;         /* take the present step by themselves (alone.c), */
    unsigned written;        /* and have their rows up to t */
    unsigned at_fault;       /* because of these lanes the last attempt was rejected */

#define ARRAY(type, name, count)
#define NUMBERS(name, count) lane *name;
#define SCRATCH
#include "arrays.h"
#undef ARRAY
#undef NUMBERS
#undef SCRATCH
    lane *y0, *y1; /* among x, next, spare, end */
    lane *spare, *end, *slopes; /* slopes: f at the start of the step */
    lane *argument, *hiding;
    lane newest;
    bgc_lane_accounts account;
    lane scale_reached;
    int n_block;             /* none: instances with algebraic equations run alone */
    const int *block;

    /* What runs are warned of. */
    lane rounding, largest_rounding;   /* as in bgc_counts */

    const double *times;     /* of all rows */
    double *const *rows;     /* of each instance */
    size_t n_rows, row;      /* row: the next one */
    double *spare_row;
    int interrupted;
} bgc_batch;

/* The active lanes for which a condition holds, as a set. */
static inline unsigned bgc_lanes_where(const bgc_batch *b, lane_mask condition) {
    return lane_bits(condition) & b->active;
}

#endif
