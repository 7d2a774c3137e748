/* Kaps' problem: x = (exp(-2 t), exp(-t)) for every eps. K. Dekker, J. G. Verwer, Stability of
 * Runge-Kutta methods for stiff nonlinear differential equations (1984), 7.5. */
enum { N = 2, P = 1, J = 4 };
static const int jac_row[] = {0, 0, 1, 1}, jac_col[] = {0, 1, 0, 1};
#include "frame.h"

static const bgc_param_info param[] = {{"eps", "", 1.0, 0.0, INFINITY}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = x[1] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = -2.0 * x[0] + (x[1] * x[1] - x[0]) / h[0];
    f[1] = x[0] - x[1] * (1.0 + x[1]);
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = -2.0 - 1.0 / h[0];
    jac[1] = 2.0 * x[1] / h[0];
    jac[2] = 1.0;
    jac[3] = -1.0 - 2.0 * x[1];
    dfdt[0] = dfdt[1] = 0.0;
}

MODEL()
