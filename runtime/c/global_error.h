/* global_error.h: what the files of the error estimate share: a step that has been taken, and vectors. */
#ifndef BGC_GLOBAL_ERROR_H
#define BGC_GLOBAL_ERROR_H

#include "bgc_internal.h"

#include <math.h>

enum { INSIDE_NODES = 3 }; /* Lobatto's points within a step */

/* A step from d->x to d->next, before that becomes the present, with f at its ends. */
typedef struct {
    double t, h;
    const bgc_method *method;
    int implicit;
    const double *f_start, *f_end;
} bgc_error_step;

/* Scratch vector k of twelve. */
static inline double *bgc_error_vector(const bgc_model *m, const bgc_data *d, int k) {
    return d->off_work + (size_t)k * bgc_padded(m->n_state);
}

/* The errors of the dense output at inner node k, beside those of the ends. */
static inline double *bgc_error_inside(const bgc_model *m, const bgc_data *d, int k) {
    return d->off_inside + (size_t)k * bgc_padded(m->n_state);
}

/* The rate of state i where f is `f`. */
static inline double bgc_rate_of_state(const bgc_data *d, const double *f, int i) {
    return d->inverse_mass[i] * f[i];
}

/* A factor by which a difference along an error v from y is not lost in rounding: the error itself, as far as it is
 * small against y, since then it sees where f bends within it, as a clutch does that holds. */
static inline double bgc_error_shift(const bgc_model *m, const bgc_data *d, const double *y, const double *v) {
    const double large = 1e-2, linear = 1e-4, lost = 1e-8;
    double part = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        part = fmax(part, d->core.rtol * fabs(v[i]) / bgc_tolerance(d, i, fabs(y[i])));
    }
    return part > large ? linear / part : part > 0.0 && part < lost ? lost / part : 1.0;
}

/* --- local_error.c */
void bgc_apply_mass_to_error(const bgc_model *m, bgc_data *d, double *v);
void bgc_solve_for_error(const bgc_model *m, bgc_data *d, double *v);
void bgc_forget_local_error(bgc_core *core);
int bgc_local_error(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double *local, double *missed);
double bgc_inside_part(double s, int k);

/* --- error_events.c */
void bgc_look_at_switches(const bgc_model *m, bgc_data *d, double t, const double *f);

#endif
