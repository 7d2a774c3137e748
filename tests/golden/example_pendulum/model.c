/* pendulum: a bond graph of model Pendulum, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 lean  [rad]
 *     1 post.r0[3]  [m]
 *     2 load.length  [m]
 *     3 load.mass  [kg]
 *     4 load.radius  [m]
 *     5 load.angles0[1]  [rad]
 *     6 load.swivel.angles0[1]  [rad]
 *     7 load.swivel.lock.stiffness  [N/m]
 *     8 load.swivel.lock.rotational_stiffness  [N*m]
 *     9 load.swivel.lock.damping_ratio
 *    10 load.swivel.lock.mass  [kg]
 *    11 load.swivel.lock.inertia  [kg*m^2]
 *    12 load.swivel.attitude.angles0[1]  [rad]
 *    13 gravity  [m/s^2]
 *
 * States x:
 *     0 load.swivel.lock.spring.q[2]
 *     1 load.swivel.lock.spring.q[3]
 *     2 load.ball.body.p[2]  [N*s]
 *     3 load.ball.body.p[3]  [N*s]
 *     4 load.ball.body.p[4]  [N*m*s]
 *     5 load.swivel.attitude.h[1]
 *     6 load.swivel.attitude.h[2]
 *
 * Outputs y:
 *     0 load[1]  [m]
 *     1 load[2]  [m]
 *     2 load[3]  [m]
 */
#include "bgc.h"

#include <math.h>

static inline double model_min(double a, double b)
{
    return a < b || a != a ? a : b;
}

static inline double model_less(double a, double b)
{
    return a < b ? 1.0 : a >= b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    h[0] = 1.0 / p[3];
    const double v1 = p[4] * (p[4] * (p[3] * 0.4));
    h[12] = v1;
    const double v2 = 1.0 / v1;
    h[2] = v2;
    h[4] = p[9] * 2.0 * sqrt(p[7] * p[10]);
    h[5] = p[3] * p[13];
    h[6] = p[2] * v2;
    const double v3 = 0.5 * p[12];
    h[8] = cos(v3);
    h[9] = sin(v3);
    const double v4 = model_less(0.0, p[7]);
    h[10] = v4 == 0.0 ? 1.0 : v4 == v4 ? sqrt(model_min(model_min(model_min(model_min(p[3], v1),
            p[3]), v1), p[3]) / p[7]) : v4;
    h[1] = p[2];
    h[3] = p[7];
    h[7] = p[1];
    h[11] = p[3];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[6] * x[6];
    const double v2 = 2.0 / (x[5] * x[5] + v1);
    const double v3 = 1.0 - v1 * v2;
    const double v4 = h[2] * x[4];
    const double v5 = x[2] * h[0] - h[1] * v4;
    const double v6 = x[3] * h[0];
    const double v7 = v2 * (x[6] * x[5]);
    const double v8 = v3 * v5 - v6 * v7;
    f[0] = v8;
    const double v9 = v7 * v5 + v6 * v3;
    f[1] = v9;
    const double v10 = h[3] * x[1] + h[4] * v9;
    const double v11 = h[3] * x[0] + h[4] * v8;
    const double v12 = v7 * v10 + v3 * v11;
    f[2] = -(v12 + (h[5] * v7 - x[3] * v4));
    f[3] = -(v3 * v10 - v7 * v11 + (h[5] * v3 + x[2] * v4));
    f[4] = h[1] * v12;
    f[5] = -(0.5 * (x[6] * v4));
    f[6] = 0.5 * (x[5] * v4);
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian_1(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    const double v1 = x[6] * x[6];
    const double v2 = 1.0 / (x[5] * x[5] + v1);
    const double v3 = 2.0 * v2;
    const double v4 = 1.0 - v1 * v3;
    const double v5 = h[0] * v4;
    jac[-16] = v5;
    jac[-10] = v5;
    const double v6 = x[6] * x[5];
    const double v7 = v3 * v6;
    const double v8 = h[0] * v7;
    jac[-11] = v8;
    jac[-15] = -v8;
    const double v9 = v4 * h[6];
    jac[-14] = -v9;
    const double v10 = h[2] * x[4];
    jac[-3] = v10;
    w[0] = v10;
    const double v11 = x[2] * h[0] - h[1] * v10;
    const double v12 = x[5] + x[5];
    const double v13 = 2.0 * (v2 * v2);
    const double v14 = v12 * (v1 * v13);
    w[1] = v14;
    const double v15 = x[3] * h[0];
    const double v16 = v12 * (v6 * v13);
    w[2] = v16;
    const double v17 = x[6] * v3 - v16;
    w[3] = v17;
    jac[-13] = v11 * v14 - v15 * v17;
    const double v18 = x[5] * v3 - v14;
    w[4] = v18;
    jac[-12] = -(v11 * v16 + v15 * v18);
    const double v19 = v7 * h[6];
    jac[-9] = -v19;
    jac[-8] = v15 * v14 + v11 * v17;
    jac[-7] = v11 * v18 - v15 * v16;
    const double v20 = h[3] * v4;
    w[5] = v20;
    const double v21 = -v20;
    jac[-6] = v21;
    jac[2] = v21;
    const double v22 = h[3] * v7;
    jac[1] = v22;
    w[6] = v22;
    jac[-5] = -v22;
    const double v23 = h[4] * v4;
    const double v24 = h[4] * v7;
    const double v25 = v5 * v23 + v8 * v24;
    w[7] = v25;
    const double v26 = -v25;
    jac[-4] = v26;
    jac[4] = v26;
    const double v27 = v24 * v19 + v23 * v9;
    w[8] = v27;
    jac[-2] = x[3] * h[2] + v27;
    const double v28 = v11 * v23;
    const double v29 = h[3] * x[0] + h[4] * (v4 * v11 - v15 * v7);
    const double v30 = v15 * v24;
    const double v31 = v28 + (v29 + v30);
    const double v32 = h[3] * x[1] + h[4] * (v7 * v11 + v15 * v4);
    const double v33 = v11 * v24;
    const double v34 = v15 * v23;
    const double v35 = v32 + v33 - v34;
    const double v36 = v14 * v31 + v17 * v35;
    w[9] = v36;
    jac[-1] = -(h[5] * v17 + v36);
    const double v37 = v18 * v35 - v16 * v31;
    w[10] = v37;
    jac[0] = -(h[5] * v18 + v37);
    jac[3] = -v10;
    jac[5] = -(x[2] * h[2]);
    w[11] = v33 - (h[5] + v32 + v34);
    w[12] = v29 - v28 - v30;
}

static void model_jacobian_2(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict dfdt, double *restrict w)
{
    jac[-11] = w[1] * w[11] + w[3] * w[12];
    jac[-10] = w[4] * w[12] - w[2] * w[11];
    jac[-9] = h[1] * w[5];
    jac[-8] = h[1] * w[6];
    jac[-7] = h[1] * w[7];
    jac[-6] = -(h[1] * w[8]);
    jac[-5] = h[1] * w[9];
    jac[-4] = h[1] * w[10];
    jac[-3] = -(h[2] * (0.5 * x[6]));
    const double v38 = 0.5 * w[0];
    jac[0] = v38;
    jac[-2] = -v38;
    jac[-1] = h[2] * (0.5 * x[5]);
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
    dfdt[4] = 0.0;
    dfdt[5] = 0.0;
    dfdt[6] = 0.0;
}

static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)u;
    model_jacobian_1(h, x, jac + 16, w);
    model_jacobian_2(h, x, jac + 33, dfdt, w);
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[3] * h[0];
    const double v2 = x[2] * h[0];
    const double v3 = h[2] * x[4];
    out[0] = 0.5 * (x[0] * (h[3] * x[0]) + x[1] * (h[3] * x[1])) + 0.5 * (x[3] * v1 + x[2] * v2 +
            x[4] * v3);
    const double v4 = x[6] * x[6];
    const double v5 = 2.0 / (x[5] * x[5] + v4);
    const double v6 = v5 * (x[6] * x[5]);
    const double v7 = 1.0 - v4 * v5;
    out[1] = -(v2 * (h[5] * v6) + v1 * (h[5] * v7));
    const double v8 = v2 - h[1] * v3;
    const double v9 = v7 * v8 - v1 * v6;
    const double v10 = v6 * v8 + v1 * v7;
    out[2] = v9 * (h[4] * v9) + v10 * (h[4] * v10);
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[6] * x[6];
    const double v2 = 2.0 / (x[5] * x[5] + v1);
    y[1] = x[0] + h[1] * (v2 * (x[6] * x[5]));
    y[2] = h[7] + x[1] - h[1] * (1.0 - v1 * v2);
    y[0] = 0.0;
}

/* Commands to the devices. */
static void model_commands(
    const double *h, double t, const double *x, const double *u, double *c, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)c, (void)w;
}

/* Conditions that have to hold: nonzero where they do. */
static void model_asserts(
    const double *h, double t, const double *x, const double *u, double *a, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)a, (void)w;
}

/* States that are set after each completed step. */
static void model_project(const double *h, double t, double *x, double *w)
{
    (void)h, (void)t;
    const double v1 = 1.0 / sqrt(x[5] * x[5] + x[6] * x[6]);
    w[0] = x[5] * v1;
    w[1] = x[6] * v1;
    x[5] = w[0];
    x[6] = w[1];
}

/* The entries of M in the order of mass_row and mass_col. */
static void model_mass(const double *h, double *m, double *w)
{
    (void)h, (void)m, (void)w;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)t, (void)u, (void)w;
    x[0] = 0.0;
    x[1] = 0.0;
    x[2] = 0.0;
    x[3] = 0.0;
    x[4] = 0.0;
    x[5] = h[8];
    x[6] = h[9];
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[10];
    scale[1] = h[10];
    scale[2] = h[11];
    scale[3] = h[11];
    scale[4] = h[12];
    scale[5] = 1.0;
    scale[6] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[11];
    check[1] = h[12];
}

/* The arguments of functions that may hide pulses. */
static void model_watched(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    z[0] = x[5] * x[5] + x[6] * x[6];
}

/* Defaults of the parameters that are given by other parameters. */
static void model_defaults(double *p, const unsigned char *is_set, double *w)
{
    (void)w;
    if (!is_set[5]) {
        p[5] = p[0];
    }
    if (!is_set[6]) {
        p[6] = p[5];
    }
    if (!is_set[8]) {
        p[8] = p[7] * 100.0;
    }
    if (!is_set[12]) {
        p[12] = p[6];
    }
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[-16] = 1.0 / c;
    g += c * fabs(lu[-16]);
    lu[-15] = -jac[15];
    lu[-14] = -jac[14];
    lu[-13] = -jac[17] * lu[-16];
    lu[-12] = 1.0 / (c - lu[-13] * lu[-15]);
    g += c * fabs(lu[-12]);
    lu[-11] = -jac[16] - lu[-13] * lu[-14];
    lu[-10] = -jac[-13] * lu[-16];
    lu[-9] = (-jac[-12] - lu[-10] * lu[-15]) * lu[-12];
    lu[-8] = 1.0 / c;
    g += c * fabs(lu[-8]);
    lu[-7] = -jac[-16];
    lu[-6] = -jac[-15];
    lu[-5] = -jac[-14] - lu[-10] * lu[-14] - lu[-9] * lu[-11];
    lu[-4] = -jac[-8] * lu[-16];
    lu[-3] = (-jac[-7] - lu[-4] * lu[-15]) * lu[-12];
    lu[-2] = 1.0 / c;
    g += c * fabs(lu[-2]);
    lu[-1] = -jac[-11];
    lu[0] = -jac[-10];
    lu[1] = -jac[-9] - lu[-4] * lu[-14] - lu[-3] * lu[-11];
    lu[2] = -jac[-1] * lu[-16];
    lu[3] = (-jac[0] - lu[2] * lu[-15]) * lu[-12];
    lu[4] = -jac[-6] * lu[-8];
    lu[5] = -jac[-5] * lu[-2];
    lu[6] = 1.0 / (c - jac[-4] - lu[4] * lu[-7] - lu[5] * lu[-1]);
    g += (c + fabs(jac[-4])) * fabs(lu[6]);
    lu[7] = -jac[-3] - lu[4] * lu[-6] - lu[5] * lu[0];
    lu[8] = -jac[-2] - lu[2] * lu[-14] - lu[3] * lu[-11] - lu[4] * lu[-5] - lu[5] * lu[1];
    lu[9] = -jac[6] * lu[-16];
    lu[10] = (-jac[7] - lu[9] * lu[-15]) * lu[-12];
    lu[11] = -jac[1] * lu[-8];
    lu[12] = -jac[2] * lu[-2];
    lu[13] = (-jac[3] - lu[11] * lu[-7] - lu[12] * lu[-1]) * lu[6];
    lu[14] = 1.0 / (c - jac[4] - lu[11] * lu[-6] - lu[12] * lu[0] - lu[13] * lu[7]);
    g += (c + fabs(jac[4])) * fabs(lu[14]);
    lu[15] = -jac[5] - lu[9] * lu[-14] - lu[10] * lu[-11] - lu[11] * lu[-5] - lu[12] * lu[1] - lu[13] * lu[8];
    lu[16] = -jac[12] * lu[-16];
    lu[17] = (-jac[13] - lu[16] * lu[-15]) * lu[-12];
    lu[18] = -jac[8] * lu[-8];
    lu[19] = -jac[9] * lu[-2];
    lu[20] = (-jac[10] - lu[18] * lu[-7] - lu[19] * lu[-1]) * lu[6];
    lu[21] = (-lu[18] * lu[-6] - lu[19] * lu[0] - lu[20] * lu[7]) * lu[14];
    lu[22] = 1.0 / (c - jac[11] - lu[16] * lu[-14] - lu[17] * lu[-11] - lu[18] * lu[-5] - lu[19] * lu[1] - lu[20] * lu[8]
        - lu[21] * lu[15]);
    g += (c + fabs(jac[11])) * fabs(lu[22]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    double g = 0.0;
    g += model_factor_1(jac + 16, c, lu + 16);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[6] = b[6] - lu[-13] * b[5];
    b[0] = b[0] - lu[-10] * b[5] - lu[-9] * b[6];
    b[1] = b[1] - lu[-4] * b[5] - lu[-3] * b[6];
    b[2] = b[2] - lu[2] * b[5] - lu[3] * b[6] - lu[4] * b[0] - lu[5] * b[1];
    b[3] = b[3] - lu[9] * b[5] - lu[10] * b[6] - lu[11] * b[0] - lu[12] * b[1] - lu[13] * b[2];
    b[4] = b[4] - lu[16] * b[5] - lu[17] * b[6] - lu[18] * b[0] - lu[19] * b[1] - lu[20] * b[2]
        - lu[21] * b[3];
    b[4] = b[4] * lu[22];
    b[3] = (b[3] - lu[15] * b[4]) * lu[14];
    b[2] = (b[2] - lu[8] * b[4] - lu[7] * b[3]) * lu[6];
    b[1] = (b[1] - lu[1] * b[4] - lu[0] * b[3] - lu[-1] * b[2]) * lu[-2];
    b[0] = (b[0] - lu[-5] * b[4] - lu[-6] * b[3] - lu[-7] * b[2]) * lu[-8];
    b[6] = (b[6] - lu[-11] * b[4]) * lu[-12];
    b[5] = (b[5] - lu[-14] * b[4] - lu[-15] * b[6]) * lu[-16];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu + 16, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"lean", "rad", 0.5235987755982988, -INFINITY, INFINITY},
    {"post.r0[3]", "m", 10.0, -INFINITY, INFINITY},
    {"load.length", "m", 6.0, 0.001, 1000.0},
    {"load.mass", "kg", 2000.0, 1e-09, 1000000000000.0},
    {"load.radius", "m", 0.5, 1e-06, 1000.0},
    {"load.angles0[1]", "rad", 0.5235987755982988, -INFINITY, INFINITY},
    {"load.swivel.angles0[1]", "rad", 0.5235987755982988, -INFINITY, INFINITY},
    {"load.swivel.lock.stiffness", "N/m", 1000000000.0, 0.0, 1000000000000000.0},
    {"load.swivel.lock.rotational_stiffness", "N*m", 100000000000.0, 0.0, 1e+18},
    {"load.swivel.lock.damping_ratio", "", 1.0, 0.0, 100.0},
    {"load.swivel.lock.mass", "kg", 2000.0, 0.0, 1000000000000.0},
    {"load.swivel.lock.inertia", "kg*m^2", 300000.0, 0.0, 1000000000000000.0},
    {"load.swivel.attitude.angles0[1]", "rad", 0.5235987755982988, -INFINITY, INFINITY},
    {"gravity", "m/s^2", 9.81, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"load.swivel.lock.spring.q[2]", ""},
    /* 1 */ {"load.swivel.lock.spring.q[3]", ""},
    /* 2 */ {"load.ball.body.p[2]", "N*s"},
    /* 3 */ {"load.ball.body.p[3]", "N*s"},
    /* 4 */ {"load.ball.body.p[4]", "N*m*s"},
    /* 5 */ {"load.swivel.attitude.h[1]", ""},
    /* 6 */ {"load.swivel.attitude.h[2]", ""},
};

static const int model_watch[] = {
    2,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"load[1]", "m"},
    /* 1 */ {"load[2]", "m"},
    /* 2 */ {"load[3]", "m"},
};

static const char *const model_param_check[] = {
    "the inertia of `load.ball.body[3]` must be positive",
    "the inertia of `load.ball.body[6]` must be positive",
};

static const int model_jac_row[] = {
    0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2,
    2, 3, 3, 3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 5, 5,
    6, 6,
};

static const int model_jac_col[] = {
    2, 3, 4, 5, 6, 2, 3, 4, 5, 6, 0, 1, 2, 3, 4, 5,
    6, 0, 1, 2, 3, 4, 5, 6, 0, 1, 2, 4, 5, 6, 4, 6,
    4, 5,
};

static const int model_pivot_row[] = {
    5, 6, 0, 1, 2, 3, 4,
};

static const int model_pivot_col[] = {
    5, 6, 0, 1, 2, 3, 4,
};

static const int model_lu_row[] = {
    0, 3, 6, 12, 18, 25, 32, 39,
};

static const int model_lu_pivot[] = {
    0, 4, 8, 14, 22, 30, 38,
};

static const int model_lu_col[] = {
    0, 1, 6, 0, 1, 6, 0, 1, 2, 4, 5, 6, 0, 1, 3, 4,
    5, 6, 0, 1, 2, 3, 4, 5, 6, 0, 1, 2, 3, 4, 5, 6,
    0, 1, 2, 3, 4, 5, 6,
};

static const int model_lu_jac[] = {
    9, 10, 11, 6, 7, 15, 16, 17, 12, 13, 20, 21, 22, 23, 24, 18,
    19, 27, 28, 29, 30, 31, 25, 26, 34, 35, 36, 38, 32, 33, 2, 1,
    5, 3,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "pendulum",
    .hash = "of its sources",
    .n_param = 14,
    .n_hoist = 13,
    .n_state = 7,
    .n_input = 0,
    .n_output = 3,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 34,
    .n_mass = 0,
    .n_lu = 39,
    .n_check = 2,
    .n_switch = 0,
    .n_timed = 0,
    .param = model_param,
    .state = model_state,
    .switch_info = NULL,
    .watch = model_watch,
    .n_watch = 1,
    .output = model_output,
    .input = NULL,
    .command = NULL,
    .device = NULL,
    .assertion = NULL,
    .param_check = model_param_check,
    .jac_row = model_jac_row,
    .jac_col = model_jac_col,
    .mass_row = NULL,
    .mass_col = NULL,
    .pivot_row = model_pivot_row,
    .pivot_col = model_pivot_col,
    .lu_row = model_lu_row,
    .lu_pivot = model_lu_pivot,
    .lu_col = model_lu_col,
    .lu_jac = model_lu_jac,
    .lu_mass = NULL,
    .step = 0.0,
    .duration = 20.0,
    .every = 0.05,
    .n_work = 13,
    .prepare = model_prepare,
    .rhs = model_rhs,
    .jacobian = model_jacobian,
    .energy = model_energy,
    .outputs = model_outputs,
    .commands = model_commands,
    .asserts = model_asserts,
    .project = model_project,
    .mass = model_mass,
    .initial = model_initial,
    .scale = model_scale,
    .positive = model_positive,
    .watched = model_watched,
    .defaults = model_defaults,
    .factor = model_factor,
    .solve = model_solve,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
