/* bgc.h: the C interface of a compiled bond graph.
 *
 * A model is constant data and functions, emitted by the compiler; a bgc_data is one running
 * instance of it. Every call takes the const model and one mutable bgc_data, allocates nothing
 * after bgc_new and returns a status. Quantities are SI; a model's rows are M y' = f(t, y, u).
 */
#ifndef BGC_H
#define BGC_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BGC_ABI 6

typedef enum {
    BGC_OK = 0,
    BGC_STEP_TOO_SMALL,  /* error control asked for a step below the resolution of time */
    BGC_TOO_MANY_STEPS,  /* the limit on steps between two rows was reached */
    BGC_NOT_FINITE,      /* an overflow or an undefined operation in the model's equations */
    BGC_SINGULAR,        /* the iteration matrix of a step could not be factorised */
    BGC_ASSERTION,       /* an `assert` of the model failed: bgc_failed_assertion names it */
    BGC_DEVICE,          /* a device driver reported a fault; its forces were set to zero */
    BGC_BAD_PARAMETER,   /* a parameter is out of range: bgc_failed_parameter names it */
    BGC_BAD_ARGUMENT,    /* a call's own arguments are at fault */
    BGC_INTERRUPTED,     /* bgc_stop was called from another thread or a signal */
    BGC_NO_MEMORY,
    BGC_NOT_EXPLICIT,    /* an explicit method on equations that couple rates */
    BGC_INCONSISTENT,    /* no values satisfy the algebraic equations near those at hand */
    BGC_NOT_CONVERGED,   /* the iteration for the stages of an implicit step found no solution */
    BGC_CHATTERING       /* a law switches without end: bgc_failed_switch names it */
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

/* A channel component that the model reads from (input) or writes to (command) a device. */
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
    BGC_GRIPPER_FORCE = 8  /* out, N, 1 */
} bgc_channel;

typedef struct {
    const char *name;     /* as the scene calls it */
    const char *driver;   /* "trace" */
    const char *options;  /* "key=value" lines, as written in the scene */
} bgc_device_info;

/* A discontinuous operation on one argument z: its result is its mode. */
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
    int jumps;      /* 0: the laws that it switches are continuous there */
} bgc_switch_info;

typedef struct bgc_model {
    uint32_t abi;       /* BGC_ABI */
    const char *name;   /* scene's name */
    const char *hash;   /* content hash of the source, hex */

    int n_param;   /* p */
    int n_hoist;   /* h: everything that depends on parameters only */
    int n_state;   /* x */
    int n_input;   /* u: device inputs, held over a sample; n_switch modes follow them in u */
    int n_output;  /* y: observed, without the energy accounts */
    int n_command; /* c: to devices */
    int n_assert;
    int n_device;
    int n_jac;     /* stored entries of df/dx */
    int n_mass;    /* stored entries of M; 0 means the identity */
    int n_lu;      /* entries of the factors of W: what factor() fills */
    int n_work;    /* doubles of scratch that any function may need */

    const bgc_param_info *param;
    const bgc_var_info *state;
    const bgc_var_info *output;
    const bgc_channel_use *input;
    const bgc_channel_use *command;
    const bgc_device_info *device;
    const char *const *assertion;        /* messages */
    const char *const *param_check;      /* messages of positive(), n_check of them */
    int n_check;
    const int *jac_row, *jac_col;        /* of the entries that jacobian() fills */
    const int *mass_row, *mass_col;

    /* The factors of W in the order of elimination: row k is row pivot_row[k] of W, column k is
     * column pivot_col[k]. Entries lie row after row, row k from lu_row[k] (n_state + 1 of them):
     * L, the reciprocal of the pivot at lu_pivot[k], U; lu_col has their columns. Entry e of the
     * Jacobian goes to place lu_jac[e], of M to lu_mass[e]. */
    const int *pivot_row, *pivot_col;
    const int *lu_row, *lu_pivot, *lu_col, *lu_jac, *lu_mass;

    /* Discontinuous operations that the derivatives or energies depend on, timed ones first. A
     * kernel takes u[n_input + k] for the result of operation k, or computes it if that is a NaN. */
    const bgc_switch_info *switch_info;
    int n_switch;
    int n_timed;

    double step;       /* the scene's step (and device sample), s; 0 if it gives none */
    double duration;   /* the scene's run, s; 0 if it gives none */
    double every;      /* row interval, s; 0: each step, or 1,000 rows if adaptive */

    /* h from p; done whenever a parameter changes. */
    void (*prepare)(const double *p, double *h, double *w);
    /* parameters that must be positive (message k belongs to check[k]): check[k] > 0 is good. */
    void (*positive)(const double *p, const double *h, double *check, double *w);
    /* defaults of parameters that depend on others: fills p[k] where is_set[k] is 0. */
    void (*defaults)(double *p, const unsigned char *is_set, double *w);
    /* x at the start; scale: the unit of each state for absolute tolerances. */
    void (*initial)(const double *h, double t, const double *u, double *x, double *w);
    void (*scale)(const double *h, double *scale, double *w);
    void (*mass)(const double *h, double *m, double *w);
    void (*rhs)(const double *h, double t, const double *x, const double *u, double *f, double *w);
    /* entries of df/dx in the order of jac_row, jac_col; and df/dt, dense. */
    void (*jacobian)(const double *h, double t, const double *x, const double *u, double *jac,
                     double *dfdt, double *w);
    /* factorises W = c M - J with static pivots; NULL: the runtime does, by the tables above.
     * growth: by how much pivots are smaller than what they were made of; beyond 1e5 solutions are
     * checked. Nonzero: a pivot vanished. */
    int (*factor)(const double *m, const double *jac, double c, double *lu, double *growth);
    /* b := W^-1 b, in the model's own order of states. */
    void (*solve)(const double *lu, double *b, double *w);
    void (*outputs)(const double *h, double t, const double *x, const double *u, double *y,
                    double *w);
    void (*commands)(const double *h, double t, const double *x, const double *u, double *c,
                     double *w);
    /* stored energy in J, supplied and dissipated power in W. */
    void (*energy)(const double *h, double t, const double *x, const double *u, double out[3],
                   double *w);
    /* states that are set after each completed step (a quaternion's length); NULL if none. */
    void (*project)(const double *h, double t, double *x, double *w);
    /* the arguments of the switches; NULL if there are none. */
    void (*switches)(const double *h, double t, const double *x, const double *u, double *z,
                     double *w);
    /* a[k] a number that is not 0: assertion k holds. */
    void (*asserts)(const double *h, double t, const double *x, const double *u, double *a,
                    double *w);
} bgc_model;

/* The emitted model. */
const bgc_model *bgc_get_model(void);

typedef struct bgc_data bgc_data;

/* --- an instance ------------------------------------------------------------------------ */

bgc_data *bgc_new(const bgc_model *m);  /* NULL when there is no memory; parameters at default */
void bgc_free(const bgc_model *m, bgc_data *d);

/* Sets one parameter, or with k < 0 puts all back to their defaults. Takes effect at
 * bgc_reset. */
bgc_status bgc_set_param(const bgc_model *m, bgc_data *d, int k, double value);
double bgc_get_param(const bgc_model *m, const bgc_data *d, int k);
/* Recomputes what depends on parameters, checks them, puts x to its initial values at time t, and
 * states without a derivative on their equations. Reads the devices that are open. */
bgc_status bgc_reset(const bgc_model *m, bgc_data *d, double t);
/* The run starts anew at the present time, from the state as the caller has written it; states
 * without a derivative are put on their equations. Parameters, modes and devices are left alone. */
bgc_status bgc_restart(const bgc_model *m, bgc_data *d);

int bgc_failed_parameter(const bgc_data *d); /* index into param, or n_param + check index */
int bgc_failed_assertion(const bgc_data *d);
int bgc_failed_state(const bgc_data *d);     /* the state at fault, or -1 */
int bgc_failed_switch(const bgc_data *d);
const char *bgc_status_text(bgc_status s);

/* The present: the end of the last step, which may lie beyond the last row (see bgc_run). */
double bgc_time(const bgc_data *d);
double *bgc_state(bgc_data *d);              /* x, n_state; may be written between steps */
const double *bgc_scale(const bgc_data *d);  /* sizes that absolute tolerances are parts of */
double *bgc_input(bgc_data *d);              /* u, n_input; what no device writes is the caller's */
/* Everything but the devices: a restored run continues with the same bits. Another model's state
 * is refused. */
size_t bgc_save_size(const bgc_model *m);
bgc_status bgc_save(const bgc_model *m, const bgc_data *d, void *memory);
bgc_status bgc_restore(const bgc_model *m, bgc_data *d, const void *memory);

/* --- evaluation at the instance's time and state ------------------------------------------ */

bgc_status bgc_rhs(const bgc_model *m, bgc_data *d, double *f);
bgc_status bgc_jacobian(const bgc_model *m, bgc_data *d, double *jac, double *dfdt);
/* Stored entries of M, n_mass of them; none for the identity. */
bgc_status bgc_mass(const bgc_model *m, bgc_data *d, double *mass);
bgc_status bgc_outputs(const bgc_model *m, bgc_data *d, double *y);
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
} bgc_method_info;

/* Properties of method k; BGC_BAD_ARGUMENT past the last. The first method with error control and
 * the first with fixed steps are the defaults. */
bgc_status bgc_get_method(int k, bgc_method_info *info);

typedef struct {
    const char *name;  /* a method's; NULL: the default, with fixed steps where a step is given */
    double rtol;       /* 0: 1e-6 */
    double atol;       /* > 0: one for all states; 0: rtol times each state's scale, and less
                       * where no state comes near its own */
    double step;       /* fixed step, or first step of an adaptive method; 0: chosen */
    double max_step;   /* 0: none */
    long max_steps;    /* between two rows; 0: 10 million */
    int keep;          /* fixed-step methods keep the factorisation over this many steps; 0: 1 */
    int accounts;      /* integrate the energy accounts, under error control: 1, or not: 0 */
} bgc_options;

typedef struct {
    long steps, rejected, rhs, jacobians, factorisations, solves, refinements, fallbacks;
    long samples;       /* of devices */
    long events;        /* times at which a switch changed its mode */
    double last_step, worst_step_seconds, run_seconds;
    double worst_sample_seconds; /* spent on the steps between two samples; 0: none were taken */
    double exchanged; /* J: the largest account, stored energy itself, or what tolerances take for
                       * small; 0 without accounts */
    /* Of fixed steps too long for their equations: the most that the stages of one correct, as a
     * part of the range of a state, when, and of which; 0 where none is. */
    double coarsest, coarsest_at;
    long coarsest_state;
    double liveliest; /* the largest that any state has been over its scale, at most 1, which it is
                       * under a fixed step: the part of scales that step control counts in */
} bgc_counts;

/* Also counts steps and samples anew from the present time; rows inside the last step are lost. */
bgc_status bgc_set_options(const bgc_model *m, bgc_data *d, const bgc_options *o);

/* Integrates and writes one row a time in times[0..n): y then, with accounts, the four energies.
 * times[0] may equal the present time. Rows inside a step come from its dense output, so the last
 * step may end beyond the last row; the next call goes on from there, and rows in several calls
 * have the bits of rows in one. Steps of a model with devices or inputs end at samples.
 * `done` counts finished rows, also after a failure; the instance then stands at its last good
 * state, and its devices without force. A step ends where a switch leaves its mode; rows before
 * that time are in the old mode, one at that time is in the new. */
bgc_status bgc_run(const bgc_model *m, bgc_data *d, const double *times, size_t n, double *rows,
                   size_t *done);
void bgc_stop(bgc_data *d);                   /* async-signal-safe: bgc_run returns soon */
const bgc_counts *bgc_get_counts(const bgc_data *d);

/* --- devices ------------------------------------------------------------------------------ */

typedef struct {
    double position[3], orientation[4], velocity[3], angular_velocity[3], gripper[1], buttons[8];
} bgc_pose;

typedef struct {
    double force[3], torque[3], gripper_force[1];
} bgc_effort;

/* A driver: open takes "key=value" lines and returns a handle, or fills message (size bytes).
 * read and write return 0, or nonzero on a fault. Times are simulation time in seconds. */
typedef struct {
    const char *name;
    void *(*open)(const char *options, char *message, size_t size);
    int (*read)(void *handle, double t, bgc_pose *pose);
    int (*write)(void *handle, double t, const bgc_effort *effort);
    void (*close)(void *handle);
} bgc_driver;

extern const bgc_driver bgc_trace_driver;
const bgc_driver *bgc_find_driver(const char *name);  /* NULL: unknown */

/* Opens device k of the model with the given driver (NULL: the scene's) and options (NULL: the
 * scene's); on a fault `message` says why. Device inputs are read at every multiple of the sample
 * period, held over it, and commands are written there. The period is m->step, or 1 ms without one;
 * a fixed step that is no whole part of m->step is a period of its own. */
bgc_status bgc_open_device(const bgc_model *m, bgc_data *d, int k, const bgc_driver *driver,
                           const char *options, char *message, size_t size);
void bgc_close_devices(const bgc_model *m, bgc_data *d);  /* zero force first */

#ifdef __cplusplus
}
#endif
#endif
