/* ends.c: what ends the loop: a fault that it meets itself, and the watchdog beside it. */
#include "servo_internal.h"

/* Takes the drivers; 0 where another thread has them. */
int bgc_servo_claim(bgc_servo *s, int owner) {
    int nobody = BGC_NOBODY;

    return atomic_compare_exchange_strong(&s->owner, &nobody, owner);
}

/* Ends the loop: zero force, then the cause for all to read. `due` is the instant of the sample. */
void bgc_servo_finish(bgc_servo *s, bgc_servo_end cause, int64_t due) {
    bgc_servo_note(s, cause, -1, NULL);
    if (atomic_load(&s->owner) == BGC_LOOP || bgc_servo_claim(s, BGC_LOOP)) {
        bgc_servo_write_zero(s);
        if (!atomic_load(&s->unsettled)) {
            bgc_servo_set(&s->zero_after, 1e-9 * (double)(bgc_servo_now(s) - due));
        }
        atomic_store(&s->owner, BGC_NOBODY);
    }
    bgc_servo_set(&s->gain, 0.0);
    atomic_store_explicit(&s->ended, s->cause, memory_order_release);
}

void bgc_servo_watch(bgc_servo *s) {
    const double limit = fmax(s->options.watchdog, 3.0 * s->options.period);
    const int64_t beat = atomic_load(&s->beat);
    const bgc_course *course;

    if (!(s->options.watchdog > 0.0) || beat == 0 || atomic_load(&s->ended) != BGC_SERVO_RUNNING ||
        atomic_load(&s->stalled) || bgc_servo_now(s) - beat <= bgc_servo_ns(limit)) {
        return;
    }

    /* Zero force, unless the loop is inside a call of a driver, which no other thread may enter. */
    if (bgc_servo_claim(s, BGC_WATCHDOG)) {
        bgc_servo_write_zero(s);
        bgc_servo_set(&s->zero_after, 1e-9 * (double)(bgc_servo_now(s) - beat) - limit);
    } else {
        atomic_store(&s->in_driver, 1);
    }
    atomic_store(&s->stalled, 1);
    course = atomic_load(&s->course);
    course->model.stop(course->model.d);
}
