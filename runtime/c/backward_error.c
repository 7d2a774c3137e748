/* backward_error.c: the check of solutions of real and of complex systems. */
#include "bgc_internal.h"
#include "solutions.h"

#include <math.h>

/* Turns the sizes in d->reach into those that count in the check of a solution. */
static void raise_to_least_part(const bgc_model *m, bgc_ivp *d) {
    number largest = number_of(0.0);

    for (int i = 0; i < m->n_state; i++) {
        const number part = d->reach[i] / d->scale[i];
        largest = number_larger(largest, part);
    }
    for (int i = 0; i < bgc_unknowns(m); i++) {
        d->reach[i] += bgc_least_part * largest * d->scale[i];
    }
}

#include "backward_error_kinds.h"

#ifndef BGC_IN_LANES
#define BGC_COMPLEX
#include "backward_error_kinds.h"
#undef BGC_COMPLEX
#endif
