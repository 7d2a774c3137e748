/* y' = z - y with the algebraic equation 0 = z - u, whose input jumps at samples. */
enum { N = 2, P = 1, J = 3 };
static const int jac_row[] = {0, 0, 1}, jac_col[] = {0, 1, 1};
#define MASS 1
static const int mass_row[] = {0}, mass_col[] = {0};
#include "frame.h"

static const bgc_param_info param[] = {{"unused", "", 0.0, -INFINITY, INFINITY}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = x[1] = 0.0;
}

static void mass(const double *h, double *m, double *w) {
    (void)h;
    (void)w;
    m[0] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = x[1] - x[0];
    f[1] = x[1] - u[0];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = -1.0;
    jac[1] = jac[2] = 1.0;
    dfdt[0] = dfdt[1] = 0.0;
}

MODEL(.mass = mass, .step = 0.1, .n_input = 1)
