/* fmus.c: replaces fmus.c, fmus2.c and fmus3.c in a model without FMUs of other tools. */
#include "bgc_internal.h"

#include <stdio.h>

bgc_status bgc_open_fmu(const bgc_model *m, bgc_data *d, int k, const char *library, const char *resources,
                        char *message, size_t size) {
    (void)m, (void)d, (void)library, (void)resources;
    snprintf(message, size, "the model has no FMU %d", k);
    return BGC_BAD_ARGUMENT;
}

void bgc_close_fmus(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

void bgc_renew_fmus(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

bgc_status bgc_take_fmus(const bgc_model *m, bgc_data *d, int rate, double t) {
    (void)m, (void)d, (void)rate, (void)t;
    return BGC_OK;
}

const char *bgc_fmu_reason(const bgc_model *m, const bgc_data *d) {
    (void)m, (void)d;
    return "";
}
