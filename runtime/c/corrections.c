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
    int both; /* the other weights count, too */
    double weight[2][MOST_TERMS];
    const number *stage[MOST_TERMS];
} correction_terms;

/* The terms: stages of a tableau, or one vector that the family fills. Those that are missing have
 * no weight. */
static correction_terms find_terms(const bgc_model *m, bgc_ivp *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    correction_terms of = {.both = 0};
    int count = 1;

    if (tableau == NULL) {
        bgc_correct_by(m, d, method, d->right);
        of.weight[0][0] = 1.0;
    } else {
        count = tableau->stages > 1 ? tableau->stages : 2;
        memcpy(of.weight[0], tableau->e, sizeof of.weight[0]);
        if (!method->family->jacobian) {
            of.both = 1;
            memcpy(of.weight[1], tableau->embedded, sizeof of.weight[1]);
        }
    }
    for (int j = 0; j < MOST_TERMS; j++) {
        const size_t at = j < count ? (size_t)j * bgc_chunked(m->n_state) : 0;
        of.stage[j] = tableau == NULL ? d->right : d->stages + at;
    }
    return of;
}

/* The correction of a state with these stages. */
static inline number correction_of(const correction_terms *of, int both, number u0, number u1,
                                   number u2, number u3) {
    const double *w = of->weight[0], *v = of->weight[1];
    const number one = (w[0] * u0 + w[1] * u1) + (w[2] * u2 + w[3] * u3);
    const number other = (v[0] * u0 + v[1] * u1) + (v[2] * u2 + v[3] * u3);

    return both ? number_larger(number_fabs(one), number_fabs(other)) : number_fabs(one);
}

/* Raises the ranges of states, and `excess` by how much their corrections are above the largest so
 * far. Inlined with a constant `both`. */
static inline void raise_ranges(const correction_terms *of, int both,
                                const number *restrict u0, const number *restrict u1,
                                const number *restrict u2, const number *restrict u3,
                                const number *restrict next, const number *restrict correction,
                                number *restrict range, number *restrict excess) {
    for (int l = 0; l < BGC_CHUNK; l++) {
        const number now = number_fabs(next[l]), most = range[l];
        const number above = correction_of(of, both, u0[l], u1[l], u2[l], u3[l]) - correction[l];
        range[l] = number_select(now > most, now, most);
        excess[l] += number_select(above > number_of(0.0), above, number_of(0.0));
    }
}

/* Keeps the largest correction of each state, and its time. */
static void keep_largest(const bgc_model *m, bgc_ivp *d, const correction_terms *of,
                         number_mask together, double t) {
    const number *const *u = of->stage;

    for (int i = 0; i < m->n_state; i++) {
        const number size = correction_of(of, of->both, u[0][i], u[1][i], u[2][i], u[3][i]);
        const number largest = d->correction[i];
        const number_mask larger = (size > largest) & together;
        d->corrected_at[i] = number_select(larger, number_of(t), d->corrected_at[i]);
        d->correction[i] = number_select(larger, size, largest);
    }
}

/* After a fixed step from t to d->next, before that becomes the present. A method of one stage is
 * compared with the step before. */
void bgc_record_correction(const bgc_model *m, bgc_ivp *d, const bgc_method *method, double t) {
    const int compares = method->tableau != NULL && method->tableau->stages == 1;
    const correction_terms of = find_terms(m, d, method);
    const number *const *u = of.stage;
    const number_mask together = bgc_together(d);
    number excess[BGC_CHUNK], all = number_of(0.0);

    if (compares && d->core.ticks == 0) {
        keep_stage(m, d);
    }
    memset(excess, 0, sizeof excess);
    for (size_t i = 0; i < bgc_chunked(m->n_state); i += BGC_CHUNK) {
        if (of.both) {
            raise_ranges(&of, 1, u[0] + i, u[1] + i, u[2] + i, u[3] + i, d->next + i,
                         d->correction + i, d->range + i, excess);
        } else {
            raise_ranges(&of, 0, u[0] + i, u[1] + i, u[2] + i, u[3] + i, d->next + i,
                         d->correction + i, d->range + i, excess);
        }
    }
    for (int l = 0; l < BGC_CHUNK; l++) {
        all += excess[l];
    }
    if (bgc_holds_in_any(d, all > number_of(0.0))) { /* not in most steps */
        keep_largest(m, d, &of, together, t);
    }
    if (compares) {
        keep_stage(m, d);
    }
}
