/* devices.c: replaces devices.c and the drivers in a model without devices. */
#include "bgc_internal.h"

#include <stdio.h>

const bgc_driver *bgc_find_driver(const char *name) {
    (void)name;
    return NULL;
}

void bgc_default_inputs(const bgc_model *m, double *u) {
    for (int k = 0; k < m->n_input; k++) {
        u[k] = 0.0;
    }
}

void bgc_zero_devices(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

bgc_status bgc_read_devices(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

bgc_status bgc_write_devices(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

bgc_status bgc_open_device(const bgc_model *m, bgc_data *d, int k, const bgc_driver *driver,
                           const char *options, char *message, size_t size) {
    (void)m, (void)d, (void)driver, (void)options;
    snprintf(message, size, "the model has no device %d", k);
    return BGC_BAD_ARGUMENT;
}

void *bgc_device_handle(const bgc_model *m, const bgc_data *d, int k) {
    (void)m, (void)d, (void)k;
    return NULL;
}

void bgc_feed_pointer(void *handle, const bgc_pose *pose) {
    (void)handle, (void)pose;
}

int bgc_failed_device(const bgc_data *d) { return d->failed_device; }

const char *bgc_device_reason(const bgc_data *d) { return d->device_reason; }

void bgc_close_devices(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}
