/* Equations that fail, as `kind` says: 0 y' = y^2 escapes at t = 1; 1 y' = -sqrt(y) leaves its
 * domain at t = 2; 2 the algebraic equation 0 = y^2 + 1 - z has one solution, and 0 = z^2 + 1 + y
 * (kind 3) none; for kind 4 it is 0 = 0. */
enum { N = 2, P = 1, J = 4 };
static const int jac_row[] = {0, 0, 1, 1}, jac_col[] = {0, 1, 0, 1};
#define MASS 1
static const int mass_row[] = {0}, mass_col[] = {0};
#include "frame.h"

static const bgc_param_info param[] = {{"kind", "", 0.0, 0.0, 4.0}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
    x[1] = 0.5;
}

static void mass(const double *h, double *m, double *w) {
    (void)h;
    (void)w;
    m[0] = 1.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    const int kind = (int)h[0];
    UNUSED;
    f[0] = kind == 1 ? -sqrt(x[0]) : kind == 0 ? x[0] * x[0] : -x[0];
    f[1] = kind == 3 ? x[1] * x[1] + 1.0 + x[0] : kind == 4 ? 0.0 : x[0] * x[0] + 1.0 - x[1];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const int kind = (int)h[0];
    UNUSED;
    jac[0] = kind == 1 ? -0.5 / sqrt(x[0]) : kind == 0 ? 2.0 * x[0] : -1.0;
    jac[1] = 0.0;
    jac[2] = kind == 3 ? 1.0 : kind == 4 ? 0.0 : 2.0 * x[0];
    jac[3] = kind == 3 ? 2.0 * x[1] : kind == 4 ? 0.0 : -1.0;
    dfdt[0] = dfdt[1] = 0.0;
}

MODEL(.mass = mass)
