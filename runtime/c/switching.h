/* switching.h: what the choice between a method and its explicit partner needs of an instance, or of a
 * batch whose instances take their steps together: switching.c, switching_fixed.c.
 */
#ifndef BGC_SWITCHING_H
#define BGC_SWITCHING_H

#include "instance.h"
#include "number.h"

typedef struct {
    const bgc_core *option; /* tolerances, the fixed step or the longest one */
    double explicit_cost;   /* as in bgc_model */
    bgc_choice *choice;
    bgc_counts *counts;
    bgc_spectrum *spectrum;
    double *h_next, *error_old;
    int *held;

    /* Of the last step of the partner, its length times the dominant eigenvalue. Of a batch, the largest. */
    double (*find_product)(void *run);
    /* A product of an estimate of the spectral radius, to know whether it exceeds `enough`. Of a batch, the
     * largest. */
    bgc_estimate (*continue_estimate)(void *run, double enough);
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

/* Step times the dominant eigenvalue, from the two stages in the middle of a step of rk4, which are U_2
 * at x + U_1 / 2 and U_3 at x + U_2 / 2. */
static inline number bgc_product_of_middle(int n, const number *scale, const number *first,
                                           const number *second, const number *third) {
    const number none = number_of(0.0);
    number change = none, distance = none;

    for (int i = 0; i < n; i++) {
        const number unit = 1.0 / scale[i];
        const number rise = (third[i] - second[i]) * unit, apart = (second[i] - first[i]) * unit;
        change += rise * rise;
        distance += apart * apart;
    }
    return number_select(distance > none, 2.0 * number_sqrt(change / distance), none);
}

/* One instance, as `run` of a chooser. */
typedef struct {
    const bgc_model *m;
    bgc_data *d;
} bgc_single;

/* --- switching.c */
bgc_chooser bgc_chooser_of(bgc_single *single);
void bgc_choose(const bgc_chooser *of, double t, double h);
void bgc_enter_rejection(const bgc_chooser *of, double t, int rejected);

/* --- switching_fixed.c */
int bgc_return_to_implicit(const bgc_chooser *of, double t);
int bgc_rejects_product(const bgc_chooser *of, double t);
void bgc_choose_fixed(const bgc_chooser *of, double t);

#endif
