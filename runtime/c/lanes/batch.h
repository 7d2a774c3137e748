/* batch.h: what the files of the lockstep integrator share. */
#ifndef BGC_BATCH_H
#define BGC_BATCH_H

#define BGC_IN_LANES /* numbers are lanes */

#include "bgc_internal.h"
#include "bgc_lanes.h"
#include "control.h"
#include "number.h"

/* Instances in lockstep. An array of a batch is that of an instance with a lane for each number. */
typedef struct {
    const bgc_model *m;
    const bgc_lane_model *kernel;
    const bgc_method *method;
    const bgc_core *option;  /* of the first instance, as all have them */
    bgc_data *const *instance;
    unsigned live;           /* bit k: instance k is still in the batch */
    unsigned astray;         /* it takes the present step alone (alone.c), */
    unsigned written;        /* and has its rows up to t */
    bgc_counts counts;

    double t, t_old;
    int64_t ticks, sample;
    int f_valid;             /* f is at the present */
    int dense;               /* k holds the dense output of the last step */
    double c;                /* W = c M - J is factorised, for so many more steps */
    int held, watched, checked;

    double h_next, error_old; /* of step control */
    int rejected;            /* the last attempt was, because of the lanes at fault */
    unsigned at_fault;
    int account_rejections;  /* in a row */

    lane *h, *x, *u, *mass, *scale, *inverse_mass, *jac, *dfdt, *lu, *f;
    lane *y0, *k, *stages;
    lane *next, *error, *point, *b, *residual, *magnitude, *output, *check, *argument, *work;
    lane stored0, supplied, dissipated, supplied_old, dissipated_old;
    lane imbalance; /* of the accounts at t */
    lane largest_account, exchanged, energy_scale;
    lane liveliest; /* the count of bgc.h */

    double *alone;           /* a row */
    const double *times;     /* of all rows */
    double *const *rows;     /* of each instance */
    size_t n_rows, row;      /* row: the next one */
    int interrupted;
} bgc_batch;

/* Energies in J of one step: bgc_balance on lanes. */
typedef struct {
    lane supplied, dissipated, moved, error, stored;
} bgc_lane_balance;

/* The lanes of the batch for which a condition holds, as bits. */
static inline unsigned bgc_lanes_where(const bgc_batch *b, lane_mask condition) {
    unsigned found = 0;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        found |= lane_holds(condition, l) ? 1u << l : 0u;
    }
    return found & b->live;
}

/* Doubles in a row. */
static inline size_t bgc_batch_row_width(const bgc_batch *b) {
    return (size_t)b->m->n_output + (b->option->accounts ? 4 : 0);
}

/* Times closer than this count as equal. */
static inline double bgc_batch_slack(const bgc_batch *b) { return bgc_time_slack(b->t, b->t_old); }

/* --- lane_vectors.c */
void bgc_batch_combine(int n, int count, const double *weight, const lane *vectors, lane *out);
void bgc_batch_multiply_mass(const bgc_batch *b, const lane *v, lane *out);
unsigned bgc_batch_bad(const bgc_batch *b, int n, const lane *v);
lane bgc_batch_norm(const bgc_batch *b, const lane *v, const lane *p, const lane *q);
void bgc_batch_evaluate_f(bgc_batch *b);
void bgc_batch_check(bgc_batch *b, double t, const lane *x);

/* --- alone.c */
void bgc_batch_take_inputs(bgc_batch *b, int count);
void bgc_batch_sample(bgc_batch *b);
void bgc_batch_watch_switches(bgc_batch *b);
void bgc_batch_step_alone(bgc_batch *b);
void bgc_batch_rejoin(bgc_batch *b);

/* --- lockstep.c */
void bgc_batch_attempt(bgc_batch *b);

/* --- lane_stages.c */
void bgc_batch_advance(bgc_batch *b, double h);
void bgc_batch_solve(bgc_batch *b, lane *v);

/* --- lane_rows.c */
void bgc_batch_interpolate(bgc_batch *b, double t);
lane bgc_batch_dense_error(bgc_batch *b);
void bgc_batch_balance(bgc_batch *b, bgc_lane_balance *balance);
void bgc_batch_row(bgc_batch *b);

#endif
