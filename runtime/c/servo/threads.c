/* threads.c: the thread of the loop and that of the watchdog. */
#include "servo_internal.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

enum { LOOP_PRIORITY = 80, WATCHDOG_PRIORITY = 81, STACK_TOUCHED = 65536 };

/* 1: this thread has real-time priority from now on; or -errno. */
static int take_priority(int priority) {
    const struct sched_param parameters = {.sched_priority = priority};
    const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);

    return refused != 0 ? -refused : 1;
}

/* Maps the pages of the stack that the loop may use. */
static void touch_stack(void) {
    volatile char stack[STACK_TOUCHED];

    for (int k = 0; k < STACK_TOUCHED; k += 1024) {
        stack[k] = 0;
    }
    (void)stack[0];
}

static void *run_loop(void *of) {
    bgc_servo *s = of;

    touch_stack();
    if (s->options.realtime) {
        atomic_store(&s->fifo, take_priority(LOOP_PRIORITY));
    }
    bgc_servo_loop(s);
    atomic_fetch_sub(&s->threads, 1);
    return NULL;
}

static void *run_watchdog(void *of) {
    bgc_servo *s = of;
    const int64_t period = (int64_t)(1e9 * s->options.period);

    if (s->options.realtime) {
        take_priority(WATCHDOG_PRIORITY);
    }
    while (atomic_load(&s->ended) == BGC_SERVO_RUNNING) {
        s->clock.sleep(s->clock.of, s->clock.now(s->clock.of) + period);
        bgc_servo_watch(s);
    }
    atomic_fetch_sub(&s->threads, 1);
    return NULL;
}

/* A thread of its own, which nobody joins: 1, or 0 where the system gives none. */
static int start_thread(bgc_servo *s, void *(*run)(void *)) {
    pthread_t thread;

    atomic_fetch_add(&s->threads, 1);
    if (pthread_create(&thread, NULL, run, s) != 0) {
        atomic_fetch_sub(&s->threads, 1);
        return 0;
    }
    pthread_detach(thread);
    return 1;
}

int bgc_servo_start(bgc_servo *s) {
    if (s->options.realtime) {
        atomic_store(&s->locked, mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 1 : -errno);
    }
    if (s->options.watchdog > 0.0 && !start_thread(s, run_watchdog)) {
        atomic_store(&s->ended, BGC_SERVO_NO_THREAD);
        return 0;
    }
    if (!start_thread(s, run_loop)) {
        atomic_store(&s->ended, BGC_SERVO_NO_THREAD);
        return 0;
    }
    return 1;
}

int bgc_servo_join(bgc_servo *s, double seconds) {
    const int64_t end = bgc_system_clock.now(NULL) + (int64_t)(1e9 * seconds);

    while (atomic_load(&s->threads) > 0 && bgc_system_clock.now(NULL) < end) {
        bgc_system_clock.sleep(NULL, bgc_system_clock.now(NULL) + 200000);
    }
    if (atomic_load(&s->threads) == 0 && atomic_load(&s->locked) == 1) {
        munlockall();
        atomic_store(&s->locked, 2);
    }
    return atomic_load(&s->threads) == 0;
}
