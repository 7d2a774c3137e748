/* servo.c: an instance of the loop: made, asked and freed. See servo.h. */
#include "servo_internal.h"

uint32_t bgc_servo_version(void) { return BGC_SERVO_ABI; }

bgc_servo_options bgc_servo_defaults(void) {
    return (bgc_servo_options){.period = 1e-3,
                               .duration = INFINITY,
                               .realtime = 1,
                               .spin = 150e-6,
                               .max_force_rate = -1.0,
                               .ramp = 0.5,
                               .stale = 0.1,
                               .watchdog = 0.1,
                               .max_speed = 5.0,
                               .max_turn_rate = 60.0,
                               .workspace_margin = 0.1,
                               .records = 16384};
}

bgc_servo *bgc_servo_new(const bgc_servo_model *model, const bgc_servo_options *options, int width,
                         const bgc_servo_clock *clock) {
    bgc_servo *s = calloc(1, sizeof *s);

    if (s == NULL) {
        return NULL;
    }
    s->options = *options;
    s->clock = clock != NULL ? *clock : bgc_system_clock;
    s->device = -1;
    s->ports = model->m->n_device;
    bgc_servo_set(&s->zero_after, -1.0);
    bgc_servo_set(&s->lag, -1.0);
    atomic_store(&s->late_device, -1);
    s->port = calloc((size_t)s->ports + 1, sizeof *s->port);
    s->courses = s->port != NULL ? bgc_servo_make_course(s, model, options, width) : NULL;
    if (s->courses == NULL) {
        bgc_servo_free(s);
        return NULL;
    }
    s->reading = s->courses;
    atomic_store(&s->course, s->courses);
    return s;
}

bgc_status bgc_servo_open(bgc_servo *s, int k, const bgc_driver *driver, const char *options,
                          char *message, size_t size) {
    bgc_port *port = &s->port[k];

    message[0] = '\0';
    port->handle = driver->open(options, message, size);
    if (port->handle == NULL) {
        return BGC_DEVICE;
    }
    port->driver = driver;
    port->news_at = INT64_MAX; /* until the loop begins, which waits for news from then on */
    port->can = (bgc_capabilities){.sensed = BGC_EVERY_AXIS, .driven = BGC_EVERY_AXIS};
    if (driver->capabilities != NULL) {
        memset(&port->can, 0, sizeof port->can);
        driver->capabilities(port->handle, &port->can);
    }
    port->ledger.resolution = port->can.resolution;
    return bgc_servo_attach(atomic_load(&s->course), k, k, message, size);
}

void bgc_servo_seed(bgc_servo *s, const double *pose) {
    bgc_servo_seed_course(atomic_load(&s->course), pose);
}

void bgc_servo_take_back(bgc_servo *s, bgc_course *course, int k) {
    (course != NULL ? course : atomic_load(&s->course))->slot[k].takes_back = 1;
}

const bgc_capabilities *bgc_servo_capabilities(const bgc_servo *s, int k) {
    return &s->port[k].can;
}

void *bgc_servo_handle(const bgc_servo *s, int k) { return s->port[k].handle; }

void bgc_servo_stop(bgc_servo *s, int at_once) {
    if (at_once) {
        atomic_store(&s->stop_wanted, 2);
    } else {
        int running = 0;
        atomic_compare_exchange_strong(&s->stop_wanted, &running, 1);
    }
}

int bgc_servo_histogram(const bgc_servo *s, int which, double *end, int64_t *count) {
    const bgc_histogram *h = which == 0 ? &s->lateness : which == 1 ? &s->jitter : &s->work;

    for (int k = 0; k < BGC_CLASSES && end != NULL; k++) {
        end[k] = 1e-9 * bgc_class_end(k);
        count[k] = atomic_load_explicit(&h->count[k], memory_order_relaxed);
    }
    return BGC_CLASSES;
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
    r->lost_records = atomic_load(&s->lost_records);
    r->exchanges = atomic_load(&s->exchanges);
    r->late_poses = atomic_load(&s->late_poses);
    r->refused = atomic_load(&s->refused);
    r->late_device = atomic_load(&s->late_device);
    r->lag = atomic_load(&s->lag);
    r->time = atomic_load(&s->time);
    r->elapsed = atomic_load(&s->elapsed);
    r->behind = atomic_load(&s->behind);
    r->gain = atomic_load(&s->gain);
    r->worst_power = atomic_load(&s->worst_power);
    r->zero_after = atomic_load(&s->zero_after);
    r->fastest = atomic_load(&s->fastest);
    r->given = atomic_load(&s->given);
    r->created = atomic_load(&s->created);
    r->taken = atomic_load(&s->taken);
    r->owed = atomic_load(&s->owed);
    r->released = atomic_load(&s->released);
    r->unsettled = atomic_load(&s->unsettled);
    r->in_driver = atomic_load(&s->in_driver);
    r->lateness = bgc_times_of(&s->lateness);
    r->jitter = bgc_times_of(&s->jitter);
    r->work = bgc_times_of(&s->work);
}

void bgc_servo_free(bgc_servo *s) {
    if (s->port != NULL) {
        bgc_servo_write_zero(s);
    }
    for (int k = 0; s->port != NULL && k < s->ports; k++) {
        if (s->port[k].driver != NULL) {
            s->port[k].driver->close(s->port[k].handle);
        }
    }
    for (bgc_course *c = s->courses, *older; c != NULL; c = older) {
        older = c->older;
        bgc_servo_free_course(c);
    }
    free(s->port);
    free(s);
}
