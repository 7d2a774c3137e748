/* bgc.h: the C interface of a compiled bond graph.
 *
 * A model is constant data and functions, emitted by the compiler; a bgc_data is one running
 * instance of it. Calls take the const model and one mutable bgc_data, allocate nothing after
 * bgc_new, and return a status where they can fail. Quantities are SI. The equations of a model are
 * M y' = f(t, y, u).
 */
#ifndef BGC_H
#define BGC_H

#include "bgc_device.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BGC_ABI 20

typedef enum {
    BGC_OK = 0,
    BGC_STEP_TOO_SMALL,  /* error control asks for a step below the resolution of time */
    BGC_TOO_MANY_STEPS,  /* the limit on steps between two rows is reached */
    BGC_NOT_FINITE,      /* an overflow or an undefined operation in the model's equations */
    BGC_SINGULAR,        /* the iteration matrix of a step could not be factorised */
    BGC_ASSERTION,       /* an `assert` of the model failed: bgc_failed_assertion names it */
    BGC_DEVICE,          /* a device driver reported a fault; its forces were set to zero */
    BGC_BAD_PARAMETER,   /* a parameter is out of range: bgc_failed_parameter names it */
    BGC_BAD_ARGUMENT,    /* the arguments of the call are wrong */
    BGC_INTERRUPTED,     /* bgc_stop was called */
    BGC_NO_MEMORY,
    BGC_NOT_EXPLICIT,    /* an explicit method on equations that couple rates */
    BGC_INCONSISTENT,    /* no values near the present ones satisfy the algebraic equations */
    BGC_NOT_CONVERGED,   /* the Newton iteration of an implicit step does not converge */
    BGC_CHATTERING,      /* a law switches back and forth without end: bgc_failed_switch names it */
    BGC_VANISHING,       /* a divisor of the equations vanishes: bgc_failed_divisor names it */
    BGC_SINGULAR_CHAIN,  /* a closed chain is at a singular position: bgc_failed_chain names it */
    BGC_OPEN_CHAIN,      /* the start does not close a chain: bgc_failed_chain names the condition */
    BGC_ENDLESS_JUMPS,   /* jumps follow each other ever faster: bgc_failed_jump names one */
    BGC_BAD_SAMPLE,      /* a sampled value is not finite: bgc_failed_held names it */
    BGC_GRAZING,         /* an event without a derivative: bgc_failed_switch names what touches its edge, */
    BGC_SIMULTANEOUS,    /* or one of several that the parameters part */
    BGC_FMU              /* an FMU of another tool failed: bgc_failed_fmu names it */
} bgc_status;

typedef struct {
    const char *name;
    const char *unit;
    double value;      /* default */
    double low, high;  /* inclusive; -INFINITY and INFINITY where open */
} bgc_param_info;

typedef struct {
    const char *name;
    const char *unit;
} bgc_var_info;

/* A component of a channel that the model reads from a device (input) or writes to it (command). */
typedef struct {
    int device;     /* -1: an input that the caller writes */
    int channel;    /* one of bgc_channel */
    int component;  /* from 0 */
} bgc_channel_use;

typedef enum {
    BGC_POSITION = 0,      /* in, m, 3 */
    BGC_ORIENTATION = 1,   /* in, unit quaternion w x y z, 4 */
    BGC_VELOCITY = 2,      /* in, m/s, 3 */
    BGC_ANGULAR_VELOCITY = 3, /* in, rad/s, 3 */
    BGC_GRIPPER = 4,       /* in, m, 1 */
    BGC_BUTTONS = 5,       /* in, 0 or 1 each, 8 */
    BGC_FORCE = 6,         /* out, N, 3 */
    BGC_TORQUE = 7,        /* out, N m, 3 */
    BGC_GRIPPER_FORCE = 8, /* out, N, 1 */
    BGC_HELD_FORCE = 9,    /* in, N, 3 */
    BGC_AGE = 10           /* in, s, 1 */
} bgc_channel;

typedef struct {
    const char *name;     /* as the scene calls it */
    const char *driver;   /* "trace" */
    const char *options;  /* "key=value" lines, as written in the scene */
} bgc_device_info;

/* A number of an FMU of another tool, and the held value that it gives or takes, which is
 * factor * number + offset. */
typedef struct {
    uint32_t reference;
    int kind;   /* its type: the place in the list of fmus.h */
    int role;   /* 0: a parameter, set at the start; 1: one that is also set later, where it changes; 2: an
                 * input, set at each instant; 3: read at each instant */
    int held;   /* a place in bgc_model.held_input */
    int place, count; /* the number `place` of the `count` behind its reference */
    double factor, offset;
    double start; /* of a parameter, its number in the FMU: one that has it is not set. NAN: not known */
} bgc_fmu_variable;

/* An FMU that takes a communication step at each instant of a rate. What is set comes before what is read;
 * the components of an array follow each other. */
typedef struct {
    const char *name;
    const char *file;   /* as the model names it */
    const char *token;  /* guid or instantiationToken */
    int version;        /* of FMI: 2 or 3 */
    int rate;
    int n_variable;
    const bgc_fmu_variable *variable;
} bgc_fmu_info;

/* An initial value that the user gives. */
typedef enum { BGC_GIVEN = 0, BGC_GIVEN_BY_DEFAULT = 1, BGC_GIVEN_ROUNDED = 2 } bgc_given_kind;

/* A piecewise operation on an argument z. Its mode is its result, or the piece that applies: of a kink,
 * BGC_NOT_BELOW. */
typedef enum {
    BGC_ABOVE = 0,      /* z > 0 */
    BGC_NOT_BELOW = 1,  /* z >= 0 */
    BGC_SIGN = 2,       /* -1, 0 or 1 */
    BGC_FLOOR = 3,
    BGC_CEIL = 4,
    BGC_TRUNC = 5
} bgc_operation;

typedef struct {
    int operation;  /* one of bgc_operation */
    int timed;      /* z depends on time, inputs and parameters alone */
    int jumps;      /* 0: f is continuous where the mode changes; 2: the condition of a jump reads the mode */
} bgc_switch_info;

/* A function that may have a pulse inside a step. */
typedef enum {
    BGC_EXPONENTIAL = 0, /* where its argument is largest */
    BGC_SATURATING = 1,  /* where its argument comes near zero and returns */
    BGC_RECIPROCAL = 2   /* the same, for a divisor */
} bgc_watch;

typedef struct {
    double low, high;
} bgc_range;

/* Closed chains of rigid connections. Rows w(x) that close them, and conditions g(x) on positions, are
 * kept at zero. All follow from the first n_row and n_condition. Rows of one chain are consecutive; `rank`
 * of them are independent, and condition_rank of the conditions. Where there are more, that many are chosen
 * along a run, at first those that come first. */
typedef struct {
    int n_row, n_all_rows, n_condition, n_all_conditions, condition_rank;
    int n_impulse, n_moved, n_start, n_chain, n_selector;
    const int *chain_of;          /* of each row: its chain */
    const int *rank;              /* n_chain */
    const int *selector;          /* of each row: the place in p that is 1 where the row is chosen and 0
                                   * elsewhere, one of n_selector behind the parameters; -1 without a choice */
    const int *impulse;           /* n_impulse: states that the multipliers of the rows act on */
    const int *moved;             /* n_moved: states in the conditions */
    const int *start;             /* n_start: parameters that may close the start */
    const char *const *chain;     /* parts of each chain */
    const char *const *condition; /* names */
} bgc_closure_info;

/* At most 8 rows and columns of W that are eliminated together: see blocks.c. */
typedef struct {
    int rows;
    int at;             /* place of its first row and column in vectors by blocks */
    int factors, upper; /* places in lu of its factors, and there of the inverse of its upper triangle */
    int left, right, mass, jac; /* where its part of the lists begins, and that of the one before ends */
} bgc_block;

/* The factors of W in blocks of rows. */
typedef struct {
    int n_block, n_place;   /* n_place: size of vectors by blocks, in which columns are aligned */
    int in_lanes;           /* not 0: batches of instances have code for the factors, see bgc_lanes.h */
    const bgc_block *block; /* n_block + 1: the last has the ends of the lists */
    const int *row_place, *col_place; /* of each row and column of W */
    const int *left;        /* numbers of the blocks with entries left of each, ascending */
    const int *right;       /* places of the columns with entries right of each, ascending */
    const int *mass, *mass_to; /* entries of M in the rows of each, also of an identity; 8 x place of
                                * the column + row */
    const int *jac, *jac_to;   /* the same of the Jacobian */
} bgc_block_info;

typedef struct bgc_model {
    uint32_t abi;       /* BGC_ABI */
    const char *name;   /* scene's name */
    const char *hash;   /* content hash of the source, hex */

    int n_param;   /* p; the selectors of closing rows follow */
    int n_hoist;   /* h: expressions of parameters alone */
    int n_state;   /* x */
    int n_input;   /* u: device inputs, held over a sample; n_switch modes follow them in u */
    int n_output;  /* y: observed, without the energy accounts */
    int n_command; /* c: to devices */
    int n_assert;
    int n_device;
    int n_jac;     /* stored entries of df/dx */
    int n_mass;    /* stored entries of M; 0 means the identity */
    int n_lu;      /* entries of the factors of W, which factor() fills */
    int n_work;    /* doubles of scratch w, for any of the functions below */

    const bgc_param_info *param;
    const bgc_var_info *state;
    const bgc_var_info *output;
    const bgc_channel_use *input;
    const bgc_channel_use *command;
    const bgc_device_info *device;
    const char *const *assertion;        /* messages */
    const char *const *param_check;      /* messages of positive(), n_check of them */
    int n_check;
    int n_given_assert;                  /* assertions that parameters alone decide: the first ones */
    const int *jac_row, *jac_col;        /* of df/dx; jacobian() fills them unless n_inner > 0 */
    const int *mass_row, *mass_col;

    /* The factors of W in the order of elimination: row k is row pivot_row[k] of W, column k is
     * column pivot_col[k]. Entries lie row after row, row k from lu_row[k] (one more than rows):
     * L, the reciprocal of the pivot at lu_pivot[k], U; lu_col has their columns. Entry e of the
     * Jacobian goes to place lu_jac[e], of M to lu_mass[e]. NULL in a model with neither inner unknowns
     * nor blocks: then W is factorised densely wherever factor() does not do it, also for complex c. */
    const int *pivot_row, *pivot_col;
    const int *lu_row, *lu_pivot, *lu_col, *lu_jac, *lu_mass;

    /* Piecewise operations in derivatives and energies, timed ones first. A kernel takes
     * u[n_input + k] as the mode of operation k; where that is a NaN it evaluates the operation. */
    const bgc_switch_info *switch_info;
    int n_switch;
    int n_timed;

    double step;       /* the scene's step (and device sample), s; 0 if it gives none */
    double duration;   /* the scene's run, s; 0 if it gives none */
    double every;      /* row interval, s; 0: each step, or 1,000 rows if adaptive */

    /* h from p; called at each reset. */
    void (*prepare)(const double *p, double *h, double *w);
    /* quantities that must be positive: check[k] > 0, else message k applies. */
    void (*positive)(const double *p, const double *h, double *check, double *w);
    /* defaults that depend on other parameters: sets p[k] where is_set[k] is 0. */
    void (*defaults)(double *p, const unsigned char *is_set, double *w);
    /* x at the start, and the scale of each state for absolute tolerances. */
    void (*initial)(const double *h, double t, const double *u, double *x, double *w);
    void (*scale)(const double *h, double *scale, double *w);
    void (*mass)(const double *h, double *m, double *w);
    void (*rhs)(const double *h, double t, const double *x, const double *u, double *f, double *w);
    /* entries of df/dx in the order of jac_row, jac_col, or those described at n_inner; and df/dt,
     * dense. */
    void (*jacobian)(const double *h, double t, const double *x, const double *u, double *jac,
                     double *dfdt, double *w);
    /* factorises W = c M - J with static pivots; NULL: the runtime does it by the tables above, in
     * blocks of rows, or densely.
     * growth: sum over the pivots of the terms of a pivot, in absolute value, over the pivot; above
     * 1e5 solutions are checked. Returns nonzero where a pivot vanishes. */
    int (*factor)(const double *m, const double *jac, double c, double *lu, double *growth);
    /* b := W^-1 b, in the order of the states. Inner unknowns (see n_inner) are left in w, as far as
     * the states need them. */
    void (*solve)(const double *lu, double *b, double *w);
    void (*outputs)(const double *h, double t, const double *x, const double *u, double *y,
                    double *w);
    void (*commands)(const double *h, double t, const double *x, const double *u, double *c,
                     double *w);
    /* stored energy in J, supplied and dissipated power in W. */
    void (*energy)(const double *h, double t, const double *x, const double *u, double out[3],
                   double *w);
    /* normalises states after each completed step (quaternions); NULL if there are none. */
    void (*project)(const double *h, double t, double *x, double *w);
    /* the arguments of the switches; NULL if there are none. */
    void (*switches)(const double *h, double t, const double *x, const double *u, double *z,
                     double *w);
    /* those of the timed ones alone; NULL where these are none or all. */
    void (*timed_switches)(const double *h, double t, const double *x, const double *u, double *z,
                           double *w);
    /* Ranges over a range of times of the arguments of the timed ones, b[2 k], and of their derivatives by time,
     * b[2 k + 1], which stay as they are where an argument jumps; an infinite range is not known. NULL if there
     * are none. */
    void (*timed_ranges)(const bgc_range *h, bgc_range t, const bgc_range *u, bgc_range *b, bgc_range *w);
    /* assertion k holds where a[k] is defined and not 0. */
    void (*asserts)(const double *h, double t, const double *x, const double *u, double *a,
                    double *w);

    /* Divisors in f that vary during a run and may vanish: what each belongs to, and their values.
     * A run ends where one vanishes. */
    int n_divisor;
    const char *const *divisor;
    void (*divisors)(const double *h, double t, const double *x, const double *u, double *z,
                     double *w);
    /* Initial values without a closed form: n_start equations in as many unknowns s, solved at each
     * reset from start_guess. `start` gives the residuals r and their Jacobian, row by row; `started`
     * overwrites the states that follow from s. 0 and NULL where there are none. */
    int n_start;
    const double *start_guess;
    void (*start)(const double *h, double t, const double *u, const double *s, double *r, double *j,
                  double *w);
    void (*started)(const double *h, double t, const double *u, const double *s, double *x,
                    double *w);
    /* Initial values that the user gives and that need a check: what value k is at the start in g[2 k], what it has
     * to be in g[2 k + 1]. A default of zero need not hold, and a value that counts as rounded may be off by 1e-3
     * of itself. 0 and NULL where there are none. */
    int n_given;
    const char *const *given_name;
    const int *given_kind;  /* bgc_given_kind */
    void (*given)(const double *h, double t, const double *x, const double *u, double *g, double *w);
    /* The states that switches() reads, where they are few and neither projected nor algebraic; 0
     * where it may read any. */
    const int *switch_state;
    int n_switch_state;

    /* Ranges of the terms of time alone over a range of times: b[2 k] of term k, b[2 k + 1] of its
     * derivative by time; an infinite range is not known. NULL if there are none. */
    int n_term;
    void (*ranges)(const bgc_range *h, bgc_range t, const bgc_range *u, bgc_range *b, bgc_range *w);

    /* Closed chains; NULL if there are none. Sets all w, all g, dw/dx (n_row by n_impulse), the rates
     * of these states by the multipliers (n_impulse by n_row), dg/dx (n_condition by n_moved), and
     * the derivatives of the start of `moved` by the parameters `start` (n_moved by n_start). */
    const bgc_closure_info *closure_info;
    void (*closures)(const double *h, double t, const double *x, const double *u, double *c,
                     double *w);
    /* The arguments of functions of states that may have a pulse inside a step, and their kinds. */
    int n_watch;
    const int *watch; /* of bgc_watch */
    const int *watch_state; /* as switch_state, of watched() */
    int n_watch_state;
    void (*watched)(const double *h, double t, const double *x, const double *u, double *z,
                    double *w);
    /* Jumps: where condition k becomes true (not 0), resets jump_first[k] to before jump_first[k + 1]
     * give states reset_state new values. The conditions read the modes of the switches edge_switch,
     * whose arguments have the edge_rates where the states have the rates r. NULL if there are none. */
    int n_jump, n_edge;
    const int *jump_first, *reset_state, *edge_switch;
    void (*conditions)(const double *h, double t, const double *x, const double *u, double *c,
                       double *w);
    void (*resets)(const double *h, double t, const double *x, const double *u, double *z, double *w);
    void (*edge_rates)(const double *h, double t, const double *x, const double *u, const double *r,
                       double *z, double *w);

    /* Sampled parts. The last n_slot inputs are reserved for values that are held between instants:
     * value k is input held_input[k]. At each instant of rate held_rate[k] it takes the result k of
     * held(), evaluated before all changes; its start is result k of held_start(). The instants of
     * rate r are s[2 r + 1] + i s[2 r] for i = 0, 1, .., with s from sampling(). */
    int n_held, n_rate, n_slot;
    const int *held_input, *held_rate;
    void (*sampling)(const double *h, double *s, double *w);
    void (*held_start)(const double *h, double t, const double *u, double *z, double *w);
    void (*held)(const double *h, double t, const double *x, const double *u, double *z, double *w);
    /* Sampled ports: of each the numbers of three held values, whose changes at an instant are the energies
     * that it has received from its device, dissipated and created. */
    int n_port;
    const int *book;

    /* Inner unknowns z of the linear systems, beside the states: f is g(x, z) with 0 = r(x, z), and
     * df/dx = g_x - g_z r_z^-1 r_x. Then jacobian() fills the n_local entries of [g_x g_z; r_x r_z] at
     * local_row, local_col, and W = c M - J has n_inner more rows and columns, which M lacks.
     * Elimination of z from the last to the first meets no zero pivot. 0 and NULL: there are none. */
    int n_inner, n_local;
    const int *local_row, *local_col;

    /* The factors of W in blocks of rows; then factor() and the tables of W are NULL. NULL: these. */
    const bgc_block_info *blocks;

    /* Operations of an explicit step over those of an implicit one, by which `switching` and
     * `switching_fixed` choose; 0: explicit steps are not worth while, or impossible since M is not the
     * identity. */
    double explicit_cost;

    /* The arguments of all switches, at the place of the evaluation of rhs() that was the last to use w;
     * NULL where they cost little by themselves. */
    void (*switches_after_rhs)(const double *h, double t, const double *x, const double *u, double *z,
                               double *w);

    int n_fmu;
    const bgc_fmu_info *fmu; /* FMUs of other tools */
} bgc_model;

/* The emitted model. */
const bgc_model *bgc_get_model(void);

/* The number of jumps of the states of a model, and of its sampling rates. */
int bgc_count_jumps(const bgc_model *m);
int bgc_count_rates(const bgc_model *m);

/* m->explicit_cost. */
double bgc_explicit_cost(const bgc_model *m);

/* Whether batches of instances (bgc_lanes.h) can have code for the factors of W. */
int bgc_has_lane_factors(const bgc_model *m);

typedef struct bgc_data bgc_data;

/* --- an instance ------------------------------------------------------------------------ */

bgc_data *bgc_new(const bgc_model *m);  /* NULL when there is no memory; parameters at default */
void bgc_free(const bgc_model *m, bgc_data *d);

/* Sets parameter k; k < 0 restores the defaults of all. Takes effect at bgc_reset. */
bgc_status bgc_set_param(const bgc_model *m, bgc_data *d, int k, double value);
double bgc_get_param(const bgc_model *m, const bgc_data *d, int k);
/* Checks the parameters, evaluates the expressions that depend on them, sets x to its initial values
 * at time t (BGC_BAD_PARAMETER where they do not exist, or where one that is given does not hold) and
 * solves the algebraic equations for the states without a derivative. Reads the open devices. */
bgc_status bgc_reset(const bgc_model *m, bgc_data *d, double t);
/* The same for callers that set another state afterwards: given values need not hold. */
bgc_status bgc_reset_unchecked(const bgc_model *m, bgc_data *d, double t);
/* After a reset: by how much each state differs from its given initial value because that does not close a
 * chain, n_state numbers; zero where parameters that nothing sets close it. */
void bgc_closing_moves(const bgc_model *m, bgc_data *d, double *move);
/* Restarts the run at the present time from the state that the caller has written; the algebraic
 * equations are solved for the states without a derivative. Parameters, modes and devices do not
 * change. */
bgc_status bgc_restart(const bgc_model *m, bgc_data *d);

/* Index into param; n_param + index of a check; n_param + n_check: initial values do not exist;
 * n_param + n_check + 1 + index of a given value that the start misses. */
int bgc_failed_parameter(const bgc_data *d);
int bgc_failed_assertion(const bgc_data *d);
int bgc_failed_state(const bgc_data *d);     /* or -1 */
int bgc_failed_switch(const bgc_data *d);
int bgc_failed_divisor(const bgc_data *d);
double bgc_failed_time(const bgc_data *d);   /* s: when that divisor vanishes */
int bgc_failed_chain(const bgc_data *d);
int bgc_failed_jump(const bgc_data *d);
int bgc_failed_held(const bgc_data *d);
/* The parts of closed chain k, and the name of condition k; NULL past the last. */
const char *bgc_chain_name(const bgc_model *m, int k);
/* The k-th state of those that describe the position of closed chains; -1 past the last. */
int bgc_chain_state(const bgc_model *m, int k);
const char *bgc_condition_name(const bgc_model *m, int k);
const char *bgc_status_text(bgc_status s);

/* The end of the last step, which may lie beyond the last row (see bgc_run). */
double bgc_time(const bgc_data *d);
/* The state at t within the last step, by its dense output. */
bgc_status bgc_state_at(const bgc_model *m, bgc_data *d, double t, double *x);
/* Continues a reset at other values: those of x, n_state, and then of all that sampled parts hold. */
bgc_status bgc_restart_at(const bgc_model *m, bgc_data *d, const double *start);
double *bgc_state(bgc_data *d);              /* x, n_state; may be written between steps */
const double *bgc_scale(const bgc_data *d);  /* n_state: absolute tolerances are relative to them */
double *bgc_input(bgc_data *d);              /* u, n_input; the caller writes those without a device */
/* The whole instance except its devices: a restored run continues with the same bits. The state of
 * another model is refused. */
size_t bgc_save_size(const bgc_model *m);
bgc_status bgc_save(const bgc_model *m, const bgc_data *d, void *memory);
bgc_status bgc_restore(const bgc_model *m, bgc_data *d, const void *memory);

/* --- evaluation at the present time and state ------------------------------------------ */

bgc_status bgc_rhs(const bgc_model *m, bgc_data *d, double *f);
/* The arguments of all switches, n_switch of them. */
void bgc_switch_arguments(const bgc_model *m, bgc_data *d, double *argument);
bgc_status bgc_jacobian(const bgc_model *m, bgc_data *d, double *jac, double *dfdt);
/* Stored entries of M, n_mass of them; none for the identity. */
bgc_status bgc_mass(const bgc_model *m, bgc_data *d, double *mass);
bgc_status bgc_outputs(const bgc_model *m, bgc_data *d, double *y);
/* The rows and conditions of closed chains, which are zero in a run, with their derivatives by the
 * states, count * n_state by rows; those of the rows by momenta alone. The count is bgc_chain_rows(m). */
int bgc_chain_rows(const bgc_model *m);
bgc_status bgc_evaluate_chain_rows(const bgc_model *m, bgc_data *d, double *value, double *slope);
/* The values that sampled parts would hold after an instant at the present time and state, and the period
 * of each in s; bgc_count_held(m) of them. Value k is input bgc_held_input(m, k). */
int bgc_count_held(const bgc_model *m);
int bgc_held_input(const bgc_model *m, int k);
bgc_status bgc_next_held(const bgc_model *m, bgc_data *d, double *value, double *period);
/* stored since reset, supplied, dissipated, residual = stored - supplied + dissipated; J. */
bgc_status bgc_energy(const bgc_model *m, bgc_data *d, double account[4]);

/* --- integration -------------------------------------------------------------------------- */

/* An integration method. */
typedef struct {
    const char *name;    /* "rodas5p" */
    const char *family;  /* "Rosenbrock" */
    const char *purpose; /* a line of text: the equations and uses that it is for */
    int order;
    int error_order;     /* of the embedded solution that estimates its error; 0: fixed steps only */
    int jacobian;        /* 1: steps use df/dx; 0: explicit, and M has to be diagonal */
    int lanes;           /* 1: bgc_run_lanes serves it */
    int embedded_order;  /* of the solution by which fixed steps may be subdivided; 0: they may not */
    int substeps;        /* the default of bgc_options.substeps */
    int stages;
} bgc_method_info;

/* Properties of method k; BGC_BAD_ARGUMENT past the last. The first method with error control and
 * the first with fixed steps are the defaults; where explicit_cost is not 0 those that change to an
 * explicit one: `switching`, `switching_fixed`. */
bgc_status bgc_get_method(int k, bgc_method_info *info);

typedef struct {
    const char *name;  /* a method's; NULL: the default, with fixed steps where a step is given */
    double rtol;       /* 0: 1e-6 */
    double atol;       /* > 0: for all states; 0: rtol times the scale of each state, less while no
                       * state has reached its scale (scale_reached below) */
    double step;       /* fixed step, or first step of an adaptive method; 0: the scene's, or chosen */
    double max_step;   /* 0: none */
    double min_step;   /* error control that asks for a shorter step ends the run; 0: none */
    int max_steps;     /* between two rows; 0: 10 million */
    int keep;          /* fixed steps that one factorisation serves; 0: 1 */
    int substeps;      /* a fixed step whose error is above rtol (0: 1e-3) and atol (as above, of the
                        * whole scales) is subdivided, with at most so many further attempts; 1: never, 0: as the
                        * method has it */
    int accounts;      /* 1: integrate the energy accounts, under error control */
    int errors;        /* 1: rows end with estimates of the errors of y, each the largest since the row
                        * before; NaN where they cannot be followed */
} bgc_options;

typedef struct {
    long steps, rejected, rhs, jacobians, factorisations, solves, refinements, fallbacks;
    long samples; /* of devices */
    long events;  /* times at which a switch changed its mode */
    double last_step, worst_step_seconds, run_seconds;
    double worst_sample_seconds; /* computing time of the steps between two samples */
    double exchanged; /* J: the largest of the accounts, the stored energy and the energy that
                       * tolerances regard as small; 0 without accounts */
    /* Of fixed steps that are too long for their equations: the largest change that the last stages
     * of a step make, relative to the range of the state; its time, and the state. 0: none. */
    double largest_correction, correction_time;
    long correction_state;
    double scale_reached; /* the largest abs(x_i) / scale_i so far, at most 1; 1 under a fixed step.
                           * Step tolerances are relative to this part of the scales */
    /* Of fixed steps that may be subdivided: how many were; how many of those were completed with an
     * error above the tolerance, since their budget was spent, the largest such error over the
     * tolerance and its time; the most attempts that one of the first took. */
    long subdivided, over_budget, most_attempts;
    double largest_excess, excess_time;
    /* Of methods that use df/dx: an upper bound on the spectral radius rho of M^-1 df/dx, 1/s, and the
     * integral of that bound; INFINITY where M is not diagonal. An explicit method needs about a
     * third as many steps for its stability. 0: not measured. */
    double fastest, stiffness;
    double controlled_steps; /* the steps that error control alone would have taken, about */
    /* Of some steps with error control: how many were examined, in how many the error estimate
     * consisted of the rounding of f, and the largest rounding over the tolerance. */
    long rounding_samples, rounding;
    double largest_rounding;
    /* Of a method that changes between an implicit and an explicit one: steps of the explicit one, and
     * changes. */
    long explicit_steps, method_changes;
    long doubtful_errors; /* steps and events at which estimated errors were too large for linearised equations */
} bgc_counts;

/* Restarts the count of steps and samples at the present time, and discards the dense output of the
 * last step. */
bgc_status bgc_set_options(const bgc_model *m, bgc_data *d, const bgc_options *o);

/* Integrates and writes a row for each of times[0..n): y, with accounts the four energies, and with errors those
 * of y.
 * times[0] may equal the present time. Rows inside a step come from its dense output, so the last
 * step may end beyond the last row. The next call continues from there: several calls give the same
 * bits as one. Steps of a model with devices or inputs end at samples. A step ends where a switch
 * leaves its mode; a row before that time is in the old mode, a row at that time in the new one. The
 * same holds for the states before and after a jump.
 * `done` is the number of finished rows. After a failure the instance is at its last good state, and
 * the forces of its devices are zero. */
bgc_status bgc_run(const bgc_model *m, bgc_data *d, const double *times, size_t n, double *rows,
                   size_t *done);
/* Integrates to t without the sample of the devices that is due at t, which the next bgc_run takes: for a
 * loop that waits until the clock shows t. Both together give the bits of one bgc_run. */
bgc_status bgc_advance(const bgc_model *m, bgc_data *d, double t);
/* Seconds between two samples of the devices; 0 in a model that samples nothing. */
double bgc_sample_period(const bgc_data *d);
void bgc_stop(bgc_data *d); /* makes bgc_run return soon; from any thread or signal handler */
const bgc_counts *bgc_get_counts(const bgc_data *d);

/* A state that fell below its absolute tolerance and has grown to a thousand times it since; or one that has
 * moved, but never to 30 times its tolerance. */
typedef struct {
    double tolerance;
    double low, fell;    /* its least absolute value, and the time of it, s; of the second, where it first moved */
    double grown, value; /* the time at which it had grown, s, and its value then; of the second, those also */
} bgc_subtolerance_state;

/* Nonzero where state k did so in this run, under error control; of several times the one with the
 * least value. Rounding and local errors decide the run where the state grew by itself, and not where
 * others drove it. */
int bgc_get_subtolerance(const bgc_model *m, const bgc_data *d, int k, bgc_subtolerance_state *state);

/* --- devices ------------------------------------------------------------------------------ */

const bgc_driver *bgc_find_driver(const char *name);  /* of the runtime; NULL: unknown */

/* Opens device k of the model with the given driver (NULL: the scene's) and options (NULL: the
 * scene's); on a fault `message` gives the reason. Device inputs are read at every multiple of the
 * sample period and held over it; commands are written at the same times. The period is m->step, or
 * 1 ms without one; a fixed step that does not divide m->step is the period itself. */
bgc_status bgc_open_device(const bgc_model *m, bgc_data *d, int k, const bgc_driver *driver,
                           const char *options, char *message, size_t size);
void bgc_close_devices(const bgc_model *m, bgc_data *d);  /* zero force first */
/* What the driver of device k returned when it was opened; NULL: it is closed. */
void *bgc_device_handle(const bgc_model *m, const bgc_data *d, int k);
/* Hands a pose to an open driver `pointer` or `gamepad`, from one thread, without waiting; a velocity or angular velocity
 * that begins with a NaN is computed from the positions. `handle` is what its `open` returned. */
void bgc_feed_pointer(void *handle, const bgc_pose *pose);
/* After BGC_DEVICE: the device at fault, and the reason that its driver gives; -1 and "" without one. */
int bgc_failed_device(const bgc_data *d);
const char *bgc_device_reason(const bgc_data *d);

/* --- FMUs of other tools ------------------------------------------------------------------ */

/* Opens FMU k of the model, before a reset: its binary for this machine, and its resources, as the standard
 * wants them: a URI "file:///../resources" in FMI 2, a path that ends in a slash in FMI 3. On a fault `message`
 * gives the reason. Its program runs in this process. bgc_free closes it. */
bgc_status bgc_open_fmu(const bgc_model *m, bgc_data *d, int k, const char *library, const char *resources,
                        char *message, size_t size);
/* After BGC_FMU: the FMU at fault, and the reason that it gives. */
int bgc_failed_fmu(const bgc_data *d);
const char *bgc_fmu_reason(const bgc_model *m, const bgc_data *d);

#ifdef __cplusplus
}
#endif
#endif
