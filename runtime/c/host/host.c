/* host.c: the process of a driver: `host FILE LIFE WATCH LIBRARY DRIVER OPTIONS`.
 *
 * The first process (LIFE is "-") opens the driver, reads it shortly before each sample of the loop, and writes
 * each effort of the loop to it; FILE is the file that it shares with the loop (servo/shared.h). It writes zero
 * and closes where the loop asks it to, where the loop is silent for too long, where its parent has ended, and
 * after a fault. A signal in a call of the driver leaves the call; zero is tried once more.
 *
 * The process in reserve waits at the pipe LIFE, whose other end the first process alone holds, and at the pipe
 * WATCH, whose other end their parent holds. Where the first one ends without zero force, it opens the device
 * anew, writes zero and closes it. It ends a first process that outlives its parent.
 */
#define _GNU_SOURCE

#include "servo/shared.h"

#include <dlfcn.h>
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#endif

enum { PRIORITY = 79, SPARE_PRIORITY = 81 };
enum { SPIN = 100000, NAP = 100000, OUTLIVED = 300000000 }; /* ns */

static bgc_shared *shared;
static const bgc_driver *driver;
static void *handle;
static sigjmp_buf left;                /* out of a call of the driver */
static volatile sig_atomic_t in_call, caught;

static int64_t now(void) {
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void sleep_until(int64_t until) {
    const int64_t rest = until - now();
    const struct timespec span = {(time_t)(rest / 1000000000), (long)(rest % 1000000000)};

    if (rest > 0) {
        nanosleep(&span, NULL);
    }
}

static void tell(int state, const char *message) {
    snprintf(shared->message, sizeof shared->message, "%s", message != NULL ? message : "");
    atomic_store(&shared->state, state);
}

/* --- calls of the driver -------------------------------------------------------------------------- */

static void catch_signal(int number) {
    if (!in_call) {
        signal(number, SIG_DFL);
        raise(number);
        return;
    }
    caught = number;
    siglongjmp(left, 1);
}

static void catch_signals(void) {
    static char stack[65536];
    static const int numbers[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    const stack_t other = {.ss_sp = stack, .ss_size = sizeof stack};
    struct sigaction action = {.sa_handler = catch_signal, .sa_flags = SA_ONSTACK};

    sigaltstack(&other, NULL);
    sigemptyset(&action.sa_mask);
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        sigaction(numbers[k], &action, NULL);
    }
    signal(SIGINT, SIG_IGN); /* that of a terminal is for the parent, which then asks for the end */
    signal(SIGTERM, SIG_IGN);
    signal(SIGHUP, SIG_IGN);
    signal(SIGPIPE, SIG_IGN);
}

static void begin_call(int is_write) {
    atomic_store_explicit(&shared->in_write, is_write, memory_order_relaxed);
    atomic_store(&shared->call_since, now());
    in_call = 1;
}

static void end_call(void) {
    in_call = 0;
    atomic_store(&shared->call_since, 0);
}

/* A signal has ended a call. */
static void note_signal(void) {
    static const struct {
        int number;
        const char *name;
    } names[] = {{SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"},   {SIGFPE, "SIGFPE"},
                 {SIGILL, "SIGILL"},   {SIGABRT, "SIGABRT"}};
    const char *name = "a signal";
    char message[80];

    end_call();
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        name = names[k].number == caught ? names[k].name : name;
    }
    snprintf(message, sizeof message, "%s in `%s` of its driver", name,
             atomic_load(&shared->in_write) ? "write" : "read");
    tell(BGC_DEAD, message);
}

/* Writes an effort: 1, or 0 after a fault or a signal. */
static int write_effort(const bgc_effort *effort, double t) {
    int answer, is_zero = 1;

    for (int k = 0; k < 3; k++) {
        is_zero &= effort->force[k] == 0.0 && effort->torque[k] == 0.0;
    }
    is_zero &= effort->gripper_force[0] == 0.0;
    atomic_store(&shared->is_zero, 0);
    if (sigsetjmp(left, 1) != 0) {
        note_signal();
        return 0;
    }
    begin_call(1);
    answer = driver->write(handle, t, effort);
    end_call();
    if (bgc_is_fault(answer)) {
        return 0;
    }
    atomic_store(&shared->answer, answer);
    atomic_store(&shared->is_zero, is_zero);
    return 1;
}

static int write_zero(void) {
    static const bgc_effort none = {{0.0}, {0.0}, {0.0}};

    return write_effort(&none, atomic_load(&shared->time));
}

static void close_device(void) {
    if (sigsetjmp(left, 1) == 0) {
        in_call = 1;
        driver->close(handle);
    }
    in_call = 0;
}

static void note_fault(void) {
    if (atomic_load(&shared->state) == BGC_OPEN) {
        tell(BGC_FAULTY, driver->last_error != NULL ? driver->last_error(handle) : NULL);
    }
}

/* Reads a pose, and hands it to the loop: 1, or 0 after a fault or a signal. */
static int read_pose(const bgc_effort *held) {
    bgc_pose pose = {.orientation = {1.0, 0.0, 0.0, 0.0}};
    double words[BGC_POSE_WORDS];
    int answer;

    memcpy(pose.held_force, held->force, sizeof pose.held_force);
    if (sigsetjmp(left, 1) != 0) {
        note_signal();
        return 0;
    }
    begin_call(0);
    answer = driver->read(handle, atomic_load(&shared->time), &pose);
    end_call();
    if (bgc_is_fault(answer)) {
        note_fault();
        return 0;
    }
    memcpy(words, &pose, sizeof words);
    if (answer != BGC_DEVICE_NO_NEWS || atomic_load(&shared->pose.sequence) == 0) {
        bgc_put(&shared->pose, words, BGC_POSE_WORDS);
    }
    return 1;
}

/* --- the first process ----------------------------------------------------------------------------- */

/* Waits for a new effort until an instant, up to `spin` actively: its sequence, or `before`. */
static unsigned wait_for_effort(unsigned before, int64_t spin, int64_t until, bgc_effort *effort, double *t) {
    double words[BGC_EFFORT_WORDS + 1];
    unsigned found = bgc_get(&shared->effort, before, words, BGC_EFFORT_WORDS + 1);

    while (found == before && now() < until && atomic_load(&shared->end) == 0) {
        if (now() > spin) {
#ifdef __linux__
            const struct timespec nap = {0, (long)fmin((double)(until - now()), 1e8)};
            atomic_store(&shared->asleep, 1u);
            if (atomic_load(&shared->effort.sequence) == before && atomic_load(&shared->end) == 0 &&
                nap.tv_nsec > 0) {
                syscall(SYS_futex, &shared->asleep, FUTEX_WAIT, 1, &nap, NULL, 0);
            }
            atomic_store(&shared->asleep, 0u);
#else
            sleep_until(now() + NAP);
#endif
        }
        found = bgc_get(&shared->effort, before, words, BGC_EFFORT_WORDS + 1);
    }
    if (found != before) {
        memcpy(effort, words, sizeof *effort);
        *t = words[BGC_EFFORT_WORDS];
    }
    return found;
}

/* Serves the loop until it ends, or a call fails. */
static void serve(int parent) {
    bgc_effort effort = {{0.0}, {0.0}, {0.0}};
    int64_t sample = now(), heard = sample, longest = 0;
    unsigned sequence = 0;

    while (atomic_load(&shared->end) == 0 && getppid() == parent) {
        const int64_t due = atomic_load_explicit(&shared->due, memory_order_acquire);
        int64_t begun;
        unsigned found;
        double t = 0.0;

        /* A pose shortly before the sample: that of the loop, or without one a period after the last. */
        sample = due > sample ? due : sample + shared->period;
        sample = sample > now() ? sample : now();
        sleep_until(sample - shared->ahead - (longest < shared->period / 2 ? longest : shared->period / 2));
        begun = now();
        if (!read_pose(&effort)) {
            return;
        }
        longest = (int64_t)fmax((double)(now() - begun), 0.99 * (double)longest);

        /* The effort of the sample; where the loop says nothing for too long, zero. */
        sleep_until(sample);
        found = wait_for_effort(sequence, sample + SPIN, sample + shared->period / 2, &effort, &t);
        if (found != sequence) {
            sequence = found;
            heard = now();
            if (!write_effort(&effort, t)) {
                note_fault();
                return;
            }
            atomic_store(&shared->written, sequence);
        } else if (shared->silence > 0 && now() - heard > shared->silence && !atomic_load(&shared->is_zero)) {
            memset(&effort, 0, sizeof effort);
            if (!write_zero()) {
                note_fault();
                return;
            }
        }
    }
}

static int run_first(const char *options, int parent) {
    char message[sizeof shared->message] = "";

    atomic_store(&shared->pid, (int)getpid());
    if (sigsetjmp(left, 1) != 0) {
        note_signal();
        snprintf(message, sizeof message, "a signal (%d) in `open` of its driver", (int)caught);
        tell(BGC_REFUSED, message);
        return 1;
    }
    in_call = 1;
    handle = driver->open(options, message, sizeof message);
    if (handle != NULL) {
        shared->can = (bgc_capabilities){.sensed = BGC_EVERY_AXIS, .driven = BGC_EVERY_AXIS};
        if (driver->capabilities != NULL) {
            memset(&shared->can, 0, sizeof shared->can);
            driver->capabilities(handle, &shared->can);
        }
    }
    in_call = 0;
    tell(handle != NULL ? BGC_OPEN : BGC_REFUSED, message);
    if (handle == NULL) {
        return 1;
    }

    /* A process in reserve writes zero where these two calls do not return or fail. */
    serve(parent);
    write_zero();
    atomic_store(&shared->written, atomic_load(&shared->effort.sequence));
    if (atomic_load(&shared->state) == BGC_DEAD) {
        _exit(1); /* what a signal has left of the driver is not called again */
    }
    close_device();
    if (atomic_load(&shared->state) == BGC_OPEN) {
        atomic_store(&shared->state, BGC_CLOSED);
    }
    return 0;
}

/* --- the process in reserve ------------------------------------------------------------------------- */

static int run_spare(const char *options, int life, int watch) {
    struct pollfd ends[2] = {{.fd = life, .events = POLLIN}, {.fd = watch, .events = POLLIN}};
    char message[64];
    volatile int done = 2;

    /* Until the first process has ended; it has its time where their parent has ended before. */
    while (ends[0].revents == 0) {
        poll(ends, ends[1].revents == 0 ? 2 : 1, ends[1].revents == 0 ? -1 : OUTLIVED / 1000000);
        if (ends[1].revents != 0 && ends[0].revents == 0) {
            struct pollfd rest = {.fd = life, .events = POLLIN};
            if (poll(&rest, 1, OUTLIVED / 1000000) == 0 && atomic_load(&shared->pid) > 0) {
                kill(atomic_load(&shared->pid), SIGKILL);
            }
        }
    }
    if (atomic_load(&shared->state) == BGC_STARTING) {
        tell(BGC_REFUSED, "the process of its driver ended while it opened the device");
    }
    if (atomic_load(&shared->state) == BGC_REFUSED || atomic_load(&shared->is_zero)) {
        done = 3;
    } else if (sigsetjmp(left, 1) == 0) {
        in_call = 1;
        handle = driver->open(options, message, sizeof message);
        in_call = 0;
        if (handle != NULL) {
            done = write_zero() ? 1 : 2;
            close_device();
        }
    }
    in_call = 0;
    atomic_store(&shared->spare, done);
    if (atomic_load(&shared->state) == BGC_OPEN) {
        tell(BGC_DEAD, "the process of its driver has ended");
    }
    return 0;
}

/* --- both ------------------------------------------------------------------------------------------- */

static const bgc_driver *find_driver(const char *library, const char *name) {
    void *object = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    union {
        void *object;
        const bgc_driver *(*by_name)(const char *);
        const bgc_driver *(*only)(void);
    } found;

    if (object == NULL) {
        return NULL;
    }
    found.object = dlsym(object, *name != '\0' ? "bgc_find_driver" : "bgc_device_driver");
    if (found.object == NULL) {
        return NULL;
    }
    return *name != '\0' ? found.by_name(name) : found.only();
}

static void take_priority(int priority) {
    const struct sched_param parameters = {.sched_priority = priority};

    if (shared->realtime) {
        pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
        mlockall(MCL_CURRENT | MCL_FUTURE);
    }
}

int main(int count, char **argument) {
    const int parent = (int)getppid();
    const struct rlimit none = {0, 0};
    int is_spare;

    if (count != 7) {
        return 2;
    }
    is_spare = strcmp(argument[2], "-") != 0;
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED, atoi(argument[1]), 0);
    if (shared == MAP_FAILED) {
        return 2;
    }
    setrlimit(RLIMIT_CORE, &none);
    catch_signals();
    driver = find_driver(argument[4], argument[5]);
    if (driver == NULL) {
        tell(BGC_REFUSED, "the process of its driver cannot load it");
        return 1;
    }
    take_priority(is_spare ? SPARE_PRIORITY : PRIORITY);
    return is_spare ? run_spare(argument[6], atoi(argument[2]), atoi(argument[3]))
                    : run_first(argument[6], parent);
}
