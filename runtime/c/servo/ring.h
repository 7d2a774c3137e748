/* ring.h: a ring of records with one writer and one reader; neither waits for the other. */
#ifndef BGC_RING_H
#define BGC_RING_H

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double *memory;
    size_t width, room;
    atomic_size_t written, taken; /* records since the start */
} bgc_ring;

/* Whether there is memory for it; every page is touched. */
static inline int bgc_make_ring(bgc_ring *r, size_t width, size_t room) {
    r->width = width;
    r->room = room;
    r->memory = malloc(width * room * sizeof *r->memory);
    if (r->memory != NULL) {
        memset(r->memory, 0, width * room * sizeof *r->memory);
    }
    return r->memory != NULL;
}

/* The writer's next record, which bgc_publish hands over; NULL: there is no room. */
static inline double *bgc_next_record(bgc_ring *r) {
    const size_t written = atomic_load_explicit(&r->written, memory_order_relaxed);

    if (written - atomic_load_explicit(&r->taken, memory_order_acquire) >= r->room) {
        return NULL;
    }
    return r->memory + written % r->room * r->width;
}

static inline void bgc_publish(bgc_ring *r) {
    atomic_fetch_add_explicit(&r->written, 1, memory_order_release);
}

/* The reader: moves at most n records. */
static inline size_t bgc_take_records(bgc_ring *r, double *to, size_t n) {
    const size_t taken = atomic_load_explicit(&r->taken, memory_order_relaxed);
    const size_t ready = atomic_load_explicit(&r->written, memory_order_acquire) - taken;
    const size_t count = ready < n ? ready : n;

    for (size_t i = 0; i < count; i++) {
        memcpy(to + i * r->width, r->memory + (taken + i) % r->room * r->width,
               r->width * sizeof *to);
    }
    atomic_store_explicit(&r->taken, taken + count, memory_order_release);
    return count;
}

#endif
