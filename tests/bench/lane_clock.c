/* lane_clock.c: times of the functions of a model on lanes, as clock.c has those of one instance. */
#include "bgc_lanes.h"
#include "clock.h"

#include <stdlib.h>
#include <string.h>

static lane *lanes(int count) {
    const size_t size = ((size_t)count + 1) * sizeof(lane);
    lane *made = aligned_alloc(64, (size + 63) & ~(size_t)63);

    memset(made, 0, size);
    return made;
}

/* Every lane gets its own state, a little apart from the others. */
static lane *spread(int count, const double *from, double by) {
    lane *made = lanes(count);

    for (int i = 0; i < count; i++) {
        for (int l = 0; l < BGC_LANE_WIDTH; l++) {
            lane_set(made + i, l, from[i] * (1.0 + by * l));
        }
    }
    return made;
}

int lane_clock_width(void) { return BGC_LANE_WIDTH; }

/* Seconds a call of f, J, factor and solve on all lanes together, the least of several batches. */
void clock_lanes(const bgc_model *m, const bgc_lane_model *on, const double *p, const double *x0,
                 double t, int calls, int batches, double seconds[4]) {
    const int n = m->n_state;
    double *h0 = calloc((size_t)m->n_hoist + 1, sizeof *h0);
    double *work0 = calloc((size_t)m->n_work + 1, sizeof *work0);
    double *mass0 = calloc((size_t)m->n_mass + 1, sizeof *mass0);
    lane *h, *x, *mass, *f = lanes(n), *dfdt = lanes(n), *b = lanes(n);
    lane *jac = lanes(m->n_inner > 0 ? m->n_local : m->n_jac), *lu = lanes(m->n_lu), *work = lanes(on->n_work), growth;

    m->prepare(p, h0, work0);
    m->mass(h0, mass0, work0);
    h = spread(m->n_hoist, h0, 0.0);
    mass = spread(m->n_mass, mass0, 0.0);
    x = spread(n, x0, 1e-9);
    for (int k = 0; k < 4; k++) {
        seconds[k] = 1e9;
    }
    for (int batch = 0; batch < batches; batch++) {
        double start[5];
        start[0] = clock_now();
        for (int k = 0; k < calls; k++) {
            x[0] += 1e-12;
            on->rhs(h, lane_of(t), x, NULL, f, work);
        }
        start[1] = clock_now();
        for (int k = 0; k < calls; k++) {
            x[0] += 1e-12;
            on->jacobian(h, lane_of(t), x, NULL, jac, dfdt, work);
        }
        start[2] = clock_now();
        for (int k = 0; k < calls; k++) {
            on->factor(mass, jac, lane_of(1e3 + 1e-9 * k), lu, &growth);
        }
        start[3] = clock_now();
        for (int k = 0; k < calls; k++) {
            memcpy(b, f, (size_t)n * sizeof *b);
            on->solve(lu, b, work);
        }
        start[4] = clock_now();
        for (int k = 0; k < 4; k++) {
            const double each = (start[k + 1] - start[k]) / calls;
            seconds[k] = each < seconds[k] ? each : seconds[k];
        }
    }
    free(h0), free(work0), free(mass0), free(h), free(x), free(mass), free(f), free(dfdt);
    free(b), free(jac), free(lu), free(work);
}
