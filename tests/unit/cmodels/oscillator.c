/* A damped oscillator (momentum p, displacement q) that a force sin t drives; its books, bounds on
 * its parameters and an assertion on its displacement. */
enum { N = 2, P = 4, J = 3 };
static const int jac_row[] = {0, 0, 1}, jac_col[] = {0, 1, 0};
#include "frame.h"

static const bgc_param_info param[] = {{"mass", "kg", 2.0, 0.0, 100.0},
                                       {"stiffness", "N/m", 3.0, 0.0, INFINITY},
                                       {"damping", "N*s/m", 0.4, 0.0, INFINITY},
                                       {"limit", "m", 10.0, -INFINITY, INFINITY}};
static const char *const assertion[] = {"the displacement stays below its limit"};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 0.0;
    x[1] = 1.0;
}

static void positive(const double *p, const double *h, double *check, double *w) {
    (void)h;
    (void)w;
    check[0] = p[0];
}

/* Critical damping, where the user gives none and makes the mass more than 50 kg. */
static void defaults(double *p, const unsigned char *is_set, double *w) {
    (void)w;
    if (!is_set[2] && p[0] > 50.0) {
        p[2] = 2.0 * sqrt(p[0] * p[1]);
    }
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = sin(t) - h[1] * x[1] - h[2] * x[0] / h[0];
    f[1] = x[0] / h[0];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = -h[2] / h[0];
    jac[1] = -h[1];
    jac[2] = 1.0 / h[0];
    dfdt[0] = cos(t);
    dfdt[1] = 0.0;
}

static void energy(SIGNATURE, double out[3], double *w) {
    const double v = x[0] / h[0];
    UNUSED;
    out[0] = 0.5 * (x[0] * v + h[1] * x[1] * x[1]);
    out[1] = sin(t) * v;
    out[2] = h[2] * v * v;
}

static void asserts(SIGNATURE, double *a, double *w) {
    UNUSED;
    a[0] = x[1] < h[3];
}

MODEL(.energy = energy, .n_check = 1, .positive = positive, .defaults = defaults, .n_assert = 1,
      .assertion = assertion, .asserts = asserts)
