/* A mass on a spring that meets a damped end stop: the force jumps at contact. With UNLOCATED the
 * runtime does not know of the switch. A second switch, timed, pushes from p[1] on; with p[2] = 1 the
 * stop pushes so that it chatters. With KEPT, f keeps an argument for its caller. */
enum { N = 2, P = 3, J = 4 };
static const int jac_row[] = {0, 0, 1, 1}, jac_col[] = {0, 1, 0, 1};
#include "frame.h"

static const bgc_param_info param[] = {{"gap", "m", 0.5, -INFINITY, INFINITY},
                                       {"push from", "s", INFINITY, -INFINITY, INFINITY},
                                       {"push back", "N", 0.0, -INFINITY, INFINITY}};

static int mode(const double *u, int k, double z) {
#ifdef UNLOCATED
    (void)u;
    (void)k;
    return z > 0.0;
#else
    return isnan(u[k]) ? z > 0.0 : u[k] != 0.0;
#endif
}

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[0] = 0.0;
    x[1] = 3.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
#ifdef KEPT
    w[0] = x[0] - h[0];
#endif
    f[0] = x[1];
    f[1] = -9.0 * x[0];
    if (mode(u, 0, t - h[1])) {
        f[1] += 2.0;
    }
    if (mode(u, 1, x[0] - h[0])) {
        f[1] -= 40.0 * (x[0] - h[0]) + 2.0 * x[1];
    }
    if (mode(u, 2, x[1])) {
        f[1] -= h[2];
    }
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const int stopped = mode(u, 1, x[0] - h[0]);
    UNUSED;
    jac[0] = 0.0;
    jac[1] = 1.0;
    jac[2] = -9.0 - (stopped ? 40.0 : 0.0);
    jac[3] = stopped ? -2.0 : 0.0;
    dfdt[0] = dfdt[1] = 0.0;
}

static void energy(SIGNATURE, double out[3], double *w) {
    const double over = x[0] - h[0];
    const int stopped = mode(u, 1, over);
    UNUSED;
    out[0] = 0.5 * (x[1] * x[1] + 9.0 * x[0] * x[0] + (stopped ? 40.0 * over * over : 0.0));
    out[1] = mode(u, 0, t - h[1]) ? 2.0 * x[1] : 0.0;
    out[2] = (stopped ? 2.0 * x[1] * x[1] : 0.0) + (mode(u, 2, x[1]) ? h[2] * x[1] : 0.0);
}

#ifdef UNLOCATED
MODEL(.energy = energy)
#else
int switch_calls;

static void switches(SIGNATURE, double *z, double *w) {
    UNUSED;
    switch_calls++;
    z[0] = t - h[1];
    z[1] = x[0] - h[0];
    z[2] = x[1];
}

#ifdef KEPT
static void behind(SIGNATURE, double *z, double *w) {
    UNUSED;
    z[0] = t - h[1];
    z[1] = w[0];
    z[2] = x[1];
}
#else
#define behind NULL
#endif

static const bgc_switch_info switch_info[] = {
    {BGC_ABOVE, 1, 1}, {BGC_ABOVE, 0, 1}, {BGC_ABOVE, 0, 1}};

MODEL(.energy = energy, .n_switch = 3, .n_timed = 1, .switch_info = switch_info,
      .n_work = 1, .switches = switches, .switches_after_rhs = behind)
#endif
