/* A mass that swings freely at 1 rad/s carries a light one on a spring and a damper: of the natural
 * frequency w, a free motion that decays at the rate b, and displaced by d at first. */
enum { N = 4, P = 3, J = 7 };
static const int jac_row[] = {0, 1, 2, 3, 3, 3, 3}, jac_col[] = {1, 0, 3, 0, 1, 2, 3};
#include "frame.h"

#ifndef COST
#define COST 0.3
#endif

static const bgc_param_info param[] = {{"w", "rad/s", 100.0, 0.0, INFINITY},
                                       {"d", "m", 0.0, -INFINITY, INFINITY},
                                       {"b", "1/s", 0.0, 0.0, INFINITY}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
    x[1] = x[3] = 0.0;
    x[2] = x[0] * h[0] * h[0] / (h[0] * h[0] - 1.0) + h[1];
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = x[1];
    f[1] = -x[0];
    f[2] = x[3];
    f[3] = -h[0] * h[0] * (x[2] - x[0]) - 2.0 * h[2] * (x[3] - x[1]);
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = jac[2] = 1.0;
    jac[1] = -1.0;
    jac[3] = h[0] * h[0];
    jac[5] = -jac[3];
    jac[4] = 2.0 * h[2];
    jac[6] = -jac[4];
    memset(dfdt, 0, N * sizeof *dfdt);
}

MODEL(.explicit_cost = COST)
