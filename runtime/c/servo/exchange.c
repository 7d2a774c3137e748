/* exchange.c: the models of the loop: made, started by another thread, and handed to the loop. */
#include "servo_internal.h"

bgc_course *bgc_servo_make_course(bgc_servo *s, const bgc_servo_model *model,
                                  const bgc_servo_options *options, int width) {
    const int head = BGC_RECORD_HEAD + s->ports * (BGC_POSE_SIZE + 2 * BGC_EFFORT_SIZE);
    bgc_course *c = calloc(1, sizeof *c);

    if (c == NULL) {
        return NULL;
    }
    c->servo = s;
    c->model = *model;
    c->deadline = options->deadline > 0.0 ? options->deadline : s->options.period;
    c->policy = options->policy;
    c->width = width;
    c->slot = calloc((size_t)s->ports + 1, sizeof *c->slot);
    c->row = calloc((size_t)width + 1, sizeof *c->row);
    if (c->slot == NULL || c->row == NULL ||
        !bgc_make_ring(&c->ring, (size_t)(head + width), (size_t)options->records)) {
        bgc_servo_free_course(c);
        return NULL;
    }
    for (int k = 0; k < s->ports; k++) {
        c->slot[k] = (bgc_slot){.course = c, .port = k, .pose = bgc_servo_resting};
    }
    return c;
}

bgc_status bgc_servo_attach(bgc_course *c, int device, int port, char *message, size_t size) {
    return c->model.open_device(c->model.m, c->model.d, device, &bgc_servo_stand_in,
                                (const char *)&c->slot[port], message, size);
}

void bgc_servo_seed_course(bgc_course *c, const double *pose) {
    for (int k = 0; k < c->servo->ports; k++) {
        memcpy(&c->slot[k].pose, pose + k * BGC_POSE_SIZE, sizeof c->slot[k].pose);
        c->slot[k].is_read = 1;
    }
}

void bgc_servo_free_course(bgc_course *c) {
    c->model.close_devices(c->model.m, c->model.d);
    free(c->slot);
    free(c->row);
    free(c->ring.memory);
    free(c);
}

bgc_course *bgc_servo_prepare(bgc_servo *s, const bgc_servo_model *model, const bgc_servo_options *options,
                              int width, const int *port, const double *pose) {
    bgc_course *c = bgc_servo_make_course(s, model, options, width);
    char message[64];

    if (c == NULL) {
        return NULL;
    }
    bgc_servo_seed_course(c, pose);
    for (int k = 0; k < model->m->n_device; k++) {
        bgc_servo_attach(c, k, port[k], message, sizeof message);
    }
    c->older = s->courses;
    s->courses = c;
    return c;
}

int bgc_servo_post(bgc_servo *s, bgc_course *course) {
    bgc_course *none = NULL;

    return atomic_load(&s->ended) == BGC_SERVO_RUNNING &&
           atomic_compare_exchange_strong(&s->pending, &none, course);
}

void bgc_servo_drop(bgc_servo *s, bgc_course *course) {
    bgc_course **link = &s->courses;

    while (*link != course) {
        link = &(*link)->older;
    }
    *link = course->older;
    bgc_servo_free_course(course);
}

/* --- records ------------------------------------------------------------------------------------- */

int bgc_servo_record_size(const bgc_servo *s) { return (int)s->reading->ring.width; }

size_t bgc_servo_take(bgc_servo *s, double *to, size_t n) {
    return bgc_take_records(&s->reading->ring, to, n);
}

int bgc_servo_retired(const bgc_servo *s) {
    return atomic_load_explicit(&s->reading->retired, memory_order_acquire);
}

void bgc_servo_next(bgc_servo *s) {
    bgc_course *read = s->reading;

    s->reading = atomic_load(&read->next);
    free(read->ring.memory); /* the loop has left it */
    read->ring.memory = NULL;
}
