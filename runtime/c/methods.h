/* methods.h: integration methods as data: coefficients, families, and the table in tableaus.c. */
#ifndef BGC_METHODS_H
#define BGC_METHODS_H

#include "bgc.h"

#include <string.h>

enum { BGC_MAX_STAGES = 8, BGC_MAX_IMPLICIT = 3, BGC_MAX_DENSE = 3 };

/* A Rosenbrock method in the variables U = h Gamma k, which need no product with J:
 *   (M / (h gamma) - J) U_i = f(t + alpha_i h, y + sum a_ij U_j) + M sum c_ij U_j / h + g_i h df/dt
 * or, with gamma = 0, an explicit Runge-Kutta method:
 *   M U_i = h f(t + alpha_i h, y + sum a_ij U_j).
 * Then
 *   y1 = y + sum m_i U_i,  error = sum e_i U_i
 * (in a method without an error estimate, the change made by its last stages: see corrections.c)
 * and with dense > 0, for s in [0, 1],
 *   y(s) = (1 - s) y + s (y1 + (1 - s) (k_1 + s (k_2 + s k_3))),  k_l = sum h_li U_i.  */
typedef struct {
    int stages;
    int w_order; /* the order that remains with any matrix in the place of J */
    int dense;   /* rows of h; 0: dense output is the cubic Hermite polynomial of dense.c */
    double gamma;
    double a[BGC_MAX_STAGES][BGC_MAX_STAGES], c[BGC_MAX_STAGES][BGC_MAX_STAGES];
    double m[BGC_MAX_STAGES], alpha[BGC_MAX_STAGES], g[BGC_MAX_STAGES], e[BGC_MAX_STAGES];
    double embedded[BGC_MAX_STAGES]; /* error weights by which fixed steps are subdivided */
    double h[BGC_MAX_DENSE][BGC_MAX_STAGES];
} bgc_tableau;

/* Whether the last stage of an explicit method is at the end of the step, where nothing moves the state
 * afterwards: f there is that at the start of the next step. */
static inline int bgc_ends_at_last_stage(const bgc_model *m, const bgc_tableau *tableau) {
    const int last = tableau->stages - 1;

    return tableau->gamma == 0.0 && tableau->alpha[last] == 1.0 && m->n_switch == 0 &&
           m->project == NULL && m->closure_info == NULL &&
           memcmp(tableau->a[last], tableau->m, sizeof tableau->m) == 0;
}

/* A collocation method, M Z_i = h sum A_ij f(t + c_j h, y + Z_j). A^-1 has the left and right
 * eigenvectors given, to a real eigenvalue (where stages is odd) and to a complex one and its
 * conjugate (where there is more than one stage); left times right is 1. Then
 *   y1 = y + sum last_i Z_i,
 *   error = (lambda / h M - J)^-1 (f(t, y) + M sum e_i Z_i / h)
 * (in a method without an error estimate, the term in parentheses alone: see corrections.c). */
typedef struct {
    int stages;
    double node[BGC_MAX_IMPLICIT], weight[BGC_MAX_IMPLICIT]; /* of the quadrature over a step */
    double last[BGC_MAX_IMPLICIT], e[BGC_MAX_IMPLICIT];
    double lambda, left[BGC_MAX_IMPLICIT], right[BGC_MAX_IMPLICIT];
    double lambda2[2], left2[2][BGC_MAX_IMPLICIT], right2[2][BGC_MAX_IMPLICIT]; /* re, im */
} bgc_collocation;

typedef struct bgc_method bgc_method;

/* How well a completed step satisfies the algebraic equations, the empty rows of M. */
typedef enum {
    BGC_ROWS_LEFT,   /* not at all: the states without a rate are solved for afterwards */
    BGC_ROWS_NEARLY, /* to a part of the error of the step, which is measured */
    BGC_ROWS_SOLVED  /* to the tolerance of the stages' iteration */
} bgc_rows;

/* A family of methods: everything that a step does differently for it. Functions that are NULL are
 * left out. The table of families is in tableaus.c. */
typedef struct {
    const char *name;
    int jacobian; /* steps solve systems with W = c M - J; 0: M has to be diagonal */
    int lanes;    /* the integrator of batches has the same step (integrator.h) */
    bgc_rows rows;

    /* One step of length h from d->x at d->core.t, with f there in d->f, to d->next; the error
     * estimate, where the method has one, to d->error. */
    bgc_status (*advance)(const bgc_model *m, bgc_data *d, const bgc_method *method, double h);

    /* After the step: the coefficients k_l of the dense output to d->k. Returns 0 where the method
     * has no dense output of its own. */
    int (*interpolate)(const bgc_model *m, bgc_data *d, const bgc_method *method);

    /* After a fixed step: by how much its last stages change the result, to `change`. */
    void (*correction)(const bgc_model *m, bgc_data *d, const bgc_method *method, double *change);

    /* After the step: the integrals of the supplied and the dissipated power over it, by the
     * quadrature of the method itself. */
    void (*quadrature)(const bgc_model *m, bgc_data *d, const bgc_method *method, double power[2]);
} bgc_family;

struct bgc_method {
    const char *name;
    const bgc_family *family;
    const bgc_tableau *tableau;         /* the coefficients: one of these two */
    const bgc_collocation *collocation;
    int order;
    int error_order; /* of the embedded solution that estimates its error; 0: fixed steps only */
    int embedded_order; /* of that of tableau->embedded; 0: fixed steps are never subdivided */
    int substeps;       /* most parts of a fixed step where the options give none; 0: 1 */
    const char *partner; /* the explicit method that takes over where nothing is stiff (switching.c,
                          * switching_fixed.c) */
    int check_dense; /* the error estimate ignores stiff components, which L-stability damps by the
                      * end of the step: the dense output within it is checked as well */
    const char *purpose;
};

extern const bgc_method bgc_methods[];
extern const int bgc_method_count;

static inline int bgc_is_adaptive(const bgc_method *method) { return method->error_order > 0; }

#endif
