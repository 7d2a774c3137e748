/* sensitivities.h: the derivatives of a run, and what its files share. */
#ifndef BGC_SENSITIVITIES_H
#define BGC_SENSITIVITIES_H

#include "bgc_internal.h"
#include "bgc_tangents.h"

/* As many parameters as a register has lanes. */
typedef struct {
    lane *q, *mass;                    /* changes of h, behind them of what sampled parts hold; and of M */
    lane *now;                         /* derivatives of the states at the present, */
    lane *start, *end, *k;             /* and the dense output of the last step */
    int has_dense;                     /* k is complete */
    lane *products;                    /* of the change of the Jacobian with the stages */
    lane *delay;                       /* derivatives of the time of the last event */
} bgc_sensitivity_block;

struct bgc_sensitivities {
    const bgc_tangent_model *kernel;
    int count, blocks;
    bgc_sensitivity_block *block;
    void *allocated;

    /* Values of the run, the same in all lanes. */
    lane *h, *x, *u, *points;          /* points: of the stages */
    lane *x_jac, *u_jac;               /* where the Jacobian was evaluated, at t_jac */
    double t_jac;
    lane *pair_d, *pair_q, *pair_r;    /* of each group of pairs, and of one: tangent_jacobian.c */
    int pair_stages;                   /* stages of the pairs in pair_q; 0: none */
    long jacobians;                    /* of the run when the Jacobian was taken */

    /* Scratch. */
    lane *stages, *right, *change, *along, *no_change, *result, *speed, *work, *solve_work, *closing;
    double *p, *prepared, *prepare_work, *column, *rate, *rate_after, *before_flows;
    double *before_inputs, *inputs_before, *instants_before; /* at an instant of sampled parts */
    double *reset; /* the states as jumps give them */
    double *jump;  /* the jumps at the present: tangent_events.c */
    int jumps, jump_room;
    double *parameter;  /* changes of the parameters along each direction */
    double *multiplier; /* of the rows of closed chains, then the changes of momenta by these */
    int *pivot;
    double *dense_mass;

    double event_at; /* the last event that changed rates or states; -INFINITY: none */
    double *slopes;  /* where the next row goes */
};

/* A state, with its time and the inputs and modes there. */
typedef struct {
    double t;
    const double *x;
    double *u;
} bgc_moment;

static inline void bgc_spread(int n, const double *from, lane *to) {
    for (int i = 0; i < n; i++) {
        to[i] = lane_of(from[i]);
    }
}

/* --- sensitivities.c: what depends on parameters alone; the same where other rows of closed chains have been
 * chosen */
void bgc_prepare_sensitivities(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s);
void bgc_follow_chosen_rows(const bgc_model *m, bgc_data *d, bgc_sensitivities *s);

/* derivatives of f, to s->right, where the states have the derivatives v and time has
 * `delay` */
void bgc_slope_sensitivity(const bgc_model *m, bgc_sensitivities *s, const bgc_sensitivity_block *b,
                           const bgc_moment *at, const lane *v, lane delay);

/* --- tangent_consistent.c: derivatives v of the states of which algebraic equations determine some, `from`
 * the states from which these were solved for or NULL; projects v where states x are projected */
bgc_status bgc_satisfy_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                   bgc_sensitivity_block *b, const bgc_moment *at, const double *from,
                                   lane delay, lane *v);
void bgc_project_sensitivity(const bgc_model *m, bgc_sensitivities *s, const bgc_sensitivity_block *b,
                             double t, const double *x, lane *v);

/* --- tangent_chains.c: size of s->closing; projects derivatives v of the states onto closed chains, to which
 * states were projected, `from` those before; derivatives of the chains' rows with the states held */
size_t bgc_closing_tangents(const bgc_model *m);
bgc_status bgc_close_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 const bgc_sensitivity_block *b, const bgc_moment *at, const double *from,
                                 lane delay, lane *v);
void bgc_chain_slopes(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, int k, double *slope);

/* --- tangent_dense.c: derivatives at t inside the last step, where the states are x */
bgc_status bgc_interpolate_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                       bgc_sensitivity_block *b, double t, const double *x, lane *out);

/* --- tangent_events.c: the rates of the states, M rate = f; carries derivatives v before an event or change
 * of inputs, where the states are `ahead`, to b->now behind it, where their rates are s->rate_after; v has the
 * derivative of its time in the last element */
bgc_status bgc_find_rate(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, const bgc_moment *at,
                         double *rate);
bgc_status bgc_carry_sensitivity(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 bgc_sensitivity_block *b, const double *ahead, const bgc_moment *behind,
                                 lane *v);

/* --- tangent_jacobian.c: notes that the step has evaluated the Jacobian at t, its first point; J' U_i + slope_i (df/dt)' of all
 * stages to the products of the blocks */
void bgc_note_jacobian(const bgc_model *m, bgc_sensitivities *s, double t, int stages);
void bgc_multiply_change_of_jacobian(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s,
                                     int stages, const double *slope);

/* --- tangent_samples.c */
void bgc_held_slopes(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, int k, double *slope);

/* --- tangent_steps.c, tangent_events.c, tangent_samples.c: functions of a bgc_follower */
bgc_status bgc_differentiate_step(const bgc_model *m, bgc_data *d, void *of, const bgc_method *method,
                                  double t);
bgc_status bgc_differentiate_event(const bgc_model *m, bgc_data *d, void *of);
bgc_status bgc_note_jump(const bgc_model *m, bgc_data *d, void *of);
void bgc_keep_before_inputs(const bgc_model *m, bgc_data *d, void *of);
bgc_status bgc_differentiate_inputs(const bgc_model *m, bgc_data *d, void *of);

#endif
