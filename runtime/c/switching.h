/* switching.h: what the choice between a method and its explicit partner needs of an instance, or of a
 * batch whose instances take their steps together: switching.c.
 */
#ifndef BGC_SWITCHING_H
#define BGC_SWITCHING_H

#include "instance.h"

typedef struct {
    const bgc_core *option; /* tolerances, and the longest steps */
    double explicit_cost;   /* as in bgc_model */
    bgc_choice *choice;
    bgc_counts *counts;
    bgc_spectrum *spectrum;
    double *h_next, *error_old;

    /* Of the last step of the partner, its length times the dominant eigenvalue. Of a batch, the largest. */
    double (*find_product)(void *run);
    /* A new estimate of the spectral radius, to know whether it exceeds `enough`. Of a batch, the largest. */
    double (*estimate)(void *run, double enough);
    void *run; /* the argument of both */
} bgc_chooser;

/* The method that takes the next step; `usual` is the place of the implicit one in bgc_methods. */
static inline const bgc_method *bgc_chosen(const bgc_choice *choice, int usual) {
    return &bgc_methods[choice->is_explicit ? choice->partner : usual];
}

/* The weights of the stages whose sum is the distance between the points of the last two, which are at the
 * same time. The last stages themselves differ by the step times M^-1 (f - f'). */
static inline void bgc_weigh_distance(const bgc_tableau *tableau, double *weight) {
    const int last = tableau->stages - 1;

    for (int j = 0; j < last; j++) {
        weight[j] = tableau->a[last][j] - tableau->a[last - 1][j];
    }
}

void bgc_choose(const bgc_chooser *of, double t, double h);
void bgc_enter_rejection(const bgc_chooser *of, double t, int rejected);

#endif
