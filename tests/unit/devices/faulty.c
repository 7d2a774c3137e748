/* faulty.c: a driver that injects faults, and a clock that only moves when the loop or a fault moves it.
 *
 * Options: fault=KIND, from=TIME, to=TIME (s of simulated time), delay=TIME, size=LENGTH of a jump.
 *
 * With `fault=hand` it is no fault but a hand of 0.25 kg whose grip, a spring and a damper, follows a swing
 * along x into positions above 0. It keeps its own account of the work that it receives, and lets go of
 * button 2 for 0.3 s in every `letting` seconds.
 */
#include "bgc_device.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int64_t virtual_time; /* ns */
void (*virtual_watch)(void *servo);
void *virtual_servo;
void (*virtual_call)(void); /* called once, from within a read, at this time or after it */
double virtual_call_at;     /* s of simulated time, or of the hand */
double faulty_force[3], faulty_zero_at; /* s: when zero force was written after another */
int faulty_open, faulty_hold;
double hand_work; /* J: that the hand has received */

static struct {
    char kind[20];
    double from, to, delay, size, letting, time;
    int pending; /* the next sleep of the loop lasts longer */
} fault;

static struct {
    double x, v, time;
} hand;

/* A millisecond of the hand, under the force that was written last. */
static double move_hand(void) {
    const double mass = 0.25, grip = 300.0, damping = 3.0, before = hand.x;

    for (int k = 0; k < 20; k++) {
        const double step = 5e-5, time = hand.time += step;
        const double wanted = 0.02 * sin(6.283185307179586 * 1.07 * time) + 0.004 * sin(11.0 * time);
        hand.v += step / mass * (faulty_force[0] + grip * (wanted - hand.x) - damping * hand.v);
        hand.x += step * hand.v;
    }
    hand_work += faulty_force[0] * (hand.x - before);
    return hand.x;
}

/* Time passes in steps of 0.1 ms, and the watchdog has its turn. */
static void pass(double seconds) {
    for (int64_t end = virtual_time + (int64_t)(1e9 * seconds); virtual_time < end;) {
        virtual_time += 100000;
        if (virtual_watch != NULL) {
            virtual_watch(virtual_servo);
        }
    }
}

int64_t virtual_now(void *of) {
    (void)of;
    return virtual_time += 1000;
}

void virtual_sleep(void *of, int64_t until) {
    (void)of;
    virtual_time = until > virtual_time ? until : virtual_time;
    if (fault.pending) {
        fault.pending = 0;
        pass(fault.delay);
    }
}

static double number(const char *options, const char *key, double value) {
    const char *found = strstr(options, key);

    return found != NULL ? atof(found + strlen(key)) : value;
}

static void *faulty_open_device(const char *options, char *message, size_t size) {
    const char *kind = strstr(options, "fault=");

    memset(&fault, 0, sizeof fault);
    if (kind != NULL) {
        sscanf(kind + strlen("fault="), "%19[a-z_]", fault.kind);
    }
    fault.from = number(options, "from=", 0.1);
    fault.to = number(options, "to=", 1e9);
    fault.delay = number(options, "delay=", 0.0);
    fault.size = number(options, "size=", 0.0);
    fault.letting = number(options, "letting=", 0.0);
    memset(&hand, 0, sizeof hand);
    hand_work = 0.0;
    if (strcmp(fault.kind, "absent") == 0) {
        snprintf(message, size, "no device found");
        return NULL;
    }
    faulty_open++;
    return &fault;
}

static int is(const char *kind) {
    return fault.time > fault.from - 1e-9 && fault.time < fault.to - 1e-9 &&
           strcmp(fault.kind, kind) == 0;
}

/* Of `fault=old`: samples from a pose to the force that answers it. */
static double number_of_lag(void) { return is("old") ? fault.delay : 0.0; }

static int faulty_read(void *handle, double t, bgc_pose *pose) {
    const double own = strcmp(fault.kind, "hand") == 0 ? hand.time : t; /* goes on at an exchange */
    void (*const call)(void) = own >= virtual_call_at ? virtual_call : NULL;

    (void)handle;
    fault.time = t;
    if (call != NULL) {
        virtual_call = NULL;
        call();
    }
    if (is("unplugged")) {
        return BGC_DEVICE_LOST;
    }
    if (is("late") || is("stalled_driver")) {
        pass(fault.delay);
    }
    fault.pending = is("stalled");
    while (is("hang") && faulty_hold) {
        const struct timespec ms = {0, 1000000};
        nanosleep(&ms, NULL);
    }
    pose->position[0] = 0.1 * sin(7.0 * t);
    pose->velocity[0] = 0.7 * cos(7.0 * t);
    pose->orientation[0] = -cos(t); /* not a unit quaternion, and of the other sign */
    pose->orientation[3] = -sin(1.01 * t);
    if (is("no_orientation")) {
        memset(pose->orientation, 0, sizeof pose->orientation);
    }
    pose->angular_velocity[2] = 2.0;
    pose->buttons[1] = t < 0.3 || t > 0.4;
    pose->stamp = is("stuck") ? fault.from : 1.0 + t;
    pose->age = 1e-3 * (1.0 + number_of_lag());
    pose->velocity[1] = is("nan") ? NAN : 0.0;
    pose->position[2] = is("jump") ? fault.size : is("infinite") ? INFINITY : 0.0;
    if (is("hand")) {
        memcpy(pose->orientation, (const double[]){1.0, 0.0, 0.0, 0.0}, sizeof pose->orientation);
        pose->position[0] = move_hand();
        pose->velocity[0] = hand.v;
        pose->buttons[1] = !(fault.letting > 0.0 && fmod(hand.time, fault.letting) > fault.letting - 0.3);
    }
    return is("no_news") ? BGC_DEVICE_NO_NEWS : BGC_DEVICE_FINE;
}

static int faulty_write(void *handle, double t, const bgc_effort *effort) {
    const int was = faulty_force[0] != 0.0;

    (void)handle, (void)t;
    memcpy(faulty_force, effort->force, sizeof faulty_force);
    if (was && faulty_force[0] == 0.0) {
        faulty_zero_at = 1e-9 * (double)virtual_time;
    }
    return is("write_lost") && was ? BGC_DEVICE_LOST
           : is("saturated")       ? BGC_DEVICE_SATURATED
                                   : BGC_DEVICE_FINE;
}

static void faulty_close(void *handle) {
    (void)handle;
    faulty_open--;
}

static void faulty_capabilities(void *handle, bgc_capabilities *can) {
    (void)handle;
    can->sensed = BGC_EVERY_AXIS;
    can->driven = BGC_TRANSLATIONS;
    can->max_force = 12.0;
    can->lag = strcmp(fault.kind, "old") == 0 ? 3 : 0;
}

static const char *faulty_error(void *handle) {
    (void)handle;
    return "the cable is out";
}

const bgc_driver *bgc_device_driver(void) {
    static const bgc_driver driver = {.abi = BGC_DEVICE_ABI,
                                      .name = "faulty",
                                      .open = faulty_open_device,
                                      .read = faulty_read,
                                      .write = faulty_write,
                                      .close = faulty_close,
                                      .capabilities = faulty_capabilities,
                                      .last_error = faulty_error};

    return &driver;
}
