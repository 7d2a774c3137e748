/* y' = (p - 1) z - p with 0 = z^2 - y. For p = 0 y = (1 - t / 2)^2 and z = 1 - t / 2; for p = 1
 * y = 1 - t, and z = sqrt(1 - t) has no continuation beyond t = 1. */
enum { N = 2, P = 1, J = 3 };
static const int jac_row[] = {0, 1, 1}, jac_col[] = {1, 0, 1};
#define MASS 1
static const int mass_row[] = {0}, mass_col[] = {0};
#include "frame.h"

static const bgc_param_info param[] = {{"p", "", 0.0, 0.0, 1.0}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = x[1] = 1.0;
}

static void mass(const double *h, double *m, double *w) {
    (void)h;
    (void)w;
    m[0] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = (h[0] - 1.0) * x[1] - h[0];
    f[1] = x[1] * x[1] - x[0];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = h[0] - 1.0;
    jac[1] = -1.0;
    jac[2] = 2.0 * x[1];
    dfdt[0] = dfdt[1] = 0.0;
}

MODEL(.mass = mass)
