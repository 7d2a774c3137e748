/* matrices.c: room for the dense factors of an instance. */
#include "bgc_internal.h"

#include <stdlib.h>

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
    const int few = n <= BGC_RESERVED_STATES;

    return bgc_make_room(&d->dense_lu, &d->dense_room, few || m->n_jump > 0 ? n : 0) &&
           bgc_make_room(&d->block_lu, &d->block_room, few ? n : 0);
}
