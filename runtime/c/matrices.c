/* matrices.c: room for the dense factors of an instance. */
#include "bgc_internal.h"

#include <stdlib.h>

/* States of a model up to which the room for dense factors is reserved with the instance, so that a
 * servo loop allocates nothing. Of a larger model it is reserved with the first need: 3 GB at 20,000
 * states, where a dense factorisation takes hours. */
enum { RESERVED_STATES = 1000 };

/* Makes room for n by n numbers in *matrix, which has room for *room by *room; returns 0 where the
 * memory does not suffice. */
int bgc_make_room(double **matrix, size_t *room, size_t n) {
    if (*matrix != NULL && n <= *room) {
        return 1;
    }
    free(*matrix);
    *matrix = calloc(n * n + 1, sizeof **matrix);
    *room = *matrix != NULL ? n : 0;
    return *matrix != NULL;
}

/* Reserves the matrices where the model is small, or where its jumps need them; returns 0 where the
 * memory does not suffice. */
int bgc_reserve_dense(const bgc_model *m, bgc_data *d) {
    const size_t n = (size_t)m->n_state;
    const int few = n <= RESERVED_STATES;

    return bgc_make_room(&d->dense_lu, &d->dense_room, few || m->n_jump > 0 ? n : 0) &&
           bgc_make_room(&d->block_lu, &d->block_room, few ? n : 0);
}
