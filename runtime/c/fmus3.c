/* fmus3.c: an FMU of FMI 3.0, by the functions of its Co-Simulation. */
#include "fmus.h"

#include "fmi/fmi3.h"

#include <math.h>
#include <stdio.h>

/* The types of numbers: the name of their functions and that of C, by the types of fmus.h. */
#define NUMBERS3(X)                                                                                         \
    X(BGC_FLOAT64, Float64, fmi3Float64)                                                                    \
    X(BGC_FLOAT32, Float32, fmi3Float32)                                                                    \
    X(BGC_INT8, Int8, fmi3Int8)                                                                             \
    X(BGC_UINT8, UInt8, fmi3UInt8)                                                                          \
    X(BGC_INT16, Int16, fmi3Int16)                                                                          \
    X(BGC_UINT16, UInt16, fmi3UInt16)                                                                       \
    X(BGC_INT32, Int32, fmi3Int32)                                                                          \
    X(BGC_UINT32, UInt32, fmi3UInt32)                                                                       \
    X(BGC_INT64, Int64, fmi3Int64)                                                                          \
    X(BGC_UINT64, UInt64, fmi3UInt64)                                                                       \
    X(BGC_BOOLEAN3, Boolean, fmi3Boolean)

typedef struct {
    fmi3Instance (*instantiate)(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                fmi3Boolean, const fmi3ValueReference *, size_t, fmi3InstanceEnvironment,
                                fmi3LogMessageCallback, fmi3IntermediateUpdateCallback);
    void (*free_instance)(fmi3Instance);
    fmi3Status (*enter)(fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Float64);
    fmi3Status (*leave)(fmi3Instance);
    fmi3Status (*terminate)(fmi3Instance);
    fmi3Status (*step)(fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean *, fmi3Boolean *,
                       fmi3Boolean *, fmi3Float64 *);
#define DECLARED3(kind, name, type)                                                                          \
    fmi3Status (*get_##name)(fmi3Instance, const fmi3ValueReference *, size_t, type *, size_t);             \
    fmi3Status (*set_##name)(fmi3Instance, const fmi3ValueReference *, size_t, const type *, size_t);
    NUMBERS3(DECLARED3)
} functions3;

static const bgc_fmu_function names3[] = {
    {"fmi3InstantiateCoSimulation", offsetof(functions3, instantiate)},
    {"fmi3FreeInstance", offsetof(functions3, free_instance)},
    {"fmi3EnterInitializationMode", offsetof(functions3, enter)},
    {"fmi3ExitInitializationMode", offsetof(functions3, leave)},
    {"fmi3Terminate", offsetof(functions3, terminate)},
    {"fmi3DoStep", offsetof(functions3, step)},
#define NAMED3(kind, name, type)                                                                             \
    {"fmi3Get" #name, offsetof(functions3, get_##name)}, {"fmi3Set" #name, offsetof(functions3, set_##name)},
    NUMBERS3(NAMED3)
    {NULL, 0},
};

/* Keeps the message of the first discarded value or error. */
static void keep_message3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                         fmi3String message) {
    bgc_fmu *f = environment;

    (void)category;
    if (f != NULL && message != NULL && status >= fmi3Discard && f->reason[0] == '\0') {
        snprintf(f->reason, sizeof f->reason, "%s", message);
    }
}

/* Whether a call has gone well; its name and the status are the reason otherwise. */
static int well3(bgc_fmu *f, const char *call, fmi3Status status) {
    static const char *const words[] = {"returned Discard", "returned Error", "returned Fatal"};

    if (status == fmi3OK || status == fmi3Warning) {
        return 1;
    }
    f->lost |= status == fmi3Fatal;
    return bgc_fmu_gives_up(f, call, words[status <= fmi3Fatal ? status - fmi3Discard : 1]);
}

/* The nearest integer, within the range of 64 bits. */
static int64_t integer3(double x) { return (int64_t)fmin(fmax(nearbyint(x), -9.2e18), 9.2e18); }

static int is_float3(int kind) { return kind == BGC_FLOAT64 || kind == BGC_FLOAT32; }

/* Enumerations have the functions of 64-bit integers. */
static int kind3(const bgc_fmu_variable *v) {
    return v->kind == BGC_ENUMERATION3 ? BGC_INT64 : v->kind;
}

/* Sets the numbers of a variable, which stand one after the other. */
static int set_numbers3(bgc_fmu *f, const bgc_fmu_variable *v, const double *number) {
    const functions3 *call = f->functions;
    const size_t n = (size_t)v->count;

    switch (kind3(v)) {
#define SET3(kind_, name, type)                                                                              \
    case kind_: {                                                                                           \
        type *value = (type *)(void *)f->array;                                                             \
        for (size_t i = 0; i < n; i++) {                                                                    \
            value[i] = is_float3(kind_) ? (type)number[i] : (type)integer3(number[i]);                      \
        }                                                                                                   \
        return well3(f, "fmi3Set" #name, call->set_##name(f->instance, &v->reference, 1, value, n));        \
    }
        NUMBERS3(SET3)
    default:
        return 0;
    }
}

/* Reads the numbers of a variable to f->array. */
static int get_numbers3(bgc_fmu *f, const bgc_fmu_variable *v) {
    const functions3 *call = f->functions;
    const size_t n = (size_t)v->count;

    switch (kind3(v)) {
        /* Widened from the last to the first, in place. */
#define GET3(kind_, name, type)                                                                              \
    case kind_: {                                                                                           \
        type *value = (type *)(void *)f->array;                                                             \
        if (!well3(f, "fmi3Get" #name, call->get_##name(f->instance, &v->reference, 1, value, n))) {        \
            return 0;                                                                                       \
        }                                                                                                   \
        for (size_t i = n; i-- > 0;) {                                                                      \
            const type one = value[i];                                                                      \
            f->array[i] = (double)one;                                                                      \
        }                                                                                                   \
        return 1;                                                                                           \
    }
        NUMBERS3(GET3)
    default:
        return 0;
    }
}

/* The components of an array are set together, and follow each other. */
static int set3(bgc_fmu *f, int role) {
    int well = 1;

    for (int k = 0; well && k < f->info->n_variable; k++) {
        if (bgc_fmu_is_due(f, k, role)) {
            well = set_numbers3(f, &f->info->variable[k], &f->number[k]);
        }
    }
    return well;
}

static int get3(bgc_fmu *f) {
    const bgc_fmu_variable *last = NULL;

    for (int k = 0; k < f->info->n_variable; k++) {
        const bgc_fmu_variable *v = &f->info->variable[k];
        if (v->role != BGC_FMU_OUTPUT) {
            continue;
        }
        if (last == NULL || last->reference != v->reference) {
            if (!get_numbers3(f, v)) {
                return 0;
            }
            last = v;
        }
        f->number[k] = f->array[v->place];
    }
    return 1;
}

/* Parameters are set before the initialisation, which may depend on the inputs too. */
static int start3(bgc_fmu *f, double t) {
    const functions3 *call = f->functions;

    f->instance = call->instantiate(f->info->name, f->info->token, f->resources, 0, 1, 0, 0, NULL, 0, f,
                                    keep_message3, NULL);
    if (f->instance == NULL) {
        return bgc_fmu_gives_up(f, "fmi3InstantiateCoSimulation", "returned no instance");
    }
    return set3(f, BGC_FMU_PARAMETER) &&
           well3(f, "fmi3EnterInitializationMode", call->enter(f->instance, 0, 0.0, t, 0, 0.0)) &&
           set3(f, BGC_FMU_INPUT) && well3(f, "fmi3ExitInitializationMode", call->leave(f->instance));
}

static int step3(bgc_fmu *f, double h) {
    const functions3 *call = f->functions;
    fmi3Boolean event = 0, ends = 0, early = 0;
    fmi3Float64 reached = f->t;

    if (!well3(f, "fmi3DoStep", call->step(f->instance, f->t, h, 1, &event, &ends, &early, &reached))) {
        return 0;
    }
    if (ends) {
        return bgc_fmu_gives_up(f, "it", "asks to end the simulation");
    }
    return early ? bgc_fmu_gives_up(f, "fmi3DoStep", "returned before the end of the step") : 1;
}

static void end3(bgc_fmu *f) {
    const functions3 *call = f->functions;

    if (f->reason[0] == '\0') { /* else the instance has failed, and may only be freed */
        call->terminate(f->instance);
    }
    call->free_instance(f->instance);
}

const bgc_fmu_version bgc_fmu_version3 = {sizeof(functions3), names3, start3, step3, set3, get3, end3};
