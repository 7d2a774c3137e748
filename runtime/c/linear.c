/* linear.c: linear systems with W = c M - J: with a real c, and with a complex c of collocation methods,
 * for which no code is unrolled. */
#include "bgc_internal.h"
#include "solutions.h"

#include <math.h>
#include <string.h>

/* How solutions of factorisation number `count` with static pivots of this growth are checked;
 * *watched counts the factorisations whose solutions are all still to be checked. */
bgc_pivoting bgc_choose_checks(long count, double growth, int *watched) {
    if (growth > bgc_growth_limit) {
        *watched = BGC_WATCH_FOR;
    }
    if (*watched > 0) {
        (*watched)--;
        return BGC_WATCHED;
    }
    return count % BGC_CHECK_EVERY == 1 ? BGC_CHECKED_ONCE : BGC_STATIC;
}

/* Code that is unrolled for the model; these return 0 where there is none. */
static int factorise_unrolled(const bgc_model *m, bgc_data *d, double c, double *growth,
                              int *failed) {
    if (m->factor == NULL) {
        return 0;
    }
    *failed = m->factor(d->mass, d->jac, c, d->lu, growth);
    return 1;
}
static int factorise_unrolled_complex(const bgc_model *m, bgc_data *d, bgc_complex c,
                                      double *growth, int *failed) {
    (void)m, (void)d, (void)c, (void)growth, (void)failed;
    return 0;
}
static int solve_unrolled(const bgc_model *m, bgc_data *d, double *b) {
    if (m->solve == NULL) {
        return 0;
    }
    m->solve(d->lu, b, d->work);
    return 1;
}
static int solve_unrolled_complex(const bgc_model *m, bgc_data *d, bgc_complex *b) {
    (void)m, (void)d, (void)b;
    return 0;
}

/* The number of this factorisation, by which checks are spaced. */
static long count_factorisation(bgc_core *core) { return ++core->counts.factorisations; }
static long count_factorisation_complex(bgc_core *core) {
    core->counts.factorisations++;
    return ++core->factorisations_complex;
}

#include "linear_kinds.h"

#define BGC_COMPLEX
#include "linear_kinds.h"
#undef BGC_COMPLEX
