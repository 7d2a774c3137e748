/* events.c: replaces events.c in a model without switches. */
#include "bgc_internal.h"

#include <math.h>

void bgc_hold_modes(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

void bgc_release_modes(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

void bgc_find_modes(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
}

void bgc_reset_modes(const bgc_model *m, bgc_data *d) {
    (void)m;
    d->core.unresolved = 0;
    d->core.event_at = (double)NAN;
}

bgc_status bgc_settle(const bgc_model *m, bgc_data *d) {
    return bgc_make_consistent(m, d);
}

void bgc_forget_quiet(bgc_data *d) {
    (void)d;
}

double bgc_stop_for_switch(const bgc_model *m, bgc_data *d, double end) {
    (void)m, (void)d;
    return end;
}

bgc_status bgc_find_event(const bgc_model *m, bgc_data *d, double end, int may_shorten,
                          double *found) {
    (void)m, (void)d, (void)may_shorten;
    *found = end;
    return BGC_OK;
}

bgc_status bgc_handle_event(const bgc_model *m, bgc_data *d, double whole) {
    (void)m, (void)d, (void)whole;
    return BGC_OK;
}
