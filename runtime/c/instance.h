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

#include <math.h>
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

    /* Errors of the states: global_error.c, local_error.c. */
    int off_method;       /* of the steps that the local errors at hand belong to */
    int off_every, off_since; /* a step in so many is measured; steps since the last one */
    int off_bends, off_delayed; /* J changes e by more than little; e is a delay */
    double off_event;     /* the time of the last event, or of the start */
    double off_noted;     /* the last time whose errors are in largest_off */
    double off_size;      /* of the local error at hand, over the tolerances */
    double off_error;     /* the estimate of the method for the measured step */
    double off_step, off_scale; /* length of the measured step; factor of its errors in the present one */
    double off_slope;     /* |h J e| / |e| when last looked at */
    /* Of the step that off_power belongs to: 1 / (c h), and the part of the lower order in it. */
    double off_gamma, off_part;
    double off_power[4];
    int off_powers;       /* of S */

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

/* What follows a run beside it. */
typedef struct {
    void *of;
    /* Before d->next, to which a step of the method leads, becomes the present at t. */
    bgc_status (*step)(const bgc_model *m, bgc_data *d, void *of, const bgc_method *method, double t);
    /* After an event, with the new modes; d->next has the states before a jump, d->u_step the modes. */
    bgc_status (*event)(const bgc_model *m, bgc_data *d, void *of);
    /* Before the resets of the conditions in d->condition, with consistent states and their modes. */
    bgc_status (*jump)(const bgc_model *m, bgc_data *d, void *of);
    /* Before devices or sampled parts change the inputs, and after what has followed. */
    void (*before_inputs)(const bgc_model *m, bgc_data *d, void *of);
    bgc_status (*inputs)(const bgc_model *m, bgc_data *d, void *of);
    /* With the row at t, inside the last step or at the present. */
    bgc_status (*row)(const bgc_model *m, bgc_data *d, void *of, double t, int inside);
} bgc_follower;

struct bgc_data {
    bgc_core core;
    const bgc_follower *follower; /* NULL: none */
    unsigned char *is_set; /* n_param: set by the user */
    void *allocated; /* holds `memory`, which begins at a cache line */
    double *memory;

    size_t n_saved; /* doubles of the arrays that are saved */
#define ARRAY(type, name, count) type *name;
#define NUMBERS(name, count) double *name;
#define SCRATCH
#include "arrays.h"
#undef ARRAY
#undef NUMBERS
#undef SCRATCH

    /* Matrices that are allocated when they are needed: of all unknowns, dense factors, of a search for
     * a start, for at most BGC_MAX_SEARCHED unknowns. */
    double *inner, *dense_lu, *block_search;
    bgc_complex *dense_lu_complex;
    size_t inner_room, dense_room, dense_room_complex, block_room; /* rows that there is room for */
    int *pivot, *pivot_complex;

    /* The block of states that the algebraic equations are solved for: consistent.c. */
    int n_block;
    int *block; /* their numbers */
    int *place; /* of each state: its position in the block, or -1 */
    int *block_pivot;
    double *block_lu; /* n_block by n_block */
    int *start_pivot; /* of the equations of the start: start.c */
    int *closing_pivot, *closing_list; /* of closed chains: closures.c */

    bgc_device *device;
    struct bgc_fmu *fmu;     /* n_fmu, once one is open; */
    int failed_fmu;          /* the one that failed, or -1 */
    int failed_device;       /* the last one that reported a fault, or -1; */
    char device_reason[256]; /* and its driver's reason */
    atomic_int stop;
};

/* The tolerance of state i at this size, by which solutions of the algebraic equations are judged. */
static inline double bgc_tolerance(const bgc_data *d, int i, double size) {
    const double atol = d->core.atol > 0.0 ? d->core.atol : d->core.rtol * d->scale[i];

    return atol + d->core.rtol * size;
}

/* BGC_ASSERTION where one of the first n assertions fails at (t, x) or is undefined:
 * core.failed_assertion. */
static inline bgc_status bgc_check_first_asserts(const bgc_model *m, bgc_data *d, int n, double t,
                                                 const double *x) {
    if (n == 0) {
        return BGC_OK;
    }
    m->asserts(d->h, t, x, d->u, d->check, d->work);
    for (int k = 0; k < n; k++) {
        if (!(fabs(d->check[k]) > 0.0)) {
            d->core.failed_assertion = k;
            return BGC_ASSERTION;
        }
    }
    return BGC_OK;
}

/* The same of all assertions. */
static inline bgc_status bgc_check_asserts(const bgc_model *m, bgc_data *d, double t,
                                           const double *x) {
    return bgc_check_first_asserts(m, d, m->n_assert, t, x);
}

#endif
