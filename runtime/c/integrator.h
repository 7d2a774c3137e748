/* integrator.h: the functions of the integrator that are compiled twice, from one source: on
 * doubles for one instance, and with BGC_IN_LANES on lanes for a batch of instances that take their
 * steps together.
 *
 * In both, `number` is the type of numbers (number.h) and `bgc_ivp` that of the data: initial value
 * problems on their way, bgc_data or bgc_batch (lanes/batch.h), whose members have the same names.
 * The differences are the inline functions below: a condition on one instance is a status, on a
 * batch a set of lanes that go on by themselves.
 */
#ifndef BGC_INTEGRATOR_H
#define BGC_INTEGRATOR_H

#include "number.h"
#include "tolerance.h"

#include <string.h>

#ifdef BGC_IN_LANES

typedef bgc_batch bgc_ivp; /* lanes/batch.h, which comes first */
typedef bgc_lane_accounts bgc_accounts;

/* The names are those of the functions for one instance, so that they stay within the unit of a
 * batch. */
#define BGC_TWICE static

/* The functions of the model. */
static inline const bgc_lane_model *bgc_functions(const bgc_model *m, const bgc_ivp *d) {
    (void)m;
    return d->kernel;
}

static inline number bgc_reached(const bgc_ivp *d) { return d->scale_reached; }
static inline void bgc_raise_reached(const bgc_model *m, bgc_ivp *d) {
    d->scale_reached = bgc_scale_reached(m->n_state, d->x, d->scale, d->scale_reached);
}
static inline bgc_accounts *bgc_accounts_of(bgc_ivp *d) { return &d->account; }
static inline number *bgc_exchanged(bgc_ivp *d) { return &d->account.exchanged; }
static inline number *bgc_newest_radius(bgc_ivp *d) { return &d->newest; }

/* Whether a condition holds in any active lane; the largest number in these, or in those that take
 * the last step together. */
static inline int bgc_holds_in_any(const bgc_ivp *d, number_mask condition) {
    return bgc_lanes_where(d, condition) != 0;
}
double bgc_largest_in(unsigned lanes, lane v);
static inline double bgc_largest(const bgc_ivp *d, number v) {
    return bgc_largest_in(d->active, v);
}
static inline double bgc_largest_together(const bgc_ivp *d, number v) {
    return fmax(0.0, bgc_largest_in(d->active & ~d->single, v));
}
number_mask bgc_together(const bgc_ivp *d);
unsigned bgc_bad_lanes(const bgc_batch *b, int n, const lane *v);
static inline int bgc_is_finite(const bgc_ivp *d, int n, const number *v) {
    return bgc_bad_lanes(d, n, v) == 0;
}

/* The lanes that are active, as a set: those that leave a perturbed attempt come back. */
static inline unsigned bgc_active(const bgc_ivp *d) { return d->active; }
static inline void bgc_set_active(bgc_ivp *d, unsigned lanes) { d->active = lanes; }

/* Instances with algebraic equations or closed chains run alone. */
static inline bgc_status bgc_satisfy_rows(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    (void)m, (void)d, (void)t, (void)x;
    return BGC_OK;
}
static inline void bgc_close_inside(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    (void)m, (void)d, (void)t, (void)x;
}

/* One step of the method: bgc_family. */
BGC_TWICE bgc_status bgc_rosenbrock(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                    double h);
BGC_TWICE bgc_status bgc_runge_kutta(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                     double h);
static inline bgc_status bgc_advance_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                        double h) {
    return method->family->jacobian ? bgc_rosenbrock(m, d, method, h)
                                    : bgc_runge_kutta(m, d, method, h);
}
BGC_TWICE int bgc_interpolate_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method);
static inline int bgc_interpolate_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    return bgc_interpolate_stages(m, d, method);
}
static inline void bgc_integrate_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                    number power[2]) {
    (void)m, (void)d, (void)method, (void)power; /* collocation methods alone */
}
static inline void bgc_correct_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                  number *change) {
    (void)m, (void)d, (void)method, (void)change; /* collocation methods alone */
}

/* The ends of a step to d->next, for its dense output; d->next becomes the present. Pointers to the
 * arrays change places. */
static inline void bgc_keep_ends(const bgc_model *m, bgc_ivp *d) {
    (void)m;
    d->y0 = d->x;
    d->y1 = d->next;
    d->slopes = d->f;
}
/* f at the start to d->k, before d->f changes; f at the end to d->f. */
static inline void bgc_load_slopes(const bgc_model *m, bgc_ivp *d) {
    memcpy(d->k, d->slopes, (size_t)m->n_state * sizeof *d->k);
}
static inline void bgc_take_slopes(const bgc_model *m, bgc_ivp *d, number **from) {
    number *before = d->f;

    (void)m;
    d->f = *from;
    *from = before;
}
static inline void bgc_replace_present(const bgc_model *m, bgc_ivp *d) {
    number *before = d->x;

    (void)m;
    d->x = d->next;
    d->next = d->spare;
    d->spare = before;
}

BGC_TWICE bgc_status bgc_give_up(bgc_ivp *d);
void bgc_limit_next(bgc_ivp *d, double h);

/* State i has passed a multiple of its tolerance where `changed`, in a step to t. */
void bgc_follow_where(bgc_ivp *d, int i, number_mask changed, number limit, double t);

/* After an attempt from a perturbed state: in which lanes rounding dominates its error. */
static inline void bgc_enter_rounding(bgc_ivp *d, number_mask found, number noise) {
    d->core.counts.rounding_samples++;
    d->rounding += lane_select(found, lane_of(1.0), lane_of(0.0));
    d->largest_rounding =
        lane_select(found, number_larger(d->largest_rounding, noise), d->largest_rounding);
}

#else

#include "instance.h"

typedef bgc_data bgc_ivp;
typedef bgc_core bgc_accounts;

#define BGC_TWICE

static inline const bgc_model *bgc_functions(const bgc_model *m, const bgc_ivp *d) {
    (void)d;
    return m;
}

static inline number bgc_reached(const bgc_ivp *d) { return d->core.counts.scale_reached; }
static inline void bgc_raise_reached(const bgc_model *m, bgc_ivp *d) {
    double *reached = &d->core.counts.scale_reached;

    *reached = *reached < 1.0 ? bgc_scale_reached(m->n_state, d->x, d->scale, *reached) : *reached;
}
static inline bgc_accounts *bgc_accounts_of(bgc_ivp *d) { return &d->core; }
static inline number *bgc_exchanged(bgc_ivp *d) { return &d->core.counts.exchanged; }
static inline number *bgc_newest_radius(bgc_ivp *d) { return &d->core.spectrum.newest; }
static inline int bgc_holds_in_any(const bgc_ivp *d, number_mask condition) {
    (void)d;
    return condition;
}
static inline double bgc_largest(const bgc_ivp *d, number v) {
    (void)d;
    return v;
}
static inline double bgc_largest_together(const bgc_ivp *d, number v) {
    (void)d;
    return v;
}
static inline number_mask bgc_together(const bgc_ivp *d) {
    (void)d;
    return 1;
}
static inline int bgc_is_finite(const bgc_ivp *d, int n, const number *v) {
    (void)d;
    return bgc_first_bad(n, v) < 0;
}
static inline unsigned bgc_active(const bgc_ivp *d) {
    (void)d;
    return 1u;
}
static inline void bgc_set_active(bgc_ivp *d, unsigned lanes) { (void)d, (void)lanes; }
static inline bgc_status bgc_satisfy_rows(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    return bgc_satisfy(m, d, t, x);
}
/* Closes the chains of a state inside the last step. Where that fails, x is as accurate as the
 * step. */
static inline void bgc_close_inside(const bgc_model *m, bgc_ivp *d, double t, number *x) {
    const size_t size = (size_t)m->n_state * sizeof *x;

    memcpy(d->magnitude, x, size);
    if (bgc_close_chains(m, d, t, x) != BGC_OK) {
        memcpy(x, d->magnitude, size);
    }
}
static inline bgc_status bgc_advance_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                        double h) {
    return method->family->advance(m, d, method, h);
}
static inline int bgc_interpolate_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    return method->family->interpolate != NULL && method->family->interpolate(m, d, method);
}
static inline void bgc_integrate_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                    number power[2]) {
    method->family->quadrature(m, d, method, power);
}
static inline void bgc_correct_by(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                  number *change) {
    method->family->correction(m, d, method, change);
}
static inline void bgc_keep_ends(const bgc_model *m, bgc_ivp *d) {
    memcpy(d->y0, d->x, (size_t)m->n_state * sizeof *d->x);
    memcpy(d->y1, d->next, (size_t)m->n_state * sizeof *d->x);
    memcpy(d->k, d->f, (size_t)m->n_state * sizeof *d->x);
}
static inline void bgc_load_slopes(const bgc_model *m, bgc_ivp *d) {
    (void)m, (void)d;
}
static inline void bgc_take_slopes(const bgc_model *m, bgc_ivp *d, number **from) {
    memcpy(d->f, *from, (size_t)m->n_state * sizeof *d->f);
}
static inline void bgc_replace_present(const bgc_model *m, bgc_ivp *d) {
    memcpy(d->x, d->next, (size_t)m->n_state * sizeof *d->x);
}
static inline void bgc_follow_where(bgc_ivp *d, int i, number_mask changed, number limit,
                                    double t) {
    (void)changed;
    bgc_follow_subtolerance_state(d, i, d->next[i], limit, t);
}
static inline bgc_status bgc_give_up(const bgc_ivp *d) { return d->core.reason; }
static inline void bgc_limit_next(bgc_ivp *d, double h) { (void)d, (void)h; }
static inline void bgc_enter_rounding(bgc_ivp *d, number_mask found, number noise) {
    bgc_counts *counts = &d->core.counts;

    counts->rounding_samples++;
    if (found) {
        counts->rounding++;
        counts->largest_rounding = number_larger(counts->largest_rounding, noise);
    }
}

#endif

/* Energies of one step, J. */
typedef struct {
    number supplied, dissipated; /* integrals of the powers */
    number moved;  /* the larger of the integrals of their absolute values */
    number error;  /* the larger error of the two integrals */
    number stored; /* at the end of the step, absolute */
} bgc_balance;

/* --- vectors.c */
BGC_TWICE void bgc_combine(int n, int count, const double *weight, const number *vectors,
                           const number *base, number *out);
BGC_TWICE number bgc_norm_within(const bgc_model *m, const bgc_ivp *d, const number *v,
                                 const number *a, const number *b, double rtol, double atol,
                                 number reached);
BGC_TWICE number bgc_norm(const bgc_model *m, const bgc_ivp *d, const number *v, const number *a,
                          const number *b);
BGC_TWICE void bgc_multiply_mass(const bgc_model *m, const bgc_ivp *d, const number *v,
                                 number *out);

/* --- backward_error.c */
BGC_TWICE number bgc_backward_error(const bgc_model *m, bgc_ivp *d, const number *b,
                                    const number *x);

/* --- linear.c, lanes/lane_stages.c */
BGC_TWICE bgc_status bgc_factorise(const bgc_model *m, bgc_ivp *d, double c);
BGC_TWICE bgc_status bgc_solve(const bgc_model *m, bgc_ivp *d, number *b);

/* --- evaluate.c */
BGC_TWICE void bgc_evaluate_f(const bgc_model *m, bgc_ivp *d);
BGC_TWICE void bgc_evaluate_jacobian(const bgc_model *m, bgc_ivp *d);

/* --- rosenbrock.c, explicit.c, stages.c: functions of the families */
BGC_TWICE bgc_status bgc_rosenbrock(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                    double h);
BGC_TWICE bgc_status bgc_runge_kutta(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                     double h);
BGC_TWICE void bgc_sum_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method);
BGC_TWICE number bgc_embedded_error(const bgc_model *m, bgc_ivp *d, const bgc_method *method);
BGC_TWICE int bgc_interpolate_stages(const bgc_model *m, bgc_ivp *d, const bgc_method *method);

/* --- dense.c */
BGC_TWICE void bgc_store_dense(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                               double end);
BGC_TWICE void bgc_interpolate(const bgc_model *m, bgc_ivp *d, double t, number *x);
BGC_TWICE void bgc_interpolate_all(const bgc_model *m, bgc_ivp *d, double t, number *x);
BGC_TWICE void bgc_interpolate_some(const bgc_model *m, bgc_ivp *d, double t, int count,
                                    const int *state, number *x);
BGC_TWICE void bgc_dense_slope(const bgc_model *m, const bgc_ivp *d, number *slope);

/* --- dense_error.c */
BGC_TWICE number bgc_dense_error(const bgc_model *m, bgc_ivp *d, const bgc_method *method);

/* --- accounts.c */
BGC_TWICE void bgc_integrate_energy(const bgc_model *m, bgc_ivp *d, double t, number power[2]);
BGC_TWICE void bgc_balance_step(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double t,
                                bgc_balance *balance);
BGC_TWICE double bgc_drift_error(bgc_ivp *d, const bgc_balance *balance, double q, double error);
BGC_TWICE void bgc_enter_balance(bgc_ivp *d, const bgc_balance *balance);

/* --- acceptance.c */
BGC_TWICE void bgc_accept(const bgc_model *m, bgc_ivp *d, const bgc_balance *balance, double t_new);

/* --- rows.c */
BGC_TWICE void bgc_evaluate_row(const bgc_model *m, bgc_ivp *d, double t, int inside, number *row);

/* --- attempt.c */
BGC_TWICE bgc_status bgc_attempt_adaptive(const bgc_model *m, bgc_ivp *d, const bgc_method *method);

/* --- attempt_parts.c, lanes/lane_attempt.c: parts of an attempt. Those that return 0 have rejected
 * it. */
BGC_TWICE bgc_status bgc_begin_attempt(const bgc_model *m, bgc_ivp *d);
BGC_TWICE double bgc_wanted_step(const bgc_model *m, bgc_ivp *d, const bgc_method *method);
BGC_TWICE double bgc_shorten(const bgc_model *m, bgc_ivp *d, double h, double *t_new);
BGC_TWICE int bgc_advances(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h);
BGC_TWICE int bgc_rejects(const bgc_model *m, bgc_ivp *d, const bgc_method *method, number errors,
                          const number *vector, double h, double *error);
BGC_TWICE int bgc_completes(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h,
                            double *t_new);
BGC_TWICE int bgc_passes(const bgc_model *m, bgc_ivp *d, double t_new, bgc_status *status);
BGC_TWICE bgc_status bgc_finish_step(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                     const bgc_balance *balance, double t_new);

/* --- rounding.c */
BGC_TWICE int bgc_samples_rounding(const bgc_model *m, const bgc_ivp *d, const bgc_method *method);
BGC_TWICE int bgc_try_perturbed(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double h);
BGC_TWICE void bgc_judge_rounding(const bgc_model *m, bgc_ivp *d, number error);

/* --- corrections.c: a correction relative to the range of a state. An oscillation at 0.9 radians a
 * step reaches this; steps that resolve their motion stay below 0.1, most of them far below. */
static const double bgc_unresolved_part = 0.15;
BGC_TWICE void bgc_record_correction(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                                     double t);

/* --- followed_states.c */
BGC_TWICE void bgc_follow_subtolerance(const bgc_model *m, bgc_ivp *d, double t);

/* --- spectrum.c */
BGC_TWICE bgc_estimate bgc_continue_estimate(const bgc_model *m, bgc_ivp *d, double enough);

/* --- switching.c */
BGC_TWICE const bgc_method *bgc_present_method(const bgc_core *core);
BGC_TWICE void bgc_reset_choice(const bgc_model *m, bgc_ivp *d);
BGC_TWICE void bgc_change_method(bgc_ivp *d, double t, double cost, int is_trial);
BGC_TWICE void bgc_choose_method(const bgc_model *m, bgc_ivp *d, double t, double h);
BGC_TWICE void bgc_count_rejection(bgc_ivp *d);

/* --- switching_fixed.c */
BGC_TWICE void bgc_choose_fixed_method(const bgc_model *m, bgc_ivp *d);
BGC_TWICE int bgc_return_from_partner(bgc_ivp *d);
BGC_TWICE int bgc_rejects_explicit_step(const bgc_model *m, bgc_ivp *d);

#endif
