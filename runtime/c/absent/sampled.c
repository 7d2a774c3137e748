/* sampled.c: replaces sampled.c in a model without `sample`. */
#include "bgc_internal.h"

void bgc_start_sampled(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

bgc_status bgc_take_sampled(const bgc_model *m, bgc_data *d, double slack) {
    (void)m, (void)d, (void)slack;
    return BGC_OK;
}
