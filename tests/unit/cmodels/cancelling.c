/* x swings at w = 1 rad/s by a matrix of large entries that cancel: its eigenvalues are w i and -w i, that of
 * its absolute values is about 2 k. */
enum { N = 2, P = 1, J = 4 };
static const int jac_row[] = {0, 0, 1, 1}, jac_col[] = {0, 1, 0, 1};
#include "frame.h"

static const bgc_param_info param[] = {{"k", "1/s", 10.0, 0.0, INFINITY}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
    x[1] = 0.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    const double k = h[0];

    UNUSED;
    f[0] = k * x[0] - (k + 1.0 / k) * x[1];
    f[1] = k * x[0] - k * x[1];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = jac[2] = h[0];
    jac[1] = -(h[0] + 1.0 / h[0]);
    jac[3] = -h[0];
    memset(dfdt, 0, N * sizeof *dfdt);
}

MODEL(.explicit_cost = 0.3)
