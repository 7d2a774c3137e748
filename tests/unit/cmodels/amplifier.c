/* The transistor amplifier of the Test Set for IVP Solvers (CWI and Bari): M singular and not
 * diagonal, index 1. */
enum { N = 8, P = 1, J = 64 };
#define MASS 14
static const int mass_row[] = {0, 0, 1, 1, 2, 3, 3, 4, 4, 5, 6, 6, 7, 7};
static const int mass_col[] = {0, 1, 0, 1, 2, 3, 4, 3, 4, 5, 6, 7, 6, 7};
#define ROW(i) i, i, i, i, i, i, i, i
#define COL 0, 1, 2, 3, 4, 5, 6, 7
static const int jac_row[] = {ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6), ROW(7)};
static const int jac_col[] = {COL, COL, COL, COL, COL, COL, COL, COL};
#include "frame.h"

static const bgc_param_info param[] = {{"unused", "", 0.0, -INFINITY, INFINITY}};
static const double ub = 6.0, uf = 0.026, alpha = 0.99, beta = 1e-6, r0 = 1000.0, r = 9000.0;
static const double pi = 3.14159265358979324;

static double current(double volt) { return beta * (exp(volt / uf) - 1.0); }
static double conductance(double volt) { return beta / uf * exp(volt / uf); }

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    const double start[N] = {0.0, ub / 2, ub / 2, ub, ub / 2, ub / 2, ub, 0.0};
    UNUSED;
    memcpy(x, start, sizeof start);
}

static void mass(const double *h, double *m, double *w) {
    const double entry[MASS] = {-1e-6, 1e-6, 1e-6, -1e-6, -2e-6, -3e-6, 3e-6,
                                3e-6,  -3e-6, -4e-6, -5e-6, 5e-6, 5e-6, -5e-6};
    (void)h;
    (void)w;
    memcpy(m, entry, sizeof entry);
}

static void rhs(SIGNATURE, double *f, double *w) {
    const double first = current(x[1] - x[2]), second = current(x[4] - x[5]);
    UNUSED;
    f[0] = (x[0] - 0.1 * sin(200.0 * pi * t)) / r0;
    f[1] = x[1] / r + (x[1] - ub) / r + (1.0 - alpha) * first;
    f[2] = x[2] / r - first;
    f[3] = (x[3] - ub) / r + alpha * first;
    f[4] = x[4] / r + (x[4] - ub) / r + (1.0 - alpha) * second;
    f[5] = x[5] / r - second;
    f[6] = (x[6] - ub) / r + alpha * second;
    f[7] = x[7] / r;
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    const double first = conductance(x[1] - x[2]), second = conductance(x[4] - x[5]);
    const double part[3] = {1.0 - alpha, -1.0, alpha};
    const double linear[N] = {1.0 / r0, 2.0 / r, 1.0 / r, 1.0 / r,
                              2.0 / r,  1.0 / r, 1.0 / r, 1.0 / r};
    UNUSED;
    memset(jac, 0, J * sizeof *jac);
    memset(dfdt, 0, N * sizeof *dfdt);
    for (int i = 0; i < N; i++) {
        jac[i * N + i] = linear[i];
    }
    for (int i = 0; i < 3; i++) {
        jac[(1 + i) * N + 1] += part[i] * first;
        jac[(1 + i) * N + 2] -= part[i] * first;
        jac[(4 + i) * N + 4] += part[i] * second;
        jac[(4 + i) * N + 5] -= part[i] * second;
    }
    dfdt[0] = -0.1 * 200.0 * pi * cos(200.0 * pi * t) / r0;
}

MODEL(.mass = mass)
