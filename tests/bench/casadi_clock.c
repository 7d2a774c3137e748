/* casadi_clock.c: seconds a call of a function in CasADi's C interface, of (t, x, h). */
#include "clock.h"

#include <stdlib.h>

typedef int (*casadi_function)(const double **arguments, double **results, long long *iw, double *w,
                               int memory);

/* The least of several batches; the second result lies `first` behind the first. */
double casadi_seconds(casadi_function call, double *t, double *x, double *h, double *out, int first,
                      int n_work, int calls, int batches) {
    double *w = calloc((size_t)n_work + 1, sizeof *w);
    const double x0 = x[0];
    double best = 1e9;

    for (int batch = 0; batch < batches; batch++) {
        const double start = clock_now();
        double each;
        for (int k = 0; k < calls; k++) {
            const double *arguments[8] = {t, x, h};
            double *results[8] = {out, out + first};
            long long iw[8];
            x[0] = x0 + 1e-12 * k;
            call(arguments, results, iw, w, 0);
        }
        each = (clock_now() - start) / calls;
        best = each < best ? each : best;
    }
    x[0] = x0;
    free(w);
    return best;
}
