/* A clock x[1] that runs while x[0] = 1 is above a wave of the period p[0], whose amplitude grows from 1e-6
 * by the factor p[1] in each period. Steps of one period end where the wave is zero. */
enum { N = 2, P = 2, J = 1 };
static const int jac_row[] = {0}, jac_col[] = {0};
#include "frame.h"

static const bgc_param_info param[] = {{"period", "s", 0.01, 0.0, INFINITY},
                                       {"growth", "", 1.3, 0.0, INFINITY}};

static double margin(SIGNATURE) {
    const double periods = t / h[0], wave = sin(3.14159265358979323846 * periods);
    (void)u;
    return x[0] - 1e-6 * pow(h[1], periods) * wave * wave;
}

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 1.0;
    x[1] = 0.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    f[0] = 0.0;
    f[1] = isnan(u[0]) ? margin(h, t, x, u) > 0.0 : u[0];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    jac[0] = dfdt[0] = dfdt[1] = 0.0;
}

static void switches(SIGNATURE, double *z, double *w) {
    UNUSED;
    z[0] = margin(h, t, x, u);
}

static const bgc_switch_info switch_info[] = {{BGC_ABOVE, 0, 1}};

MODEL(.n_switch = 1, .switch_info = switch_info, .switches = switches)
