/* web.c: a model in a page: the functions that a WebAssembly module of it exports.
 *
 * The host (client/src/run.js) writes texts and numbers to memory that it has taken with `allocate`.
 * There is one instance. A run begins with begin(), then open() for each device, then start(); a slider is
 * change(), and take_back() where the run cannot go on with the value. Rows come from run().
 *
 * A device has the driver of the scene until the page takes it with hand(): then it has `pointer`.
 */
#include "bgc_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define EXPORTED(name) __attribute__((export_name(name)))

static struct {
    const bgc_model *m;
    bgc_data *d;
    unsigned char *saved;  /* the instance before a change */
    double *state, *input; /* at the time of a change */
    size_t done;
    char message[300];
    char *name, *text;     /* of the file that has been handed over */
} page;

/* --- files that the page has handed over ------------------------------------------------------- */

/* Hands over the text of a file, for the driver that is opened next. Both stay the caller's. */
EXPORTED("give") void page_give(char *name, char *text) {
    page.name = name;
    page.text = text;
}

const char *bgc_given_text(const char *name) {
    return page.name != NULL && strcmp(page.name, name) == 0 ? page.text : NULL;
}

/* --- a run ------------------------------------------------------------------------------------- */

EXPORTED("allocate") void *page_allocate(size_t size) { return calloc(size + 1, 1); }
EXPORTED("release") void page_release(void *memory) { free(memory); }

static void page_end(void) {
    bgc_free(page.m, page.d);
    free(page.saved);
    free(page.state);
    free(page.input);
    page.d = NULL;
    page.saved = NULL;
    page.state = page.input = NULL;
}

/* Makes an instance with the method of this name; the compiler defines BGC_OPTIONS, which takes each option
 * from its place among the numbers. */
EXPORTED("begin") int page_begin(const char *method, const double *number) {
    const bgc_options options = {.name = method, BGC_OPTIONS(number)};

    page_end();
    page.m = bgc_get_model();
    page.d = bgc_new(page.m);
    page.saved = calloc(bgc_save_size(page.m) + 1, 1);
    page.state = calloc((size_t)page.m->n_state + 1, sizeof(double));
    page.input = calloc((size_t)page.m->n_input + 1, sizeof(double));
    if (page.d == NULL || page.saved == NULL || page.state == NULL || page.input == NULL) {
        page_end();
        return BGC_NO_MEMORY;
    }
    return bgc_set_options(page.m, page.d, &options);
}

EXPORTED("set") void page_set(int k, double value) { bgc_set_param(page.m, page.d, k, value); }
EXPORTED("get") double page_get(int k) { return bgc_get_param(page.m, page.d, k); }

/* Opens device k with the driver of this name; message() has the reason where that fails. */
EXPORTED("open") int page_open(int k, const char *driver, const char *options) {
    return bgc_open_device(page.m, page.d, k, bgc_find_driver(driver), options, page.message,
                           sizeof page.message);
}

EXPORTED("message") const char *page_message(void) { return page.message; }

/* Takes the initial state; or `state` and held values, for which the first `count` parameters of `index` have other values. */
EXPORTED("start") int page_start(const double *state, int count, const int *index, const double *value) {
    bgc_status status;

    for (int k = 0; k < count; k++) {
        bgc_set_param(page.m, page.d, index[k], value[k]);
    }
    if (state == NULL) {
        return bgc_reset(page.m, page.d, 0.0);
    }
    status = bgc_reset_unchecked(page.m, page.d, 0.0);
    return status == BGC_OK ? bgc_restart_at(page.m, page.d, state) : status;
}

/* Integrates to n times and writes their rows; done() is their number. */
EXPORTED("run") int page_run(const double *times, size_t n, double *rows) {
    return bgc_run(page.m, page.d, times, n, rows, &page.done);
}

EXPORTED("done") size_t page_done(void) { return page.done; }
EXPORTED("now") double page_now(void) { return bgc_time(page.d); }
EXPORTED("states") int page_states(void) { return page.m->n_state; }
EXPORTED("inputs") int page_inputs(void) { return page.m->n_input; }
EXPORTED("input") const double *page_input(void) { return bgc_input(page.d); }

/* The state at a time within the last step; that at its end where the dense output has none. Returns the time. */
static double page_take_state(double time) {
    if (bgc_state_at(page.m, page.d, time, page.state) == BGC_OK &&
        bgc_first_bad(page.m->n_state, page.state) < 0) {
        return time;
    }
    memcpy(page.state, bgc_state(page.d), (size_t)page.m->n_state * sizeof(double));
    return bgc_time(page.d);
}

EXPORTED("state_at") const double *page_state_at(double time) {
    (void)page_take_state(time);
    return page.state;
}

/* Sets parameter k in the middle of a run, at a time within the last step; the state stays. */
EXPORTED("change") int page_change(int k, double value, double time) {
    const bgc_model *m = page.m;
    bgc_data *d = page.d;
    bgc_status status;

    bgc_save(m, d, page.saved);
    time = page_take_state(time);
    memcpy(page.input, bgc_input(d), (size_t)m->n_input * sizeof(double));
    bgc_set_param(m, d, k, value);
    status = bgc_reset_unchecked(m, d, time);
    if (status == BGC_OK) {
        memcpy(bgc_state(d), page.state, (size_t)m->n_state * sizeof(double));
        memcpy(bgc_input(d), page.input, (size_t)m->n_input * sizeof(double));
        status = bgc_restart(m, d);
    }
    return status;
}

/* Returns to the instance before the last change. */
EXPORTED("take_back") void page_take_back(void) { bgc_restore(page.m, page.d, page.saved); }

/* Gives device k, whose driver is `pointer`, a pose: position, orientation, gripper, 8 buttons. */
EXPORTED("hand") void page_hand(int k, const double *number) {
    bgc_pose pose = {
        .velocity = {(double)NAN}, .angular_velocity = {(double)NAN}, .held_force = {(double)NAN}};

    memcpy(pose.position, number, sizeof pose.position);
    memcpy(pose.orientation, number + 3, sizeof pose.orientation);
    memcpy(pose.gripper, number + 7, sizeof pose.gripper);
    memcpy(pose.buttons, number + 8, sizeof pose.buttons);
    bgc_feed_pointer(bgc_device_handle(page.m, page.d, k), &pose);
}

/* --- faults ------------------------------------------------------------------------------------ */

/* What failed: 0 parameter, 1 assertion, 2 state, 3 switch, 4 divisor, 5 chain, 6 jump, 7 held value, 8 device. */
EXPORTED("failed") int page_failed(int what) {
    int (*const index[])(const bgc_data *) = {
        bgc_failed_parameter, bgc_failed_assertion, bgc_failed_state,
        bgc_failed_switch,    bgc_failed_divisor,   bgc_failed_chain,
        bgc_failed_jump,      bgc_failed_held,      bgc_failed_device,
    };

    return index[what](page.d);
}

EXPORTED("failed_time") double page_failed_time(void) { return bgc_failed_time(page.d); }
EXPORTED("reason") const char *page_reason(void) { return bgc_device_reason(page.d); }
