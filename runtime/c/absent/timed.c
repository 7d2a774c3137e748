/* timed.c: replaces timed.c in a model without terms of time alone that need watching. */
#include "bgc_internal.h"

void bgc_reset_terms(const bgc_model *m, bgc_data *d) {
    d->core.limited_by = -1;
    bgc_reset_time_windows(m, d);
}

double bgc_limit_for_time(const bgc_model *m, bgc_data *d, double t, double h) {
    (void)m, (void)d, (void)t;
    return h;
}

void bgc_judge_terms(const bgc_model *m, bgc_data *d, double h) {
    (void)m, (void)d, (void)h;
}
