/* Robertson's reaction with the conservation of mass as an algebraic equation: index 1. The start
 * of x[2] is a guess, for the runtime to put right. */
enum { N = 3, P = 1, J = 9 };
static const int jac_row[] = {0, 0, 0, 1, 1, 1, 2, 2, 2}, jac_col[] = {0, 1, 2, 0, 1, 2, 0, 1, 2};
#define MASS 2
static const int mass_row[] = {0, 1}, mass_col[] = {0, 1};
#include "frame.h"

static const bgc_param_info param[] = {{"guess", "", 0.5, -INFINITY, INFINITY}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
    x[1] = 0.0;
    x[2] = h[0];
}

static void mass(const double *h, double *m, double *w) {
    (void)h;
    (void)w;
    m[0] = m[1] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = -0.04 * x[0] + 1e4 * x[1] * x[2];
    f[1] = 0.04 * x[0] - 1e4 * x[1] * x[2] - 3e7 * x[1] * x[1];
    f[2] = x[0] + x[1] + x[2] - 1.0;
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const double entry[9] = {-0.04, 1e4 * x[2],                1e4 * x[1],
                             0.04,  -1e4 * x[2] - 6e7 * x[1],  -1e4 * x[1],
                             1.0,   1.0,                       1.0};
    UNUSED;
    memcpy(jac, entry, sizeof entry);
    memset(dfdt, 0, N * sizeof *dfdt);
}

MODEL(.mass = mass)
