/* global_error.h: what the files of the error estimate share: a step that has been taken, and vectors. */
#ifndef BGC_GLOBAL_ERROR_H
#define BGC_GLOBAL_ERROR_H

#include "bgc_internal.h"

/* A step from d->x to d->next, before that becomes the present: Lobatto's four points in it, its start and its end
 * among them, with f there. The inner ones are set where the local error is measured. */
typedef struct {
    double t, h;
    const bgc_method *method;
    int implicit;
    double *inner[2];
    const double *f[4];
    double *f_inner[2];
} bgc_error_step;

/* Scratch vector k of ten. */
static inline double *bgc_error_vector(const bgc_model *m, const bgc_data *d, int k) {
    return d->off_work + (size_t)k * bgc_padded(m->n_state);
}

/* The rate of state i where f is `f`. */
static inline double bgc_rate_of_state(const bgc_data *d, const double *f, int i) {
    return d->inverse_mass[i] * f[i];
}

/* --- local_error.c */
void bgc_apply_mass_to_error(const bgc_model *m, bgc_data *d, double *v);
void bgc_solve_for_error(const bgc_model *m, bgc_data *d, double *v);
void bgc_forget_local_error(bgc_core *core);
int bgc_local_error(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double *local);
double bgc_inside_correction(double s, double first, double second);

#endif
