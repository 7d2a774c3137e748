/* jumps.c: replaces jumps.c in a model without `when`. */
#include "bgc_internal.h"

void bgc_reset_jumps(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

bgc_status bgc_meet_edges(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

void bgc_ignore_turned(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

void bgc_judge_turned(const bgc_model *m, bgc_data *d, const double *const *z) {
    (void)m, (void)d, (void)z;
}

bgc_status bgc_jump(const bgc_model *m, bgc_data *d, const double *before, double whole) {
    (void)m, (void)d, (void)before, (void)whole;
    return BGC_OK;
}
