/* servo.c: the loop, sample by sample, and what ends it. See servo.h; the threads are in threads.c. */
#include "servo_internal.h"

#include <errno.h>
#include <stdio.h>

enum { MOST_BLIND = 100 };  /* samples in a row without the devices, under BGC_SKIP */
enum { BURST_LIMIT = 100 }; /* missed deadlines, where a device has motors */

static const bgc_pose resting = {.orientation = {1.0, 0.0, 0.0, 0.0}};

static int64_t to_ns(double seconds) { return (int64_t)(1e9 * seconds + 0.5); }

static int64_t now_of(const bgc_servo *s) { return s->clock.now(s->clock.of); }

static void add(atomic_int_fast64_t *counter, int64_t n) {
    atomic_fetch_add_explicit(counter, n, memory_order_relaxed);
}

static void set(atomic_double *value, double to) {
    atomic_store_explicit(value, to, memory_order_relaxed);
}

/* --- ends ---------------------------------------------------------------------------------------- */

/* Zero force to all devices, by the owner of the drivers. */
static void write_zero(bgc_servo *s) {
    static const bgc_effort none = {{0.0}, {0.0}, {0.0}};

    for (int k = 0; k < s->model.m->n_device; k++) {
        bgc_slot *slot = &s->slot[k];
        if (slot->driver != NULL) {
            slot->driver->write(slot->handle, slot->time, &none);
            slot->given = none;
        }
    }
}

/* Takes the drivers; 0 where the watchdog has them. */
static int claim(bgc_servo *s, int owner) {
    int nobody = BGC_NOBODY;

    return atomic_compare_exchange_strong(&s->owner, &nobody, owner);
}

/* Notes the cause of the end that is under way, unless there is one. */
static void note(bgc_servo *s, bgc_servo_end cause, int device, const char *message) {
    if (s->cause == BGC_SERVO_RUNNING) {
        s->cause = cause;
        s->device = device;
        snprintf(s->message, sizeof s->message, "%s", message != NULL ? message : "");
    }
}

/* Ends the loop: zero force, then the cause for all to read. `due` is the instant of the sample. */
static void end_loop(bgc_servo *s, bgc_servo_end cause, int64_t due) {
    note(s, cause, -1, NULL);
    if (atomic_load(&s->owner) == BGC_LOOP || claim(s, BGC_LOOP)) {
        write_zero(s);
        set(&s->zero_after, 1e-9 * (double)(now_of(s) - due));
        atomic_store(&s->owner, BGC_NOBODY);
    }
    set(&s->gain, 0.0);
    atomic_store_explicit(&s->ended, s->cause, memory_order_release);
}

/* --- the stand-ins of the devices ---------------------------------------------------------------- */

/* The reason of a driver's last fault. */
static const char *reason_of(const bgc_slot *slot) {
    return slot->driver->last_error != NULL ? slot->driver->last_error(slot->handle) : NULL;
}

static int is_answer(int answer) {
    return answer == BGC_DEVICE_FINE || answer == BGC_DEVICE_SATURATED ||
           answer == BGC_DEVICE_NO_NEWS;
}

/* Whether all numbers of a pose are finite; its quaternion becomes a unit one, of the two the one nearer to
 * that before. */
static int make_valid(bgc_pose *pose, const bgc_pose *before) {
    double values[BGC_POSE_SIZE], length = 0.0, sum = 0.0, dot = 0.0;

    memcpy(values, pose, sizeof values);
    for (int k = 0; k < BGC_POSE_SIZE; k++) {
        sum += 0.0 * values[k];
    }
    for (int k = 0; k < 4; k++) {
        length += pose->orientation[k] * pose->orientation[k];
        dot += pose->orientation[k] * before->orientation[k];
    }
    if (sum != 0.0 || !(length > 0.0) || !isfinite(length)) {
        return 0;
    }
    length = sqrt(length);
    length = fabs(length - 1.0) > 1e-12 ? length : 1.0;
    for (int k = 0; k < 4; k++) {
        pose->orientation[k] /= dot < 0.0 ? -length : length;
    }
    return 1;
}

/* bgc_driver.read of a stand-in: the pose of the real device, or the last one in a blind sample. The first
 * sample takes the pose with which the model was started, so that a replay of the record starts alike. */
static int slot_read(void *handle, double t, bgc_pose *pose) {
    bgc_slot *slot = handle;
    bgc_servo *s = slot->servo;
    const int64_t now = now_of(s);
    bgc_pose found = resting;
    int answer;

    slot->time = t;
    if (s->blind || (s->first && slot->is_read)) {
        *pose = slot->pose;
        return BGC_DEVICE_FINE;
    }
    answer = slot->driver->read(slot->handle, t, &found);
    if (!is_answer(answer)) {
        note(s, BGC_SERVO_LOST, slot->k, reason_of(slot));
        return BGC_DEVICE_LOST;
    }
    if (!make_valid(&found, &slot->pose)) {
        note(s, BGC_SERVO_BAD_POSE, slot->k, NULL);
        return BGC_DEVICE_LOST;
    }

    /* Without news the last pose holds, for a time. */
    if (answer == BGC_DEVICE_NO_NEWS || (found.stamp != 0.0 && found.stamp == slot->pose.stamp)) {
        add(&s->no_news, 1);
        if (s->options.stale > 0.0 && slot->can.driven != 0 && now - slot->news_at > to_ns(s->options.stale)) {
            note(s, BGC_SERVO_STUCK, slot->k, NULL);
            return BGC_DEVICE_LOST;
        }
    } else {
        slot->news_at = now;
    }
    slot->pose = *pose = found;
    slot->is_read = 1;
    return BGC_DEVICE_FINE;
}

/* The gain of the force, once a sample: it rises after a start, and after each press of the dead man's
 * button; without that it is zero at once. */
static void follow_ramp(bgc_servo *s) {
    const int button = s->options.dead_man;
    double gain = atomic_load_explicit(&s->gain, memory_order_relaxed);
    int is_held = button == 0;

    for (int k = 0; k < s->model.m->n_device && button > 0; k++) {
        is_held |= s->slot[k].pose.buttons[button - 1] > 0.5;
    }
    gain = s->options.ramp > 0.0 ? fmin(1.0, gain + s->options.period / s->options.ramp) : 1.0;
    set(&s->gain, is_held ? gain : 0.0);
    atomic_store_explicit(&s->released, !is_held, memory_order_relaxed);
}

/* bgc_driver.write of a stand-in: the limited effort to the real device. Between samples, and in a blind
 * one, the device keeps what it has. */
static int slot_write(void *handle, double t, const bgc_effort *effort) {
    bgc_slot *slot = handle;
    bgc_servo *s = slot->servo;
    bgc_effort e = *effort;
    double gain, power = 0.0;
    int answer;

    (void)t;
    if (!s->sampling || s->blind || s->cause != BGC_SERVO_RUNNING) {
        return BGC_DEVICE_FINE;
    }
    if (slot->k == 0) {
        follow_ramp(s);
    }
    slot->wanted = *effort;
    gain = atomic_load_explicit(&s->gain, memory_order_relaxed);
    if (gain > 0.0) {
        add(&s->limited, bgc_limit_effort(&s->options, &slot->can, &slot->pose, &slot->given, gain,
                                          &e, &power));
    } else {
        memset(&e, 0, sizeof e);
    }
    if (power > atomic_load_explicit(&s->worst_power, memory_order_relaxed)) {
        set(&s->worst_power, power);
    }
    answer = slot->driver->write(slot->handle, slot->time, &e);
    slot->given = e;
    add(&s->saturated, answer == BGC_DEVICE_SATURATED);
    if (!is_answer(answer)) {
        note(s, BGC_SERVO_LOST, slot->k, reason_of(slot));
        return BGC_DEVICE_LOST;
    }
    return BGC_DEVICE_FINE;
}

/* bgc_driver.open of a stand-in: `options` is the address of its slot. */
static void *slot_open(const char *options, char *message, size_t size) {
    (void)message, (void)size;
    return (void *)(uintptr_t)options;
}

static void slot_close(void *handle) { (void)handle; }

static const bgc_driver stand_in = {
    .abi = BGC_DEVICE_ABI,
    .name = "servo",
    .open = slot_open,
    .read = slot_read,
    .write = slot_write,
    .close = slot_close,
};

/* --- a sample ------------------------------------------------------------------------------------ */

/* Sleeps to shortly before an instant, then spins. */
static void wait_until(bgc_servo *s, int64_t due) {
    const int64_t spin = to_ns(fmin(s->options.spin, 0.4 * s->options.period));

    if (now_of(s) < due - spin) {
        s->clock.sleep(s->clock.of, due - spin);
    }
    while (now_of(s) < due) {
    }
}

/* The record of a sample, where the ring has room. */
static void record(bgc_servo *s, double t, int64_t lateness) {
    const int devices = s->model.m->n_device;
    double *to = bgc_next_record(&s->ring);

    if (to == NULL) {
        return;
    }
    *to++ = devices > 0 ? s->slot[0].time : t;
    *to++ = 1e-9 * (double)lateness;
    *to++ = 1e-9 * (double)s->last_work;
    for (int k = 0; k < devices; k++) {
        const bgc_slot *slot = &s->slot[k];
        memcpy(to, &slot->pose, BGC_POSE_SIZE * sizeof *to);
        memcpy(to + BGC_POSE_SIZE, &slot->wanted, BGC_EFFORT_SIZE * sizeof *to);
        memcpy(to + BGC_POSE_SIZE + BGC_EFFORT_SIZE, &slot->given, BGC_EFFORT_SIZE * sizeof *to);
        to += BGC_POSE_SIZE + 2 * BGC_EFFORT_SIZE;
    }
    memcpy(to, s->row, (size_t)s->width * sizeof *to);
    bgc_publish(&s->ring);
}

/* Reads the devices, writes to them, and takes the model's row at t. 0: the loop has ended. */
static int take_sample(bgc_servo *s, double t, int64_t due, int64_t begun) {
    size_t done;

    if (!claim(s, BGC_LOOP)) {
        end_loop(s, BGC_SERVO_STALLED, due);
        return 0;
    }
    atomic_store(&s->beat, begun);
    s->sampling = 1;
    s->status = s->model.run(s->model.m, s->model.d, &t, 1, s->row, &done);
    s->sampling = 0;
    if (atomic_load(&s->stalled)) {
        note(s, BGC_SERVO_STALLED, -1, NULL);
    }
    if (s->status != BGC_OK || s->cause != BGC_SERVO_RUNNING) {
        end_loop(s, BGC_SERVO_MODEL, due);
        return 0;
    }
    atomic_store(&s->owner, BGC_NOBODY);
    record(s, t, begun - due);
    set(&s->time, t);
    return 1;
}

/* Periods of the clock that the grid moves on by where the loop is late by `late` ns, at least a period:
 * the policy of the scene. */
static int64_t catch_up(bgc_servo *s, int64_t late, int64_t period) {
    int64_t shift = 0;

    add(&s->overruns, 1);
    if (s->options.policy == BGC_HOLD) {
        shift = late / period * period;
        add(&s->dropped, late / period);
    } else if (s->options.policy == BGC_SLOW) {
        shift = late;
    }
    set(&s->behind, atomic_load_explicit(&s->behind, memory_order_relaxed) + 1e-9 * (double)shift);
    return shift;
}

/* Counts a sample that met its deadline or missed it. 0: a burst of missed ones. */
static int count_deadline(bgc_servo *s, int is_missed) {
    add(&s->missed, is_missed);
    s->misses = is_missed ? s->misses + 1.0 : fmax(0.0, s->misses - 0.1);
    return !(s->options.burst > 0.0 && s->misses > s->options.burst);
}

void bgc_servo_loop(bgc_servo *s) {
    const double origin = s->model.time(s->model.d), period = s->options.period;
    const int64_t tick = to_ns(period), first = now_of(s) + tick;
    const int64_t deadline = to_ns(s->options.deadline > 0.0 ? s->options.deadline : period);
    int64_t due = first, before = first - tick;
    int blind = 0;

    atomic_store(&s->beat, first);
    for (int k = 0; k < s->model.m->n_device; k++) {
        s->slot[k].news_at = first;
        if (s->options.burst < 0.0 && s->slot[k].can.driven != 0) {
            s->options.burst = BURST_LIMIT;
        }
    }
    for (int64_t k = 0;; k++) {
        const double t = origin + (double)k * period;
        const int64_t wanted = due;
        int64_t begun, finished;

        /* The instant of the sample, or a later one. */
        wait_until(s, due);
        begun = now_of(s);
        if (atomic_load_explicit(&s->stop_wanted, memory_order_relaxed)) {
            end_loop(s, BGC_SERVO_STOPPED, due);
            return;
        }
        if (begun - due >= tick && k > 0) {
            due += catch_up(s, begun - due, tick);
        }
        blind = s->options.policy == BGC_SKIP && begun - due >= tick && blind < MOST_BLIND
                    ? blind + 1
                    : 0;
        s->blind = blind > 0 && k > 0;
        s->first = k == 0;
        add(&s->skipped, s->blind);
        bgc_count_time(&s->lateness, begun - wanted);
        if (k > 0) {
            bgc_count_time(&s->jitter, llabs(begun - before - tick));
        }
        before = begun;

        /* The sample, then the model up to the next one. */
        if (!take_sample(s, t, wanted, begun)) {
            return;
        }
        add(&s->samples, 1);
        set(&s->elapsed, 1e-9 * (double)(begun - first));
        if (t + 0.5 * period >= origin + s->options.duration) {
            end_loop(s, BGC_SERVO_DONE, wanted);
            return;
        }
        s->status = s->model.advance(s->model.m, s->model.d, origin + (double)(k + 1) * period);
        finished = now_of(s);
        s->last_work = finished - begun;
        bgc_count_time(&s->work, s->last_work);
        if (s->status != BGC_OK) {
            end_loop(s, atomic_load(&s->stalled) ? BGC_SERVO_STALLED : BGC_SERVO_MODEL, wanted);
            return;
        }
        if (!count_deadline(s, finished > wanted + deadline)) {
            end_loop(s, BGC_SERVO_LATE, wanted);
            return;
        }
        due += tick;
    }
}

void bgc_servo_watch(bgc_servo *s) {
    const double limit = fmax(s->options.watchdog, 3.0 * s->options.period);
    const int64_t beat = atomic_load(&s->beat);
    int free = BGC_NOBODY;

    if (!(s->options.watchdog > 0.0) || beat == 0 || atomic_load(&s->ended) != BGC_SERVO_RUNNING ||
        atomic_load(&s->stalled) || now_of(s) - beat <= to_ns(limit)) {
        return;
    }

    /* Zero force, unless the loop is inside a call of a driver, which no other thread may enter. */
    if (atomic_compare_exchange_strong(&s->owner, &free, BGC_WATCHDOG)) {
        write_zero(s);
        set(&s->zero_after, 1e-9 * (double)(now_of(s) - beat) - limit);
    } else {
        atomic_store(&s->in_driver, 1);
    }
    atomic_store(&s->stalled, 1);
    s->model.stop(s->model.d);
}

/* --- an instance --------------------------------------------------------------------------------- */

uint32_t bgc_servo_version(void) { return BGC_SERVO_ABI; }

bgc_servo_options bgc_servo_defaults(void) {
    return (bgc_servo_options){.period = 1e-3,
                               .duration = INFINITY,
                               .realtime = 1,
                               .spin = 150e-6,
                               .ramp = 0.5,
                               .stale = 0.1,
                               .watchdog = 0.1,
                               .records = 16384};
}

bgc_servo *bgc_servo_new(const bgc_servo_model *model, const bgc_servo_options *options, int width,
                         const bgc_servo_clock *clock) {
    const int devices = model->m->n_device;
    bgc_servo *s = calloc(1, sizeof *s);

    if (s == NULL) {
        return NULL;
    }
    s->model = *model;
    s->options = *options;
    s->width = width;
    s->clock = clock != NULL ? *clock : bgc_system_clock;
    s->device = -1;
    set(&s->zero_after, -1.0);
    s->slot = calloc((size_t)devices + 1, sizeof *s->slot);
    s->row = calloc((size_t)width + 1, sizeof *s->row);
    if (s->slot == NULL || s->row == NULL ||
        !bgc_make_ring(&s->ring, (size_t)bgc_servo_record_size(s), (size_t)options->records)) {
        bgc_servo_free(s);
        return NULL;
    }
    for (int k = 0; k < devices; k++) {
        s->slot[k] = (bgc_slot){.servo = s, .k = k, .pose = resting};
    }
    return s;
}

bgc_status bgc_servo_open(bgc_servo *s, int k, const bgc_driver *driver, const char *options,
                          char *message, size_t size) {
    bgc_slot *slot = &s->slot[k];

    message[0] = '\0';
    slot->handle = driver->open(options, message, size);
    if (slot->handle == NULL) {
        return BGC_DEVICE;
    }
    slot->driver = driver;
    slot->can = (bgc_capabilities){.sensed = BGC_EVERY_AXIS, .driven = BGC_EVERY_AXIS};
    if (driver->capabilities != NULL) {
        memset(&slot->can, 0, sizeof slot->can);
        driver->capabilities(slot->handle, &slot->can);
    }
    return s->model.open_device(s->model.m, s->model.d, k, &stand_in, (const char *)slot, message,
                                size);
}

const bgc_capabilities *bgc_servo_capabilities(const bgc_servo *s, int k) {
    return &s->slot[k].can;
}

void *bgc_servo_handle(const bgc_servo *s, int k) { return s->slot[k].handle; }

void bgc_servo_stop(bgc_servo *s) { atomic_store(&s->stop_wanted, 1); }

int bgc_servo_record_size(const bgc_servo *s) {
    return BGC_RECORD_HEAD + s->model.m->n_device * (BGC_POSE_SIZE + 2 * BGC_EFFORT_SIZE) + s->width;
}

size_t bgc_servo_take(bgc_servo *s, double *to, size_t n) {
    return bgc_take_records(&s->ring, to, n);
}

void bgc_servo_get_report(const bgc_servo *s, bgc_servo_report *r) {
    memset(r, 0, sizeof *r);
    r->end = atomic_load_explicit(&s->ended, memory_order_acquire);
    r->device = -1;
    if (r->end != BGC_SERVO_RUNNING) {
        r->status = (int)s->status;
        r->device = s->device;
        memcpy(r->message, s->message, sizeof r->message);
    }
    r->fifo = atomic_load(&s->fifo);
    r->locked = atomic_load(&s->locked);
    r->samples = atomic_load(&s->samples);
    r->missed = atomic_load(&s->missed);
    r->overruns = atomic_load(&s->overruns);
    r->dropped = atomic_load(&s->dropped);
    r->skipped = atomic_load(&s->skipped);
    r->saturated = atomic_load(&s->saturated);
    r->limited = atomic_load(&s->limited);
    r->no_news = atomic_load(&s->no_news);
    r->lost_records = atomic_load(&s->ring.lost);
    r->time = atomic_load(&s->time);
    r->elapsed = atomic_load(&s->elapsed);
    r->behind = atomic_load(&s->behind);
    r->gain = atomic_load(&s->gain);
    r->worst_power = atomic_load(&s->worst_power);
    r->zero_after = atomic_load(&s->zero_after);
    r->released = atomic_load(&s->released);
    r->in_driver = atomic_load(&s->in_driver);
    r->lateness = bgc_times_of(&s->lateness);
    r->jitter = bgc_times_of(&s->jitter);
    r->work = bgc_times_of(&s->work);
}

void bgc_servo_free(bgc_servo *s) {
    for (int k = 0; s->slot != NULL && k < s->model.m->n_device; k++) {
        bgc_slot *slot = &s->slot[k];
        static const bgc_effort none = {{0.0}, {0.0}, {0.0}};
        if (slot->driver != NULL) {
            slot->driver->write(slot->handle, slot->time, &none);
            slot->driver->close(slot->handle);
        }
    }
    if (s->slot != NULL) {
        s->model.close_devices(s->model.m, s->model.d);
    }
    free(s->slot);
    free(s->row);
    free(s->ring.memory);
    free(s);
}
