/* fmi.h: an instance of a model behind the Functional Mock-up Interface, for both of its versions.
 *
 * fmi2.c and fmi3.c hold the functions of the standard, which translate to those of this header; what they
 * have in common stands in fmi_functions.h. A
 * quantity has a place in one list of numbers, which is its value reference:
 *
 *   0                   time
 *   1 ..                parameters, as in bgc_model.param
 *   then                inputs of the importer, outputs, commands, the four energy accounts
 *   then                states, their rates, supplied and dissipated power, event indicators
 *
 * The energy accounts are integrals. In Co-Simulation the solver of the model integrates them, in Model
 * Exchange `supplied` and `dissipated` are two more continuous states.
 *
 * In Co-Simulation a solver step may end beyond the communication point; values there come from its dense
 * output, so results do not depend on the communication steps. Where an input changes, the step is taken
 * back and ends at the change (co_simulation.c). In Model Exchange the modes of all switches are held
 * between events (model_exchange.c).
 */
#ifndef BGC_FMI_H
#define BGC_FMI_H

#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#if defined _WIN32 || defined __CYGWIN__
#define BGC_EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define BGC_EXPORT __attribute__((visibility("default")))
#else
#define BGC_EXPORT
#endif

/* The part of an FMU that belongs to one model: emitted with it. */
typedef struct {
    const char *token; /* of the model description: guid or instantiationToken */
    bgc_options options;
    int n_input;               /* inputs of the importer: the first ones of the model */
    const double *input_start;
    const double *start;       /* n_state, then held values: a start at rest; NULL: the model's own */
    const unsigned char *tunable; /* n_param */
    int n_continuous;          /* continuous states of Model Exchange, accounts included */
    int n_free;                /* those that are states of the model */
    const int *free_state;     /* their numbers; the other states follow from algebraic equations */
    int derivatives;           /* 1: directional derivatives exist */
    const int *count;          /* of each reference: the numbers of an array that begins there */

    /* Entries of the derivatives of f, outputs, commands and energies (rows) by states and inputs
     * (columns), which partials() fills; those of df/dx are not among them. */
    int n_partial;
    const int *partial_row, *partial_col;
    void (*partials)(const double *h, double t, const double *x, const double *u, double *j, double *w);
} bgc_fmi_info;

const bgc_fmi_info *bgc_fmi_get_info(void);

typedef enum { BGC_FMI_OK, BGC_FMI_WARNING, BGC_FMI_DISCARD, BGC_FMI_ERROR } bgc_fmi_status;

typedef enum {
    BGC_FMI_INSTANTIATED,
    BGC_FMI_INITIALISING,
    BGC_FMI_EVENTS,     /* Model Exchange, and Co-Simulation of 3.0 in event mode */
    BGC_FMI_CONTINUOUS, /* Model Exchange */
    BGC_FMI_STEPS,      /* Co-Simulation */
    BGC_FMI_TERMINATED
} bgc_fmi_phase;

typedef enum { BGC_FMI_MODEL_EXCHANGE, BGC_FMI_CO_SIMULATION } bgc_fmi_kind;

typedef struct bgc_fmi bgc_fmi;

/* What the importer offers: a logger, with a category of the standard, and the update of 3.0 after each
 * internal step, which returns nonzero where the importer wants to return at *stop. */
typedef struct {
    void (*log)(bgc_fmi *i, bgc_fmi_status status, const char *category, const char *message);
    int (*stepped)(bgc_fmi *i, double t, double *stop);
} bgc_fmi_hooks;

/* The part of an instance without pointers, which is saved as it is. */
typedef struct {
    bgc_fmi_phase phase;
    double t;            /* of the importer: communication point, or time of its integrator */
    double start_time;
    int started;         /* the start has been computed for the present parameters */
    int satisfied;       /* Model Exchange: algebraic equations hold at the present */
    int viewed;          /* view_x and view_u belong to t */
    int has_row;         /* row belongs to them */
    int has_snapshot;    /* snapshot is the instance before the last step */
    double rtol;         /* of the importer; 0: that of the scene */
    double last_step;    /* of the importer's integrator */
} bgc_fmi_core;

struct bgc_fmi {
    const bgc_model *m;
    const bgc_fmi_info *info;
    bgc_data *d;
    bgc_fmi_kind kind;
    bgc_fmi_hooks hooks;
    char *name;
    void *environment;
    void (*logger)(void); /* the importer's, cast back by its version */
    void (*update)(void);
    int may_return_early, event_mode, logs;
    bgc_fmi_core core;

    double *view_x, *view_u; /* state and inputs with modes at core.t */
    double *inputs;          /* scratch of the size of view_u */
    double *given;           /* n_input: as the importer has set them */
    double *row;             /* outputs and accounts at core.t */
    double *command, *rate, *indicator, *partial;
    double *seed, *result;   /* of directional derivatives: n_state + n_input, and rows */
    double *matrix;          /* dense, n_state by n_state */
    int *pivot;
    unsigned char *snapshot;
    int n_partial;           /* places of i->partial: df/dx, then those of partials() */
    int *partial_row, *partial_col;
};

/* --- instance.c of this folder */
bgc_fmi *bgc_fmi_new(bgc_fmi_kind kind, const char *name, const char *token, int logs,
                     const bgc_fmi_hooks *hooks, void *environment, void (*logger)(void));
void bgc_fmi_free(bgc_fmi *i);
bgc_fmi_status bgc_fmi_set_logging(bgc_fmi *i, int logs);
bgc_fmi_status bgc_fmi_enter(bgc_fmi *i, bgc_fmi_phase phase);
bgc_fmi_status bgc_fmi_enter_initialisation(bgc_fmi *i, double rtol, double start);
bgc_fmi_status bgc_fmi_exit_initialisation(bgc_fmi *i);
bgc_fmi_status bgc_fmi_reset(bgc_fmi *i);
bgc_fmi_status bgc_fmi_report(bgc_fmi *i, bgc_fmi_status as, const char *text);
bgc_fmi_status bgc_fmi_refuse(bgc_fmi *i, const char *text);
bgc_fmi_status bgc_fmi_refuse_variables(bgc_fmi *i, size_t n, const char *name, const char *type);
bgc_fmi_status bgc_fmi_explain(bgc_fmi *i, bgc_fmi_status as, bgc_status status);
bgc_fmi_status bgc_fmi_start(bgc_fmi *i);
size_t bgc_fmi_state_size(const bgc_fmi *i);
bgc_fmi_status bgc_fmi_get_state(bgc_fmi *i, void **state);
bgc_fmi_status bgc_fmi_free_state(bgc_fmi *i, void **state);
bgc_fmi_status bgc_fmi_copy_state(bgc_fmi *i, const void *state, void *bytes, size_t size);
bgc_fmi_status bgc_fmi_take_state(bgc_fmi *i, const void *bytes, size_t size, void **state);
bgc_fmi_status bgc_fmi_restore(bgc_fmi *i, const void *memory);

/* --- present.c */
static const double bgc_fmi_allowed_drift = 0.1; /* of constraints, over the tolerances */
static inline int bgc_fmi_is_free(const bgc_fmi *i, int k) { return i->d->algebraic[k] == 0.0; }
bgc_fmi_status bgc_fmi_solve_matrix(bgc_fmi *i, double *right);
bgc_fmi_status bgc_fmi_solve_algebraic(bgc_fmi *i, double *right, int transposed);
bgc_fmi_status bgc_fmi_satisfy(bgc_fmi *i);
bgc_fmi_status bgc_fmi_view(bgc_fmi *i);
bgc_fmi_status bgc_fmi_rates(bgc_fmi *i, double *rate);
bgc_fmi_status bgc_fmi_indicators(bgc_fmi *i, double *z);

/* --- variables.c */
bgc_fmi_status bgc_fmi_get(bgc_fmi *i, const unsigned *ref, size_t n, double *value, size_t n_value);
bgc_fmi_status bgc_fmi_set(bgc_fmi *i, const unsigned *ref, size_t n, const double *value,
                           size_t n_value);
int bgc_fmi_place(const bgc_fmi *i, int group);
int bgc_fmi_references(const bgc_fmi *i);

/* Groups of references, in their order. */
enum {
    BGC_FMI_PARAMETERS, BGC_FMI_INPUTS, BGC_FMI_OUTPUTS, BGC_FMI_COMMANDS, BGC_FMI_ACCOUNTS,
    BGC_FMI_STATES, BGC_FMI_RATES, BGC_FMI_POWERS, BGC_FMI_INDICATORS, BGC_FMI_END
};

/* --- derivatives.c */
bgc_fmi_status bgc_fmi_directional(bgc_fmi *i, const unsigned *unknown, size_t n_unknown,
                                   const unsigned *known, size_t n_known, const double *seed,
                                   size_t n_seed, double *result, size_t n_result);
bgc_fmi_status bgc_fmi_adjoint(bgc_fmi *i, const unsigned *unknown, size_t n_unknown,
                               const unsigned *known, size_t n_known, const double *seed, size_t n_seed,
                               double *result, size_t n_result);

/* --- tuning.c: parameters that have changed during a run take effect */
bgc_fmi_status bgc_fmi_tune(bgc_fmi *i);

/* --- co_simulation.c: to t + step, or to *reached where the importer wants to return early */
bgc_fmi_status bgc_fmi_step(bgc_fmi *i, double t, double step, double *reached);
bgc_status bgc_fmi_return_to_point(bgc_fmi *i);

/* --- model_exchange.c */
bgc_fmi_status bgc_fmi_set_time(bgc_fmi *i, double t);
bgc_fmi_status bgc_fmi_set_states(bgc_fmi *i, const double *x, size_t n);
bgc_fmi_status bgc_fmi_get_states(bgc_fmi *i, double *x, size_t n);
bgc_fmi_status bgc_fmi_get_rates(bgc_fmi *i, double *rate, size_t n);
bgc_fmi_status bgc_fmi_get_nominals(bgc_fmi *i, double *nominal, size_t n);
bgc_fmi_status bgc_fmi_get_indicators(bgc_fmi *i, double *z, size_t n);
bgc_fmi_status bgc_fmi_completed_step(bgc_fmi *i, int *wants_event);
bgc_fmi_status bgc_fmi_handle_events(bgc_fmi *i, int *states_changed, double *next);

#endif
