/* A mass on a spring, written by hand as the compiler would emit it: m v' = -k q - c v + s q^2.
 * With s it runs to infinity in finite time; beyond q = limit its assertion fails. */
#include "bgc.h"

#include <math.h>

static const bgc_param_info params[] = {
    {"mass", "kg", 1.0, 0.0, 1000.0},           {"spring.k", "N/m", 4.0, -INFINITY, INFINITY},
    {"spring.c", "N*s/m", 0.0, 0.0, INFINITY},  {"s", "N/m^2", 0.0, -INFINITY, INFINITY},
    {"limit", "m", 1e300, -INFINITY, INFINITY},
};
static const bgc_var_info states[] = {{"spring.q", "m"}, {"body.p", "kg*m/s"}};
static const bgc_var_info outputs_[] = {{"q", "m"}, {"v", "m/s"}, {"r[1]", "m"}, {"r[2]", "m"}};
static const char *const messages[] = {"the spring is too long"};
static const char *const checks[] = {"the mass must be positive"};
static const int jac_row[] = {0, 1, 1}, jac_col[] = {1, 0, 1};

static void prepare(const double *p, double *h, double *w) {
    (void)w;
    for (int i = 0; i < 5; i++) {
        h[i] = p[i];
    }
}

static void positive(const double *p, const double *h, double *check, double *w) {
    (void)h, (void)w;
    check[0] = p[0];
}

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    (void)h, (void)t, (void)u, (void)w;
    x[0] = 1.0;
    x[1] = 0.0;
}

static void scale(const double *h, double *s, double *w) {
    (void)w;
    s[0] = 1.0;
    s[1] = h[0];
}

static void rhs(const double *h, double t, const double *x, const double *u, double *f, double *w) {
    (void)t, (void)u, (void)w;
    f[0] = x[1] / h[0];
    f[1] = -h[1] * x[0] - h[2] * x[1] / h[0] + h[3] * x[0] * x[0];
}

static void jacobian(const double *h, double t, const double *x, const double *u, double *jac,
                     double *dfdt, double *w) {
    (void)t, (void)u, (void)w;
    jac[0] = 1.0 / h[0];
    jac[1] = -h[1] + 2.0 * h[3] * x[0];
    jac[2] = -h[2] / h[0];
    dfdt[0] = dfdt[1] = 0.0;
}

/* W = [c, -j0; -j1, c - j2] */
static int factor(const double *m, const double *jac, double c, double *lu, double *growth) {
    (void)m;
    lu[0] = c;
    lu[1] = -jac[0];
    lu[2] = -jac[1] / c;
    lu[3] = c - jac[2] - lu[2] * lu[1];
    *growth = 1.0;
    return lu[3] == 0.0;
}

static void solve(const double *lu, double *b, double *w) {
    (void)w;
    b[1] = (b[1] - lu[2] * b[0]) / lu[3];
    b[0] = (b[0] - lu[1] * b[1]) / lu[0];
}

static void outputs(const double *h, double t, const double *x, const double *u, double *y,
                    double *w) {
    (void)t, (void)u, (void)w;
    y[0] = x[0];
    y[1] = x[1] / h[0];
    y[2] = 2.0 * x[0];
    y[3] = 3.0 * x[0];
}

static void energy(const double *h, double t, const double *x, const double *u, double out[3],
                   double *w) {
    (void)t, (void)u, (void)w;
    out[0] = 0.5 * h[1] * x[0] * x[0] + 0.5 * x[1] * x[1] / h[0];
    out[1] = 0.0;
    out[2] = h[2] * x[1] * x[1] / (h[0] * h[0]);
}

static void asserts(const double *h, double t, const double *x, const double *u, double *a,
                    double *w) {
    (void)t, (void)u, (void)w;
    a[0] = x[0] < h[4];
}

static const bgc_model model = {
    .abi = BGC_ABI, .name = "oscillator", .hash = "0", .n_param = 5, .n_hoist = 5, .n_state = 2,
    .n_output = 4, .n_assert = 1, .n_jac = 3, .n_lu = 4, .n_work = 1, .param = params,
    .state = states, .output = outputs_, .assertion = messages, .param_check = checks,
    .n_check = 1, .jac_row = jac_row, .jac_col = jac_col, .duration = 2.0, .prepare = prepare,
    .positive = positive, .initial = initial, .scale = scale, .rhs = rhs, .jacobian = jacobian,
    .factor = factor, .solve = solve, .outputs = outputs, .energy = energy, .asserts = asserts,
};

const bgc_model *bgc_get_model(void) { return &model; }
