/* bgc_internal.h: the types and functions that files of the runtime share; no part of the interface.
 *
 * The order of calls of a run:
 *
 *   bgc_run (run.c)                modes and inputs at the present, then for each row:
 *     advance_to                     until the present is at or beyond the time of the row:
 *       bgc_sample                     devices and inputs, where a sample is due, and
 *                                      bgc_take_sampled (sampled.c) at an instant of sampled parts
 *       bgc_attempt (step.c)           one attempt at a step, from d->x at d->core.t:
 *         bgc_evaluate_f                 d->f (evaluate.c)
 *         bgc_first_step                 its length, at the start (first_step.c, control.h)
 *         bgc_limit_for_time             cut before a motion of time alone (timed.c)
 *         bgc_stop_for_switch            cut at an event that depends on time alone (events.c)
 *         family->advance                stages, d->next and d->error: rosenbrock.c, explicit.c or
 *                                        collocation.c, with linear.c, sparse.c, blocks.c
 *                                        and complex.c;
 *                                        the sums of stages are in stages.c
 *         bgc_norm                       error over the tolerances (vectors.c, tolerance.h)
 *         bgc_close_chains               closed chains at the end (closures.c)
 *         bgc_keep_consistent            algebraic equations at the end (consistent_steps.c)
 *         bgc_store_dense                dense output (dense.c, interpolation.h)
 *         bgc_find_event                 the first change of a mode within the step (events.c)
 *         bgc_check_asserts              (evaluate.c)
 *         bgc_check_divisors             (divisors.c)
 *         bgc_follow_faint               states below their tolerance (faint.c)
 *         bgc_before_hidden              a pulse of a function of states within the step (watch.c)
 *         bgc_balance_step               energies of the step and their error (accounts.c)
 *         bgc_choose_method              implicit, or explicit where nothing is stiff (switching.c)
 *         accept_step                    d->next becomes the present; bgc_handle_event, bgc_jump
 *     write_row                        outputs and accounts, by dense output inside the step
 *
 * A rejected attempt leaves the present as it was and sets a shorter length. A fixed step is taken
 * whatever its error is, and bgc_record_correction (corrections.c) watches its length; or, with a
 * budget, it is subdivided where its error is too large (substeps.c).
 * lanes/ has the same sequence for instances that take their steps together.
 */
#ifndef BGC_INTERNAL_H
#define BGC_INTERNAL_H

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

/* Energies of one step, J. */
typedef struct {
    double supplied, dissipated; /* integrals of the powers */
    double moved;  /* the larger of the integrals of their absolute values */
    double error;  /* the larger error of the two integrals */
    double stored; /* at the end of the step, absolute */
} bgc_balance;

/* The choice between the method of a run and its explicit partner: switching.c. */
typedef struct {
    int partner;     /* place in bgc_methods; -1: none */
    int is_explicit; /* the partner takes the steps at present */
    int is_trial;    /* the last change is not judged yet */
    int unexcited;   /* consecutive steps of the partner that are short for stability alone */
    int attempts;    /* since the last change */
    int wait;        /* attempts before the next trial */
    double since;    /* time of the last change */
    double cost;     /* implicit steps for a second, by the other method before it */
} bgc_choice;

/* The part of an instance without pointers, which is saved and restored as it is. */
typedef struct {
    bgc_counts counts;

    /* Options, with the defaults filled in. */
    int method, keep, accounts;
    double rtol, atol, step, max_step;
    long max_steps;
    int substeps;              /* attempts in a sample after the first, and their tolerances */
    double sub_rtol, sub_atol;

    int ready; /* a reset succeeded */
    int failed_parameter, failed_assertion, failed_state, failed_switch, failed_divisor;
    int failed_chain, failed_jump, failed_held;
    double failed_time; /* of failed_divisor */

    /* Fixed steps end at origin + ticks step, samples are at origin + k period. */
    double t, origin, period;
    int64_t ticks, sample;
    double instant;      /* the next instant of a sampled part; INFINITY: there is none */
    double due;          /* the next instant or sample, whichever is first */
    double since_sample; /* s of computing since the last sample */
    double stop;         /* adaptive steps end there; INFINITY: nowhere */
    int step_cut;        /* an event or a sub-step has cut the fixed step under way */
    int attempts;        /* in this sample; see substeps.c */
    int last_resort;     /* the attempt under way is accepted whatever its error is */
    int exceeded;        /* one of this sample has been, with an error above the tolerance */
    double sub_step;     /* wanted length of the next attempt */

    int f_valid, jac_valid;   /* d->f, and d->jac with d->dfdt, are those at the present */
    int f_ahead;              /* f at the end of the step is in d->error */
    double f_last_at;         /* d->f_last is f at the end of the step, if it ends then; or INFINITY */
    int algebraic;            /* number of empty rows of M: algebraic equations */
    int too_coarse, halvings; /* the step under way is too long for them; fixed steps are halved
                               * that often */

    /* The last step, for rows inside it. Its dense output reaches to t_end, beyond t after an
     * event. */
    double t_old, t_end;
    bgc_dense_state dense;

    int event;       /* the step under way ends at an event */
    double event_at; /* time of the last event */
    int unreturned;  /* an argument that a jump turned back has not come back within its mode */
    int unresolved;  /* consecutive steps that were too long for the argument of a switch */

    /* What depends on time alone: timed.c. Steps of at most clear_step are clear between two times. */
    double clear_from, clear_to, clear_step;
    double ahead;       /* steps that one look ahead spans */
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
    bgc_complex complex_c;
    bgc_pivoting complex_pivoting;
    int complex_watched;
    long complex_factorisations;

    double spectral_bound; /* see stiffness.c */
    bgc_choice choice;

    /* Step control. */
    double h_next, error_old;
    int rejected;      /* attempts in a row that were rejected, the last one */
    bgc_status reason; /* for this reason */
    int left;          /* the attempt leaves a root (bgc_leave_root) */

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
    double *returns;        /* n_switch: consecutive immediate returns to the mode before; INFINITY:
                             * the switch is left to error control */
    double *change_of_mode; /* n_switch: the last change of each mode */
    double *faint_phase, *faint_from, *faint_to; /* see faint.c */
    double *faint_low, *faint_at, *faint_entered, *faint_left;
    double *sampling, *instants; /* 2 n_rate: periods and offsets; n_rate: instants that have passed */
    double *turned;         /* n_switch: not 0 where the mode is that before a jump: how far the
                             * argument may lie beyond its edge by rounding (jumps.c) */
    double *holds;          /* n_jump: not 0 where the condition was true at the last event */
    double *jumped_at, *close_jumps; /* n_jump: time of the last jump, and jumps in quick succession */
    bgc_faint_state *faint; /* n_state */
    double *divisor_extent; /* n_divisor: the largest absolute value of each divisor so far */
    double *divisor_slope;  /* n_divisor: the rate of each divisor at the end of the last step */
    bgc_range *h_range, *u_range; /* h and u as ranges: timed.c */
    double *variation;      /* n_term: of each term of time alone, the largest that a step resolved */
    double *patience;       /* n_term: factor of the steps that each allows; INFINITY: not watched */
    double *f_before;       /* f at the start of a step that a term has limited */
    double *inverse_mass;   /* 1 / m_ii where row i of M has no other entry, else 0 */
    double *algebraic;      /* 1 where row i of M is empty, else 0 */
    double *correction, *corrected_at, *range; /* of fixed steps: corrections.c */
    double *dominant;       /* of the last power iteration: stiffness.c */
    double *jac, *dfdt, *lu, *f;
    double *y0, *y1, *k;    /* dense output; k is BGC_MAX_DENSE vectors */
    bgc_complex *complex_lu;
    double *closed_before;  /* dw/dx and responses of closed chains at the present */
    double *response_size;  /* of each row of these: the largest diagonal of S so far */

    /* Scratch. */
    double *stages;         /* BGC_MAX_STAGES vectors: the U_i, or Z_i */
    double *implicit;       /* twice BGC_MAX_IMPLICIT vectors: f at the stages, corrections */
    bgc_complex *complex_right, *complex_b, *complex_residual;
    double *complex_work;   /* 3 n_state: complex elimination */
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
    double *around;         /* n_term: variations to compare with, */
    double *widest;         /* and in the window ahead */
    double *sparse_work;    /* 2 n_unknowns: elimination by tables */
    double *block_work;     /* 18 n_place: elimination in blocks */
    double *reach;          /* n_unknowns: sizes of a solution that count in its check */
    double *wide;           /* n_unknowns: a right-hand side with inner rows, and its solution */
    bgc_complex *complex_wide;
    double *local, *slopes; /* n_local; n_jac: inner.c */
    double *inner;          /* a dense matrix of all unknowns */
    size_t inner_room;
    double *dense_lu;       /* n by n: dense factors */
    size_t dense_room, block_room; /* rows and columns that dense_lu and block_lu have room for */
    bgc_complex *dense_complex; /* n by n; NULL before it is needed, see complex.c */
    int *pivot, *complex_pivot;

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
    int *closing_pivot;

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

/* --- instance.c */
bgc_status bgc_check_parameters(const bgc_model *m, bgc_data *d);

/* --- layout.c */
size_t bgc_place_all(const bgc_model *m, bgc_data *d, double *from);
size_t bgc_saved_count(const bgc_model *m);

/* --- linear.c */
bgc_pivoting bgc_choose_checks(long count, double growth, int *watched);
bgc_status bgc_factorise(const bgc_model *m, bgc_data *d, double c);
bgc_status bgc_refactorise_dense(const bgc_model *m, bgc_data *d);
bgc_status bgc_solve(const bgc_model *m, bgc_data *d, double *b);
int bgc_factorise_dense(int n, double *a, int *pivot, double *weight);
int bgc_rounded_pivot(int n, const double *lu);
void bgc_solve_dense(int n, const double *lu, const int *pivot, double *b);
int bgc_reserve_dense(const bgc_model *m, bgc_data *d);
int bgc_make_room(double **matrix, size_t *room, size_t n);
void bgc_raise_to_least_part(const bgc_model *m, bgc_data *d);
void bgc_multiply_mass(const bgc_model *m, const bgc_data *d, const double *v, double *out);

/* --- least_squares.c */
typedef struct { /* n equations in n unknowns; the functions return whether all is finite */
    int n;
    int (*residual)(void *of, const double *y, double *r);
    int (*matrix)(void *of, const double *y, double *a); /* the Jacobian, row by row */
    void *of;
    double *work; /* 6 n + 3 n^2 doubles */
} bgc_dense_system;
int bgc_least_squares(const bgc_dense_system *s, double *y, const double *scale);
#define BGC_MAX_SEARCHED 200

/* --- sparse.c */
int bgc_sparse_factor(const bgc_model *m, const double *mass, const double *jac, double c,
                      double *lu, double *growth, double *scratch);
void bgc_sparse_solve(const bgc_model *m, const double *lu, double *b, double *scratch);
int bgc_complex_factor(const bgc_model *m, const double *mass, const double *jac, bgc_complex c,
                       bgc_complex *lu, double *growth, double *scratch);
void bgc_complex_solve(const bgc_model *m, const bgc_complex *lu, bgc_complex *b,
                       bgc_complex *scratch);

/* --- inner.c */
void bgc_differentiate(const bgc_model *m, bgc_data *d, double t, const double *x, double *jac,
                       double *dfdt);
const double *bgc_slopes(const bgc_model *m, bgc_data *d);
void bgc_scale_inner(const bgc_model *m, bgc_data *d);

/* --- blocks.c, complex_blocks.c */
int bgc_block_factor(const bgc_model *m, const double *scale, const double *mass,
                     const double *jac, double c, double *lu, double *growth, double *scratch);
void bgc_block_solve(const bgc_model *m, const double *lu, double *b, double *scratch);
int bgc_complex_block_factor(const bgc_model *m, const double *scale, const double *mass,
                             const double *jac, bgc_complex c, bgc_complex *factors,
                             double *growth, double *scratch);
void bgc_complex_block_solve(const bgc_model *m, const bgc_complex *factors, bgc_complex *b,
                             bgc_complex *scratch);

/* --- complex.c */
bgc_status bgc_reserve_complex(const bgc_model *m, bgc_data *d, const bgc_method *method);
bgc_status bgc_factorise_complex(const bgc_model *m, bgc_data *d, bgc_complex c);
bgc_status bgc_refactorise_complex(const bgc_model *m, bgc_data *d);
bgc_status bgc_solve_complex(const bgc_model *m, bgc_data *d, bgc_complex *b);

/* --- vectors.c */
void bgc_combine(int n, int count, const double *weight, const double *vectors, double *out);
double bgc_norm(const bgc_model *m, const bgc_data *d, const double *v, const double *a,
                const double *b);
int bgc_first_bad(int n, const double *v);

/* --- rosenbrock.c, explicit.c, collocation.c, stages.c: functions of the families */
bgc_status bgc_rosenbrock(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);
bgc_status bgc_runge_kutta(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);
bgc_status bgc_collocate(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);
void bgc_sum_stages(const bgc_model *m, bgc_data *d, const bgc_method *method);
int bgc_interpolate_stages(const bgc_model *m, bgc_data *d, const bgc_method *method);
void bgc_correction_of_stages(const bgc_model *m, bgc_data *d, const bgc_method *method,
                              double *change);
int bgc_interpolate_radau(const bgc_model *m, bgc_data *d, const bgc_method *method);
void bgc_correction_of_slope(const bgc_model *m, bgc_data *d, const bgc_method *method,
                             double *change);
void bgc_collocation_quadrature(const bgc_model *m, bgc_data *d, const bgc_method *method,
                                double power[2]);

/* --- run.c */

/* The next sample of the devices, or the next instant of a sampled part if that is first. */
static inline void bgc_schedule(bgc_core *core) {
    const double sample = core->origin + (double)core->sample * core->period;

    core->due = core->period > 0.0 && sample < core->instant ? sample : core->instant;
}

bgc_status bgc_sample(const bgc_model *m, bgc_data *d);
bgc_status bgc_apply_inputs(const bgc_model *m, bgc_data *d);
bgc_status bgc_write_row(const bgc_model *m, bgc_data *d, double t, double *row);

/* --- step.c */
bgc_status bgc_attempt(const bgc_model *m, bgc_data *d);

/* --- substeps.c */
void bgc_begin_sample(bgc_core *core);
double bgc_plan_substep(bgc_core *core, double grid);
int bgc_accept_substep(const bgc_model *m, bgc_data *d, const bgc_method *method, bgc_status status,
                       double h);

/* --- stiffness.c */
void bgc_reset_stiffness(const bgc_model *m, bgc_data *d);
void bgc_watch_stiffness(const bgc_model *m, bgc_data *d, double h);

/* --- switching.c */
const bgc_method *bgc_present_method(const bgc_core *core);
void bgc_reset_choice(const bgc_model *m, bgc_data *d);
void bgc_choose_method(const bgc_model *m, bgc_data *d, double t, double h);
void bgc_count_rejection(bgc_core *core);

/* --- rounding.c */
int bgc_samples_rounding(const bgc_model *m, const bgc_data *d, const bgc_method *method);
int bgc_try_perturbed(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);
void bgc_judge_rounding(const bgc_model *m, bgc_data *d, double error);

/* --- evaluate.c */
void bgc_evaluate_f(const bgc_model *m, bgc_data *d);
void bgc_evaluate_jacobian(const bgc_model *m, bgc_data *d);
bgc_status bgc_check_asserts(const bgc_model *m, bgc_data *d, double t, const double *x);

/* --- divisors.c */
void bgc_reset_divisors(const bgc_model *m, bgc_data *d);
bgc_status bgc_check_divisors(const bgc_model *m, bgc_data *d, double end);
bgc_status bgc_blame_divisor(const bgc_model *m, bgc_data *d, bgc_status status);

/* --- faint.c */
void bgc_reset_faint(const bgc_model *m, bgc_data *d);
void bgc_follow_faint(const bgc_model *m, bgc_data *d, double t);

/* --- first_step.c: from d->x with d->f valid; scratch, d->next among it, is overwritten */
double bgc_first_step(const bgc_model *m, bgc_data *d, int order);
double bgc_limit_first_step(const bgc_model *m, bgc_data *d, double h);

/* --- corrections.c */
void bgc_reset_corrections(const bgc_model *m, bgc_data *d);
void bgc_record_correction(const bgc_model *m, bgc_data *d, const bgc_method *method, double t);
void bgc_report_correction(const bgc_model *m, bgc_data *d);

/* --- consistent.c */
void bgc_classify_states(const bgc_model *m, bgc_data *d);
bgc_status bgc_satisfy(const bgc_model *m, bgc_data *d, double t, double *x);
bgc_status bgc_satisfy_beside(const bgc_model *m, bgc_data *d, double t, double *x);
bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d);

/* --- consistent_steps.c */
bgc_status bgc_keep_consistent(const bgc_model *m, bgc_data *d, const bgc_method *method, double t);
int bgc_leave_root(const bgc_model *m, bgc_data *d, double h);

/* --- start.c */
bgc_status bgc_solve_start(const bgc_model *m, bgc_data *d);

/* --- closures.c */
size_t bgc_closing_size(const bgc_model *m);
bgc_status bgc_close_chains(const bgc_model *m, bgc_data *d, double t, double *x);
bgc_status bgc_close_chains_at_start(const bgc_model *m, bgc_data *d);

/* --- closed_start.c */
bgc_status bgc_close_start(const bgc_model *m, bgc_data *d);

/* --- singular_chains.c */
bgc_status bgc_watch_chains(const bgc_model *m, bgc_data *d, double t, const double *x);
int bgc_chains_were_left(const bgc_model *m, const bgc_data *d, const double *x);
void bgc_enter_chains(const bgc_model *m, bgc_data *d);
bgc_status bgc_status_near_chains(const bgc_model *m, const bgc_data *d, bgc_status status);

/* --- modes.c */
void bgc_hold_modes(const bgc_model *m, bgc_data *d);
void bgc_release_modes(const bgc_model *m, bgc_data *d);
void bgc_find_modes(const bgc_model *m, bgc_data *d);
void bgc_reset_modes(const bgc_model *m, bgc_data *d);
void bgc_perturb_by_tolerances(const bgc_model *m, const bgc_data *d, const double *x,
                               double *moved);
bgc_status bgc_settle(const bgc_model *m, bgc_data *d);

/* --- at_events.c */
bgc_status bgc_handle_event(const bgc_model *m, bgc_data *d, double whole);

/* --- sampled.c */
void bgc_start_sampled(const bgc_model *m, bgc_data *d);
bgc_status bgc_take_sampled(const bgc_model *m, bgc_data *d, double slack);

/* --- jumps.c */
void bgc_reset_jumps(const bgc_model *m, bgc_data *d);
bgc_status bgc_meet_edges(const bgc_model *m, bgc_data *d);
void bgc_ignore_turned(const bgc_model *m, bgc_data *d);
void bgc_judge_turned(const bgc_model *m, bgc_data *d, const double *const *z);
bgc_status bgc_jump(const bgc_model *m, bgc_data *d, const double *before, double whole);

/* --- events.c */
double bgc_stop_for_switch(const bgc_model *m, bgc_data *d, double end);
bgc_status bgc_find_event(const bgc_model *m, bgc_data *d, double end, int may_shorten,
                          double *found);

/* --- timed.c */
void bgc_reset_terms(const bgc_model *m, bgc_data *d);
void bgc_forget_ahead(const bgc_model *m, bgc_data *d);
double bgc_limit_for_time(const bgc_model *m, bgc_data *d, double t, double h);
void bgc_judge_terms(const bgc_model *m, bgc_data *d, double h);

/* --- watch.c */
double bgc_hidden_peak(int kind, const double *z);
double bgc_before_hidden(const bgc_model *m, bgc_data *d, double end);

/* --- dense.c */
extern const double bgc_sample_at[BGC_SAMPLES];
extern const int bgc_first_sample[BGC_FIRST_SAMPLES];
void bgc_store_dense(const bgc_model *m, bgc_data *d, const bgc_method *method, double end);
void bgc_interpolate(const bgc_model *m, bgc_data *d, double t, double *x);
void bgc_interpolate_all(const bgc_model *m, bgc_data *d, double t, double *x);
void bgc_interpolate_some(const bgc_model *m, bgc_data *d, double t, int count, const int *state,
                          double *x);
void bgc_dense_slope(const bgc_model *m, const bgc_data *d, double *slope);

/* --- accounts.c */
void bgc_integrate_energy(const bgc_model *m, bgc_data *d, double t, double power[2]);
void bgc_balance_step(const bgc_model *m, bgc_data *d, const bgc_method *method, double t,
                      bgc_balance *balance);
void bgc_settle_energy_scale(const bgc_model *m, bgc_data *d);
double bgc_residual_after(const bgc_core *core, const bgc_balance *balance);
void bgc_enter_balance(bgc_core *core, const bgc_balance *balance);

/* --- devices.c */
bgc_status bgc_read_devices(const bgc_model *m, bgc_data *d);
bgc_status bgc_write_devices(const bgc_model *m, bgc_data *d);
void bgc_zero_devices(const bgc_model *m, bgc_data *d);
void bgc_default_inputs(const bgc_model *m, double *u);

#endif
