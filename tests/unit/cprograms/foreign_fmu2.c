/* foreign_fmu2.c: an FMU of FMI 2.0 that is not made by bgc, for the tests of FMUs as parts.
 *
 * A first-order lag T x' = gain u - x, exact for an input that is held, with forces in kN and a temperature in
 * degrees Celsius. With gain 99 a step beyond 1 s is an error, with gain 98 it is fatal. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef void (*logger)(void *, const char *, int, const char *, const char *, ...);

typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

typedef struct {
    callbacks call;
    double gain, T, u, x;
    int on, steps;
} lag;

#ifdef ONCE
static int instances = 0;
#endif

#ifdef MARKER /* written as soon as the library is opened */
#include <stdio.h>

__attribute__((constructor)) static void mark(void) {
    FILE *file = fopen(MARKER, "w");

    if (file != NULL) {
        fclose(file);
    }
}
#endif

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const callbacks *call, int visible, int logs) {
    lag *f = NULL;

    (void)name, (void)visible, (void)logs;
    if (type != 1 || strcmp(guid, "{lag}") != 0 || strncmp(resources, "file:///", 8) != 0) {
        return NULL;
    }
#ifdef ONCE
    if (instances++ > 0) {
        return NULL;
    }
#endif
    f = calloc(1, sizeof *f);
    f->call = *call;
    f->gain = 2.0;
    f->T = 0.5;
    return f;
}

void fmi2FreeInstance(void *c) {
#ifdef ONCE
    instances--;
#endif
    free(c);
}

int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    (void)c, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return 0;
}

int fmi2EnterInitializationMode(void *c) {
    (void)c;
    return 0;
}

int fmi2ExitInitializationMode(void *c) {
    (void)c;
    return 0;
}

int fmi2Terminate(void *c) {
    (void)c;
    return 0;
}

int fmi2DoStep(void *c, double t, double h, int whole) {
    lag *f = c;

    (void)whole;
    if (t + h > 1.0 && f->gain == 99.0) {
        f->call.log(f->call.environment, "lag", 3, "logStatusError", "lag: %s of %d", "no step", 7);
        return 3;
    }
    if (t + h > 1.0 && f->gain == 98.0) {
        return 4;
    }
    f->x = f->on ? f->gain * f->u + (f->x - f->gain * f->u) * exp(-h / f->T) : f->x;
    f->steps++;
    return 0;
}

int fmi2GetReal(void *c, const unsigned *ref, size_t n, double *value) {
    const lag *f = c;

    for (size_t k = 0; k < n; k++) {
        const double all[] = {0.0, f->gain, f->T, f->u, 0.0, f->x, 0.0, 20.0 + f->x};
        value[k] = all[ref[k]];
    }
    return 0;
}

int fmi2SetReal(void *c, const unsigned *ref, size_t n, const double *value) {
    lag *f = c;

    for (size_t k = 0; k < n; k++) {
        double *const all[] = {NULL, &f->gain, &f->T, &f->u};
        *all[ref[k]] = value[k];
    }
    return 0;
}

int fmi2GetInteger(void *c, const unsigned *ref, size_t n, int *value) {
    (void)ref;
    for (size_t k = 0; k < n; k++) {
        value[k] = ((const lag *)c)->steps;
    }
    return 0;
}

int fmi2SetInteger(void *c, const unsigned *ref, size_t n, const int *value) {
    (void)c, (void)ref, (void)n, (void)value;
    return 3;
}

int fmi2GetBoolean(void *c, const unsigned *ref, size_t n, int *value) {
    (void)ref;
    for (size_t k = 0; k < n; k++) {
        value[k] = ((const lag *)c)->on;
    }
    return 0;
}

int fmi2SetBoolean(void *c, const unsigned *ref, size_t n, const int *value) {
    (void)ref;
    for (size_t k = 0; k < n; k++) {
        ((lag *)c)->on = value[k];
    }
    return 0;
}
