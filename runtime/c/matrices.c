/* matrices.c: dense matrices, real and complex, and room for those of an instance. */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "matrices_kinds.h"

#define BGC_COMPLEX
#include "matrices_kinds.h"
#undef BGC_COMPLEX

/* The first pivot of the factors of bgc_factorise_dense that is at most the rounding errors of
 * the terms it is the sum of, or -1: the rows do not determine that state, whatever its sign. */
int bgc_rounded_pivot(int n, const double *lu) {
    const double noise = 2.0 * n * DBL_EPSILON;

    for (int k = 0; k < n; k++) {
        const double pivot = fabs(lu[(size_t)k * (size_t)n + (size_t)k]);
        double terms = pivot;
        for (int j = 0; j < k; j++) {
            terms += fabs(lu[(size_t)k * (size_t)n + (size_t)j] * lu[(size_t)j * (size_t)n + (size_t)k]);
        }
        if (pivot <= noise * terms) {
            return k;
        }
    }
    return -1;
}

/* Reserves the matrices where the model is small, or where its jumps need them; returns 0 where the
 * memory does not suffice. */
int bgc_reserve_dense(const bgc_model *m, bgc_data *d) {
    const size_t n = (size_t)m->n_state;
    const int few = n <= BGC_RESERVED_STATES;

    return bgc_make_room(&d->dense_lu, &d->dense_room, few || m->n_jump > 0 ? n : 0) &&
           bgc_make_room(&d->block_lu, &d->block_room, few ? n : 0);
}

/* Reserves memory for complex factors, where the method has complex stages; of a large model for their
 * pivots alone. */
bgc_status bgc_reserve_complex(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const size_t n = (size_t)bgc_unknowns(m);

    if (method->collocation == NULL || method->collocation->stages < 2) {
        return BGC_OK;
    }
    if (d->pivot_complex == NULL) {
        d->pivot_complex = calloc(n + 1, sizeof *d->pivot_complex);
    }
    if (d->pivot_complex == NULL ||
        (n <= BGC_RESERVED_STATES &&
         !bgc_make_room_complex(&d->dense_lu_complex, &d->dense_room_complex, n))) {
        return BGC_NO_MEMORY;
    }
    return BGC_OK;
}
