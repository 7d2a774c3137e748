/* x = (cos t, -sin t, cos t) for every k, but for the start `apart` of the third state, which decays: the
 * rate at which the third state returns to the first rises from 1 to 1 + k at t = p1 and falls again at
 * t = p2. */
enum { N = 3, P = 5, J = 5 };
static const int jac_row[] = {0, 1, 2, 2, 2}, jac_col[] = {1, 0, 0, 1, 2};
#include "frame.h"

static const bgc_param_info param[] = {{"k", "", 1e5, 0.0, INFINITY},
                                       {"wakes", "s", 20.0, -INFINITY, INFINITY},
                                       {"rests", "s", 40.0, -INFINITY, INFINITY},
                                       {"sharp", "1/s", 4.0, 0.0, INFINITY},
                                       {"apart", "", 0.0, 0.0, INFINITY}};

static double rate(const double *h, double t) {
    return 1.0 + 0.5 * h[0] * (tanh(h[3] * (t - h[1])) - tanh(h[3] * (t - h[2])));
}

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
    x[2] = 1.0 + h[4];
    x[1] = 0.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = x[1];
    f[1] = -x[0];
    f[2] = -rate(h, t) * (x[2] - x[0]) + x[1];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const double one = tanh(h[3] * (t - h[1])), other = tanh(h[3] * (t - h[2]));

    UNUSED;
    jac[0] = jac[3] = 1.0;
    jac[1] = -1.0;
    jac[2] = rate(h, t);
    jac[4] = -jac[2];
    dfdt[0] = dfdt[1] = 0.0;
    dfdt[2] = -0.5 * h[3] * h[0] * (other * other - one * one) * (x[2] - x[0]);
}

MODEL(.explicit_cost = 0.4)
