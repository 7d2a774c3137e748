/* lift: a bond graph of model Lift, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 mass  [kg]
 *     1 area  [m^2]
 *     2 friction  [N*s/m]
 *     3 volume  [m^3]
 *     4 hose  [m^3]
 *     5 bulk_modulus  [Pa]
 *     6 supply  [Pa]
 *     7 flow[1]  [m^3/s]
 *     8 flow[2]  [m^3/s]
 *     9 small  [Pa]
 *
 * States x:
 *     0 hose_oil.q  [m^3]
 *     1 oil.q  [m^3]
 *     2 load.p  [N*s]
 *     3 height  [m]
 *
 * Outputs y:
 *     0 height  [m]
 *     1 speed  [m/s]
 *     2 pressure  [Pa]
 *     3 flow  [m^3/s]
 */
#include "bgc.h"

#include <math.h>

static inline double model_max(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double model_min(double a, double b)
{
    return a < b || a != a ? a : b;
}

static inline double model_less(double a, double b)
{
    return a < b ? 1.0 : a >= b ? 0.0 : (double)NAN;
}

static inline double model_at_most(double a, double b)
{
    return a <= b ? 1.0 : a > b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    h[0] = 0.001 * p[8];
    const double v1 = 1.0 / p[5];
    const double v2 = p[3] * v1;
    h[19] = v2;
    const double v3 = 1.0 / v2;
    h[1] = v3;
    const double v4 = p[4] * v1;
    h[18] = v4;
    const double v5 = 1.0 / v4;
    h[2] = v5;
    h[3] = p[9] * p[9];
    const double v6 = 1.0 / p[0];
    h[7] = v6;
    const double v7 = p[0] * 9.81;
    h[8] = v7;
    h[10] = -(p[1] * v6);
    h[11] = p[1] * v3;
    h[12] = -(p[2] * v6);
    const double v8 = v7 / p[1];
    h[13] = v4 * v8;
    h[14] = v8 * v2;
    const double v9 = model_less(0.0, v5);
    h[15] = v9 == 0.0 ? 1.0 : v9 == v9 ? v4 : v9;
    const double v10 = model_less(0.0, v3);
    h[16] = v10 == 0.0 ? 1.0 : v10 == v10 ? sqrt(p[0] * v2) : v10;
    h[20] = fabs(p[5]);
    h[21] = fabs(p[1]);
    h[4] = p[6];
    h[5] = p[7];
    h[6] = p[1];
    h[9] = p[2];
    h[17] = p[0];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)w;
    const double v1 = h[1] * x[1];
    const double v2 = x[0] * h[2];
    const double v3 = v1 - v2;
    const double v4 = h[0] * (v3 / sqrt(sqrt(h[3] + v3 * v3)));
    const double v5 = v2 - h[4];
    const double v6 = (t - 0.1) * 10.0;
    const double v7 = u[0] >= 1.0 ? v6 : u[0] < 1.0 ? 0.0 : model_max(v6, 0.0);
    const double v8 = 10.0 * (t - 0.6);
    const double v9 = u[2] >= 1.0 ? v8 : u[2] < 1.0 ? 0.0 : model_max(v8, 0.0);
    f[0] = v4 - v5 / sqrt(sqrt(h[3] + v5 * v5)) * (0.001 * (h[5] * ((u[1] >= 1.0 ? v7 : u[1] < 1.0
            ? 1.0 : model_min(v7, 1.0)) - (u[3] >= 1.0 ? v9 : u[3] < 1.0 ? 1.0 : model_min(v9,
            1.0)))));
    const double v10 = h[7] * x[2];
    f[3] = v10;
    f[1] = -(v4 + h[6] * v10);
    f[2] = h[6] * v1 - (h[8] + h[9] * v10);
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)w;
    const double v1 = (t - 0.1) * 10.0;
    const double v2 = u[0] >= 1.0 ? v1 : u[0] < 1.0 ? 0.0 : model_max(v1, 0.0);
    const double v3 = 10.0 * (t - 0.6);
    const double v4 = u[2] >= 1.0 ? v3 : u[2] < 1.0 ? 0.0 : model_max(v3, 0.0);
    const double v5 = x[0] * h[2];
    const double v6 = v5 - h[4];
    const double v7 = sqrt(h[3] + v6 * v6);
    const double v8 = sqrt(v7);
    const double v9 = 1.0 / v8;
    const double v10 = 0.001 * (h[5] * ((u[1] >= 1.0 ? v2 : u[1] < 1.0 ? 1.0 : model_min(v2, 1.0))
            - (u[3] >= 1.0 ? v4 : u[3] < 1.0 ? 1.0 : model_min(v4, 1.0)))) * (v9 - (v6 + v6) * ((v7
            == 0.0 ? 0.0 : v7 == v7 ? 0.5 / v7 : v7) * ((v8 == 0.0 ? 0.0 : v8 == v8 ? 0.5 * v9 :
            v8) * (v6 * (v9 * v9)))));
    const double v11 = h[1] * x[1] - v5;
    const double v12 = sqrt(h[3] + v11 * v11);
    const double v13 = sqrt(v12);
    const double v14 = 1.0 / v13;
    const double v15 = h[0] * (v14 - (v11 + v11) * ((v12 == 0.0 ? 0.0 : v12 == v12 ? 0.5 / v12 :
            v12) * ((v13 == 0.0 ? 0.0 : v13 == v13 ? 0.5 * v14 : v13) * (v11 * (v14 * v14)))));
    const double v16 = h[2] * v15;
    jac[2] = v16;
    jac[0] = -(h[2] * v10 + v16);
    const double v17 = h[1] * v15;
    jac[1] = v17;
    jac[3] = -v17;
    const double v18 = h[5] * (0.001 * (v6 * v9));
    const double v19 = model_at_most(0.0, v3);
    const double v20 = u[2] >= 1.0 ? 10.0 : u[2] < 1.0 ? 0.0 : (v19 == 0.0 ? 0.0 : v19 == v19 ?
            10.0 : v19);
    const double v21 = model_at_most(v4, 1.0);
    const double v22 = model_at_most(0.0, v1);
    const double v23 = u[0] >= 1.0 ? 10.0 : u[0] < 1.0 ? 0.0 : (v22 == 0.0 ? 0.0 : v22 == v22 ?
            10.0 : v22);
    const double v24 = model_at_most(v2, 1.0);
    dfdt[0] = v18 * (u[3] >= 1.0 ? v20 : u[3] < 1.0 ? 0.0 : (v21 == 0.0 ? 0.0 : v21 == v21 ? v20 :
            v21)) - v18 * (u[1] >= 1.0 ? v23 : u[1] < 1.0 ? 0.0 : (v24 == 0.0 ? 0.0 : v24 == v24 ?
            v23 : v24));
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
    jac[4] = h[10];
    jac[5] = h[11];
    jac[6] = h[12];
    jac[7] = h[7];
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)w;
    const double v1 = x[0] * h[2];
    const double v2 = h[1] * x[1];
    const double v3 = h[7] * x[2];
    out[0] = 0.5 * (x[0] * v1) + 0.5 * (x[1] * v2) + 0.5 * (x[2] * v3);
    const double v4 = v1 - h[4];
    const double v5 = (t - 0.1) * 10.0;
    const double v6 = u[0] >= 1.0 ? v5 : u[0] < 1.0 ? 0.0 : model_max(v5, 0.0);
    const double v7 = 10.0 * (t - 0.6);
    const double v8 = u[2] >= 1.0 ? v7 : u[2] < 1.0 ? 0.0 : model_max(v7, 0.0);
    const double v9 = v4 / sqrt(sqrt(h[3] + v4 * v4)) * (0.001 * (h[5] * ((u[1] >= 1.0 ? v6 : u[1]
            < 1.0 ? 1.0 : model_min(v6, 1.0)) - (u[3] >= 1.0 ? v8 : u[3] < 1.0 ? 1.0 :
            model_min(v8, 1.0)))));
    out[1] = -(h[8] * v3 + h[4] * v9);
    const double v10 = v2 - v1;
    out[2] = v3 * (h[9] * v3) + (v10 * (h[0] * (v10 / sqrt(sqrt(h[3] + v10 * v10)))) + v4 * v9);
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)w;
    y[1] = h[7] * x[2];
    y[2] = h[1] * x[1];
    const double v1 = x[0] * h[2] - h[4];
    const double v2 = (t - 0.1) * 10.0;
    const double v3 = u[0] >= 1.0 ? v2 : u[0] < 1.0 ? 0.0 : model_max(v2, 0.0);
    const double v4 = 10.0 * (t - 0.6);
    const double v5 = u[2] >= 1.0 ? v4 : u[2] < 1.0 ? 0.0 : model_max(v4, 0.0);
    y[3] = -(v1 / sqrt(sqrt(h[3] + v1 * v1)) * (0.001 * (h[5] * ((u[1] >= 1.0 ? v3 : u[1] < 1.0 ?
            1.0 : model_min(v3, 1.0)) - (u[3] >= 1.0 ? v5 : u[3] < 1.0 ? 1.0 : model_min(v5,
            1.0))))));
    y[0] = x[3];
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

/* The arguments of discontinuous operations. */
static void model_switches(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)h, (void)x, (void)w;
    const double v1 = (t - 0.1) * 10.0;
    z[0] = v1;
    z[1] = 1.0 - (u[0] >= 1.0 ? v1 : u[0] < 1.0 ? 0.0 : model_max(v1, 0.0));
    const double v2 = 10.0 * (t - 0.6);
    z[2] = v2;
    z[3] = 1.0 - (u[2] >= 1.0 ? v2 : u[2] < 1.0 ? 0.0 : model_max(v2, 0.0));
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
    x[0] = h[13];
    x[1] = h[14];
    x[2] = 0.0;
    x[3] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[15];
    scale[1] = h[16];
    scale[2] = h[17];
    scale[3] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[18];
    check[1] = h[19];
    check[2] = h[17];
    check[3] = h[20];
    check[4] = h[21];
}

/* The arguments of functions that may hide pulses. */
static void model_watched(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[0] * h[2];
    const double v2 = v1 - h[4];
    z[0] = sqrt(sqrt(h[3] + v2 * v2));
    const double v3 = h[1] * x[1] - v1;
    z[1] = sqrt(sqrt(h[3] + v3 * v3));
}

/* Defaults of the parameters that are given by other parameters. */
static void model_defaults(double *p, const unsigned char *is_set, double *w)
{
    (void)p;
    (void)is_set;
    (void)w;
}

#include "bgc_ranges.h"

/* Ranges of terms of time alone, each with its derivative by time. */
static void ranges_ranges(
    const bgc_range *h, bgc_range t, const bgc_range *u, bgc_range *b, bgc_range *w)
{
    (void)h, (void)w;
    const bgc_range v1 = bgc_range_product(bgc_range_difference(t, bgc_range_of(0.1)),
            bgc_range_of(10.0));
    const bgc_range v2 = bgc_range_choice(bgc_range_equal(u[0], u[0]), bgc_range_choice(u[0], v1,
            bgc_range_of(0.0)), bgc_range_max(v1, bgc_range_of(0.0)));
    b[4] = v2;
    b[0] = bgc_range_choice(bgc_range_equal(u[1], u[1]), bgc_range_choice(u[1], v2,
            bgc_range_of(1.0)), bgc_range_min(v2, bgc_range_of(1.0)));
    const bgc_range v3 = bgc_range_at_most(bgc_range_of(0.0), v1);
    const bgc_range v4 = bgc_range_choice(bgc_range_equal(u[0], u[0]), bgc_range_choice(u[0],
            bgc_range_of(10.0), bgc_range_of(0.0)), bgc_range_choice(v3, bgc_range_of(10.0),
            bgc_range_of(0.0)));
    b[5] = v4;
    const bgc_range v5 = bgc_range_at_most(v2, bgc_range_of(1.0));
    b[1] = bgc_range_choice(bgc_range_equal(u[1], u[1]), bgc_range_choice(u[1], v4,
            bgc_range_of(0.0)), bgc_range_choice(v5, v4, bgc_range_of(0.0)));
    const bgc_range v6 = bgc_range_product(bgc_range_of(10.0), bgc_range_difference(t,
            bgc_range_of(0.6)));
    const bgc_range v7 = bgc_range_choice(bgc_range_equal(u[2], u[2]), bgc_range_choice(u[2], v6,
            bgc_range_of(0.0)), bgc_range_max(v6, bgc_range_of(0.0)));
    b[6] = v7;
    b[2] = bgc_range_choice(bgc_range_equal(u[3], u[3]), bgc_range_choice(u[3], v7,
            bgc_range_of(1.0)), bgc_range_min(v7, bgc_range_of(1.0)));
    const bgc_range v8 = bgc_range_at_most(bgc_range_of(0.0), v6);
    const bgc_range v9 = bgc_range_choice(bgc_range_equal(u[2], u[2]), bgc_range_choice(u[2],
            bgc_range_of(10.0), bgc_range_of(0.0)), bgc_range_choice(v8, bgc_range_of(10.0),
            bgc_range_of(0.0)));
    b[7] = v9;
    const bgc_range v10 = bgc_range_at_most(v7, bgc_range_of(1.0));
    b[3] = bgc_range_choice(bgc_range_equal(u[3], u[3]), bgc_range_choice(u[3], v9,
            bgc_range_of(0.0)), bgc_range_choice(v10, v9, bgc_range_of(0.0)));
}

#include "bgc_ranges.h"

/* Ranges of the arguments of switches of time alone, and of their derivatives by time. */
static void ranges_timed_ranges(
    const bgc_range *h, bgc_range t, const bgc_range *u, bgc_range *b, bgc_range *w)
{
    (void)h, (void)w;
    const bgc_range v1 = bgc_range_product(bgc_range_difference(t, bgc_range_of(0.1)),
            bgc_range_of(10.0));
    b[0] = v1;
    b[2] = bgc_range_difference(bgc_range_of(1.0), bgc_range_choice(bgc_range_equal(u[0], u[0]),
            bgc_range_choice(u[0], v1, bgc_range_of(0.0)), bgc_range_max(v1, bgc_range_of(0.0))));
    const bgc_range v2 = bgc_range_at_most(bgc_range_of(0.0), v1);
    b[3] = bgc_range_opposite(bgc_range_choice(bgc_range_equal(u[0], u[0]), bgc_range_choice(u[0],
            bgc_range_of(10.0), bgc_range_of(0.0)), bgc_range_choice(v2, bgc_range_of(10.0),
            bgc_range_of(0.0))));
    const bgc_range v3 = bgc_range_product(bgc_range_of(10.0), bgc_range_difference(t,
            bgc_range_of(0.6)));
    b[4] = v3;
    b[6] = bgc_range_difference(bgc_range_of(1.0), bgc_range_choice(bgc_range_equal(u[2], u[2]),
            bgc_range_choice(u[2], v3, bgc_range_of(0.0)), bgc_range_max(v3, bgc_range_of(0.0))));
    const bgc_range v4 = bgc_range_at_most(bgc_range_of(0.0), v3);
    b[7] = bgc_range_opposite(bgc_range_choice(bgc_range_equal(u[2], u[2]), bgc_range_choice(u[2],
            bgc_range_of(10.0), bgc_range_of(0.0)), bgc_range_choice(v4, bgc_range_of(10.0),
            bgc_range_of(0.0))));
    b[1] = bgc_range_of(10.0);
    b[5] = bgc_range_of(10.0);
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[0] = 1.0 / c;
    g += c * fabs(lu[0]);
    lu[1] = -jac[7];
    lu[2] = 1.0 / (c - jac[0]);
    g += (c + fabs(jac[0])) * fabs(lu[2]);
    lu[3] = -jac[1];
    lu[4] = -jac[2] * lu[2];
    lu[5] = 1.0 / (c - jac[3] - lu[4] * lu[3]);
    g += (c + fabs(jac[3])) * fabs(lu[5]);
    lu[6] = -jac[4];
    lu[7] = -jac[5] * lu[5];
    lu[8] = 1.0 / (c - jac[6] - lu[7] * lu[6]);
    g += (c + fabs(jac[6])) * fabs(lu[8]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    double g = 0.0;
    g += model_factor_1(jac, c, lu);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[1] = b[1] - lu[4] * b[0];
    b[2] = b[2] - lu[7] * b[1];
    b[2] = b[2] * lu[8];
    b[1] = (b[1] - lu[6] * b[2]) * lu[5];
    b[0] = (b[0] - lu[3] * b[1]) * lu[2];
    b[3] = (b[3] - lu[1] * b[2]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"mass", "kg", 500.0, 1.0, 1000000.0},
    {"area", "m^2", 0.001, 1e-06, 10.0},
    {"friction", "N*s/m", 10000.0, -INFINITY, INFINITY},
    {"volume", "m^3", 0.001, -INFINITY, INFINITY},
    {"hose", "m^3", 1e-05, -INFINITY, INFINITY},
    {"bulk_modulus", "Pa", 1600000000.0, -INFINITY, INFINITY},
    {"supply", "Pa", 10000000.0, -INFINITY, INFINITY},
    {"flow[1]", "m^3/s", 0.0003333333333333333, -INFINITY, INFINITY},
    {"flow[2]", "m^3/s", 0.001, -INFINITY, INFINITY},
    {"small", "Pa", 10000.0, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"hose_oil.q", "m^3"},
    /* 1 */ {"oil.q", "m^3"},
    /* 2 */ {"load.p", "N*s"},
    /* 3 */ {"height", "m"},
};

static const bgc_switch_info model_switch_info[] = {
    {BGC_NOT_BELOW, 1, 0},
    {BGC_NOT_BELOW, 1, 0},
    {BGC_NOT_BELOW, 1, 0},
    {BGC_NOT_BELOW, 1, 0},
};

static const int model_watch[] = {
    2, 2,
};

static const int model_watch_state[] = {
    0, 1,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"height", "m"},
    /* 1 */ {"speed", "m/s"},
    /* 2 */ {"pressure", "Pa"},
    /* 3 */ {"flow", "m^3/s"},
};

static const char *const model_param_check[] = {
    "the compliance of `hose_oil` must be positive",
    "the compliance of `oil` must be positive",
    "the inertia of `load` must be positive",
    "`bulk_modulus` must not be zero: the initial value of `hose_oil.q` divides by it",
    "`area` must not be zero: the initial value of `hose_oil.q` divides by it",
};

static const int model_jac_row[] = {
    0, 0, 1, 1, 1, 2, 2, 3,
};

static const int model_jac_col[] = {
    0, 1, 0, 1, 2, 1, 2, 2,
};

static const int model_pivot_row[] = {
    3, 0, 1, 2,
};

static const int model_pivot_col[] = {
    3, 0, 1, 2,
};

static const int model_lu_row[] = {
    0, 2, 4, 7, 9,
};

static const int model_lu_pivot[] = {
    0, 2, 5, 8,
};

static const int model_lu_col[] = {
    0, 3, 1, 2, 1, 2, 3, 2, 3,
};

static const int model_lu_jac[] = {
    2, 3, 4, 5, 6, 7, 8, 1,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "lift",
    .hash = "of its sources",
    .n_param = 10,
    .n_hoist = 22,
    .n_state = 4,
    .n_input = 0,
    .n_output = 4,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 8,
    .n_mass = 0,
    .n_lu = 9,
    .n_check = 5,
    .n_switch = 4,
    .n_timed = 4,
    .param = model_param,
    .state = model_state,
    .switch_info = model_switch_info,
    .watch = model_watch,
    .n_watch = 2,
    .watch_state = model_watch_state,
    .n_watch_state = 2,
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
    .duration = 1.0,
    .every = 0.01,
    .n_work = 0,
    .prepare = model_prepare,
    .rhs = model_rhs,
    .jacobian = model_jacobian,
    .energy = model_energy,
    .outputs = model_outputs,
    .commands = model_commands,
    .asserts = model_asserts,
    .switches = model_switches,
    .mass = model_mass,
    .initial = model_initial,
    .scale = model_scale,
    .positive = model_positive,
    .watched = model_watched,
    .defaults = model_defaults,
    .factor = model_factor,
    .solve = model_solve,
    .ranges = ranges_ranges,
    .timed_ranges = ranges_timed_ranges,
    .n_term = 4,
    .project = NULL,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
