/* clock.c: the clock of the system. */
#include "servo_internal.h"

#include <errno.h>
#include <time.h>

static int64_t system_now(void *of) {
    struct timespec t;

    (void)of;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void system_sleep(void *of, int64_t until) {
    const struct timespec t = {(time_t)(until / 1000000000), (long)(until % 1000000000)};

#ifdef __APPLE__ /* without absolute sleep */
    const int64_t rest = until - system_now(of);
    const struct timespec span = {(time_t)(rest / 1000000000), (long)(rest % 1000000000)};
    (void)t;
    if (rest > 0) {
        nanosleep(&span, NULL);
    }
#else
    (void)of;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) {
    }
#endif
}

const bgc_servo_clock bgc_system_clock = {system_now, system_sleep, NULL};
