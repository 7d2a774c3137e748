/* bgc_tangents.h: derivatives of a run by parameters and initial values.
 *
 * The stages of each step are differentiated with the factors that the step has, so that a derivative
 * is that of the computed solution, at the steps of the run. A lane holds the derivative by one
 * parameter; more parameters than a register has lanes are followed in several blocks.
 */
#ifndef BGC_TANGENTS_H
#define BGC_TANGENTS_H

#include "bgc_lanes.h"

/* The tangents of the functions of bgc_model: each stores the changes of its results where the states
 * change by d[0..n_state), time by d[n_state], the unknowns of a start by what follows, and by q what
 * depends on parameters alone and, from n_hoist of the model on, what sampled parts hold. h has n_hoist elements, the first of them those of the model. */
typedef struct {
    int n_work, n_prepare_work, n_solve_work, n_hoist;
    int first_change; /* of parameters, behind these in the p of prepare */
    /* p: parameters, from first_change on their changes, then 1 for each that follows others in its
     * default. Appends elements to h, and the changes of the model's own. */
    void (*prepare)(const double *p, double *h, double *w);
    void (*rhs)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q,
                lane *f, lane *w);
    void (*outputs)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q,
                    lane *y, lane *w);
    void (*switches)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q,
                     lane *z, lane *w);
    void (*resets)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q,
                   lane *z, lane *w);
    /* Of the product of the Jacobian with r, whose element n_state is the factor of df/dt; a lane may hold any
     * pair of d with q and r. It reads what curvature_shared has left in w, which serves all d and q. */
    void (*curvature_shared)(const lane *h, lane t, const lane *x, const lane *u, const lane *r, lane *w);
    void (*curvature)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q,
                      const lane *r, lane *f, lane *w);
    void (*solve)(const double *lu, lane *b, lane *w); /* NULL: the factors are not those of code */
    void (*mass)(const lane *h, const lane *q, lane *m, lane *w);
    void (*project)(const lane *h, lane t, const lane *x, const lane *d, const lane *q, lane *z, lane *w);
    /* Of the first four parts of the results of closures(). */
    void (*closures)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q,
                     lane *c, lane *w);
    void (*sampling)(const lane *h, const lane *q, lane *s, lane *w);
    void (*held_start)(const lane *h, lane t, const lane *u, const lane *q, lane *z, lane *w);
    void (*held)(const lane *h, lane t, const lane *x, const lane *u, const lane *d, const lane *q, lane *z,
                 lane *w);
    void (*initial)(const lane *h, lane t, const lane *u, const lane *q, lane *x, lane *w);
    void (*start)(const lane *h, lane t, const lane *u, const lane *s, const lane *d, const lane *q,
                  lane *r, lane *w);
    void (*started)(const lane *h, lane t, const lane *u, const lane *s, const lane *d, const lane *q,
                    lane *x, lane *w);
} bgc_tangent_model;

const bgc_tangent_model *bgc_get_tangent_model(void);

typedef struct bgc_sensitivities bgc_sensitivities;

/* The k-th of the parameters that closed chains may take to close their start; -1 past the last. */
int bgc_closing_parameter(const bgc_model *m, int k);

/* Derivatives of a run along `count` directions of its parameters and its start. NULL without memory. */
bgc_sensitivities *bgc_new_sensitivities(const bgc_model *m, int count);
void bgc_free_sensitivities(bgc_sensitivities *s);

/* After a reset of the instance: the derivatives of its start. Direction k changes the parameters by
 * parameter[k n_param ..] and, beside what follows from these, the states by state[k n_state ..]. A
 * parameter that a direction changes does not follow others in its default. */
bgc_status bgc_start_sensitivities(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                   const double *parameter, const double *state);
/* Derivatives along direction k at the present, with the states held: of f, n_state numbers, then of the
 * bgc_chain_rows(m) rows of closed chains and of the values that sampled parts hold from the next instant on. */
void bgc_slope_by_parameters(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, int k, double *f);
/* The derivatives along direction k at the present, to x or from there: of the states, n_state numbers, then of
 * what sampled parts hold. */
void bgc_get_sensitivity(const bgc_model *m, const bgc_sensitivities *s, int k, double *x);
void bgc_set_sensitivity(const bgc_model *m, bgc_sensitivities *s, int k, const double *x);

/* bgc_run with the derivatives of the n_output outputs in each row along each direction, to `slopes`:
 * count n_output numbers a row. BGC_NOT_DIFFERENTIABLE where an event has no derivative:
 * bgc_failed_switch names it. */
bgc_status bgc_run_sensitivities(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                 const double *times, size_t n, double *rows, double *slopes,
                                 size_t *done);

#endif
