/* remote.c: the driver of a device whose own driver runs in another process, the program of host/host.c.
 *
 * It is opened with `fd=NUMBER`, the file that both processes map, once the other one has opened its device.
 * read and write take microseconds whatever the other process does. Where that hangs or has died, zero force is
 * written by a process in reserve: it waits for the end of the first one, and opens the device anew.
 */
#define _GNU_SOURCE /* syscall */

#include "servo_internal.h"
#include "shared.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#endif

/* ns: until a call hangs for good; for a process to come to its turn, and for one in reserve to open its device
 * and write zero; between two looks */
enum { GRACE = 50000000, PATIENCE = 100000000, LOOK = 20000 };

typedef struct {
    bgc_shared *shared;
    unsigned taken; /* sequence of the last pose */
    bgc_pose pose;
    int answer;     /* of the read that gave it */
    char reason[320];
} remote_device;

static int64_t remote_now(void) { return bgc_system_clock.now(NULL); }

/* Maps a file; NULL: no memory. */
static bgc_shared *map_file(int file) {
    void *found = mmap(NULL, sizeof(bgc_shared), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);

    return found != MAP_FAILED ? found : NULL;
}

static void *remote_open(const char *options, char *message, size_t size) {
    remote_device *r = calloc(1, sizeof *r);
    const int file = atoi(options + strlen("fd="));

    if (r != NULL) {
        r->shared = map_file(file);
    }
    if (r == NULL || r->shared == NULL) {
        snprintf(message, size, "there is not enough memory");
        free(r);
        return NULL;
    }
    r->pose.orientation[0] = 1.0;
    return r;
}

static void remote_wake(bgc_shared *shared) {
#ifdef __linux__
    if (atomic_exchange(&shared->asleep, 0u) != 0) {
        syscall(SYS_futex, &shared->asleep, FUTEX_WAKE, 1, NULL, NULL, 0);
    }
#else
    atomic_store(&shared->asleep, 0u);
#endif
}

static int remote_read(void *handle, double t, bgc_pose *pose) {
    remote_device *r = handle;
    double words[BGC_POSE_WORDS];
    const unsigned taken = bgc_get(&r->shared->pose, r->taken, words, BGC_POSE_WORDS);
    const int is_new = taken != r->taken;

    if (atomic_load(&r->shared->state) != BGC_OPEN) {
        return BGC_DEVICE_LOST;
    }
    if (is_new) {
        r->taken = taken;
        memcpy(&r->pose, words, sizeof r->pose);
    }
    *pose = r->pose;
    (void)t;
    return is_new ? BGC_DEVICE_FINE : BGC_DEVICE_NO_NEWS;
}

static int remote_write(void *handle, double t, const bgc_effort *effort) {
    remote_device *r = handle;
    double words[BGC_EFFORT_WORDS + 1];

    memcpy(words, effort, sizeof *effort);
    words[BGC_EFFORT_WORDS] = t;
    bgc_put(&r->shared->effort, words, BGC_EFFORT_WORDS + 1);
    remote_wake(r->shared);
    return atomic_load(&r->shared->state) != BGC_OPEN ? BGC_DEVICE_LOST : atomic_load(&r->shared->answer);
}

static void remote_close(void *handle) {
    remote_device *r = handle;

    munmap(r->shared, sizeof *r->shared);
    free(r);
}

static void remote_capabilities(void *handle, bgc_capabilities *can) {
    *can = ((const remote_device *)handle)->shared->can;
}

static const char *remote_error(void *handle) { return ((const remote_device *)handle)->shared->message; }

const bgc_driver bgc_servo_remote = {
    .abi = BGC_DEVICE_ABI,
    .name = "remote",
    .open = remote_open,
    .read = remote_read,
    .write = remote_write,
    .close = remote_close,
    .capabilities = remote_capabilities,
    .last_error = remote_error,
};

void bgc_remote_announce(void *handle, int64_t due, double time) {
    bgc_shared *shared = ((const remote_device *)handle)->shared;

    atomic_store_explicit(&shared->time, time, memory_order_relaxed);
    atomic_store_explicit(&shared->due, due, memory_order_release);
}

const char *bgc_remote_hang(void *handle, int64_t since) {
    remote_device *r = handle;
    const int64_t begun = atomic_load(&r->shared->call_since);

    if (begun == 0 || remote_now() - begun < since) {
        return NULL;
    }
    snprintf(r->reason, sizeof r->reason, "a call of `%s` of its driver does not return",
             atomic_load(&r->shared->in_write) ? "write" : "read");
    return r->reason;
}

/* Whether the driver has taken the zero that was written last, or a new process has written it. A process that
 * serves the loop no more writes nothing but zero. */
static int is_settled(bgc_shared *shared) {
    const int is_served = atomic_load(&shared->state) == BGC_OPEN &&
                          atomic_load(&shared->written) != atomic_load(&shared->effort.sequence);

    return (!is_served && atomic_load(&shared->is_zero)) || atomic_load(&shared->spare) != 0;
}

int bgc_remote_settle(void *handle) {
    bgc_shared *shared = ((const remote_device *)handle)->shared;
    const int64_t begun = remote_now();
    int is_killed = 0;

    /* A process that only waits for its turn writes zero itself. */
    while (!is_settled(shared) && remote_now() - begun < 2 * PATIENCE) {
        const int hangs = bgc_remote_hang(handle, GRACE) != NULL;
        if (!is_killed && (hangs || remote_now() - begun > PATIENCE) && atomic_load(&shared->pid) > 0) {
            kill(atomic_load(&shared->pid), SIGKILL);
            is_killed = 1;
        }
        bgc_system_clock.sleep(NULL, remote_now() + LOOK);
    }
    return is_settled(shared) && atomic_load(&shared->spare) != 2;
}

/* --- for those who hold the file ------------------------------------------------------------------- */

int bgc_remote_share(int file, double period, double silence, double ahead, int realtime) {
    bgc_shared *shared = ftruncate(file, sizeof *shared) == 0 ? map_file(file) : NULL;

    if (shared == NULL) {
        return errno;
    }
    shared->period = bgc_servo_ns(period);
    shared->silence = bgc_servo_ns(silence);
    shared->ahead = bgc_servo_ns(ahead);
    shared->realtime = realtime;
    munmap(shared, sizeof *shared);
    return 0;
}

int bgc_remote_state(int file, char *message, size_t size) {
    bgc_shared *shared = map_file(file);
    int state;

    if (shared == NULL) {
        return BGC_STARTING;
    }
    state = atomic_load(&shared->state);
    snprintf(message, size, "%s", shared->message);
    if (state == BGC_OPEN && atomic_load(&shared->pose.sequence) == 0) {
        state = -BGC_OPEN; /* and has given no pose yet */
    }
    munmap(shared, sizeof *shared);
    return state;
}

void bgc_remote_end(int file) {
    bgc_shared *shared = map_file(file);

    if (shared != NULL) {
        atomic_store(&shared->end, 1);
        remote_wake(shared);
        munmap(shared, sizeof *shared);
    }
}
