/* y' = lambda (y - cos t) - sin t, y = cos t: A. Prothero, A. Robinson, Math. Comp. 28 (1974). */
enum { N = 1, P = 1, J = 1 };
static const int jac_row[] = {0}, jac_col[] = {0};
#include "frame.h"

static const bgc_param_info param[] = {{"lambda", "", -1e6, -INFINITY, 0.0}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = cos(t);
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = h[0] * (x[0] - cos(t)) - sin(t);
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = h[0];
    dfdt[0] = h[0] * sin(t) - cos(t);
}

MODEL()
