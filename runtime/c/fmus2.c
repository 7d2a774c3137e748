/* fmus2.c: an FMU of FMI 2.0, by the functions of its Co-Simulation. */
#include "fmus.h"

#include "fmi/fmi2.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct {
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String,
                                 const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean);
    void (*free_instance)(fmi2Component);
    fmi2Status (*setup)(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    fmi2Status (*enter)(fmi2Component);
    fmi2Status (*leave)(fmi2Component);
    fmi2Status (*terminate)(fmi2Component);
    fmi2Status (*step)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    fmi2Status (*get_real)(fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *);
    fmi2Status (*get_integer)(fmi2Component, const fmi2ValueReference *, size_t, fmi2Integer *);
    fmi2Status (*get_boolean)(fmi2Component, const fmi2ValueReference *, size_t, fmi2Boolean *);
    fmi2Status (*set_real)(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Real *);
    fmi2Status (*set_integer)(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Integer *);
    fmi2Status (*set_boolean)(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Boolean *);
    fmi2CallbackFunctions callbacks; /* valid as long as the instance */
} functions2;

static const bgc_fmu_function names2[] = {
    {"fmi2Instantiate", offsetof(functions2, instantiate)},
    {"fmi2FreeInstance", offsetof(functions2, free_instance)},
    {"fmi2SetupExperiment", offsetof(functions2, setup)},
    {"fmi2EnterInitializationMode", offsetof(functions2, enter)},
    {"fmi2ExitInitializationMode", offsetof(functions2, leave)},
    {"fmi2Terminate", offsetof(functions2, terminate)},
    {"fmi2DoStep", offsetof(functions2, step)},
    {"fmi2GetReal", offsetof(functions2, get_real)},
    {"fmi2GetInteger", offsetof(functions2, get_integer)},
    {"fmi2GetBoolean", offsetof(functions2, get_boolean)},
    {"fmi2SetReal", offsetof(functions2, set_real)},
    {"fmi2SetInteger", offsetof(functions2, set_integer)},
    {"fmi2SetBoolean", offsetof(functions2, set_boolean)},
    {NULL, 0},
};

/* Keeps the message of the first discarded value or error. */
static void keep_message2(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                         fmi2String category, fmi2String message, ...) {
    bgc_fmu *f = environment;
    va_list rest;

    (void)instance, (void)category;
    if (f == NULL || message == NULL || status < fmi2Discard || f->reason[0] != '\0') {
        return;
    }
    va_start(rest, message);
    vsnprintf(f->reason, sizeof f->reason, message, rest);
    va_end(rest);
}

/* Whether a call has gone well; its name and the status are the reason otherwise. */
static int well2(bgc_fmu *f, const char *call, fmi2Status status) {
    static const char *const words[] = {"returned Discard", "returned Error", "returned Fatal",
                                        "returned Pending"};

    if (status == fmi2OK || status == fmi2Warning) {
        return 1;
    }
    f->lost |= status == fmi2Fatal;
    return bgc_fmu_gives_up(f, call, words[status <= fmi2Pending ? status - fmi2Discard : 1]);
}

/* The nearest integer, within the range of the type. */
static fmi2Integer integer2(double x) {
    return (fmi2Integer)fmin(fmax(nearbyint(x), -2147483648.0), 2147483647.0);
}

static int set2(bgc_fmu *f, int role) {
    const functions2 *call = f->functions;
    int well = 1;

    for (int k = 0; well && k < f->info->n_variable; k++) {
        const bgc_fmu_variable *v = &f->info->variable[k];
        const fmi2Integer whole = integer2(f->number[k]);
        const fmi2Boolean truth = whole != 0;
        if (!bgc_fmu_is_due(f, k, role)) {
            continue;
        }
        switch (v->kind) {
        case BGC_REAL:
            well = well2(f, "fmi2SetReal", call->set_real(f->instance, &v->reference, 1, &f->number[k]));
            break;
        case BGC_BOOLEAN:
            well = well2(f, "fmi2SetBoolean", call->set_boolean(f->instance, &v->reference, 1, &truth));
            break;
        default:
            well = well2(f, "fmi2SetInteger", call->set_integer(f->instance, &v->reference, 1, &whole));
        }
    }
    return well;
}

static int get2(bgc_fmu *f) {
    const functions2 *call = f->functions;
    int well = 1;

    for (int k = 0; well && k < f->info->n_variable; k++) {
        const bgc_fmu_variable *v = &f->info->variable[k];
        fmi2Integer whole = 0;
        if (v->role != BGC_FMU_OUTPUT) {
            continue;
        }
        switch (v->kind) {
        case BGC_REAL:
            well = well2(f, "fmi2GetReal", call->get_real(f->instance, &v->reference, 1, &f->number[k]));
            break;
        case BGC_BOOLEAN:
            well = well2(f, "fmi2GetBoolean", call->get_boolean(f->instance, &v->reference, 1, &whole));
            f->number[k] = whole != 0;
            break;
        default:
            well = well2(f, "fmi2GetInteger", call->get_integer(f->instance, &v->reference, 1, &whole));
            f->number[k] = whole;
        }
    }
    return well;
}

/* Parameters are set before the initialisation, which may depend on the inputs too. */
static int start2(bgc_fmu *f, double t) {
    functions2 *call = f->functions;

    call->callbacks = (fmi2CallbackFunctions){keep_message2, calloc, free, NULL, f};
    f->instance = call->instantiate(f->info->name, fmi2CoSimulation, f->info->token, f->resources,
                                    &call->callbacks, 0, 1);
    if (f->instance == NULL) {
        return bgc_fmu_gives_up(f, "fmi2Instantiate", "returned no instance");
    }
    return set2(f, BGC_FMU_PARAMETER) &&
           well2(f, "fmi2SetupExperiment", call->setup(f->instance, 0, 0.0, t, 0, 0.0)) &&
           well2(f, "fmi2EnterInitializationMode", call->enter(f->instance)) && set2(f, BGC_FMU_INPUT) &&
           well2(f, "fmi2ExitInitializationMode", call->leave(f->instance));
}

static int step2(bgc_fmu *f, double h) {
    const functions2 *call = f->functions;

    return well2(f, "fmi2DoStep", call->step(f->instance, f->t, h, 1));
}

static void end2(bgc_fmu *f) {
    const functions2 *call = f->functions;

    if (f->reason[0] == '\0') { /* else the instance has failed, and may only be freed */
        call->terminate(f->instance);
    }
    call->free_instance(f->instance);
}

const bgc_fmu_version bgc_fmu_version2 = {sizeof(functions2), names2, start2, step2, set2, get2, end2};
