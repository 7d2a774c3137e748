/* y' = -a, 0 = tiny a + b - y, 0 = a + b - 2 y, so that y = exp(-t) nearly; elimination in this
 * order divides by `tiny`. */
enum { N = 3, P = 1, J = 8 };
static const int jac_row[] = {0, 0, 0, 1, 1, 1, 2, 2}, jac_col[] = {0, 1, 2, 0, 1, 2, 0, 1};
#define MASS 1
static const int mass_row[] = {2}, mass_col[] = {2};
#include "frame.h"

static const bgc_param_info param[] = {{"tiny", "", 1e-14, 0.0, 1.0}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = x[1] = x[2] = 1.0;
}

static void mass(const double *h, double *m, double *w) {
    (void)h;
    (void)w;
    m[0] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = h[0] * x[0] + x[1] - x[2];
    f[1] = x[0] + x[1] - 2.0 * x[2];
    f[2] = -x[0];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const double entry[J] = {h[0], 1.0, -1.0, 1.0, 1.0, -2.0, -1.0, 0.0};
    UNUSED;
    memcpy(jac, entry, sizeof entry);
    memset(dfdt, 0, N * sizeof *dfdt);
}

MODEL(.mass = mass)
