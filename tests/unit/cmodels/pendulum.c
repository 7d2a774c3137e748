/* A pendulum (1 kg, 1 m) on a stiff spring whose stretch q is a state: x, z, vx, vz, q. */
enum { N = 5, P = 2, J = 14 };
static const int jac_row[] = {0, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 4, 2, 3};
static const int jac_col[] = {2, 3, 0, 1, 4, 0, 1, 4, 0, 1, 2, 3, 2, 3};
#include "frame.h"

static const double g = 9.81;
static const bgc_param_info param[] = {{"k", "N/m", 1e8, 1.0, INFINITY},
                                       {"d", "N*s/m", 0.0, 0.0, INFINITY}};

/* Released from rest at 1 rad, the spring in balance with gravity. */
static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    x[4] = g * cos(1.0) / h[0];
    x[0] = (1.0 + x[4]) * sin(1.0);
    x[1] = -(1.0 + x[4]) * cos(1.0);
    x[2] = x[3] = 0.0;
}

static void rhs(SIGNATURE, double *f, double *w) {
    const double length = sqrt(x[0] * x[0] + x[1] * x[1]);
    const double nx = x[0] / length, nz = x[1] / length;
    UNUSED;
    f[0] = x[2];
    f[1] = x[3];
    f[2] = -h[0] * x[4] * nx - h[1] * x[2];
    f[3] = -h[0] * x[4] * nz - h[1] * x[3] - g;
    f[4] = nx * x[2] + nz * x[3];
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const double length = sqrt(x[0] * x[0] + x[1] * x[1]);
    const double nx = x[0] / length, nz = x[1] / length, force = h[0] * x[4];
    const double xx = nz * nz / length, xz = -nx * nz / length, zz = nx * nx / length;
    UNUSED;
    jac[0] = jac[1] = 1.0;
    jac[2] = -force * xx;
    jac[3] = -force * xz;
    jac[4] = -h[0] * nx;
    jac[5] = -force * xz;
    jac[6] = -force * zz;
    jac[7] = -h[0] * nz;
    jac[8] = xx * x[2] + xz * x[3];
    jac[9] = xz * x[2] + zz * x[3];
    jac[10] = nx;
    jac[11] = nz;
    jac[12] = jac[13] = -h[1];
    memset(dfdt, 0, N * sizeof *dfdt);
}

static void energy(SIGNATURE, double out[3], double *w) {
    UNUSED;
    out[0] = 0.5 * (x[2] * x[2] + x[3] * x[3]) + g * x[1] + 0.5 * h[0] * x[4] * x[4];
    out[1] = 0.0;
    out[2] = h[1] * (x[2] * x[2] + x[3] * x[3]);
}

MODEL(.energy = energy)
