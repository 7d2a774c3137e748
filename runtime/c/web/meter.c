/* meter.c: efforts and flows of all bonds in a page: the functions of its second WebAssembly module.
 *
 * The module holds the model with all bonds observed. It never steps: the page gives it the state of the run, and
 * reads one row. The host is client/src/meter.js.
 */
#include "bgc_internal.h"

#include <string.h>

#define EXPORTED(name) __attribute__((export_name(name)))

static struct {
    const bgc_model *m;
    bgc_data *d;
} meter;

const char *bgc_given_text(const char *name) {
    (void)name;
    return NULL;
}

EXPORTED("allocate") void *meter_allocate(size_t size) { return calloc(size + 1, 1); }

/* Makes the instance. */
EXPORTED("begin") int meter_begin(void) {
    meter.m = bgc_get_model();
    meter.d = bgc_new(meter.m);
    return meter.d == NULL ? BGC_NO_MEMORY : BGC_OK;
}

EXPORTED("set") void meter_set(int k, double value) { bgc_set_param(meter.m, meter.d, k, value); }
EXPORTED("width") int meter_width(void) { return meter.m->n_output; }

/* Takes the initial state at a time: after it the page writes the states and inputs that it knows. */
EXPORTED("reset") int meter_reset(double time) { return bgc_reset_unchecked(meter.m, meter.d, time); }
EXPORTED("state") double *meter_state(void) { return bgc_state(meter.d); }
EXPORTED("input") double *meter_input(void) { return bgc_input(meter.d); }

/* Writes the row of the present state. */
EXPORTED("read") int meter_read(double *row) {
    const bgc_status status = bgc_restart(meter.m, meter.d);

    return status != BGC_OK ? status : bgc_outputs(meter.m, meter.d, row);
}
