/* closures.h: the kernel of closed chains, as the files share it that project states, close the start
 * and watch for singular positions. */
#ifndef BGC_CLOSURES_H
#define BGC_CLOSURES_H

#include "bgc_internal.h"

/* Parts of d->closing: results of the kernel, then scratch. */
typedef struct {
    double *flow, *condition, *by_impulse, *response, *by_place, *by_start;
    double *matrix, *other, *mixed, *table, *change;
} bgc_chain_parts;

/* Sets the parts to their places from `from` on, and returns the number of doubles. */
size_t bgc_place_chain_parts(const bgc_closure_info *c, double *from, bgc_chain_parts *p);

/* Evaluates the kernel at (t, x); returns whether its results are finite. */
int bgc_evaluate_chains(const bgc_model *m, bgc_data *d, double t, const double *x,
                        bgc_chain_parts *p);

/* S of rows first to last, at positions of which `left` is dw/dx, and `right` the response. */
void bgc_chain_response(const bgc_closure_info *c, const double *left, const double *right,
                        int first, int last, double *s);

/* The least change of `width` unknowns that satisfies the linearised conditions, with derivatives
 * `slopes` by these, in p->change; the normal equations are damped. Returns 0 where there is none. */
int bgc_least_chain_change(const bgc_model *m, bgc_data *d, const double *slopes, int width,
                           double damping, bgc_chain_parts *p);

/* The largest condition among the first n. */
double bgc_chain_gap(const bgc_chain_parts *p, int n, int *worst);

#endif
