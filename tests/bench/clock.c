/* clock.c: times of the functions of a compiled model, and of its runs.
 *
 * The model's shared object is loaded by the caller, who passes what bgc_get_model gave. States are
 * moved a little between calls, so that no call can be moved out of the loop. */
#include "clock.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Seconds that this thread has computed: others on the machine do not count. */
double clock_now(void) {
    struct timespec now;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Seconds a call of f, J, factor and solve, the least of several batches; h, x and u are an
 * instance's. `t` is passed to the functions. */
void clock_kernels(const bgc_model *m, const double *p, const double *x0, const double *u, double t,
                   int calls, int batches, double seconds[4]) {
    const size_t n = (size_t)m->n_state;
    double *h = calloc((size_t)m->n_hoist + 1, sizeof *h);
    double *work = calloc((size_t)m->n_work + n + 1, sizeof *work);
    double *x = calloc(n, sizeof *x), *f = calloc(n, sizeof *f), *dfdt = calloc(n, sizeof *dfdt);
    double *b = calloc(n, sizeof *b);
    double *jac = calloc((size_t)(m->n_inner > 0 ? m->n_local : m->n_jac) + 1, sizeof *jac);
    double *mass = calloc((size_t)m->n_mass + 1, sizeof *mass);
    double *lu = calloc((size_t)m->n_lu + 1, sizeof *lu);
    double growth = 0.0;

    memcpy(x, x0, n * sizeof *x);
    m->prepare(p, h, work);
    m->mass(h, mass, work);
    for (int k = 0; k < 4; k++) {
        seconds[k] = 1e9;
    }
    for (int batch = 0; batch < batches; batch++) {
        double start[5];
        start[0] = clock_now();
        for (int k = 0; k < calls; k++) {
            x[0] = x0[0] + 1e-12 * k;
            m->rhs(h, t, x, u, f, work);
        }
        start[1] = clock_now();
        for (int k = 0; k < calls; k++) {
            x[0] = x0[0] + 1e-12 * k;
            m->jacobian(h, t, x, u, jac, dfdt, work);
        }
        start[2] = clock_now();
        for (int k = 0; k < calls && m->factor != NULL; k++) {
            m->factor(mass, jac, 1e3 + 1e-9 * k, lu, &growth);
        }
        start[3] = clock_now();
        for (int k = 0; k < calls && m->solve != NULL; k++) {
            memcpy(b, f, n * sizeof *b); /* solved again and again it would vanish */
            m->solve(lu, b, work);
        }
        start[4] = clock_now();
        for (int k = 0; k < 4; k++) {
            const double each = (start[k + 1] - start[k]) / calls;
            seconds[k] = each < seconds[k] ? each : seconds[k];
        }
    }
    free(h), free(work), free(x), free(f), free(dfdt), free(jac), free(mass), free(lu), free(b);
}

/* An evaluator of f for callers without C: memory for one, f at (t, x), and its release. */
typedef struct {
    const bgc_model *m;
    double *h, *u, *work;
} evaluator;

void *clock_open(const bgc_model *m, const double *p) {
    evaluator *e = malloc(sizeof *e);

    e->m = m;
    e->h = calloc((size_t)m->n_hoist + 1, sizeof *e->h);
    e->u = calloc((size_t)m->n_input + 1, sizeof *e->u);
    e->work = calloc((size_t)m->n_work + 1, sizeof *e->work);
    m->prepare(p, e->h, e->work);
    return e;
}

void clock_rhs(const void *opened, double t, const double *x, double *f) {
    const evaluator *e = opened;

    e->m->rhs(e->h, t, x, e->u, f, e->work);
}

void clock_scale(const void *opened, double *scale) {
    const evaluator *e = opened;

    e->m->scale(e->h, scale, e->work);
}

void clock_close(void *opened) {
    evaluator *e = opened;

    free(e->h), free(e->u), free(e->work), free(e);
}
