/* servo_internal.h: an instance of the loop, shared by servo.c and threads.c. */
#ifndef BGC_SERVO_INTERNAL_H
#define BGC_SERVO_INTERNAL_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif

#include "histogram.h"
#include "limits.h"
#include "ring.h"
#include "servo.h"

typedef _Atomic double atomic_double;

/* Who may call the drivers. */
enum { BGC_NOBODY, BGC_LOOP, BGC_WATCHDOG };

/* A device: the real driver, and what went to it and came from it last. */
typedef struct {
    bgc_servo *servo;
    int k;
    const bgc_driver *driver; /* NULL: not open */
    void *handle;
    bgc_capabilities can;
    int is_read; /* the pose is one of the device */
    bgc_pose pose;
    bgc_effort wanted, given; /* of the model; written */
    double time;              /* s: of the last sample, as the model has it */
    int64_t news_at;          /* ns: when the device last gave something new */
} bgc_slot;

struct bgc_servo {
    bgc_servo_model model;
    bgc_servo_options options;
    bgc_servo_clock clock;
    bgc_slot *slot;
    double *row;
    int width;
    bgc_ring ring;

    /* Of the loop alone. */
    int sampling; /* in the model's bgc_run: its stand-ins are those of a sample */
    int first;    /* in the first sample */
    int blind;    /* in a sample that leaves the devices alone */
    bgc_servo_end cause;
    bgc_status status;
    int device;
    char message[256];
    double misses;
    int64_t last_work;

    /* Between threads. */
    atomic_int owner, ended, stop_wanted, stalled, in_driver, released, fifo, locked, threads;
    atomic_int_fast64_t beat; /* ns: begin of the last sample */
    atomic_int_fast64_t samples, missed, overruns, dropped, skipped, saturated, limited, no_news;
    atomic_double time, elapsed, behind, gain, worst_power, zero_after;
    bgc_histogram lateness, jitter, work;
};

extern const bgc_servo_clock bgc_system_clock;

#endif
