/* linear_clock.c: times of a factorisation of W and of a solution, as the runtime calls them.
 *
 * The functions are those of a model's shared object, which the caller has loaded. The Jacobian is that of
 * the instance's last step. */
#include "clock.h"

#include <string.h>

typedef bgc_status (*factorise)(const bgc_model *m, bgc_data *d, double c);
typedef bgc_status (*solve)(const bgc_model *m, bgc_data *d, double *b);

/* Seconds a call, the least of several batches, and the last solution, of W x = c scale. */
void clock_linear(const bgc_model *m, bgc_data *d, factorise factor, solve solution,
                  const double *scale, double c, int calls, int batches, double seconds[2], double *x) {
    const size_t n = (size_t)m->n_state;

    seconds[0] = seconds[1] = 1e9;
    for (int batch = 0; batch < batches; batch++) {
        double start[3];
        start[0] = clock_now();
        for (int k = 0; k < calls; k++) {
            factor(m, d, c * (1.0 + 1e-9 * k));
        }
        start[1] = clock_now();
        for (int k = 0; k < 8 * calls; k++) {
            for (size_t i = 0; i < n; i++) {
                x[i] = c * scale[i];
            }
            solution(m, d, x);
        }
        start[2] = clock_now();
        for (int k = 0; k < 2; k++) {
            const double each = (start[k + 1] - start[k]) / (k == 0 ? calls : 8 * calls);
            seconds[k] = each < seconds[k] ? each : seconds[k];
        }
    }
}
