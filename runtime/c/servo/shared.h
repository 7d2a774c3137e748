/* shared.h: what the loop and the process of a driver share: a mapped file that both write without a lock.
 *
 * Each side has a slot that it alone writes, under a sequence number that is odd meanwhile; the other one reads
 * again where the number has changed. The driver's process waits for an effort: actively for a short time, then
 * asleep, and only then does the loop wake it.
 */
#ifndef BGC_SHARED_H
#define BGC_SHARED_H

#include "bgc_device.h"

#include <stdatomic.h>
#include <string.h>

enum { BGC_POSE_WORDS = sizeof(bgc_pose) / sizeof(double), BGC_EFFORT_WORDS = 7 };

/* States of the process, in which it goes forward alone. */
enum {
    BGC_STARTING = 0,
    BGC_OPEN,    /* the driver is open, and `can` is known */
    BGC_REFUSED, /* it could not be opened: `message` */
    BGC_FAULTY,  /* a call reported a fault: `message` */
    BGC_DEAD,    /* a signal ended a call, or the process: `message` */
    BGC_CLOSED   /* zero force, and closed */
};

typedef struct {
    atomic_uint sequence; /* odd while it is written */
    _Atomic double word[BGC_POSE_WORDS];
} bgc_mailbox;

typedef struct {
    /* Set before the processes begin. */
    int64_t period, silence; /* ns: between samples; without an effort, until the force is zero */
    int64_t ahead;           /* ns: of the pose before its sample */
    int realtime;            /* 1: SCHED_FIFO and locked memory are asked for */

    /* Of the loop. */
    bgc_mailbox effort;   /* 7 words of the effort, then the time of the model */
    atomic_int end;       /* 1: the process is to close its device */
    _Atomic int64_t due;  /* ns: of the next sample */
    _Atomic double time;  /* s: of the model at that sample */

    /* Of the driver's process. */
    bgc_mailbox pose;
    atomic_int state, pid;
    atomic_int answer;          /* of the last write */
    atomic_int in_write;        /* the present call is one of write, not of read */
    _Atomic int64_t call_since; /* ns: begin of the present call; 0: none */
    atomic_uint written;        /* sequence of the last effort that the driver took; */
    atomic_uint asleep;         /* 1: waits for an effort asleep */
    atomic_int is_zero;         /* the last write that the driver took was zero */
    bgc_capabilities can;
    char message[256];

    /* Of the process in reserve. */
    atomic_int spare; /* 1: zero was written by a new process, 2: it could not be, 3: was not needed */
} bgc_shared;

static inline void bgc_put(bgc_mailbox *box, const double *words, int n) {
    atomic_fetch_add_explicit(&box->sequence, 1, memory_order_relaxed);
    atomic_thread_fence(memory_order_release);
    for (int k = 0; k < n; k++) {
        atomic_store_explicit(&box->word[k], words[k], memory_order_relaxed);
    }
    atomic_fetch_add_explicit(&box->sequence, 1, memory_order_release);
}

/* Takes what is in a box; returns its sequence, or `before` where there is nothing new or the writer is in the
 * midst of it. */
static inline unsigned bgc_get(bgc_mailbox *box, unsigned before, double *words, int n) {
    for (int attempt = 0; attempt < 8; attempt++) {
        const unsigned sequence = atomic_load_explicit(&box->sequence, memory_order_acquire);
        if (sequence == before) {
            return before;
        }
        for (int k = 0; k < n; k++) {
            words[k] = atomic_load_explicit(&box->word[k], memory_order_relaxed);
        }
        atomic_thread_fence(memory_order_acquire);
        if (sequence % 2 == 0 &&
            atomic_load_explicit(&box->sequence, memory_order_relaxed) == sequence) {
            return sequence;
        }
    }
    return before;
}

#endif
