/* servo_internal.h: an instance of the loop, shared by the files of this folder. They call each other in the
 * order clock.c, remote.c, ports.c, ends.c, loop.c, exchange.c, servo.c, threads.c, each only those before it. */
#ifndef BGC_SERVO_INTERNAL_H
#define BGC_SERVO_INTERNAL_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif

#include "histogram.h"
#include "limits.h"
#include "poses.h"
#include "ring.h"
#include "servo.h"

typedef _Atomic double atomic_double;

/* Who may call the drivers. */
enum { BGC_NOBODY, BGC_LOOP, BGC_WATCHDOG };

/* A device: the real driver, and what was written to it last. */
typedef struct {
    const bgc_driver *driver; /* NULL: not open */
    void *handle;
    bgc_capabilities can;
    bgc_effort given;
    double time;     /* s: of the last sample */
    int64_t news_at; /* ns: when the device last gave something new; INT64_MAX before the loop begins */
    int64_t pose_at; /* ns: when it gave the pose of the ledger */
    bgc_ledger ledger;
} bgc_port;

/* The stand-in of a device in a model. */
typedef struct {
    bgc_course *course;
    int port;
    int is_read; /* the pose is one of the device */
    int takes_back; /* the ledger of the device takes back */
    double time; /* s: of the last sample, as the model has it */
    bgc_pose pose;
    bgc_effort wanted; /* of the model */
} bgc_slot;

/* A model in the loop. Until it is posted it belongs to the thread that prepares it, then to the loop. */
struct bgc_course {
    bgc_servo *servo;
    bgc_servo_model model;
    double deadline; /* s */
    int policy;
    bgc_slot *slot; /* one for each port */
    double *row;
    int width;
    bgc_ring ring;
    double origin;   /* s: time of the model at its first sample */
    int64_t samples; /* taken */
    int sampling;    /* in the model's bgc_run: its stand-ins are those of a sample */
    atomic_int retired;
    bgc_course *_Atomic next; /* took its place */
    bgc_course *older;        /* in the list of all */
};

struct bgc_servo {
    bgc_servo_options options;
    bgc_servo_clock clock;
    bgc_port *port;
    int ports;

    /* Of the loop alone. */
    int skipping;       /* in a sample that neither reads nor writes the devices */
    int falls;          /* the force goes to zero, before a normal end or an exchange */
    int has_gain;       /* the gain of this sample is known */
    double most_gain;   /* before the end of the duration */
    bgc_servo_end cause;
    bgc_status status;
    int device;
    char message[256];
    double misses;
    int64_t last_work;

    /* Of callers. */
    bgc_course *courses; /* all, the latest first */
    bgc_course *reading; /* of the reader of records */

    /* Between threads. */
    bgc_course *_Atomic course;  /* in the loop */
    bgc_course *_Atomic pending; /* to take its place */
    atomic_int owner, ended, stop_wanted, stalled, in_driver, released, fifo, locked, threads;
    atomic_int_fast64_t beat; /* ns: begin of the last sample */
    atomic_int_fast64_t samples, missed, overruns, dropped, skipped, saturated, limited, no_news;
    atomic_int_fast64_t lost_records, exchanges, late_poses, refused;
    atomic_int late_device, unsettled;
    atomic_double time, elapsed, behind, gain, worst_power, zero_after, lag, excess;
    atomic_double fastest, given, created, taken, owed;
    bgc_histogram lateness, jitter, work;
};

extern const bgc_servo_clock bgc_system_clock;

/* remote.c: the driver of a device whose own driver runs in another process. */
void bgc_remote_announce(void *handle, int64_t due, double time); /* of the next sample: ns, s of the model */
/* That a call of the driver has not returned for so many ns; NULL: it has. */
const char *bgc_remote_hang(void *handle, int64_t since);
int bgc_remote_settle(void *handle); /* waits for the zero that was written; 1: the device has it */

static inline int64_t bgc_servo_ns(double seconds) { return (int64_t)(1e9 * seconds + 0.5); }

static inline int64_t bgc_servo_now(const bgc_servo *s) { return s->clock.now(s->clock.of); }

static inline void bgc_servo_add(atomic_int_fast64_t *counter, int64_t n) {
    atomic_fetch_add_explicit(counter, n, memory_order_relaxed);
}

static inline double bgc_servo_get(const atomic_double *value) {
    return atomic_load_explicit(value, memory_order_relaxed);
}

static inline void bgc_servo_set(atomic_double *value, double to) {
    atomic_store_explicit(value, to, memory_order_relaxed);
}

/* ports.c: the devices, and their stand-ins in a model. */
extern const bgc_pose bgc_servo_resting;
extern const bgc_driver bgc_servo_stand_in; /* opened with the address of a slot as its options */
void bgc_servo_write_zero(bgc_servo *s);    /* by the owner of the drivers */
void bgc_servo_announce(bgc_servo *s, int64_t due, double time);
void bgc_servo_note(bgc_servo *s, bgc_servo_end cause, int device, const char *message);
int bgc_servo_is_quiet(const bgc_servo *s); /* no device has a force */
int bgc_servo_has_motors(const bgc_servo *s);

/* ends.c */
int bgc_servo_claim(bgc_servo *s, int owner);
void bgc_servo_finish(bgc_servo *s, bgc_servo_end cause, int64_t due);

/* exchange.c */
bgc_course *bgc_servo_make_course(bgc_servo *s, const bgc_servo_model *model,
                                  const bgc_servo_options *options, int width);
bgc_status bgc_servo_attach(bgc_course *c, int device, int port, char *message, size_t size);
void bgc_servo_seed_course(bgc_course *c, const double *pose);
void bgc_servo_free_course(bgc_course *c);

#endif
