/* foreign_fmu3.c: an FMU of FMI 3.0 that is not made by bgc, for the tests of FMUs as parts.
 *
 * Two lags T x' = g * u - x with gains and inputs in arrays, exact for inputs that are held, and numbers of all
 * types. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef void (*logger)(void *, int, const char *, const char *);

typedef struct {
    logger log;
    void *environment;
    double gain[2], T, u[2], x[2];
    bool on;
    int64_t level; /* of all integer types, and of the enumeration */
} lags;

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logs, bool events, bool early, const uint32_t *intermediate, size_t n,
                                  void *environment, logger log, void *update) {
    lags *f = NULL;
    const size_t length = resources == NULL ? 0 : strlen(resources);

    (void)name, (void)visible, (void)logs, (void)events, (void)early, (void)intermediate, (void)n, (void)update;
    if (strcmp(token, "{lags}") != 0 || length == 0 || resources[length - 1] != '/') {
        return NULL;
    }
    f = calloc(1, sizeof *f);
    *f = (lags){log, environment, {2.0, 3.0}, 0.5, {0.0}, {0.0}, false, 0};
    return f;
}

void fmi3FreeInstance(void *c) { free(c); }

int fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_stop,
                                double stop) {
    (void)c, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return 0;
}

int fmi3ExitInitializationMode(void *c) {
    (void)c;
    return 0;
}

int fmi3Terminate(void *c) {
    (void)c;
    return 0;
}

int fmi3DoStep(void *c, double t, double h, bool whole, bool *event, bool *ends, bool *early, double *reached) {
    lags *f = c;

    (void)whole;
    *event = *early = false;
    *ends = f->T == 77.0;
    *reached = t + h;
    if (f->T == 99.0) {
        f->log(f->environment, 3, "logStatusError", "lags: no step");
        return 3;
    }
    for (int k = 0; f->on && k < 2; k++) {
        f->x[k] = f->gain[k] * f->u[k] + (f->x[k] - f->gain[k] * f->u[k]) * exp(-h / f->T);
    }
    return 0;
}

static double *reals(lags *f, uint32_t ref) {
    double *const all[] = {NULL, f->gain, &f->T, f->u, f->x};
    return all[ref];
}

int fmi3GetFloat64(void *c, const uint32_t *ref, size_t n, double *value, size_t n_value) {
    (void)n;
    memcpy(value, reals(c, *ref), n_value * sizeof *value);
    return 0;
}

int fmi3SetFloat64(void *c, const uint32_t *ref, size_t n, const double *value, size_t n_value) {
    (void)n;
    memcpy(reals(c, *ref), value, n_value * sizeof *value);
    return 0;
}

int fmi3GetFloat32(void *c, const uint32_t *ref, size_t n, float *value, size_t n_value) {
    (void)ref, (void)n;
    for (size_t k = 0; k < n_value; k++) {
        value[k] = (float)((lags *)c)->x[k];
    }
    return 0;
}

int fmi3SetFloat32(void *c, const uint32_t *ref, size_t n, const float *value, size_t n_value) {
    (void)c, (void)ref, (void)n, (void)value, (void)n_value;
    return 3;
}

int fmi3GetBoolean(void *c, const uint32_t *ref, size_t n, bool *value, size_t n_value) {
    (void)ref, (void)n, (void)n_value;
    *value = ((lags *)c)->on;
    return 0;
}

int fmi3SetBoolean(void *c, const uint32_t *ref, size_t n, const bool *value, size_t n_value) {
    (void)ref, (void)n, (void)n_value;
    ((lags *)c)->on = *value;
    return 0;
}

#define WHOLE(name, type)                                                                                   \
    int fmi3Get##name(void *c, const uint32_t *ref, size_t n, type *value, size_t n_value) {                \
        (void)ref, (void)n, (void)n_value;                                                                  \
        *value = (type)((lags *)c)->level;                                                                  \
        return 0;                                                                                           \
    }                                                                                                       \
    int fmi3Set##name(void *c, const uint32_t *ref, size_t n, const type *value, size_t n_value) {          \
        (void)ref, (void)n, (void)n_value;                                                                  \
        ((lags *)c)->level = (int64_t)*value;                                                               \
        return 0;                                                                                           \
    }
WHOLE(Int8, int8_t)
WHOLE(UInt8, uint8_t)
WHOLE(Int16, int16_t)
WHOLE(UInt16, uint16_t)
WHOLE(Int32, int32_t)
WHOLE(UInt32, uint32_t)
WHOLE(Int64, int64_t)
WHOLE(UInt64, uint64_t)
