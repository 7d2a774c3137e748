/* fmus.c: FMUs of other tools at the instants of sampled parts; fmus.h says how. */
#include "fmus.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ends the instance, where one is running. */
static void end_instance(bgc_fmu *f) {
    if (f->instance != NULL && !f->lost) {
        f->version->end(f);
    }
    f->instance = NULL;
}

static void close_fmu(bgc_fmu *f) {
    if (f->library != NULL) {
        end_instance(f);
        if (!f->lost) {
            dlclose(f->library);
        }
    }
    free(f->resources);
    free(f->functions);
    free(f->number);
    free(f->sent);
    free(f->array);
    *f = (bgc_fmu){0};
}

void bgc_close_fmus(const bgc_model *m, bgc_data *d) {
    for (int k = 0; d->fmu != NULL && k < m->n_fmu; k++) {
        close_fmu(&d->fmu[k]);
    }
    free(d->fmu);
    d->fmu = NULL;
}

/* --- opening ------------------------------------------------------------------------------- */

/* Looks up the functions of a version in a library. */
static int find_functions(bgc_fmu *f, char *message, size_t size) {
    for (const bgc_fmu_function *each = f->version->function; each->name != NULL; each++) {
        void *found = dlsym(f->library, each->name);
        if (found == NULL) {
            snprintf(message, size, "it exports no function `%s`", each->name);
            return 0;
        }
        memcpy((char *)f->functions + each->place, &found, sizeof found);
    }
    return 1;
}

static int longest_array(const bgc_fmu_info *info) {
    int longest = 1;

    for (int k = 0; k < info->n_variable; k++) {
        longest = info->variable[k].count > longest ? info->variable[k].count : longest;
    }
    return longest;
}

static bgc_status open_fmu(bgc_fmu *f, const char *library, const char *resources, char *message,
                           size_t size) {
    /* Memory. */
    f->version = f->info->version == 2 ? &bgc_fmu_version2 : &bgc_fmu_version3;
    f->resources = malloc(strlen(resources) + 1);
    f->functions = calloc(1, f->version->size);
    f->number = calloc((size_t)f->info->n_variable + 1, sizeof *f->number);
    f->sent = calloc((size_t)f->info->n_variable + 1, sizeof *f->sent);
    f->array = calloc((size_t)longest_array(f->info), sizeof *f->array);
    if (f->resources == NULL || f->functions == NULL || f->number == NULL || f->sent == NULL ||
        f->array == NULL) {
        return BGC_NO_MEMORY;
    }
    memcpy(f->resources, resources, strlen(resources) + 1);

    /* The library and its functions. */
    f->library = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    if (f->library == NULL) {
        snprintf(message, size, "%s", dlerror());
        return BGC_FMU;
    }
    return find_functions(f, message, size) ? BGC_OK : BGC_FMU;
}

bgc_status bgc_open_fmu(const bgc_model *m, bgc_data *d, int k, const char *library, const char *resources,
                        char *message, size_t size) {
    bgc_fmu *f;
    bgc_status status;

    if (size > 0) {
        message[0] = '\0';
    }
    if (k < 0 || k >= m->n_fmu) {
        snprintf(message, size, "the model has no FMU %d", k);
        return BGC_BAD_ARGUMENT;
    }
    if (d->fmu == NULL) {
        d->fmu = calloc((size_t)m->n_fmu, sizeof *d->fmu);
        if (d->fmu == NULL) {
            return BGC_NO_MEMORY;
        }
    }
    f = &d->fmu[k];
    close_fmu(f);
    f->info = &m->fmu[k];
    f->fresh = 1;
    status = open_fmu(f, library, resources, message, size);
    if (status != BGC_OK) {
        close_fmu(f);
    }
    return status;
}

/* --- instants ------------------------------------------------------------------------------ */

void bgc_renew_fmus(const bgc_model *m, bgc_data *d) {
    d->failed_fmu = -1;
    for (int k = 0; d->fmu != NULL && k < m->n_fmu; k++) {
        d->fmu[k].fresh = 1;
    }
}

/* Starts the FMU at t, or takes the communication step that ends there. A model that was reset in the middle
 * of a run, where a parameter has changed, goes on with an FMU that is there already or one period behind. */
static int advance_fmu(bgc_fmu *f, double t, double period) {
    const double near = 1e-6 * period;
    const int follows = f->instance != NULL && fabs(f->t + period - t) <= near;
    const int is_there = f->instance != NULL && f->stepped && fabs(f->t - t) <= near;
    int done;

    f->reason[0] = '\0';
    if (f->lost) {
        return bgc_fmu_gives_up(f, "it", "failed for good in an earlier run");
    }
    if (!follows && !f->fresh) {
        return bgc_fmu_gives_up(f, "it", "cannot be taken back to an earlier time");
    }
    if (follows || is_there) {
        done = f->version->set(f, BGC_FMU_TUNABLE) && (is_there || f->version->step(f, t - f->t));
        f->stepped = 1;
    } else {
        end_instance(f);
        for (int k = 0; k < f->info->n_variable; k++) {
            f->sent[k] = f->info->variable[k].start;
        }
        done = f->version->start(f, t);
        f->stepped = 0;
    }
    f->t = t;
    f->fresh = 0;
    return done && f->version->get(f);
}

/* The numbers of an FMU from the values that are due, an instant, and back. */
static bgc_status take_instant(const bgc_model *m, bgc_data *d, int k, double t) {
    const bgc_fmu_info *info = &m->fmu[k];
    bgc_fmu *f = d->fmu == NULL ? NULL : &d->fmu[k];

    d->failed_fmu = k;
    if (f == NULL || f->library == NULL) {
        return BGC_FMU;
    }
    for (int i = 0; i < info->n_variable; i++) {
        const bgc_fmu_variable *v = &info->variable[i];
        if (v->role != BGC_FMU_OUTPUT) {
            f->number[i] = (d->held_value[v->held] - v->offset) / v->factor;
            if (!isfinite(f->number[i])) {
                d->core.failed_held = v->held;
                return BGC_BAD_SAMPLE;
            }
        }
    }
    if (!advance_fmu(f, t, d->sampling[2 * info->rate])) {
        return BGC_FMU;
    }
    for (int i = 0; i < info->n_variable; i++) {
        const bgc_fmu_variable *v = &info->variable[i];
        if (v->role == BGC_FMU_OUTPUT) {
            d->held_value[v->held] = v->factor * f->number[i] + v->offset;
        }
    }
    d->failed_fmu = -1;
    return BGC_OK;
}

bgc_status bgc_take_fmus(const bgc_model *m, bgc_data *d, int rate, double t) {
    bgc_status status = BGC_OK;

    for (int k = 0; status == BGC_OK && k < m->n_fmu; k++) {
        if (m->fmu[k].rate == rate) {
            status = take_instant(m, d, k, t);
        }
    }
    return status;
}

const char *bgc_fmu_reason(const bgc_model *m, const bgc_data *d) {
    const int k = d->failed_fmu;

    if (k < 0 || k >= m->n_fmu) {
        return "";
    }
    return d->fmu == NULL || d->fmu[k].library == NULL ? "it is not open" : d->fmu[k].reason;
}
