/* options.c: the registry of integration methods and the options of a run. */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

static const double default_sample = 1e-3; /* s, of devices in a scene that gives no step */
static const double largest_denominator = 1e6; /* of a step */

/* --- methods ------------------------------------------------------------------------------- */

/* Place in bgc_methods, or -1 where there is no method of that name. */
static int find_method(const char *name) {
    for (int k = 0; k < bgc_method_count; k++) {
        if (strcmp(bgc_methods[k].name, name) == 0) {
            return k;
        }
    }
    return -1;
}

/* The first method with fixed steps, or with error control; in a model in which it pays the first that
 * changes to an explicit one. */
static int default_method(const bgc_model *m, int fixed) {
    int k = 0;

    while (bgc_is_adaptive(&bgc_methods[k]) == fixed ||
           (m->explicit_cost > 0.0 && bgc_methods[k].partner == NULL)) {
        k++;
    }
    return k;
}

double bgc_explicit_cost(const bgc_model *m) {
    return m->explicit_cost;
}

bgc_status bgc_get_method(int k, bgc_method_info *info) {
    const bgc_method *method;

    if (k < 0 || k >= bgc_method_count) {
        return BGC_BAD_ARGUMENT;
    }
    method = &bgc_methods[k];
    *info = (bgc_method_info){
        .name = method->name,
        .family = method->family->name,
        .purpose = method->purpose,
        .order = method->order,
        .error_order = method->error_order,
        .jacobian = method->family->jacobian,
        .lanes = method->family->lanes,
        .embedded_order = method->embedded_order,
        .substeps = method->substeps > 0 ? method->substeps : 1,
        .stages = method->tableau != NULL ? method->tableau->stages : method->collocation->stages,
    };
    return BGC_OK;
}

/* --- options ------------------------------------------------------------------------------- */

/* The least fraction that rounds to the step, by its continued fraction; the step over 1 where its denominator
 * is large. */
static void divide_step(bgc_core *core) {
    double rest = core->step, before[2] = {0.0, 1.0}, last[2] = {1.0, 0.0};

    core->step_parts = core->step;
    core->step_whole = 1.0;
    for (;;) {
        const double whole = floor(rest);
        const double parts[2] = {whole * last[0] + before[0], whole * last[1] + before[1]};
        if (!(parts[1] <= largest_denominator)) {
            return;
        }
        if (parts[0] / parts[1] == core->step) {
            core->step_parts = parts[0];
            core->step_whole = parts[1];
            return;
        }
        memcpy(before, last, sizeof last);
        memcpy(last, parts, sizeof last);
        rest = 1.0 / (rest - whole);
    }
}

/* Whether the step of the scene is a multiple of this step. */
static int divides(double step, double scene) {
    const double parts = round(scene / step);

    return parts >= 1.0 && fabs(scene - parts * step) <= 1e-9 * scene;
}

bgc_status bgc_set_options(const bgc_model *m, bgc_data *d, const bgc_options *o) {
    bgc_core *core = &d->core;
    const double step = o->step > 0.0 ? o->step : m->step;
    const int method = o->name != NULL ? find_method(o->name) : default_method(m, step > 0.0);
    const int fixed = method >= 0 && !bgc_is_adaptive(&bgc_methods[method]);

    if (method < 0 || !(o->rtol >= 0.0 && o->atol >= 0.0 && o->step >= 0.0 && o->max_step >= 0.0) ||
        !isfinite(o->rtol + o->atol + o->step + o->max_step) || o->max_steps < 0 || o->keep < 0 ||
        (fixed && step == 0.0) || o->substeps < 0 ||
        (o->substeps > 1 && bgc_methods[method].embedded_order == 0)) {
        return BGC_BAD_ARGUMENT;
    }
    if (bgc_reserve_complex(m, d, &bgc_methods[method]) != BGC_OK) {
        return BGC_NO_MEMORY;
    }

    /* Options, with the defaults filled in. */
    core->given = *o;
    core->given.name = NULL;
    core->method = method;
    core->substeps = o->substeps > 0 ? o->substeps : bgc_methods[method].substeps;
    core->rtol = o->rtol > 0.0 && !fixed ? o->rtol : 1e-6;
    core->atol = fixed ? 0.0 : o->atol;
    core->sub_rtol = o->rtol > 0.0 ? o->rtol : 1e-3;
    core->sub_atol = o->atol;
    core->max_steps = o->max_steps > 0 ? o->max_steps : 10000000;
    core->keep = o->keep > 0 ? o->keep : 1;
    core->accounts = o->accounts != 0 && m->energy != NULL;
    core->errors = o->errors != 0;
    core->step = fixed ? step : o->step;
    divide_step(core);

    /* The sample period is the step of the scene under every method whose steps end at it. */
    core->period = 0.0;
    if (fixed) {
        core->period = divides(step, m->step) ? m->step : step;
    } else if (m->n_device > 0 || m->n_input > m->n_slot) {
        core->period = m->step > 0.0 ? m->step : default_sample;
    }

    /* Steps and samples count from the present. */
    core->origin = core->t;
    core->t_old = core->t_end = core->t;
    core->ticks = core->sample = core->step_cut = 0;
    bgc_schedule(core);
    core->dense = BGC_NO_DENSE;
    core->held = core->rejected = core->halvings = 0;
    core->pivoting = core->pivoting_complex = BGC_STATIC;
    core->h_next = 0.0;
    core->error_old = 1.0;
    bgc_reset_choice(m, d);
    core->energy_scale = -1.0;
    core->counts.scale_reached = fixed ? 1.0 : 0.0;
    core->since_sample = 0.0;
    bgc_begin_sample(core);
    bgc_reset_terms(m, d);
    return BGC_OK;
}
