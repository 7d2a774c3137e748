/* standin.c: a driver whose hardware is a file: the force that was written last stays there, whichever process
 * wrote it. It injects one fault, in a call of its own process.
 *
 * Options: file=PATH of the hardware, fault=KIND, from=TIME (s after it was opened), size=LENGTH of a jump,
 * delay=TIME (s) of a freeze.
 */
#define _GNU_SOURCE

#include "bgc_device.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

/* As numbers, which Python reads. */
typedef struct {
    double force;     /* N: along y, as it is written last */
    double writer;    /* process of that write */
    double opened, closed;
    double fault_at;  /* s: of the clock, and of the model, when the fault began; 0: none */
    double fault_time;
    double zero_at;   /* s: of the clock, when the force went to zero; 0: it did not since it was not */
    double first;     /* process that opened it first */
    double most;      /* N: largest force */
} hardware;

static struct {
    hardware *unit;
    char kind[20];
    double from, size, delay, opened;
    int done; /* the fault is over */
} device;

static double clock_now(void) {
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double number(const char *options, const char *key, double value) {
    const char *found = strstr(options, key);

    return found != NULL ? atof(found + strlen(key)) : value;
}

static void pause_for(double seconds) {
    const struct timespec span = {(time_t)seconds, (long)(1e9 * (seconds - floor(seconds)))};

    nanosleep(&span, NULL);
}

static void hang(void) {
    for (;;) {
        pause_for(0.01);
    }
}

static int is(const char *kind) {
    return !device.done && strcmp(device.kind, kind) == 0 && clock_now() > device.opened + device.from &&
           device.unit->first == getpid();
}

/* Notes the first call in which a fault is there. */
static int begins(const char *kind, double t) {
    if (!is(kind)) {
        return 0;
    }
    if (device.unit->fault_at == 0.0) {
        device.unit->fault_at = clock_now();
        device.unit->fault_time = t;
    }
    return 1;
}

static void *standin_open(const char *options, char *message, size_t size) {
    char path[400] = "";
    const char *kind = strstr(options, "fault=");
    int file;

    sscanf(strstr(options, "file="), "file=%399[^\n]", path);
    file = open(path, O_RDWR | O_CREAT, 0600);
    if (strstr(options, "missing=") != NULL || file < 0 || ftruncate(file, sizeof(hardware)) != 0) {
        snprintf(message, size, "no hardware");
        return NULL;
    }
    device.unit = mmap(NULL, sizeof(hardware), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (kind != NULL) {
        sscanf(kind + strlen("fault="), "%19[a-z_]", device.kind);
    }
    device.from = number(options, "from=", 0.4);
    device.size = number(options, "size=", 0.0);
    device.delay = number(options, "delay=", 0.0);
    device.opened = clock_now();
    if (strcmp(device.kind, "killed_for_good") == 0 && device.unit->first != 0.0) {
        snprintf(message, size, "no hardware");
        return NULL;
    }
    device.unit->first = device.unit->first != 0.0 ? device.unit->first : getpid();
    device.unit->opened += 1.0;
    if (strcmp(device.kind, "hang_open") == 0) {
        hang();
    }
    if (strcmp(device.kind, "segv_open") == 0) {
        raise(SIGSEGV);
    }
    return &device;
}

static int standin_read(void *handle, double t, bgc_pose *pose) {
    volatile double *nowhere = NULL;

    (void)handle;
    if (begins("hang", t)) {
        hang();
    }
    if (begins("freeze", t)) {
        pause_for(device.delay);
        device.done = 1;
    }
    if (begins("segv", t)) {
        *nowhere = 1.0;
    }
    if (begins("abrt", t)) {
        abort();
    }
    if (begins("fpe", t)) {
        raise(SIGFPE);
    }
    if (begins("killed", t) || begins("killed_for_good", t)) {
        raise(SIGKILL);
    }
    if (begins("exit", t)) {
        _exit(0);
    }
    if (begins("unplugged", t)) {
        return BGC_DEVICE_LOST;
    }
    pose->position[0] = begins("jump", t)       ? device.size
                        : begins("nan", t)      ? NAN
                        : begins("infinite", t) ? INFINITY
                                                : 0.01;
    pose->stamp = begins("stuck", t) ? device.unit->fault_at : clock_now();
    return BGC_DEVICE_FINE;
}

static int standin_write(void *handle, double t, const bgc_effort *effort) {
    hardware *unit = device.unit;
    const double force = effort->force[1];

    (void)handle;
    if (force != 0.0 && begins("hang_write", t)) {
        hang();
    }
    if (force != 0.0 && begins("segv_write", t)) {
        raise(SIGSEGV);
    }
    if (unit->force != 0.0 && force == 0.0) {
        unit->zero_at = clock_now();
    }
    unit->most = fmax(unit->most, fabs(force));
    unit->force = force;
    unit->writer = getpid();
    return BGC_DEVICE_FINE;
}

static void standin_close(void *handle) {
    (void)handle;
    if (strcmp(device.kind, "hang_close") == 0) {
        hang();
    }
    device.unit->closed += 1.0;
}

static void standin_capabilities(void *handle, bgc_capabilities *can) {
    (void)handle;
    can->sensed = can->driven = BGC_TRANSLATIONS;
    can->max_force = 12.0;
    for (int k = 0; k < 3; k++) {
        can->workspace_low[k] = -0.1;
        can->workspace_high[k] = 0.1;
    }
}

static const char *standin_error(void *handle) {
    (void)handle;
    return "the cable is out";
}

const bgc_driver *bgc_device_driver(void) {
    static const bgc_driver driver = {.abi = BGC_DEVICE_ABI,
                                      .name = "standin",
                                      .open = standin_open,
                                      .read = standin_read,
                                      .write = standin_write,
                                      .close = standin_close,
                                      .capabilities = standin_capabilities,
                                      .last_error = standin_error};

    return &driver;
}
