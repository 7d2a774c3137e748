/* batch.h: the types and functions that files of the lockstep integrator share.
 *
 * The order of calls is that of bgc_internal.h: bgc_run_lanes (batch.c) loads the instances and calls
 * bgc_batch_attempt (lockstep.c) up to the time of each row, which bgc_batch_advance (lane_stages.c)
 * and bgc_batch_interpolate (lane_rows.c) serve. alone.c handles devices and events, one instance at
 * a time. lane_switching.c chooses the method. lane_corrections.c, lane_rounding.c and lane_subtolerance.c note
 * what runs are warned of.
 */
#ifndef BGC_BATCH_H
#define BGC_BATCH_H

#define BGC_IN_LANES /* numbers are lanes */

#include "bgc_internal.h"
#include "bgc_lanes.h"
#include "control.h"
#include "number.h"

/* The stages that enter the corrections of a step (lane_corrections.c), with their weights. */
typedef struct {
    double weight[BGC_MAX_STAGES];
    const lane *stage[BGC_MAX_STAGES];
    int count; /* 0: corrections are not watched */
} bgc_lane_terms;

/* Instances that take their steps together. An array of a batch is that of an instance (bgc_data), with
 * a lane in the place of each double. */
typedef struct {
    const bgc_model *m;
    const bgc_lane_model *kernel;
    const bgc_method *method; /* of the last step, or of the attempt under way */
    const bgc_core *option;  /* of the first instance: options are the same for all */
    bgc_data *const *instance;

    /* Sets of lanes: bit k is instance k. */
    unsigned active;         /* still in the batch */
    unsigned single;         /* take the present step by themselves (alone.c), */
    unsigned written;        /* and have their rows up to t */
    int apart;               /* a lane took the last step by itself */
    bgc_counts counts;

    double t, t_old;
    int64_t ticks, sample;
    int f_valid;             /* f is that at the present */
    double f_last_at;        /* as in bgc_core */
    int dense;               /* k is the dense output of the last step */

    /* Factorisation of W = c M - J. */
    double c;
    int held;                /* steps for which it is still to be used */
    int watched;             /* factorisations whose solutions are all still to be checked */
    int checked;             /* the next solution is checked */

    /* Step control. */
    double h_next, error_old;
    int rejected;            /* attempts in a row that were rejected, the last one */
    unsigned at_fault;       /* because of these lanes */
    int account_rejections;  /* consecutive */
    int near_edge;           /* in the last step the argument of a switch came near to the edge of its mode */
    int unresolved;          /* consecutive steps that were too long for such an argument */
    bgc_choice choice;       /* of the method, for all instances, */
    bgc_spectrum spectrum;   /* by their largest spectral radius */
    lane newest;             /* those of the estimate under way */

    lane *h, *x, *u, *mass, *scale, *inverse_mass, *jac, *dfdt, *lu, *f, *f_last;
    lane *y0, *k, *stages;
    lane *direction, *image; /* as in bgc_data */
    lane *next, *error, *point, *b, *wide, *residual, *reach, *magnitude, *output, *check, *argument, *extent, *hiding, *work;
    lane stored0, supplied, dissipated, supplied_old, dissipated_old;
    lane imbalance;          /* residual of the accounts at t */
    lane largest_account, exchanged, energy_scale, scale_reached;

    /* What runs are warned of. */
    bgc_lane_terms terms;
    lane *correction, *corrected_at, *range; /* of fixed steps, */
    lane *resolved;          /* and the largest corrections that show nothing */
    lane *shifted, *shifted_f, *noise; /* a perturbed attempt: x, f, its error estimate */
    lane rounding, largest_rounding;   /* as in bgc_counts */
    lane *subtol_from, *subtol_to;       /* as in bgc_data */

    const double *times;     /* of all rows */
    double *const *rows;     /* of each instance */
    size_t n_rows, row;      /* row: the next one */
    double *spare_row;
    int interrupted;
} bgc_batch;

/* Energies of one step, J: bgc_balance on lanes. */
typedef struct {
    lane supplied, dissipated, moved, error, stored;
} bgc_lane_balance;

/* The active lanes for which a condition holds, as a set. */
static inline unsigned bgc_lanes_where(const bgc_batch *b, lane_mask condition) {
    return lane_bits(condition) & b->active;
}

/* Number of doubles in a row. */
static inline size_t bgc_batch_row_width(const bgc_batch *b) {
    return (size_t)b->m->n_output + (b->option->accounts ? 4 : 0);
}

/* Times closer than this count as equal. */
static inline double bgc_batch_slack(const bgc_batch *b) { return bgc_time_slack(b->t, b->t_old); }

/* --- lane_vectors.c */
void bgc_batch_combine(int n, int count, const double *weight, const lane *vectors, lane *out);
void bgc_batch_multiply_mass(const bgc_batch *b, const lane *v, lane *out);
unsigned bgc_batch_bad(const bgc_batch *b, int n, const lane *v);
double bgc_batch_largest(unsigned lanes, lane v);
lane bgc_batch_norm_within(const bgc_batch *b, const lane *v, const lane *p, const lane *q,
                           double rtol, double atol, lane reached);
lane bgc_batch_norm(const bgc_batch *b, const lane *v, const lane *p, const lane *q);
void bgc_batch_evaluate_f(bgc_batch *b);
void bgc_batch_forget_f(bgc_batch *b);
void bgc_batch_check(bgc_batch *b, double t, const lane *x);

/* --- alone.c */
void bgc_batch_load_inputs(bgc_batch *b, int count);
void bgc_batch_sample(bgc_batch *b);
void bgc_batch_watch_switches(bgc_batch *b);
void bgc_batch_watch_pulses(bgc_batch *b);
void bgc_batch_step_alone(bgc_batch *b);
void bgc_batch_rejoin(bgc_batch *b);

/* --- lane_switching.c */
void bgc_batch_begin_choice(bgc_batch *b);
void bgc_batch_choose_method(bgc_batch *b, double h);
void bgc_batch_choose_fixed_method(bgc_batch *b);
int bgc_batch_rejects_explicit_step(bgc_batch *b, unsigned bad);
void bgc_batch_count_rejection(bgc_batch *b);
void bgc_batch_take_method(bgc_batch *b);
void bgc_batch_give_method(const bgc_batch *b, bgc_data *d);

/* --- lane_corrections.c */
void bgc_batch_begin_corrections(bgc_batch *b);
void bgc_batch_record_corrections(bgc_batch *b);
void bgc_batch_give_stage(const bgc_batch *b, int l, bgc_data *d);
void bgc_batch_take_stage(bgc_batch *b, int l, const bgc_data *d);
void bgc_batch_report_corrections(const bgc_batch *b, int l, bgc_data *d);

/* --- lane_rounding.c */
int bgc_batch_samples_rounding(const bgc_batch *b);
void bgc_batch_try_perturbed(bgc_batch *b, double h);
void bgc_batch_judge_rounding(bgc_batch *b, lane errors);
void bgc_batch_report_rounding(const bgc_batch *b, int l, bgc_counts *counts);

/* --- lane_subtolerance.c */
void bgc_batch_load_subtolerance(bgc_batch *b, int l, const bgc_data *d);
void bgc_batch_follow_subtolerance(bgc_batch *b);

/* --- lockstep.c */
void bgc_batch_attempt(bgc_batch *b);

/* --- lane_stages.c */
void bgc_batch_factorise(bgc_batch *b, double h);
void bgc_batch_advance(bgc_batch *b, double h);
void bgc_batch_solve(bgc_batch *b, lane *v);

/* --- lane_rows.c */
void bgc_batch_interpolate(bgc_batch *b, double t);
void bgc_batch_interpolate_some(bgc_batch *b, double t, int count, const int *state);
lane bgc_batch_dense_error(bgc_batch *b);
void bgc_batch_balance(bgc_batch *b, bgc_lane_balance *balance);
void bgc_batch_row(bgc_batch *b);

#endif
