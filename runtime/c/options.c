/* options.c: the registry of integration methods, and the options of a run. */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

static const double default_sample = 1e-3; /* s, of devices in a scene that gives no step */

static int find_method(const char *name) {
    for (int k = 0; k < BGC_METHODS; k++) {
        if (strcmp(bgc_methods[k].name, name) == 0) {
            return k;
        }
    }
    return -1;
}

static int is_fixed(int method) {
    return bgc_embedded(&bgc_methods[method]) == 0;
}

int bgc_method_is_fixed(const char *name) {
    const int method = find_method(name);

    return method < 0 ? -1 : is_fixed(method);
}

const char *bgc_method_name(int k) {
    return k >= 0 && k < BGC_METHODS ? bgc_methods[k].name : NULL;
}

/* Whether the scene's step is a whole number of steps of this length. */
static int divides(double step, double scene) {
    const double parts = round(scene / step);

    return parts >= 1.0 && fabs(scene - parts * step) <= 1e-9 * scene;
}

bgc_status bgc_set_options(const bgc_model *m, bgc_data *d, const bgc_options *o) {
    bgc_core *core = &d->core;
    const double step = o->step > 0.0 ? o->step : m->step;
    const int method =
        find_method(o->name != NULL ? o->name : step > 0.0 ? "ros34prw" : "rodas5p");

    if (method < 0 || !(o->rtol >= 0.0 && o->atol >= 0.0 && o->step >= 0.0 && o->max_step >= 0.0) ||
        !isfinite(o->rtol + o->atol + o->step + o->max_step) || o->max_steps < 0 || o->keep < 0 ||
        (is_fixed(method) && step == 0.0)) {
        return BGC_BAD_ARGUMENT;
    }
    core->method = method;
    core->rtol = o->rtol > 0.0 ? o->rtol : 1e-6;
    core->atol = o->atol;
    core->max_step = o->max_step;
    core->max_steps = o->max_steps > 0 ? o->max_steps : 10000000;
    core->keep = o->keep > 0 ? o->keep : 1;
    core->accounts = o->accounts != 0 && m->energy != NULL;
    core->step = is_fixed(method) ? step : o->step;

    /* Sampled models see the same samples whatever the method, unless its step does not allow it. */
    core->period = 0.0;
    if (is_fixed(method)) {
        core->period = divides(step, m->step) ? m->step : step;
    } else if (m->n_device > 0 || m->n_input > 0) {
        core->period = m->step > 0.0 ? m->step : default_sample;
    }

    /* The count of steps and samples starts anew from here. */
    core->origin = core->t;
    core->t_old = core->t_end = core->t;
    core->ticks = core->sample = core->between = 0;
    core->dense = BGC_NO_DENSE;
    core->held = core->rejected = core->halvings = 0;
    core->h_next = 0.0;
    core->error_old = 1.0;
    core->energy_scale = -1.0;
    core->counts.liveliest = is_fixed(method) ? 1.0 : 0.0;
    core->since_sample = 0.0;
    return BGC_OK;
}
