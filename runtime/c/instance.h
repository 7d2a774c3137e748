/* instance.h: the state of an instance, with its types: what is saved and what is scratch. The functions that
 * work on it are in bgc_internal.h.
 */
#ifndef BGC_INSTANCE_H
#define BGC_INSTANCE_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#endif

#include "bgc.h"
#include "methods.h"

#include <stdatomic.h>
#include <stdlib.h>

/* Returns zeros from the start of a cache line on, or NULL; `*allocated` is for `free`. Windows has
 * no `aligned_alloc`. */
static inline void *bgc_aligned_zeros(size_t size, void **allocated) {
    char *at = *allocated = calloc(1, size + 63);

    return at == NULL ? NULL : at + (64 - (uintptr_t)at % 64) % 64;
}

enum { BGC_LANES = 8 };
enum { BGC_SAMPLES = 5 };      /* points of a step at which switches are evaluated, */
enum { BGC_FIRST_SAMPLES = 3 }; /* and those that show whether any comes near the edge of its mode */
/* Their places in a step, its end last; spaced unevenly, so that an oscillation does not fit between them. */
static const double bgc_sample_at[BGC_SAMPLES] = {0.17, 0.41, 0.63, 0.86, 1.0};
static const int bgc_first_sample[BGC_FIRST_SAMPLES] = {2, 4, BGC_SAMPLES}; /* numbers of the first ones */
enum { BGC_MAX_HALVINGS = 6 }; /* of a fixed step that is too long for the algebraic equations */

/* Unknowns of a model up to which the room for dense factors is reserved with the instance or its
 * method, so that a servo loop allocates nothing. Of a larger model it is reserved with the first need:
 * 3 GB of real numbers at 20,000 states, where a dense factorisation takes hours. */
enum { BGC_RESERVED_STATES = 1000 };

/* Vectors of states are padded to whole cache lines; entries beyond n stay zero. */
static inline size_t bgc_padded(int n) {
    return ((size_t)n + BGC_LANES - 1) / BGC_LANES * BGC_LANES;
}

typedef struct {
    double re, im;
} bgc_complex;

/* The unknowns of the linear systems: the states, then the inner unknowns. */
static inline int bgc_has_ranges(const bgc_model *m) {
    return m->n_term > 0 || m->timed_ranges != NULL;
}

static inline int bgc_unknowns(const bgc_model *m) {
    return m->n_state + m->n_inner;
}

/* Entries of a matrix, row after row. */
typedef struct {
    int count;
    const int *row, *col;
} bgc_entries;

/* The entries that m->jacobian fills. */
static inline bgc_entries bgc_local_entries(const bgc_model *m) {
    return m->n_inner > 0 ? (bgc_entries){m->n_local, m->local_row, m->local_col}
                          : (bgc_entries){m->n_jac, m->jac_row, m->jac_col};
}

/* The factorisation of W at hand: by static pivots, with or without a check of its solutions, or
 * dense with partial pivoting. */
typedef enum { BGC_STATIC, BGC_CHECKED_ONCE, BGC_WATCHED, BGC_DENSE } bgc_pivoting;

/* The dense output of the last step: none; cubic Hermite whose slope at the end is not evaluated
 * yet; complete. */
typedef enum { BGC_NO_DENSE, BGC_SLOPES_PENDING, BGC_DENSE_READY } bgc_dense_state;

/* Estimates of the spectral radius of M^-1 df/dx along a run: spectrum.c. */
typedef struct {
    double radius;        /* the last one; INFINITY: none */
    double newest;        /* that of the estimate under way, */
    int products, agreed; /* its products, and how many in a row changed it little */
    int estimates;        /* complete ones */
} bgc_spectrum;

typedef enum { BGC_ESTIMATING, BGC_ESTIMATED } bgc_estimate;

/* The choice between the method of a run and its explicit partner: switching.c. */
typedef struct {
    int partner;     /* place in bgc_methods; -1: none */
    int is_explicit; /* the partner takes the steps at present */
    int is_trial;    /* the last change is not judged yet */
    int unexcited;   /* consecutive steps of the partner that are short for stability alone */
    int limited;     /* consecutive steps of the partner that do not resolve all modes */
    int attempts;    /* since the last change */
    int wait;        /* attempts before the next trial */
    int look;        /* the same before the next estimate of the spectral radius, */
    int pause;       /* and between it and the one before */
    double since;    /* time of the last change */
    double cost;     /* implicit steps for a second, by the other method before it */
    double product;  /* of a fixed explicit step: its length times the dominant eigenvalue, */
    double usual;    /* and that at the last estimate of the spectral radius; below 0: none yet */
} bgc_choice;

/* The part of an instance without pointers, which is saved and restored as it is. */
typedef struct {
    bgc_counts counts;

    bgc_options given; /* without the name */
    /* Options, with the defaults filled in. */
    int method, keep, accounts, errors;
    double rtol, atol, step;
    long max_steps;
    int substeps;              /* attempts in a sample after the first, and their tolerances */
    double sub_rtol, sub_atol;

    int ready;      /* a reset or restart succeeded */
    int restarts;   /* a reset succeeded, so that a restart may be tried, again after one that failed */
    int failed_parameter, failed_assertion, failed_state, failed_switch, failed_divisor;
    int failed_chain, failed_jump, failed_held;
    double failed_time; /* of failed_divisor */

    /* Fixed steps end at origin + ticks step, samples are at origin + k period. The step is
     * step_parts over step_whole, so that its multiples are the numbers nearest to 0.1, 0.2, 0.3. */
    double t, origin, period;
    double step_parts, step_whole;
    int64_t ticks, sample;
    double instant;      /* the next instant of a sampled part; INFINITY: there is none */
    double due;          /* the next instant or sample, whichever is first */
    double since_sample; /* s of computing since the last sample */
    double stop;         /* adaptive steps end there; INFINITY: nowhere */
    double until;        /* the call under way integrates to there, or a little further */
    int step_cut;        /* an event or a sub-step has cut the fixed step under way */
    int attempts;        /* in this sample; see substeps.c */
    int last_resort;     /* the attempt under way is accepted whatever its error is */
    int exceeded;        /* one of this sample has been, with an error above the tolerance */
    double sub_step;     /* wanted length of the next attempt */

    int f_valid, jac_valid;   /* d->f, and d->jac with d->dfdt, are those at the present */
    int f_at_end;              /* f at the end of the step is in d->error */
    double f_last_at;         /* d->f_last is f at the end of the step, if it ends then; or INFINITY */
    int algebraic;            /* number of empty rows of M: algebraic equations */
    int too_coarse, halvings; /* the step under way is too long for them; fixed steps are halved
                               * that often */

    /* The last step, for rows inside it. Its dense output reaches to t_end, beyond t after an
     * event. */
    double t_old, t_end;
    bgc_dense_state dense;

    int event;       /* the step under way ends at an event */
    double event_at; /* time of the last event, */
    double sampled_at; /* and of the last instant of sampled parts: a row at both has the values after them */
    int after_event; /* the step that ended there began at one, too */
    int unreturned;  /* an argument that a jump turned back has not come back within its mode */
    int near_edge;   /* in that step a switch came near to the edge of its mode, or it has none */
    int end_checks;  /* steps that may be examined at their end only, before one is examined within */
    int unresolved;  /* consecutive steps that were too long for the argument of a switch */

    /* The times between which no switch of time alone leaves its mode: time_events.c. */
    double quiet_from, quiet_to;
    double event_window; /* steps of the next window */
    int skipped_tries;  /* steps before the next window is tried */
    int undecided;      /* steps that are left to samples since ranges could not tell, */
    int undecided_left; /* and those that are still to come */
    int skipped;        /* the arguments of switches of time alone are not those of the present */

    /* What depends on time alone: timed.c. Between two times steps of at most resolved_step skip nothing. */
    double resolved_from, resolved_to, resolved_step;
    double timed_window; /* steps that one look ahead spans */
    double reach;       /* part of a step up to which its stages reach */
    int limited_by;     /* the term that limits the step under way; -1: none */
    int without_effect; /* consecutive steps that it has limited in vain */
    int hidden;         /* consecutive steps that hid a pulse of a function of states: watch.c */
    int64_t cut_tick;   /* the last fixed step that was cut, */
    int cuts, cuts_in_a_row;

    /* Closed chains: the least pivot of the rows at the present, and at the end of the step. */
    double chain_pivot, next_chain_pivot;
    int watches_chains;  /* d->closed_before is that of the present */
    int passes_singular; /* the step under way passes a singular position */

    /* Factorisation of c M - J. */
    double c;
    bgc_pivoting pivoting;
    int held;    /* steps for which it is still to be used */
    int watched; /* factorisations whose solutions are all still to be checked */

    /* The same for the complex factorisation of a collocation method. */
    bgc_complex c_complex;
    bgc_pivoting pivoting_complex;
    int watched_complex;
    long factorisations_complex;

    double spectral_bound;  /* see stiffness.c */
    bgc_spectrum spectrum;
    bgc_choice choice;

    /* Step control. */
    double h_next, error_old;
    int rejected;      /* attempts in a row that were rejected, the last one */
    bgc_status reason; /* for this reason */
    int left;          /* the attempt leaves a root (bgc_leave_root) */

    /* Errors of the states: global_error.c. */
    double off_noted;    /* the last present whose errors are in largest_off */
    double off_gamma;    /* 1 / (c h) of the step that off_power belongs to */
    double off_power[4];

    /* Energy accounts, J: stored at the reset, integrals at t and at t_old, residual at t. */
    double stored0, supplied, dissipated, supplied_old, dissipated_old;
    double created;      /* by sampled ports, J */
    double imbalance;
    double energy_scale; /* below 0: not computed yet */
    double largest_account;
    int account_rejections; /* consecutive */
} bgc_core;

typedef struct {
    const bgc_driver *driver; /* NULL: not open */
    void *handle;
    bgc_pose pose;
    bgc_effort given; /* written last */
} bgc_device;

struct bgc_data {
    bgc_core core;
    unsigned char *is_set; /* n_param: set by the user */
    void *allocated; /* holds `memory`, which begins at a cache line */
    double *memory;

    /* Saved. */
    size_t n_saved;
    double *p, *h, *x, *u, *u_seen, *scale, *mass;
    double *u_step;         /* inputs and modes of the last step */
    double *mode;           /* n_switch: modes at the present; NaN where a switch has none */
    double *argument;       /* n_switch: arguments at the present */
    double *extent;         /* n_switch: the largest absolute value of each argument so far */
    double *swing;          /* n_switch: the variation of each argument over a step (switch_margins.c) */
    double *rest;           /* n_switch: how far from its edge the argument of a kink at rest there may be
                             * by rounding; 0 where it does not rest (switch_margins.c) */
    double *returns;        /* n_switch: consecutive immediate returns to the mode before; INFINITY:
                             * the switch is left to error control */
    double *change_of_mode; /* n_switch: the last change of each mode */
    double *subtol_phase, *subtol_from, *subtol_to; /* see subtolerance.c */
    double *subtol_low, *subtol_at, *subtol_entered, *subtol_left;
    double *sampling, *instants; /* 2 n_rate: periods and offsets; n_rate: instants that have passed */
    double *turned;         /* n_switch: not 0 where the mode is that before a jump: how far the
                             * argument may lie beyond its edge by rounding (jumps.c) */
    double *holds;          /* n_jump: not 0 where the condition was true at the last event */
    double *jumped_at, *close_jumps; /* n_jump: time of the last jump, and jumps in quick succession */
    bgc_subtolerance_state *subtol; /* n_state */
    double *divisor_extent; /* n_divisor: the largest absolute value of each divisor so far */
    double *divisor_slope;  /* n_divisor: the rate of each divisor at the end of the last step */
    bgc_range *h_range, *u_range; /* h and u as ranges: ranges.c */
    double *variation;      /* n_term: of each term of time alone, the largest that a step resolved */
    double *patience;       /* n_term: factor of the steps that each allows; INFINITY: not watched */
    double *f_before;       /* f at the start of a step that a term has limited */
    double *inverse_mass;   /* 1 / m_ii where row i of M has no other entry, else 0 */
    double *algebraic;      /* 1 where row i of M is empty, else 0 */
    double *correction, *corrected_at, *range; /* of fixed steps: corrections.c */
    double *dominant;       /* of the last power iteration: stiffness.c */
    double *direction, *image; /* of the power iteration of spectrum.c, and its image */
    double *jac, *dfdt, *lu, *f;
    double *y0, *y1, *k;    /* dense output; k is BGC_MAX_DENSE vectors */
    bgc_complex *lu_complex;
    double *closed_before;  /* dw/dx and responses of closed chains at the present */
    double *response_size;  /* of each row of these: the largest diagonal of S so far */
    double *off;            /* how far the present is off, true minus computed: global_error.c, */
    double *off_before, *off_at_end; /* and the ends of the last step, before a jump */
    double *off_inside;     /* 2 vectors: the same of the dense output at two points, beside that of the ends */
    double *largest_off;    /* n_output: the largest errors since the last row, */
    double *lowest, *highest; /* and the ends of the ranges of the outputs so far */
    double *chosen;         /* n_row, n_condition: 1 where a row or condition of these is chosen, else 0 */

    /* Scratch. */
    double *stages;         /* BGC_MAX_STAGES vectors: the U_i, or Z_i */
    double *implicit;       /* twice BGC_MAX_IMPLICIT vectors: f at the stages, corrections */
    bgc_complex *complex_right, *b_complex, *residual_complex;
    double *next, *error;   /* the solution and the error estimate of a step */
    double *noise;          /* the error estimate of a perturbed attempt */
    double *f_last;         /* f at the last stage of an explicit step */
    double *point, *right, *residual, *magnitude, *b;
    double *output, *command, *check, *work;
    double *samples;        /* BGC_SAMPLES vectors of arguments of switches */
    double *probe, *after;  /* arguments of switches */
    double *divisors;       /* BGC_SAMPLES + 1 vectors of divisors */
    double *ignored;        /* n_switch: not 0 where a change is negligible in the step under way */
    double *held_value;     /* n_held */
    double *condition, *reset_value; /* n_jump; of all resets */
    double *edge_rate;      /* n_edge: rates of the arguments of the switches of conditions */
    double *moved;          /* n_edge: not 0 where motion, not a jump, has changed the mode */
    double *watch_sample;   /* (BGC_SAMPLES + 1) n_watch: watched arguments */
    double *watch_probe;    /* n_watch */
    bgc_range *term_range;  /* 2 n_term: of each term and its derivative by time */
    bgc_range *timed_range; /* 2 n_timed: of each argument of a switch of time alone, and its derivative */
    double *around;         /* n_term: variations to compare with, */
    double *widest;         /* and in the window ahead */
    double *sparse_work;    /* 3 n_unknowns: elimination by tables */
    double *block_work;     /* 18 n_place: elimination in blocks */
    double *reach;          /* n_unknowns: sizes of a solution that count in its check */
    double *off_work;       /* 10 vectors of states: global_error.c, */
    double *off_output, *off_reset; /* outputs of the true state; of all resets */
    double *off_argument, *off_along, *off_rate; /* n_switch: arguments at an event, and their derivatives */
    double *wide;           /* n_unknowns: a right-hand side with inner rows, and its solution */
    bgc_complex *wide_complex;
    double *local, *slopes; /* n_local; n_jac: inner.c */
    double *inner;          /* a dense matrix of all unknowns */
    size_t inner_room;
    double *dense_lu;       /* n by n: dense factors */
    bgc_complex *dense_lu_complex;
    size_t dense_room, dense_room_complex, block_room; /* rows and columns that there is room for */
    int *pivot, *pivot_complex;

    /* The block of states that the algebraic equations are solved for, and scratch: consistent.c. */
    int n_block;
    int *block;             /* their numbers */
    int *place;             /* of each state: its position in the block, or -1 */
    int *block_pivot;
    double *block_lu, *block_jac; /* n_block by n_block; n_jac */
    double *block_search;   /* of a search for a start, for at most BGC_MAX_SEARCHED unknowns */
    double *first, *start, *largest, *trial, *homotopy, *change, *next_change;

    /* The equations of the start: unknowns, Newton iterates, residuals and factors (start.c). */
    double *start_at, *start_from, *start_trial, *start_change, *start_next, *start_first;
    double *start_magnitude, *start_jac, *start_lu;
    int *start_pivot;
    double *closing;        /* closures.c */
    int *closing_pivot, *closing_list;
    double *closed_after;   /* as closed_before, at the end of the step, */
    double *next_chosen;    /* and as chosen from there on */

    bgc_device *device;
    int failed_device;       /* the last one that reported a fault, or -1; */
    char device_reason[256]; /* and its driver's reason */
    atomic_int stop;
};

/* The tolerance of state i at this size, by which solutions of the algebraic equations are judged. */
static inline double bgc_tolerance(const bgc_data *d, int i, double size) {
    const double atol = d->core.atol > 0.0 ? d->core.atol : d->core.rtol * d->scale[i];

    return atol + d->core.rtol * size;
}

#endif
