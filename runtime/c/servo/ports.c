/* ports.c: the devices of the loop, and the stand-ins through which a model reads and drives them. */
#include "servo_internal.h"

#include <stdio.h>

#define LAG_SLACK 0.5 /* samples: of two clocks */

const bgc_pose bgc_servo_resting = {.orientation = {1.0, 0.0, 0.0, 0.0}};

void bgc_servo_write_zero(bgc_servo *s) {
    static const bgc_effort none = {{0.0}, {0.0}, {0.0}};

    for (int k = 0; k < s->ports; k++) {
        bgc_port *port = &s->port[k];
        if (port->driver != NULL) {
            port->driver->write(port->handle, port->time, &none);
            port->given = none;
        }
    }
    /* All have been written before the first one is waited for. */
    for (int k = 0; k < s->ports; k++) {
        if (s->port[k].driver == &bgc_servo_remote && !bgc_remote_settle(s->port[k].handle)) {
            atomic_store(&s->unsettled, 1);
        }
    }
}

void bgc_servo_announce(bgc_servo *s, int64_t due, double time) {
    for (int k = 0; k < s->ports; k++) {
        if (s->port[k].driver == &bgc_servo_remote) {
            bgc_remote_announce(s->port[k].handle, due, time);
        }
    }
}

/* Notes the cause of the end that is under way, unless there is one. */
void bgc_servo_note(bgc_servo *s, bgc_servo_end cause, int device, const char *message) {
    if (s->cause == BGC_SERVO_RUNNING) {
        s->cause = cause;
        s->device = device;
        snprintf(s->message, sizeof s->message, "%s", message != NULL ? message : "");
    }
}

int bgc_servo_is_quiet(const bgc_servo *s) {
    double sum = atomic_load_explicit(&s->gain, memory_order_relaxed);

    for (int k = 0; k < s->ports; k++) {
        const bgc_effort *given = &s->port[k].given;
        for (int i = 0; i < 3; i++) {
            sum += fabs(given->force[i]) + fabs(given->torque[i]);
        }
        sum += fabs(given->gripper_force[0]);
    }
    return sum == 0.0;
}

int bgc_servo_has_motors(const bgc_servo *s) {
    uint32_t driven = 0;

    for (int k = 0; k < s->ports; k++) {
        driven |= s->port[k].can.driven;
    }
    return driven != 0;
}

/* --- reading ------------------------------------------------------------------------------------- */

/* The reason of a driver's last fault. */
static const char *reason_of(const bgc_port *port) {
    return port->driver->last_error != NULL ? port->driver->last_error(port->handle) : NULL;
}

/* That the driver hangs, where it runs in another process and does. */
static const char *hang_of(const bgc_servo *s, const bgc_port *port) {
    return port->driver == &bgc_servo_remote ? bgc_remote_hang(port->handle, bgc_servo_ns(s->options.period))
                                             : NULL;
}

/* Refuses a pose that is not finite, or that no hand can have: 0, with the reason noted. */
static int judge_pose(bgc_servo *s, int device, bgc_pose *found, const bgc_pose *before, int64_t now) {
    const bgc_port *port = &s->port[device];
    const bgc_ledger *l = &port->ledger;
    double elapsed = fmax(1e-9 * (double)(now - port->pose_at), s->options.period), speed;
    char why[64];

    if (!bgc_make_valid(found, before)) {
        bgc_servo_note(s, BGC_SERVO_BAD_POSE, device, NULL);
        return 0;
    }
    if (port->can.driven == 0) {
        return 1;
    }
    /* Poses that a network has held up come together: the clock of the device tells them apart. */
    elapsed = fmax(elapsed, fmin(found->stamp - l->pose.stamp, s->options.stale));
    if (!bgc_is_plausible(&s->options, &port->can, found, l->begun ? &l->pose : NULL, elapsed, &speed, why,
                          sizeof why)) {
        bgc_servo_note(s, BGC_SERVO_JUMP, device, why);
        return 0;
    }
    if (speed > bgc_servo_get(&s->fastest)) {
        bgc_servo_set(&s->fastest, speed);
    }
    return 1;
}

/* Notes the lag that a device has measured, in samples: one that answers at once holds in each pose the
 * force of the pose before. */
static void note_lag(bgc_servo *s, int device, double age) {
    const double lag = fmax(age / s->options.period - 1.0, 0.0);
    const double excess = lag - s->port[device].can.lag;

    if (!(age > 0.0)) {
        return;
    }
    if (lag > atomic_load_explicit(&s->lag, memory_order_relaxed)) {
        bgc_servo_set(&s->lag, lag);
    }
    if (excess > LAG_SLACK) {
        bgc_servo_add(&s->late_poses, 1);
        if (excess > atomic_load_explicit(&s->excess, memory_order_relaxed)) {
            bgc_servo_set(&s->excess, excess);
            atomic_store_explicit(&s->late_device, device, memory_order_relaxed);
        }
    }
}

/* bgc_driver.read of a stand-in: the pose of the real device, or the last one in a skipped sample. The first
 * sample takes the pose with which the model was started, so that a replay of the record starts alike. */
static int slot_read(void *handle, double t, bgc_pose *pose) {
    bgc_slot *slot = handle;
    bgc_servo *s = slot->course->servo;
    bgc_port *port = &s->port[slot->port];
    bgc_pose found = bgc_servo_resting;
    int64_t now;
    int answer;

    /* Before it runs, a course that another thread prepares has no driver to call. */
    slot->time = t;
    if (slot->course->samples == 0 && slot->is_read) {
        *pose = slot->pose;
        return BGC_DEVICE_FINE;
    }
    port->time = t;
    if (s->skipping) {
        *pose = slot->pose;
        return BGC_DEVICE_FINE;
    }
    memcpy(found.held_force, port->given.force, sizeof port->given.force);
    answer = port->driver->read(port->handle, t, &found);
    now = bgc_servo_now(s);
    if (bgc_is_fault(answer)) {
        bgc_servo_note(s, BGC_SERVO_LOST, slot->port, reason_of(port));
        return BGC_DEVICE_LOST;
    }
    if (!judge_pose(s, slot->port, &found, &slot->pose, now)) {
        bgc_servo_add(&s->refused, 1);
        return BGC_DEVICE_LOST;
    }

    /* Without news the last pose holds, for a time. */
    if (answer == BGC_DEVICE_NO_NEWS || (found.stamp != 0.0 && found.stamp == slot->pose.stamp)) {
        bgc_servo_add(&s->no_news, 1);
        if (s->options.stale > 0.0 && port->can.driven != 0 &&
            now - port->news_at > bgc_servo_ns(s->options.stale)) {
            bgc_servo_note(s, BGC_SERVO_STUCK, slot->port, hang_of(s, port));
            return BGC_DEVICE_LOST;
        }
    } else {
        port->news_at = port->pose_at = now;
        bgc_ledger_read(&port->ledger, &found);
    }
    note_lag(s, slot->port, found.age);
    slot->pose = *pose = found;
    slot->is_read = 1;
    return BGC_DEVICE_FINE;
}

/* --- writing ------------------------------------------------------------------------------------- */

/* The gain of the force, once a sample: it rises after a start, an exchange, and each press of the dead
 * man's button, without which it is zero at once; it falls before a normal end and an exchange. */
static void follow_ramp(const bgc_course *c) {
    bgc_servo *s = c->servo;
    const int button = s->options.dead_man;
    const double step = s->options.ramp > 0.0 ? s->options.period / s->options.ramp : 1.0;
    double gain = atomic_load_explicit(&s->gain, memory_order_relaxed);
    int is_held = button == 0;

    for (int k = 0; k < s->ports && button > 0; k++) {
        is_held |= c->slot[k].pose.buttons[button - 1] > 0.5;
    }
    if (s->falls) {
        /* Less half a step: rounding adds up over a ramp. */
        gain = gain > 1.5 * step && bgc_servo_has_motors(s) ? gain - step : 0.0;
    } else {
        gain = fmin(1.0, gain + step);
    }
    bgc_servo_set(&s->gain, is_held ? fmin(gain, s->most_gain) : 0.0);
    atomic_store_explicit(&s->released, !is_held, memory_order_relaxed);
}

/* The sums of the ledgers, for the report. */
static void note_energy(bgc_servo *s) {
    double given = 0.0, created = 0.0, taken = 0.0, owed = 0.0;

    for (int k = 0; k < s->ports; k++) {
        const bgc_ledger *l = &s->port[k].ledger;
        given += l->given;
        created += l->created;
        taken += l->taken;
        owed += bgc_ledger_due(l);
    }
    bgc_servo_set(&s->given, given);
    bgc_servo_set(&s->created, created);
    bgc_servo_set(&s->taken, taken);
    bgc_servo_set(&s->owed, owed);
}

/* bgc_driver.write of a stand-in: the limited effort to the real device. Between samples, and in a
 * skipped one, the device keeps its effort. */
static int slot_write(void *handle, double t, const bgc_effort *effort) {
    bgc_slot *slot = handle;
    bgc_servo *s = slot->course->servo;
    bgc_port *port = &s->port[slot->port];
    bgc_effort e = *effort;
    double gain, power = 0.0;
    int answer, is_free;

    (void)t;
    if (!slot->course->sampling || s->skipping || s->cause != BGC_SERVO_RUNNING) {
        return BGC_DEVICE_FINE;
    }
    if (!s->has_gain) {
        follow_ramp(slot->course);
        s->has_gain = 1;
    }
    slot->wanted = *effort;
    gain = atomic_load_explicit(&s->gain, memory_order_relaxed);

    /* Without the dead man's button the limit of the rate does not hold the force. */
    is_free = !(gain > 0.0) && atomic_load_explicit(&s->released, memory_order_relaxed);
    port->ledger.brake = slot->takes_back ? bgc_bearable_brake(&port->can, s->options.period) : 0.0;
    bgc_servo_add(&s->limited, bgc_limit_effort(&s->options, &port->can, &slot->pose, &port->given, gain,
                                                is_free, &port->ledger, &e, &power));
    note_energy(s);
    if (power > atomic_load_explicit(&s->worst_power, memory_order_relaxed)) {
        bgc_servo_set(&s->worst_power, power);
    }
    answer = port->driver->write(port->handle, port->time, &e);
    port->given = e;
    bgc_servo_add(&s->saturated, answer == BGC_DEVICE_SATURATED);
    if (bgc_is_fault(answer)) {
        bgc_servo_note(s, BGC_SERVO_LOST, slot->port, reason_of(port));
        return BGC_DEVICE_LOST;
    }
    return BGC_DEVICE_FINE;
}

/* --- the stand-in -------------------------------------------------------------------------------- */

/* bgc_driver.open of a stand-in: `options` is the address of its slot. */
static void *slot_open(const char *options, char *message, size_t size) {
    (void)message, (void)size;
    return (void *)(uintptr_t)options;
}

static void slot_close(void *handle) { (void)handle; }

/* Why the loop ends; before it begins, why the start of the model fails. */
static const char *slot_error(void *handle) { return ((const bgc_slot *)handle)->course->servo->message; }

const bgc_driver bgc_servo_stand_in = {
    .abi = BGC_DEVICE_ABI,
    .name = "servo",
    .open = slot_open,
    .read = slot_read,
    .write = slot_write,
    .close = slot_close,
    .last_error = slot_error,
};
