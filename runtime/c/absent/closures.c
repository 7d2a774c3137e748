/* closures.c: replaces closures.c in a model without closed chains of rigid connections. */
#include "closures.h"

size_t bgc_closing_size(const bgc_model *m) {
    (void)m;
    return 0;
}

int bgc_chain_rows(const bgc_model *m) {
    (void)m;
    return 0;
}

bgc_status bgc_evaluate_chain_rows(const bgc_model *m, bgc_data *d, double *value, double *slope) {
    (void)m, (void)d, (void)value, (void)slope;
    return BGC_OK;
}

bgc_status bgc_close_chains(const bgc_model *m, bgc_data *d, double t, double *x) {
    (void)m, (void)d, (void)t, (void)x;
    return BGC_OK;
}

bgc_status bgc_close_chains_at_start(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

void bgc_reset_chains(const bgc_model *m, bgc_data *d) { (void)m, (void)d; }

bgc_status bgc_choose_chain_rows(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

bgc_status bgc_close_start(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return BGC_OK;
}

void bgc_closing_moves(const bgc_model *m, bgc_data *d, double *move) {
    (void)d;
    for (int k = 0; k < m->n_state; k++) {
        move[k] = 0.0;
    }
}

bgc_status bgc_watch_chains(const bgc_model *m, bgc_data *d, double t, const double *x) {
    (void)m, (void)d, (void)t, (void)x;
    return BGC_OK;
}

int bgc_chains_were_left(const bgc_model *m, const bgc_data *d, const double *x) {
    (void)m, (void)d, (void)x;
    return 0;
}

void bgc_enter_chains(const bgc_model *m, bgc_data *d) { (void)m, (void)d; }

bgc_status bgc_status_near_chains(const bgc_model *m, const bgc_data *d, bgc_status status) {
    (void)m, (void)d;
    return status;
}

/* --- for derivatives of a run, which ask nothing of a model without chains */

int bgc_evaluate_chains(const bgc_model *m, bgc_data *d, double t, const double *x, bgc_chain_parts *p) {
    (void)m, (void)d, (void)t, (void)x, (void)p;
    return 0;
}

void bgc_chain_response(const bgc_closure_info *c, const double *left, const double *right, int n,
                        const int *row, double *s) {
    (void)c, (void)left, (void)right, (void)n, (void)row, (void)s;
}

int bgc_list_chosen(const double *flag, int first, int last, int *list) {
    (void)flag, (void)first, (void)last, (void)list;
    return 0;
}

int bgc_list_conditions(const bgc_model *m, bgc_data *d) {
    (void)m, (void)d;
    return 0;
}

int bgc_least_chain_change(bgc_data *d, int n, const double *slopes, int width, double damping,
                           bgc_chain_parts *p) {
    (void)d, (void)n, (void)slopes, (void)width, (void)damping, (void)p;
    return 0;
}
