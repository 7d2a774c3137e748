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

/* S of the n rows in `row`, at positions of which `left` is dw/dx, and `right` the response. */
void bgc_chain_response(const bgc_closure_info *c, const double *left, const double *right,
                        int n, const int *row, double *s);

/* Lists the numbers from first to last whose flag is not 0; returns how many they are. */
int bgc_list_chosen(const double *flag, int first, int last, int *list);

/* Lists the chosen conditions in d->closing_list. */
int bgc_list_conditions(const bgc_model *m, bgc_data *d);

/* The least change of `width` unknowns that satisfies the n linearised conditions in d->closing_list, with
 * derivatives `slopes` of all by these, in p->change; the normal equations are damped. Returns 0 where there is
 * none. */
int bgc_least_chain_change(bgc_data *d, int n, const double *slopes, int width, double damping,
                           bgc_chain_parts *p);

/* The largest of the n conditions in `list`; all up to n if that is NULL. */
double bgc_chain_gap(const bgc_chain_parts *p, int n, const int *list, int *worst);

/* The first row of the chain after that of row `first`. */
int bgc_end_of_chain(const bgc_closure_info *c, int first);

/* Whether row k is chosen at first. */
int bgc_is_first_choice(const bgc_closure_info *c, int k);

/* S of all rows from first to last in p->matrix; notes the size of its diagonal. */
void bgc_whole_chain_response(const bgc_closure_info *c, bgc_data *d, int first, int last,
                              bgc_chain_parts *p);

/* From these: the rows to choose from here on, in d->next_chosen. Returns the least pivot of the best ones,
 * relative to the largest size of the diagonal so far. */
double bgc_next_chain_rows(const bgc_closure_info *c, bgc_data *d, int first, int last,
                           bgc_chain_parts *p);

/* The same of the conditions, where there is a choice. */
void bgc_next_conditions(const bgc_closure_info *c, bgc_data *d, bgc_chain_parts *p);

/* Chooses what d->next_chosen says, from the present on. */
void bgc_take_next_rows(const bgc_model *m, bgc_data *d);

#endif
