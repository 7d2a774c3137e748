/* servo.h: the servo loop: a compiled model in step with the clock, with its devices.
 *
 * A shared object of its own, compiled when it is first used; the functions of the model come in a table.
 * The loop stands between the model and its devices: it opens the real drivers, and gives the model a
 * stand-in for each, which reads poses ahead and limits what is written.
 *
 * After bgc_servo_new the loop allocates nothing, takes no lock, and touches no file or clock but the
 * monotonic one. Records go to a ring with one writer (the loop) and one reader; the report and the
 * histograms are counters that the loop alone writes. The clock and the sleep are functions, so that tests
 * run the same loop on a clock of their own.
 *
 * A model in the loop is a course. Another one takes its place while the devices stay open: it is prepared
 * and started by another thread, then posted; the loop lets the force fall to zero, changes the course
 * between two samples, and lets the force rise again.
 */
#ifndef BGC_SERVO_H
#define BGC_SERVO_H

#include "bgc.h"

#define BGC_SERVO_ABI 5

/* Functions of the model's shared object. */
typedef struct {
    const bgc_model *m;
    bgc_data *d;
    bgc_status (*run)(const bgc_model *m, bgc_data *d, const double *times, size_t n, double *rows,
                      size_t *done);
    bgc_status (*advance)(const bgc_model *m, bgc_data *d, double t);
    bgc_status (*open_device)(const bgc_model *m, bgc_data *d, int k, const bgc_driver *driver,
                              const char *options, char *message, size_t size);
    void (*close_devices)(const bgc_model *m, bgc_data *d);
    void (*stop)(bgc_data *d);
    double (*time)(const bgc_data *d);
} bgc_servo_model;

/* ns on a monotonic clock, and a sleep until then, which may end late. NULL: those of the system. */
typedef struct {
    int64_t (*now)(void *of);
    void (*sleep)(void *of, int64_t until);
    void *of;
} bgc_servo_clock;

/* What happens where a sample is late by a whole period or more. */
typedef enum {
    BGC_HOLD = 0, /* periods that were missed are left out: simulated time falls behind by them */
    BGC_SKIP = 1, /* the model catches up over them with the last pose; the devices are left alone */
    BGC_SLOW = 2  /* the grid of the clock moves by the delay */
} bgc_servo_policy;

typedef struct {
    double period;        /* s: between two samples */
    double deadline;      /* s: for the work of a sample; 0: the period */
    double duration;      /* s of simulated time; INFINITY: until it is stopped */
    int policy;           /* of bgc_servo_policy */
    int realtime;         /* 1: SCHED_FIFO and locked memory are asked for */
    double spin;          /* s before each sample in which the loop spins in place of sleeping */
    double max_force, max_torque, max_gripper_force; /* N, N m, N; 0: that of the device */
    double max_force_rate; /* N/s (torque: N m/s); 0: none; below 0: the full size in 5 ms */
    double max_power;     /* W into the hand; 0: none */
    double ramp;          /* s in which the force rises after a start, an enable or an exchange, and falls
                           * before a normal end and an exchange */
    int dead_man;         /* button 1 .. 8 without which there is no force; 0: none */
    double stale;         /* s without news of a device until it counts as stuck; 0: never */
    double burst;         /* missed deadlines, less a tenth of the kept ones, that end the loop; 0: never;
                           * below 0: 100 where a device has motors, else never */
    double watchdog;      /* s without a sample until the watchdog sets the force to zero; 0: none */
    double max_speed, max_turn_rate; /* m/s, rad/s: of a device with motors; 0: any */
    double workspace_margin; /* m: by which its position may leave the workspace that it states; 0: any */
    int records;          /* room of the ring */
} bgc_servo_options;

/* Why the loop ended. */
typedef enum {
    BGC_SERVO_RUNNING = 0,
    BGC_SERVO_DONE,      /* the duration is over */
    BGC_SERVO_STOPPED,   /* bgc_servo_stop */
    BGC_SERVO_MODEL,     /* the model failed: `status` */
    BGC_SERVO_LOST,      /* a driver reported a fault: `device`, `message` */
    BGC_SERVO_BAD_POSE,  /* a device gave a value that is not finite */
    BGC_SERVO_STUCK,     /* a device gave nothing new for `stale` seconds */
    BGC_SERVO_LATE,      /* a burst of missed deadlines */
    BGC_SERVO_STALLED,   /* no sample for `watchdog` seconds */
    BGC_SERVO_NO_THREAD, /* the system gave no thread */
    BGC_SERVO_JUMP       /* a device gave a pose that no hand can have: `message` */
} bgc_servo_end;

/* Quantiles of a time, s, from a histogram with 32 classes per octave: to 3 %. */
typedef struct {
    double mean, p50, p99, p999, worst;
} bgc_servo_times;

typedef struct {
    int end;             /* of bgc_servo_end */
    int status;          /* of bgc_status: what the model returned last */
    int device;          /* at fault, or -1 */
    int fifo, locked;    /* 1: granted, 0: not asked for, -errno: refused */
    int64_t samples, missed, overruns, dropped, skipped, saturated, limited, no_news, lost_records;
    int64_t exchanges;   /* models that took the place of another one */
    int64_t late_poses;  /* measured with a larger lag than their device states */
    int64_t refused;     /* poses that are not finite or not plausible */
    double time;         /* s, simulated, of the present model */
    double elapsed;      /* s of the clock since the first sample */
    double behind;       /* s by which simulated time has fallen behind the clock */
    double gain;         /* 0 to 1: of the force */
    double worst_power;  /* W into the hand */
    double zero_after;   /* s from the instant of the fault's sample until zero force was written; -1: none */
    double lag;          /* samples: the largest that was measured; -1: no device measures it */
    double fastest;      /* m/s: between two poses of a device with motors */
    double given;        /* J: into the hands since the start; below 0: what they have given */
    double created, taken, owed; /* J: by ramp and limits, taken back of it, and what a hand still has of it */
    int released;        /* 1: the dead man's button is not held */
    int in_driver;       /* 1: the watchdog found the loop in a call of a driver, and wrote nothing */
    int unsettled;       /* 1: a device did not take zero force in the end */
    int late_device;     /* that measured the largest lag above what it states, or -1 */
    bgc_servo_times lateness, jitter, work;
    char message[256];   /* of a driver */
} bgc_servo_report;

/* Doubles of a record: time, lateness and work (s, work of the sample before), then of each device pose
 * (BGC_POSE_SIZE), effort of the model and effort written (7 each), then the model's row. */
enum { BGC_RECORD_HEAD = 3, BGC_POSE_SIZE = 27, BGC_EFFORT_SIZE = 7 };

typedef struct bgc_servo bgc_servo;
typedef struct bgc_course bgc_course;

uint32_t bgc_servo_version(void);
bgc_servo_options bgc_servo_defaults(void);
/* NULL: no memory. `width` is the number of doubles of a row of the model's bgc_run. The model is reset
 * and has its options. */
bgc_servo *bgc_servo_new(const bgc_servo_model *model, const bgc_servo_options *options, int width,
                         const bgc_servo_clock *clock);
/* Opens device k with a driver: the real one, and the stand-in in the model. */
bgc_status bgc_servo_open(bgc_servo *s, int k, const bgc_driver *driver, const char *options,
                          char *message, size_t size);
/* Before the first model is reset: the poses with which it starts, BGC_POSE_SIZE doubles for each device, in
 * place of those that the devices have. */
void bgc_servo_seed(bgc_servo *s, const double *pose);
/* Lets the loop take back from device k what its own ramp and limits create: where its force is that of a
 * coupling. Of a prepared course, or of the first one (NULL). */
void bgc_servo_take_back(bgc_servo *s, bgc_course *course, int k);
const bgc_capabilities *bgc_servo_capabilities(const bgc_servo *s, int k);
void *bgc_servo_handle(const bgc_servo *s, int k); /* that of the real driver */
/* The loop: in this thread, or in one of its own with a watchdog beside it. */
void bgc_servo_loop(bgc_servo *s);
int bgc_servo_start(bgc_servo *s);
/* Asks the loop to end once the force has fallen to zero; or, `at_once`, after its sample. */
void bgc_servo_stop(bgc_servo *s, int at_once);

/* Another model for a loop that runs, in a thread of its caller: its deadline and policy are those of
 * `options`. port[k] is the device of the loop that device k of the model is, one for each; `pose` has
 * BGC_POSE_SIZE doubles for each device of the loop, with which the model starts. The caller then sets the
 * model's options and resets it. NULL: no memory. */
bgc_course *bgc_servo_prepare(bgc_servo *s, const bgc_servo_model *model, const bgc_servo_options *options,
                              int width, const int *port, const double *pose);
/* Asks the loop to go on with a prepared course. 0: another one waits, or the loop has ended. */
int bgc_servo_post(bgc_servo *s, bgc_course *course);
/* Frees a course that was not posted. */
void bgc_servo_drop(bgc_servo *s, bgc_course *course);
/* Waits at most so many seconds for the threads to end; 1: they have. */
int bgc_servo_join(bgc_servo *s, double seconds);
/* What the watchdog does in each of its periods. */
void bgc_servo_watch(bgc_servo *s);
/* Counts of the times in classes, `which` of lateness 0, jitter 1, work 2: the upper end of each class, s,
 * which grow by 1/32 of an octave, and the number in it. Returns the number of classes, also where both are
 * NULL. */
int bgc_servo_histogram(const bgc_servo *s, int which, double *end, int64_t *count);
void bgc_servo_get_report(const bgc_servo *s, bgc_servo_report *report);
/* Of the course that the reader is at. */
int bgc_servo_record_size(const bgc_servo *s);
/* Moves at most n records of that course to `to`; returns their number. One reader. */
size_t bgc_servo_take(bgc_servo *s, double *to, size_t n);
/* 1: that course has no more records than those that wait. The reader then goes on to the next one. */
int bgc_servo_retired(const bgc_servo *s);
void bgc_servo_next(bgc_servo *s);
/* Zero force, closes the devices and frees; not before the threads have ended. */
void bgc_servo_free(bgc_servo *s);

/* A device whose driver runs in another process (host/host.c): the driver to open it with, and `fd=FILE` as its
 * options. FILE is an empty file of its own, made ready here: the period, the silence of the loop after which the
 * force is zero, and how long before a sample the device is read, s; 0, or an errno. */
extern const bgc_driver bgc_servo_remote;
int bgc_remote_share(int file, double period, double silence, double ahead, int realtime);
/* Its state, of servo/shared.h, below 0 where it is open but has given no pose; and the reason of a fault. */
int bgc_remote_state(int file, char *message, size_t size);
void bgc_remote_end(int file); /* asks the process to write zero and to close the device */

#endif
