/* bgc_internal.h: the functions that files of the runtime share; no part of the interface. They work on the
 * instance of instance.h; those of integrator.h on a batch of instances, too.
 *
 * The order of calls of a run:
 *
 *   bgc_run (run.c)                modes and inputs at the present, then for each row:
 *     advance_to                     until the present is at or beyond the time of the row:
 *       bgc_sample                     devices and inputs, where a sample is due, and
 *                                      bgc_take_sampled (sampled.c) at an instant of sampled parts
 *       bgc_attempt (step.c)           one attempt at a step, from d->x at d->core.t (attempt.c, with
 *                                      attempt_parts.c):
 *         bgc_evaluate_f                 d->f (evaluate.c)
 *         bgc_first_step                 its length, at the start (first_step.c, control.h)
 *         bgc_limit_for_time             cut before a motion of time alone (timed.c)
 *         bgc_stop_for_switch            cut at an event that depends on time alone (events.c); no look
 *                                        where time_events.c has found that there is none
 *         family->advance                stages, d->next and d->error: rosenbrock.c, explicit.c or
 *                                        collocation.c, with linear.c, sparse.c and blocks.c;
 *                                        the sums of stages are in stages.c
 *         bgc_norm                       error over the tolerances (vectors.c, tolerance.h)
 *         bgc_close_chains               closed chains at the end (closures.c)
 *         bgc_keep_consistent            algebraic equations at the end (consistent_steps.c)
 *         bgc_store_dense                dense output (dense.c, interpolation.h)
 *         bgc_find_event                 the first change of a mode within the step (events.c,
 *                                        event_location.c, switch_margins.c)
 *         bgc_check_asserts              (instance.h)
 *         bgc_check_divisors             (divisors.c)
 *         bgc_follow_subtolerance        states below their tolerance (subtolerance.c)
 *         bgc_before_hidden              a pulse of a function of states within the step (watch.c)
 *         bgc_balance_step               energies of the step and their error (accounts.c)
 *         bgc_choose_method              implicit, or explicit where nothing is stiff (switching.c)
 *         bgc_finish_step                    d->next becomes the present; bgc_handle_event, bgc_jump
 *           bgc_follow_error               how far the run is off at the end, where that is asked for
 *                                          (global_error.c)
 *     write_row                        outputs and accounts, by dense output inside the step
 *
 * A rejected attempt leaves the present as it was and sets a shorter length. A fixed step is taken
 * whatever its error is, and bgc_record_correction (corrections.c) watches its length; or, with a
 * budget, it is subdivided where its error is too large (substeps.c).
 * lanes/ has what is different for instances that take their steps together.
 */
#ifndef BGC_INTERNAL_H
#define BGC_INTERNAL_H

#include "instance.h"

/* --- instance.c */
bgc_status bgc_check_parameters(const bgc_model *m, bgc_data *d);
void bgc_prepare_states(const bgc_model *m, bgc_data *d);

/* --- layout.c */
size_t bgc_place_all(const bgc_model *m, bgc_data *d, double *from);
size_t bgc_saved_count(const bgc_model *m);

/* --- linear.c */
bgc_pivoting bgc_choose_checks(long count, double growth, int *watched);
bgc_status bgc_refactorise_dense(const bgc_model *m, bgc_data *d);
bgc_status bgc_refactorise_dense_complex(const bgc_model *m, bgc_data *d);
bgc_status bgc_factorise_complex(const bgc_model *m, bgc_data *d, bgc_complex c);
bgc_status bgc_solve_complex(const bgc_model *m, bgc_data *d, bgc_complex *b);

/* --- backward_error.c */
double bgc_backward_error_complex(const bgc_model *m, bgc_data *d, const bgc_complex *b,
                                  const bgc_complex *x);

/* --- matrices.c */
int bgc_make_room(double **matrix, size_t *room, size_t n);
int bgc_make_room_complex(bgc_complex **matrix, size_t *room, size_t n);
int bgc_factorise_dense(int n, double *a, int *pivot, double *weight);
int bgc_factorise_dense_complex(int n, bgc_complex *a, int *pivot, double *weight);
void bgc_solve_dense(int n, const double *lu, const int *pivot, double *b);
void bgc_solve_dense_complex(int n, const bgc_complex *lu, const int *pivot, bgc_complex *b);
int bgc_rounded_pivot(int n, const double *lu);
int bgc_reserve_dense(const bgc_model *m, bgc_data *d);
bgc_status bgc_reserve_complex(const bgc_model *m, bgc_data *d, const bgc_method *method);

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
int bgc_sparse_factor_complex(const bgc_model *m, const double *mass, const double *jac,
                              bgc_complex c, bgc_complex *lu, double *growth, double *scratch);
void bgc_sparse_solve_complex(const bgc_model *m, const bgc_complex *lu, bgc_complex *b,
                              double *scratch);

/* --- inner.c */
void bgc_differentiate(const bgc_model *m, bgc_data *d, double t, const double *x, double *jac,
                       double *dfdt);
const double *bgc_slopes(const bgc_model *m, bgc_data *d);
void bgc_scale_inner(const bgc_model *m, bgc_data *d);

/* --- blocks.c */
int bgc_block_factor(const bgc_model *m, const double *scale, const double *mass,
                     const double *jac, double c, double *lu, double *growth, double *scratch);
void bgc_block_solve(const bgc_model *m, const double *lu, double *b, double *scratch);
int bgc_block_factor_complex(const bgc_model *m, const double *scale, const double *mass,
                             const double *jac, bgc_complex c, bgc_complex *factors,
                             double *growth, double *scratch);
void bgc_block_solve_complex(const bgc_model *m, const bgc_complex *factors, bgc_complex *b,
                             double *scratch);

/* --- collocation.c: functions of the family */
bgc_status bgc_collocate(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);
int bgc_interpolate_radau(const bgc_model *m, bgc_data *d, const bgc_method *method);
void bgc_correction_of_slope(const bgc_model *m, bgc_data *d, const bgc_method *method,
                             double *change);
void bgc_collocation_quadrature(const bgc_model *m, bgc_data *d, const bgc_method *method,
                                double power[2]);

/* --- run.c */

/* The end of fixed step k. */
static inline double bgc_tick(const bgc_core *core, int64_t k) {
    return core->origin + (double)k * core->step_parts / core->step_whole;
}

/* The next sample of the devices, or the next instant of a sampled part if that is first. */
static inline void bgc_schedule(bgc_core *core) {
    const double sample = core->origin + (double)core->sample * core->period;

    core->due = core->period > 0.0 && sample < core->instant ? sample : core->instant;
}

bgc_status bgc_sample(const bgc_model *m, bgc_data *d);
bgc_status bgc_apply_inputs(const bgc_model *m, bgc_data *d);
bgc_status bgc_write_row(const bgc_model *m, bgc_data *d, double t, double *row);

/* --- attempt_parts.c */
bgc_status bgc_complete(const bgc_model *m, bgc_data *d, const bgc_method *method, double *t_new);
bgc_status bgc_advance_held(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);

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

/* --- checks.c */
void bgc_reset_corrections(const bgc_model *m, bgc_data *d);
void bgc_report_correction(const bgc_model *m, bgc_data *d);
int bgc_first_bad(int n, const double *v);
int bgc_coupled_rate(const bgc_model *m, const bgc_data *d);

/* --- divisors.c */
void bgc_reset_divisors(const bgc_model *m, bgc_data *d);
bgc_status bgc_check_divisors(const bgc_model *m, bgc_data *d, double end);
bgc_status bgc_blame_divisor(const bgc_model *m, bgc_data *d, bgc_status status);

/* --- subtolerance.c */
void bgc_reset_subtolerance(const bgc_model *m, bgc_data *d);
void bgc_follow_subtolerance_state(bgc_data *d, int i, double value, double limit, double t);

/* --- first_step.c: from d->x with d->f valid; scratch, d->next among it, is overwritten */
double bgc_first_step(const bgc_model *m, bgc_data *d, int order);
double bgc_limit_first_step(const bgc_model *m, bgc_data *d, double h);
double bgc_first_step_alone(const bgc_model *m, bgc_data *d);
void bgc_settle_energy_scale(const bgc_model *m, bgc_data *d);

/* --- global_error.c */
void bgc_reset_errors(const bgc_model *m, bgc_data *d);
void bgc_follow_error(const bgc_model *m, bgc_data *d, const bgc_method *method, double t);
void bgc_carry_error_through(const bgc_model *m, bgc_data *d, const bgc_method *method);
void bgc_note_errors(const bgc_model *m, bgc_data *d, double t, const double *x, const double *u,
                     const double *e, const double *y);
void bgc_write_errors(const bgc_model *m, bgc_data *d, double t, int inside, const double *y, double *errors);

/* --- consistent.c */
void bgc_classify_states(const bgc_model *m, bgc_data *d);
bgc_status bgc_satisfy(const bgc_model *m, bgc_data *d, double t, double *x);
bgc_status bgc_satisfy_beside(const bgc_model *m, bgc_data *d, double t, double *x);
bgc_status bgc_make_consistent(const bgc_model *m, bgc_data *d);
bgc_status bgc_refresh_block(const bgc_model *m, bgc_data *d, double t, const double *x);

/* --- consistent_steps.c */
bgc_status bgc_keep_consistent(const bgc_model *m, bgc_data *d, const bgc_method *method, double t);
int bgc_leave_root(const bgc_model *m, bgc_data *d, double h);

/* --- start.c */
bgc_status bgc_solve_start(const bgc_model *m, bgc_data *d);
bgc_status bgc_check_given(const bgc_model *m, bgc_data *d);

/* --- closures.c */
size_t bgc_closing_size(const bgc_model *m);
bgc_status bgc_close_chains(const bgc_model *m, bgc_data *d, double t, double *x);

/* --- closed_start.c */
bgc_status bgc_close_start(const bgc_model *m, bgc_data *d);
bgc_status bgc_close_chains_at_start(const bgc_model *m, bgc_data *d);

/* --- chosen_rows.c */
void bgc_reset_chains(const bgc_model *m, bgc_data *d);
bgc_status bgc_choose_chain_rows(const bgc_model *m, bgc_data *d);

/* --- singular_chains.c */
bgc_status bgc_watch_chains(const bgc_model *m, bgc_data *d, double t, const double *x);
int bgc_chains_were_left(const bgc_model *m, const bgc_data *d, const double *x);
void bgc_enter_chains(const bgc_model *m, bgc_data *d);
bgc_status bgc_status_near_chains(const bgc_model *m, const bgc_data *d, bgc_status status);

/* --- switch_minima.c */
double bgc_parabola_minimum(const double t[3], const double inside[3], double *least);
double bgc_point_within(const double times[3], double at, const double *t);
void bgc_narrow(double times[3], double inside[3], double at, double depth);
int bgc_is_unresolved(const bgc_model *m, const bgc_data *d, int k, const double *const *z);
int bgc_is_beyond_tolerances(const bgc_model *m, bgc_data *d, int k, const double *const *z);

/* --- switch_margins.c */
void bgc_check_within(bgc_data *d);
int bgc_are_all_far(const bgc_model *m, bgc_data *d, const double *z, double h);
int bgc_mark_far(const bgc_model *m, bgc_data *d, const double *const *z);
void bgc_note_rest(bgc_data *d, int k, const double *const *z);

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

/* --- fmus.c: of other tools, at the instant t of a rate; at a reset; closed for good */
typedef struct bgc_fmu bgc_fmu;
bgc_status bgc_take_fmus(const bgc_model *m, bgc_data *d, int rate, double t);
void bgc_renew_fmus(const bgc_model *m, bgc_data *d);
void bgc_close_fmus(const bgc_model *m, bgc_data *d);

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

/* --- event_location.c */

/* Arguments are evaluated along the dense output of the step to d->next, or, those that depend on time
 * alone, with the present state. */
typedef enum { BGC_ALONG_STEP, BGC_TIME_ALONE } bgc_route;

void bgc_evaluate_timed(const bgc_model *m, bgc_data *d, double t, double *z);
void bgc_evaluate_arguments(const bgc_model *m, bgc_data *d, bgc_route way, double t, double *z);
double bgc_locate_first(const bgc_model *m, bgc_data *d, bgc_route way, double low, double high,
                        const double *z_low, double *z_high);

/* --- time_events.c */

/* What the switches of time alone do in a step: all stay within their modes, one leaves its mode, or ranges
 * cannot tell. */
typedef enum { BGC_STAYS, BGC_LEAVES, BGC_UNDECIDED } bgc_outlook;

bgc_outlook bgc_find_time_event(const bgc_model *m, bgc_data *d, double from, double to, double *inside,
                           double *outside);
void bgc_forget_quiet(bgc_data *d);

/* --- ranges.c */
void bgc_reset_time_windows(const bgc_model *m, bgc_data *d);

/* --- timed.c */
void bgc_reset_terms(const bgc_model *m, bgc_data *d);
double bgc_limit_for_time(const bgc_model *m, bgc_data *d, double t, double h);
void bgc_judge_terms(const bgc_model *m, bgc_data *d, double h);

/* --- watch.c */
double bgc_hidden_peak(int kind, const double *z);
double bgc_before_hidden(const bgc_model *m, bgc_data *d, double end);

/* --- devices.c */
bgc_status bgc_read_devices(const bgc_model *m, bgc_data *d);
bgc_status bgc_write_devices(const bgc_model *m, bgc_data *d);
void bgc_zero_devices(const bgc_model *m, bgc_data *d);
void bgc_default_inputs(const bgc_model *m, double *u);

#include "integrator.h"

#endif
