/* fmus.h: FMUs of other tools in a model, Co-Simulation of FMI 2.0 and 3.0.
 *
 * An FMU belongs to a rate of the sampled parts. At the first instant after a reset it is instantiated, gets
 * its parameters and inputs, and is initialised; at each further instant it gets its inputs and takes a
 * communication step up to there. The values that it gives are then held until the next instant.
 *
 * fmus.c opens libraries and decides what an instant needs; fmus2.c and fmus3.c call the functions of the two
 * versions of the standard.
 */
#ifndef BGC_FMUS_H
#define BGC_FMUS_H

#include "bgc_internal.h"

#include <stdio.h>
#include <string.h>

/* Types of variables, in the order of KINDS3 of compiler/values/fmu_files.py; those of FMI 2 follow. */
enum {
    BGC_FLOAT64, BGC_FLOAT32, BGC_INT8, BGC_UINT8, BGC_INT16, BGC_UINT16, BGC_INT32, BGC_UINT32,
    BGC_INT64, BGC_UINT64, BGC_BOOLEAN3, BGC_ENUMERATION3, BGC_REAL, BGC_INTEGER, BGC_BOOLEAN,
    BGC_ENUMERATION
};

/* What becomes of a number. */
enum { BGC_FMU_PARAMETER, BGC_FMU_TUNABLE, BGC_FMU_INPUT, BGC_FMU_OUTPUT };

struct bgc_fmu {
    const bgc_fmu_info *info;
    const struct bgc_fmu_version *version;
    void *library;
    char *resources;
    void *functions; /* of its version */
    void *instance;  /* NULL: none is running */
    double *number;  /* in its units: one for each of the variables; */
    double *sent;    /* those that the FMU has */
    double *array;   /* the numbers of the longest array */
    double t;        /* the communication point that it has reached */
    int fresh;       /* the model has been reset since the last instant */
    int stepped;     /* it has taken a step since its start */
    int lost;        /* a call was fatal: by the standard, nothing of the FMU may be called any more */
    char reason[300];
};

/* A function of the standard, and its place among those of a version. */
typedef struct {
    const char *name;
    size_t place;
} bgc_fmu_function;

/* A version of the standard. The functions return whether the FMU went on; `reason` says why not. */
typedef struct bgc_fmu_version {
    size_t size;                      /* of its functions */
    const bgc_fmu_function *function; /* ends with a name of NULL */
    int (*start)(bgc_fmu *f, double t); /* instantiate, set all numbers that are set, initialise */
    int (*step)(bgc_fmu *f, double h);
    int (*set)(bgc_fmu *f, int role); /* what is set in this role or a later one */
    int (*get)(bgc_fmu *f);
    void (*end)(bgc_fmu *f);
} bgc_fmu_version;

extern const bgc_fmu_version bgc_fmu_version2, bgc_fmu_version3;

/* The reason of a failure: what the FMU has logged, else the call. */
static inline int bgc_fmu_gives_up(bgc_fmu *f, const char *call, const char *why) {
    if (f->reason[0] == '\0') {
        snprintf(f->reason, sizeof f->reason, "%s %s", call, why);
    }
    return 0;
}

/* Whether variable k, the first behind its reference, is to be set in this role or a later one. Parameters that
 * the FMU has already are left to it: others may follow from them there. */
static inline int bgc_fmu_is_due(bgc_fmu *f, int k, int role) {
    const bgc_fmu_variable *v = &f->info->variable[k];
    const size_t size = (size_t)v->count * sizeof *f->number;

    if (v->role == BGC_FMU_OUTPUT || v->role < role || (v->count > 1 && v->place > 0)) {
        return 0;
    }
    if (v->role != BGC_FMU_INPUT && memcmp(&f->number[k], &f->sent[k], size) == 0) {
        return 0;
    }
    memcpy(&f->sent[k], &f->number[k], size);
    return 1;
}

#endif
