/* pointer.c: the drivers `pointer` and `gamepad`: a pose that another thread hands over, such as that of a
 * mouse, a page or a gamepad. They have no motor, and differ in their names alone, by which a page chooses
 * the hand that it reads.
 *
 * Options: smooth=TIME (0.02 s), of the filter of velocities that are computed from positions;
 * reach=LENGTH (0.06 m), the displacement at the end of a stick, for those that hand the pose over.
 * The pose is copied under a sequence number that is odd while it is written: the reader tries again, and
 * after a few attempts takes the pose before. Neither side waits.
 */
#include "bgc_internal.h"
#include "drivers/options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POSE_WORDS = sizeof(bgc_pose) / sizeof(double), ATTEMPTS = 8 };

typedef struct {
    atomic_uint sequence;
    _Atomic double word[POSE_WORDS]; /* the pose that was handed over */

    /* Of the reader. */
    unsigned taken;
    double smooth; /* s */
    double reach;  /* m */
    double time;   /* s: of the last read; negative: none */
    double taken_at; /* s: of the last read with a new pose */
    bgc_pose pose;
    double velocity[3];
} pointer_state;

void bgc_feed_pointer(void *handle, const bgc_pose *pose) {
    pointer_state *p = handle;
    double words[POSE_WORDS];

    memcpy(words, pose, sizeof words);
    atomic_fetch_add_explicit(&p->sequence, 1, memory_order_acquire);
    atomic_thread_fence(memory_order_release);
    for (int k = 0; k < POSE_WORDS; k++) {
        atomic_store_explicit(&p->word[k], words[k], memory_order_relaxed);
    }
    atomic_fetch_add_explicit(&p->sequence, 1, memory_order_release);
}

static void *pointer_open(const char *options, char *message, size_t size) {
    pointer_state *p = calloc(1, sizeof *p);

    if (p == NULL) {
        snprintf(message, size, "pointer: there is not enough memory");
        return NULL;
    }
    p->smooth = bgc_number_option(options, "smooth", 0.02);
    p->reach = bgc_number_option(options, "reach", 0.06);
    if (!(p->smooth >= 0.0) || !(p->reach > 0.0)) {
        snprintf(message, size, !(p->smooth >= 0.0) ? "pointer: smooth must be a time, not negative"
                                                    : "pointer: reach must be a positive length");
        free(p);
        return NULL;
    }
    p->time = -1.0;
    p->pose = (bgc_pose){.orientation = {1.0, 0.0, 0.0, 0.0}, .held_force = {(double)NAN}};
    return p;
}

/* Takes a pose that was handed over since the last one: 1; or 0. */
static int take_pose(pointer_state *p, bgc_pose *pose) {
    double words[POSE_WORDS];

    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        const unsigned before = atomic_load_explicit(&p->sequence, memory_order_acquire);
        if (before == p->taken) {
            return 0;
        }
        for (int k = 0; k < POSE_WORDS; k++) {
            words[k] = atomic_load_explicit(&p->word[k], memory_order_relaxed);
        }
        atomic_thread_fence(memory_order_acquire);
        if (before % 2 == 0 &&
            atomic_load_explicit(&p->sequence, memory_order_relaxed) == before) {
            memcpy(pose, words, sizeof words);
            p->taken = before;
            return 1;
        }
    }
    return 0;
}

/* Velocities from positions, smoothed over p->smooth. */
static void follow_velocity(pointer_state *p, double t, const bgc_pose *next) {
    const double step = t - p->time;
    const double part = step > 0.0 ? 1.0 - exp(-step / fmax(p->smooth, 1e-9)) : 0.0;

    for (int k = 0; k < 3 && p->time >= 0.0 && step > 0.0; k++) {
        const double rate = (next->position[k] - p->pose.position[k]) / step;
        p->velocity[k] += part * (rate - p->velocity[k]);
    }
    p->time = t;
}

static int pointer_read(void *handle, double t, bgc_pose *pose) {
    pointer_state *p = handle;
    bgc_pose next = p->pose;
    const int is_new = take_pose(p, &next);

    follow_velocity(p, t, &next);
    p->pose = next;
    p->taken_at = is_new ? t : p->taken_at;
    memcpy(pose, &next, offsetof(bgc_pose, held_force));
    if (!isnan(next.held_force[0])) {
        memcpy(pose->held_force, next.held_force, sizeof pose->held_force);
    }
    pose->age = next.age > 0.0 ? next.age + fmax(t - p->taken_at, 0.0) : 0.0;
    if (isnan(next.velocity[0])) {
        memcpy(pose->velocity, p->velocity, sizeof p->velocity);
    }
    if (isnan(next.angular_velocity[0])) {
        memset(pose->angular_velocity, 0, sizeof pose->angular_velocity);
    }
    return is_new ? BGC_DEVICE_FINE : BGC_DEVICE_NO_NEWS;
}

static int pointer_write(void *handle, double t, const bgc_effort *effort) {
    (void)handle, (void)t, (void)effort;
    return BGC_DEVICE_FINE;
}

static void pointer_close(void *handle) { free(handle); }

static void pointer_capabilities(void *handle, bgc_capabilities *can) {
    const pointer_state *p = handle;

    can->sensed = BGC_EVERY_AXIS;
    can->buttons = 8;
    for (int k = 0; k < 3; k++) {
        can->workspace_low[k] = -p->reach;
        can->workspace_high[k] = p->reach;
    }
}

const bgc_driver bgc_pointer_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "pointer",
    .open = pointer_open,
    .read = pointer_read,
    .write = pointer_write,
    .close = pointer_close,
    .capabilities = pointer_capabilities,
};

const bgc_driver bgc_gamepad_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "gamepad",
    .open = pointer_open,
    .read = pointer_read,
    .write = pointer_write,
    .close = pointer_close,
    .capabilities = pointer_capabilities,
};
