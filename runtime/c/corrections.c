/* corrections.c: detection of fixed steps that are far too long for their equations.
 *
 * The change that the last stages of a method make to the result of the earlier ones costs next to
 * nothing to compute. Where steps resolve the motion it is small relative to the range of a state.
 * It is large beyond a pole of the equations, through a stiff stop, and outside the stability
 * region of an explicit method.
 */
#include "bgc_internal.h"

#include <string.h>

/* A method of one stage is compared with the step before, whose stage is kept where a second stage
 * would be. */
static void keep_stage(const bgc_model *m, bgc_ivp *d) {
    memcpy(d->stages + bgc_chunked(m->n_state), d->stages, (size_t)m->n_state * sizeof *d->stages);
}

enum { MOST_TERMS = 4 }; /* stages of methods with fixed steps */

/* The correction of a state is a sum of stages with their weights; of an explicit method the larger
 * of two, the other one with the weights of sub-steps: the stability polynomial of each vanishes
 * somewhere beyond the stability limit, not both at one place. */
typedef struct {
    const double *weight, *other; /* other: NULL, or the second ones */
    const number *stage[MOST_TERMS];
    int short_sum; /* 1: the first two terms are all */
} correction_terms;

/* The terms: stages of a tableau, or one vector that the family fills. Those that are missing have
 * no weight. */
static void find_terms(const bgc_model *m, bgc_ivp *d, const bgc_method *method,
                       correction_terms *of) {
    static const double one[MOST_TERMS] = {1.0};
    const bgc_tableau *tableau = method->tableau;
    const size_t length = bgc_chunked(m->n_state);
    const number *first = d->stages;
    int count = 1;

    of->weight = one;
    of->other = NULL;
    if (tableau == NULL) {
        first = d->right;
        bgc_correct_by(m, d, method, d->right);
    } else {
        count = tableau->stages > 1 ? tableau->stages : 2;
        of->weight = tableau->e;
        of->other = method->family->jacobian ? NULL : tableau->embedded;
    }
    of->short_sum = count <= 2;
    for (int j = 0; j < MOST_TERMS; j++) {
        of->stage[j] = j < count ? first + (size_t)j * length : first;
    }
}

/* A sum of terms, of the first two where `two` is set. */
static inline number sum_of_terms(int two, const double *w, number u0, number u1, number u2,
                                  number u3) {
    const number sum = w[0] * u0 + w[1] * u1;

    return two ? sum : sum + (w[2] * u2 + w[3] * u3);
}

/* The correction of a state with these stages; `v` is NULL without other weights. */
static inline number correction_of(int two, const double *w, const double *v, number u0, number u1,
                                   number u2, number u3) {
    const number one = number_fabs(sum_of_terms(two, w, u0, u1, u2, u3));

    return v == NULL ? one
                     : number_larger(one, number_fabs(sum_of_terms(two, v, u0, u1, u2, u3)));
}

/* Raises the ranges of states, and `excess` by how much their corrections are above the largest so
 * far, and above what counts as resolved in the range of the state. Inlined, with constants `two`
 * and `v == NULL`. */
static inline void raise_ranges(int two, const double *restrict w, const double *restrict v,
                                const number *restrict u0, const number *restrict u1,
                                const number *restrict u2, const number *restrict u3,
                                const number *restrict next, const number *restrict correction,
                                number *restrict range, number *restrict excess) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        const number now = number_fabs(next[l]), most = range[l];
        const number known = number_larger(correction[l], bgc_unresolved_part * most);
        const number above = correction_of(two, w, v, u0[l], u1[l], u2[l], u3[l]) - known;
        range[l] = number_select(now > most, now, most);
        excess[l] += number_select(above > number_of(0.0), above, number_of(0.0));
    }
}

static inline void raise_all(const bgc_model *m, bgc_ivp *d, int two, const double *w,
                             const double *v, const number *const *u, number *excess) {
    const size_t length = bgc_chunked(m->n_state);

    for (size_t i = 0; i < length; i += BGC_CHUNK) {
        raise_ranges(two, w, v, u[0] + i, u[1] + i, u[2] + i, u[3] + i, d->next + i,
                     d->correction + i, d->range + i, excess);
    }
}

/* Keeps the largest correction of each state, and its time. */
static inline void keep_largest(number_mask together, double t, const double *restrict w,
                                const double *restrict v, const number *restrict u0,
                                const number *restrict u1, const number *restrict u2,
                                const number *restrict u3, number *restrict at,
                                number *restrict correction) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        const number size = correction_of(0, w, v, u0[l], u1[l], u2[l], u3[l]);
        const number largest = correction[l], before = at[l];
        const number_mask larger = (size > largest) & together;
        at[l] = number_select(larger, number_of(t), before);
        correction[l] = number_select(larger, size, largest);
    }
}

/* After a fixed step from t to d->next, before that becomes the present. A method of one stage is
 * compared with the step before. */
void bgc_record_correction(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double t) {
    const int compares = method->tableau != NULL && method->tableau->stages == 1;
    const size_t length = bgc_chunked(m->n_state);
    const number *const *u;
    double w[MOST_TERMS], v[MOST_TERMS]; /* copies, which the compiler knows to stay */
    number excess[BGC_CHUNK], all = number_of(0.0);
    correction_terms of;

    find_terms(m, d, method, &of);
    u = of.stage;
    memcpy(w, of.weight, sizeof w);
    memcpy(v, of.other != NULL ? of.other : w, sizeof v);
    if (compares && d->core.ticks == 0) {
        keep_stage(m, d);
    }
    for (int l = 0; l < BGC_CHUNK; l++) {
        excess[l] = number_of(0.0);
    }
    if (of.short_sum && of.other != NULL) {
        raise_all(m, d, 1, w, v, u, excess);
    } else if (of.short_sum) {
        raise_all(m, d, 1, w, NULL, u, excess);
    } else if (of.other != NULL) {
        raise_all(m, d, 0, w, v, u, excess);
    } else {
        raise_all(m, d, 0, w, NULL, u, excess);
    }
    for (int l = 0; l < BGC_CHUNK; l++) {
        all += excess[l];
    }
    if (bgc_holds_in_any(d, all > number_of(0.0))) { /* not in most steps */
        const number_mask together = bgc_together(d);
        for (size_t i = 0; i < length; i += BGC_CHUNK) {
            keep_largest(together, t, w, v, u[0] + i, u[1] + i, u[2] + i, u[3] + i,
                         d->corrected_at + i, d->correction + i);
        }
    }
    if (compares) {
        keep_stage(m, d);
    }
}
