/* windows_fmu.c: steps an FMU of FMI 2.0 through Co-Simulation and prints its reals as hexadecimal numbers.
 *
 * windows_fmu LIBRARY TOKEN STEP STEPS REFERENCE..: one row a step. Runs on Windows and POSIX alike, without
 * any header of the standard. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) ((void *)GetProcAddress(library, name))
typedef HMODULE library_t;
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
typedef void *library_t;
#endif

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

static void logged(void *environment, const char *name, int status, const char *category,
                   const char *message, ...) {
    (void)environment;
    fprintf(stderr, "%s: %d %s: %s\n", name, status, category, message);
}

static void *function(library_t library, const char *name) {
    void *found = FIND(library, name);
    if (found == NULL) {
        fprintf(stderr, "no %s\n", name);
        exit(1);
    }
    return found;
}

int main(int count, char **argument) {
    const callbacks calls = {logged, calloc, free, NULL, NULL};
    const double step = count > 4 ? atof(argument[3]) : 0.0;
    const int steps = count > 4 ? atoi(argument[4]) : 0;
    library_t library = count > 4 ? OPEN(argument[1]) : NULL;
    int bad = 0;

    if (library == NULL) {
        fprintf(stderr, "cannot open the library\n");
        return 1;
    }
    void *(*instantiate)(const char *, int, const char *, const char *, const callbacks *, int, int) =
        function(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = function(library, "fmi2SetupExperiment");
    int (*enter)(void *) = function(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = function(library, "fmi2ExitInitializationMode");
    int (*advance)(void *, double, double, int) = function(library, "fmi2DoStep");
    int (*get)(void *, const unsigned *, size_t, double *) = function(library, "fmi2GetReal");
    void (*end)(void *) = function(library, "fmi2FreeInstance");
    void *fmu = instantiate("one", 1, argument[2], "", &calls, 0, 0);

    if (fmu == NULL) {
        return 1;
    }
    bad |= setup(fmu, 0, 0.0, 0.0, 0, 0.0);
    bad |= enter(fmu);
    bad |= leave(fmu);
    for (int k = 0; k < steps && !bad; k++) {
        bad |= advance(fmu, k * step, step, 1);
        for (int i = 5; i < count; i++) {
            const unsigned reference = (unsigned)atoi(argument[i]);
            double value = 0.0;
            unsigned long long bits;
            bad |= get(fmu, &reference, 1, &value);
            memcpy(&bits, &value, sizeof bits);
            printf("%016llx%c", bits, i + 1 < count ? ' ' : '\n');
        }
    }
    end(fmu);
    return bad;
}
