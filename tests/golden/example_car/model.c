/* on_track: a bond graph of model QuarterCar, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 body_mass  [kg]
 *     1 wheel_mass  [kg]
 *     2 suspension  [N/m]
 *     3 damping  [N*s/m]
 *     4 tyre  [N/m]
 *
 * States x:
 *     0 tyre_spring.q  [m]
 *     1 wheel_inertia.p  [N*s]
 *     2 spring.q  [m]
 *     3 body_inertia.p  [N*s]
 *     4 z[1]  [m]
 *     5 z[2]  [m]
 *     6 z[3]  [m]
 *
 * Inputs u:
 *     0 track.velocity[1]
 *     1 track.velocity[2]
 *     2 track.velocity[3]
 *
 * Outputs y:
 *     0 z[1]  [m]
 *     1 z[2]  [m]
 *     2 z[3]  [m]
 *     3 acceleration  [m/s^2]
 *     4 grip  [N]
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
    const double v1 = 1.0 / p[1];
    h[0] = v1;
    const double v2 = 1.0 / p[0];
    h[3] = v2;
    h[5] = -v1;
    const double v3 = p[3] * v1;
    h[10] = v3;
    h[6] = -v3;
    h[7] = -p[2];
    const double v4 = p[3] * v2;
    h[8] = v4;
    h[9] = -v2;
    h[11] = -v4;
    const double v5 = model_less(0.0, p[4]);
    h[12] = v5 == 0.0 ? 1.0 : v5 == v5 ? sqrt(p[1] / p[4]) : v5;
    const double v6 = model_less(0.0, p[2]);
    h[14] = v6 == 0.0 ? 1.0 : v6 == v6 ? sqrt(model_min(p[1], p[0]) / p[2]) : v6;
    h[1] = p[4];
    h[2] = p[3];
    h[4] = p[2];
    h[13] = p[1];
    h[15] = p[0];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)w;
    const double v1 = x[1] * h[0];
    f[5] = v1;
    f[0] = u[2] - v1;
    const double v2 = h[3] * x[3];
    f[6] = v2;
    const double v3 = v1 - v2;
    f[2] = v3;
    const double v4 = h[2] * v3 + h[4] * x[2];
    f[3] = v4;
    f[1] = h[1] * x[0] - v4;
    f[4] = u[2];
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)x, (void)u, (void)w;
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
    dfdt[4] = 0.0;
    dfdt[5] = 0.0;
    dfdt[6] = 0.0;
    jac[0] = h[5];
    jac[1] = h[1];
    jac[2] = h[6];
    jac[3] = h[7];
    jac[4] = h[8];
    jac[5] = h[0];
    jac[6] = h[9];
    jac[7] = h[10];
    jac[8] = h[4];
    jac[9] = h[11];
    jac[10] = h[0];
    jac[11] = h[3];
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)w;
    out[0] = 0.0;
    out[1] = 0.0;
    out[2] = 0.0;
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)t, (void)u, (void)w;
    y[3] = h[3] * (h[2] * (x[1] * h[0] - h[3] * x[3]) + h[4] * x[2]);
    y[4] = h[1] * x[0];
    y[0] = x[4];
    y[1] = x[5];
    y[2] = x[6];
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

/* The entries of M in the order of mass_row and mass_col. */
static void model_mass(const double *h, double *m, double *w)
{
    (void)h, (void)m, (void)w;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    x[0] = 0.0;
    x[1] = 0.0;
    x[2] = 0.0;
    x[3] = 0.0;
    x[4] = 0.0;
    x[5] = 0.0;
    x[6] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[12];
    scale[1] = h[13];
    scale[2] = h[14];
    scale[3] = h[15];
    scale[4] = 1.0;
    scale[5] = 1.0;
    scale[6] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[13];
    check[1] = h[15];
}

/* Defaults of the parameters that are given by other parameters. */
static void model_defaults(double *p, const unsigned char *is_set, double *w)
{
    (void)p;
    (void)is_set;
    (void)w;
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[-16] = 1.0 / c;
    g += c * fabs(lu[-16]);
    lu[-15] = 1.0 / c;
    g += c * fabs(lu[-15]);
    lu[-14] = -jac[10];
    lu[-13] = 1.0 / c;
    g += c * fabs(lu[-13]);
    lu[-12] = -jac[11];
    lu[-11] = 1.0 / c;
    g += c * fabs(lu[-11]);
    lu[-10] = -jac[0];
    lu[-9] = -jac[1] * lu[-11];
    lu[-8] = 1.0 / (c - jac[2] - lu[-9] * lu[-10]);
    g += (c + fabs(jac[2])) * fabs(lu[-8]);
    lu[-7] = -jac[3];
    lu[-6] = -jac[4];
    lu[-5] = -jac[5] * lu[-8];
    lu[-4] = 1.0 / (c - lu[-5] * lu[-7]);
    g += c * fabs(lu[-4]);
    lu[-3] = -jac[6] - lu[-5] * lu[-6];
    lu[-2] = -jac[7] * lu[-8];
    lu[-1] = (-jac[8] - lu[-2] * lu[-7]) * lu[-4];
    lu[0] = 1.0 / (c - jac[9] - lu[-2] * lu[-6] - lu[-1] * lu[-3]);
    g += (c + fabs(jac[9])) * fabs(lu[0]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    double g = 0.0;
    g += model_factor_1(jac, c, lu + 16);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[1] = b[1] - lu[-9] * b[0];
    b[2] = b[2] - lu[-5] * b[1];
    b[3] = b[3] - lu[-2] * b[1] - lu[-1] * b[2];
    b[3] = b[3] * lu[0];
    b[2] = (b[2] - lu[-3] * b[3]) * lu[-4];
    b[1] = (b[1] - lu[-6] * b[3] - lu[-7] * b[2]) * lu[-8];
    b[0] = (b[0] - lu[-10] * b[1]) * lu[-11];
    b[6] = (b[6] - lu[-12] * b[3]) * lu[-13];
    b[5] = (b[5] - lu[-14] * b[1]) * lu[-15];
    b[4] = b[4] * lu[-16];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu + 16, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"body_mass", "kg", 300.0, 1.0, 10000.0},
    {"wheel_mass", "kg", 40.0, 1.0, 1000.0},
    {"suspension", "N/m", 20000.0, -INFINITY, INFINITY},
    {"damping", "N*s/m", 1500.0, 0.0, 1000000.0},
    {"tyre", "N/m", 200000.0, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"tyre_spring.q", "m"},
    /* 1 */ {"wheel_inertia.p", "N*s"},
    /* 2 */ {"spring.q", "m"},
    /* 3 */ {"body_inertia.p", "N*s"},
    /* 4 */ {"z[1]", "m"},
    /* 5 */ {"z[2]", "m"},
    /* 6 */ {"z[3]", "m"},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"z[1]", "m"},
    /* 1 */ {"z[2]", "m"},
    /* 2 */ {"z[3]", "m"},
    /* 3 */ {"acceleration", "m/s^2"},
    /* 4 */ {"grip", "N"},
};

static const bgc_channel_use model_input[] = {
    {0, BGC_VELOCITY, 0},
    {0, BGC_VELOCITY, 1},
    {0, BGC_VELOCITY, 2},
};

static const bgc_device_info model_device[] = {
    {"track", "trace", "file=road.csv"},
};

static const char *const model_param_check[] = {
    "the inertia of `wheel_inertia` must be positive",
    "the inertia of `body_inertia` must be positive",
};

static const int model_jac_row[] = {
    0, 1, 1, 1, 1, 2, 2, 3, 3, 3, 5, 6,
};

static const int model_jac_col[] = {
    1, 0, 1, 2, 3, 1, 3, 1, 2, 3, 1, 3,
};

static const int model_pivot_row[] = {
    4, 5, 6, 0, 1, 2, 3,
};

static const int model_pivot_col[] = {
    4, 5, 6, 0, 1, 2, 3,
};

static const int model_lu_row[] = {
    0, 1, 3, 5, 7, 11, 14, 17,
};

static const int model_lu_pivot[] = {
    0, 1, 3, 5, 8, 12, 16,
};

static const int model_lu_col[] = {
    0, 1, 4, 2, 6, 3, 4, 3, 4, 5, 6, 4, 5, 6, 4, 5,
    6,
};

static const int model_lu_jac[] = {
    6, 7, 8, 9, 10, 11, 13, 14, 15, 16, 2, 4,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "on_track",
    .hash = "of its sources",
    .n_param = 5,
    .n_hoist = 16,
    .n_state = 7,
    .n_input = 3,
    .n_output = 5,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 1,
    .n_jac = 12,
    .n_mass = 0,
    .n_lu = 17,
    .n_check = 2,
    .n_switch = 0,
    .n_timed = 0,
    .param = model_param,
    .state = model_state,
    .switch_info = NULL,
    .output = model_output,
    .input = model_input,
    .command = NULL,
    .device = model_device,
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
    .step = 0.001,
    .duration = 10.0,
    .every = 0.01,
    .n_work = 0,
    .prepare = model_prepare,
    .rhs = model_rhs,
    .jacobian = model_jacobian,
    .energy = model_energy,
    .outputs = model_outputs,
    .commands = model_commands,
    .asserts = model_asserts,
    .mass = model_mass,
    .initial = model_initial,
    .scale = model_scale,
    .positive = model_positive,
    .defaults = model_defaults,
    .factor = model_factor,
    .solve = model_solve,
    .project = NULL,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
