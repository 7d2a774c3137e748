/* loop.c: the loop, sample by sample. */
#include "servo_internal.h"

enum { MOST_SKIPPED = 100 }; /* samples in a row without the devices, under BGC_SKIP */
enum { BURST_LIMIT = 100 };  /* missed deadlines, where a device has motors */

/* Sleeps to shortly before an instant, then spins. */
static void wait_until(bgc_servo *s, int64_t due) {
    const int64_t spin = bgc_servo_ns(fmin(s->options.spin, 0.4 * s->options.period));

    if (bgc_servo_now(s) < due - spin) {
        s->clock.sleep(s->clock.of, due - spin);
    }
    while (bgc_servo_now(s) < due) {
    }
}

/* The record of a sample, where the ring has room. */
static void record(bgc_course *c, double t, int64_t lateness) {
    bgc_servo *s = c->servo;
    double *to = bgc_next_record(&c->ring);

    if (to == NULL) {
        bgc_servo_add(&s->lost_records, 1);
        return;
    }
    *to++ = s->ports > 0 ? c->slot[0].time : t;
    *to++ = 1e-9 * (double)lateness;
    *to++ = 1e-9 * (double)s->last_work;
    for (int k = 0; k < s->ports; k++) {
        memcpy(to, &c->slot[k].pose, BGC_POSE_SIZE * sizeof *to);
        memcpy(to + BGC_POSE_SIZE, &c->slot[k].wanted, BGC_EFFORT_SIZE * sizeof *to);
        memcpy(to + BGC_POSE_SIZE + BGC_EFFORT_SIZE, &s->port[k].given, BGC_EFFORT_SIZE * sizeof *to);
        to += BGC_POSE_SIZE + 2 * BGC_EFFORT_SIZE;
    }
    memcpy(to, c->row, (size_t)c->width * sizeof *to);
    bgc_publish(&c->ring);
}

/* Reads the devices, writes to them, and takes the model's row at t. 0: the loop has ended. */
static int take_sample(bgc_course *c, double t, int64_t due, int64_t begun) {
    bgc_servo *s = c->servo;
    size_t done;

    if (!bgc_servo_claim(s, BGC_LOOP)) {
        bgc_servo_finish(s, BGC_SERVO_STALLED, due);
        return 0;
    }
    atomic_store(&s->beat, begun);
    s->has_gain = 0;
    c->sampling = 1;
    s->status = c->model.run(c->model.m, c->model.d, &t, 1, c->row, &done);
    c->sampling = 0;
    if (atomic_load(&s->stalled)) {
        bgc_servo_note(s, BGC_SERVO_STALLED, -1, NULL);
    }
    if (s->status != BGC_OK || s->cause != BGC_SERVO_RUNNING) {
        bgc_servo_finish(s, BGC_SERVO_MODEL, due);
        return 0;
    }
    atomic_store(&s->owner, BGC_NOBODY);
    c->samples++;
    record(c, t, begun - due);
    bgc_servo_set(&s->time, t);
    return 1;
}

/* Periods of the clock that the grid moves on by where the loop is late by `late` ns, at least a period:
 * the policy of the scene. */
static int64_t catch_up(const bgc_course *c, int64_t late, int64_t period) {
    bgc_servo *s = c->servo;
    int64_t shift = 0;

    bgc_servo_add(&s->overruns, 1);
    if (c->policy == BGC_HOLD) {
        shift = late / period * period;
        bgc_servo_add(&s->dropped, late / period);
    } else if (c->policy == BGC_SLOW) {
        shift = late;
    }
    bgc_servo_set(&s->behind,
                  atomic_load_explicit(&s->behind, memory_order_relaxed) + 1e-9 * (double)shift);
    return shift;
}

/* Counts a sample that met its deadline or missed it. 0: a burst of missed ones. */
static int count_deadline(bgc_servo *s, int is_missed) {
    bgc_servo_add(&s->missed, is_missed);
    s->misses = is_missed ? s->misses + 1.0 : fmax(0.0, s->misses - 0.1);
    return !(s->options.burst > 0.0 && s->misses > s->options.burst);
}

/* Seconds that the force needs to fall from its full size for lack of rate, beyond those of the ramp. */
static double longest_slew(const bgc_servo *s) {
    double longest = 0.0;

    for (int k = 0; k < s->ports; k++) {
        const double size = bgc_stricter(s->options.max_force, s->port[k].can.max_force);
        const double rate = bgc_rate_of(&s->options, size);
        longest = fmax(longest, rate > 0.0 ? size / rate : 0.0);
    }
    return longest > s->options.ramp ? longest - s->options.ramp + s->options.period : 0.0;
}

/* Where the force has to fall: before a normal end, and for a course that waits. */
static void plan_force(bgc_servo *s, double left) {
    const double ramp = s->options.ramp;

    s->falls = atomic_load_explicit(&s->stop_wanted, memory_order_relaxed) != 0 ||
               atomic_load_explicit(&s->pending, memory_order_acquire) != NULL;
    s->most_gain = ramp > 0.0 && left < ramp ? fmax(0.0, left / ramp) : 1.0;
}

/* The course of this sample: one that waits takes its place where no device has a force. */
static bgc_course *present_course(bgc_servo *s) {
    bgc_course *before = atomic_load_explicit(&s->course, memory_order_relaxed);
    bgc_course *pending = atomic_load_explicit(&s->pending, memory_order_acquire);

    if (pending == NULL || !bgc_servo_is_quiet(s)) {
        return before;
    }
    pending->origin = pending->model.time(pending->model.d);
    atomic_store(&s->course, pending);
    atomic_store(&before->next, pending);
    atomic_store_explicit(&before->retired, 1, memory_order_release);
    bgc_servo_add(&s->exchanges, 1);
    atomic_store_explicit(&s->pending, NULL, memory_order_release);
    return pending;
}

/* Whether the loop ends before this sample: it was asked to, and no device has a force any more. */
static int is_over(const bgc_servo *s) {
    const int wanted = atomic_load_explicit(&s->stop_wanted, memory_order_relaxed);

    return wanted > 1 || (wanted == 1 && bgc_servo_is_quiet(s));
}

/* Whether the process stood still for longer than the watchdog allows, and the watchdog with it: what the
 * model would ask for now answers a hand of long ago. */
static int has_stood(const bgc_servo *s, int64_t now) {
    const double limit = fmax(s->options.watchdog, 3.0 * s->options.period);

    return s->options.watchdog > 0.0 && bgc_servo_has_motors(s) &&
           now - atomic_load(&s->beat) > bgc_servo_ns(limit);
}

/* Before the first sample, at the instant `first`. */
static void begin(bgc_servo *s, int64_t first) {
    bgc_course *c = atomic_load(&s->course);

    c->origin = c->model.time(c->model.d);
    atomic_store(&s->beat, first);
    for (int k = 0; k < s->ports; k++) {
        s->port[k].news_at = first;
    }
    if (s->options.burst < 0.0 && bgc_servo_has_motors(s)) {
        s->options.burst = BURST_LIMIT;
    }
}

void bgc_servo_loop(bgc_servo *s) {
    const double period = s->options.period, duration = s->options.duration - longest_slew(s);
    const int64_t tick = bgc_servo_ns(period), first = bgc_servo_now(s) + tick;
    int64_t due = first, before = first - tick;
    int in_a_row = 0;

    begin(s, first);
    for (int64_t k = 0;; k++) {
        const int64_t wanted = due;
        bgc_course *c;
        int64_t begun, finished;
        int may_skip;

        /* The instant of the sample, or a later one. */
        wait_until(s, due);
        begun = bgc_servo_now(s);
        if (is_over(s)) {
            bgc_servo_finish(s, BGC_SERVO_STOPPED, due);
            return;
        }
        if (has_stood(s, begun)) {
            bgc_servo_finish(s, BGC_SERVO_STALLED, begun);
            return;
        }
        c = present_course(s);
        plan_force(s, duration - (double)k * period);
        if (begun - due >= tick && k > 0) {
            due += catch_up(c, begun - due, tick);
        }
        may_skip = c->policy == BGC_SKIP && begun - due >= tick && in_a_row < MOST_SKIPPED;
        in_a_row = may_skip ? in_a_row + 1 : 0;
        s->skipping = in_a_row > 0 && c->samples > 0;
        bgc_servo_add(&s->skipped, s->skipping);
        bgc_count_time(&s->lateness, begun - wanted);
        if (k > 0) {
            bgc_count_time(&s->jitter, llabs(begun - before - tick));
        }
        before = begun;

        /* The sample, then the model up to the next one. */
        if (!take_sample(c, c->origin + (double)c->samples * period, wanted, begun)) {
            return;
        }
        bgc_servo_announce(s, due + tick, c->origin + (double)c->samples * period);
        bgc_servo_add(&s->samples, 1);
        bgc_servo_set(&s->elapsed, 1e-9 * (double)(begun - first));
        if (((double)k + 0.5) * period >= s->options.duration) {
            bgc_servo_finish(s, BGC_SERVO_DONE, wanted);
            return;
        }
        s->status = c->model.advance(c->model.m, c->model.d, c->origin + (double)c->samples * period);
        finished = bgc_servo_now(s);
        s->last_work = finished - begun;
        bgc_count_time(&s->work, s->last_work);
        if (s->status != BGC_OK) {
            bgc_servo_finish(s, atomic_load(&s->stalled) ? BGC_SERVO_STALLED : BGC_SERVO_MODEL, wanted);
            return;
        }
        if (!count_deadline(s, finished > wanted + bgc_servo_ns(c->deadline))) {
            bgc_servo_finish(s, BGC_SERVO_LATE, wanted);
            return;
        }
        due += tick;
    }
}
