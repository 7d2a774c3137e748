/* Runs a self-contained model with every method (fixed ones in so many steps), saves it and goes on,
 * and frees it. Prints the bits of all rows, with their errors: equal from run to run. */
#include "bgc.h"

#include <stdio.h>
#include <stdlib.h>

static int run_by(const bgc_model *m, const char *method, int steps) {
    enum { ROWS = 11 };
    const double end = m->duration;
    const int width = 2 * m->n_output + (m->energy != NULL ? 4 : 0);
    const bgc_options options = {
        .name = method, .step = end / steps, .accounts = m->energy != NULL, .errors = 1};
    double *rows = calloc((size_t)ROWS * (size_t)width, sizeof *rows), times[ROWS];
    bgc_data *d = bgc_new(m);
    void *memory = malloc(bgc_save_size(m));
    size_t done = 0;
    bgc_status status;

    for (int k = 0; k < ROWS; k++) {
        times[k] = end * k / (ROWS - 1);
    }
    status = bgc_set_options(m, d, &options);
    status = status == BGC_OK ? bgc_reset(m, d, 0.0) : status;
    status = status == BGC_OK ? bgc_run(m, d, times, ROWS / 2, rows, &done) : status;
    if (status == BGC_OK && bgc_save(m, d, memory) == BGC_OK &&
        bgc_restore(m, d, memory) == BGC_OK) {
        status = bgc_run(m, d, times + ROWS / 2, ROWS - ROWS / 2,
                         rows + (size_t)(ROWS / 2) * (size_t)width, &done);
    }
    printf("%s: %s", method, bgc_status_text(status));
    for (int k = 0; k < ROWS * width; k++) {
        printf(" %a", rows[k]);
    }
    printf("\n");
    free(memory);
    free(rows);
    bgc_free(m, d);
    return status == BGC_OK || status == BGC_NOT_EXPLICIT ? 0 : 1;
}

int main(int count, char **argument) {
    const bgc_model *m = bgc_get_model();
    const int steps = count > 1 ? atoi(argument[1]) : 500;
    bgc_method_info method;
    int failed = 0;

    for (int k = 0; bgc_get_method(k, &method) == BGC_OK; k++) {
        failed |= run_by(m, method.name, steps);
    }
    return failed;
}
