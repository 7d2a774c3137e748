/* A tank whose inflow balances its outflow: x' = 1 - 10 sqrt(x), from x = 1 to x = 0.01. */
enum { N = 1, P = 1, J = 1 };
static const int jac_row[] = {0}, jac_col[] = {0};
#include "frame.h"

static const bgc_param_info param[] = {{"inflow", "", 1.0, 0.0, INFINITY}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = h[0] - 10.0 * sqrt(x[0]);
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = -5.0 / sqrt(x[0]);
    dfdt[0] = 0.0;
}

MODEL()
