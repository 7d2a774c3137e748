/* drive: a bond graph of model ElasticDrive, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 n
 *     1 J  [kg*m^2]
 *     2 b  [N*m*s]
 *     3 stiffness  [N*m]
 *     4 damping  [N*m*s]
 *     5 motor.U  [V]
 *     6 motor.R  [ohm]
 *     7 motor.L  [H]
 *     8 motor.k  [V*s]
 *     9 motor.J  [kg*m^2]
 *    10 motor.b  [N*m*s]
 *
 * States x:
 *     0 motor.winding.p  [V*s]
 *     1 motor.rotor.p  [N*m*s]
 *     2 spring.q  [rad]
 *     3 load.p  [N*m*s]
 *
 * Outputs y:
 *     0 current  [A]
 *     1 motor_speed  [rad/s]
 *     2 load_speed  [rad/s]
 *     3 torque  [N*m]
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
    const double v1 = 1.0 / p[7];
    h[2] = v1;
    const double v2 = 1.0 / p[9];
    h[4] = v2;
    const double v3 = 1.0 / p[0];
    h[6] = v3;
    const double v4 = 1.0 / p[1];
    h[8] = v4;
    h[11] = -(p[6] * v1);
    h[12] = -(p[8] * v2);
    h[13] = p[8] * v1;
    const double v5 = v3 * v2;
    h[17] = v5;
    const double v6 = p[4] * v5;
    h[19] = v6;
    h[14] = -(p[10] * v2 + v3 * v6);
    h[15] = -(p[3] * v3);
    const double v7 = p[4] * v4;
    h[16] = v3 * v7;
    h[18] = -v4;
    h[20] = -(v7 + p[2] * v4);
    const double v8 = model_less(0.0, v1);
    h[21] = v8 == 0.0 ? 1.0 : v8 == v8 ? sqrt(p[7] * p[9]) : v8;
    const double v9 = model_less(0.0, p[3]);
    h[23] = v9 == 0.0 ? 1.0 : v9 == v9 ? sqrt(model_min(p[9], p[1]) / p[3]) : v9;
    h[26] = fabs(p[0]);
    h[0] = p[5];
    h[1] = p[6];
    h[3] = p[8];
    h[5] = p[10];
    h[7] = p[4];
    h[9] = p[3];
    h[10] = p[2];
    h[22] = p[9];
    h[24] = p[1];
    h[25] = p[7];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = h[2] * x[0];
    const double v2 = h[4] * x[1];
    f[0] = h[0] - h[1] * v1 - h[3] * v2;
    const double v3 = h[8] * x[3];
    const double v4 = h[6] * v2 - v3;
    f[2] = v4;
    const double v5 = h[7] * v4 + h[9] * x[2];
    f[1] = h[3] * v1 - h[5] * v2 - h[6] * v5;
    f[3] = v5 - h[10] * v3;
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
    for (int k = 0; k < 9; k++) jac[k] = h[k + 11];
    jac[9] = h[9];
    jac[10] = h[20];
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
    y[0] = h[2] * x[0];
    y[1] = h[4] * x[1];
    y[2] = h[8] * x[3];
    y[3] = h[9] * x[2];
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
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[21];
    scale[1] = h[22];
    scale[2] = h[23];
    scale[3] = h[24];
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[25];
    check[1] = h[22];
    check[2] = h[24];
    check[3] = h[26];
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
    lu[0] = 1.0 / (c - jac[0]);
    g += (c + fabs(jac[0])) * fabs(lu[0]);
    lu[1] = -jac[1];
    lu[2] = -jac[2] * lu[0];
    lu[3] = 1.0 / (c - jac[3] - lu[2] * lu[1]);
    g += (c + fabs(jac[3])) * fabs(lu[3]);
    lu[4] = -jac[4];
    lu[5] = -jac[5];
    lu[6] = -jac[6] * lu[3];
    lu[7] = 1.0 / (c - lu[6] * lu[4]);
    g += c * fabs(lu[7]);
    lu[8] = -jac[7] - lu[6] * lu[5];
    lu[9] = -jac[8] * lu[3];
    lu[10] = (-jac[9] - lu[9] * lu[4]) * lu[7];
    lu[11] = 1.0 / (c - jac[10] - lu[9] * lu[5] - lu[10] * lu[8]);
    g += (c + fabs(jac[10])) * fabs(lu[11]);
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
    b[1] = b[1] - lu[2] * b[0];
    b[2] = b[2] - lu[6] * b[1];
    b[3] = b[3] - lu[9] * b[1] - lu[10] * b[2];
    b[3] = b[3] * lu[11];
    b[2] = (b[2] - lu[8] * b[3]) * lu[7];
    b[1] = (b[1] - lu[5] * b[3] - lu[4] * b[2]) * lu[3];
    b[0] = (b[0] - lu[1] * b[1]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"n", "", 20.0, 1.0, 200.0},
    {"J", "kg*m^2", 0.05, -INFINITY, INFINITY},
    {"b", "N*m*s", 0.2, -INFINITY, INFINITY},
    {"stiffness", "N*m", 150.0, -INFINITY, INFINITY},
    {"damping", "N*m*s", 0.05, -INFINITY, INFINITY},
    {"motor.U", "V", 24.0, -INFINITY, INFINITY},
    {"motor.R", "ohm", 1.2, -INFINITY, INFINITY},
    {"motor.L", "H", 0.0015, -INFINITY, INFINITY},
    {"motor.k", "V*s", 0.05, -INFINITY, INFINITY},
    {"motor.J", "kg*m^2", 2e-05, -INFINITY, INFINITY},
    {"motor.b", "N*m*s", 1.5e-05, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"motor.winding.p", "V*s"},
    /* 1 */ {"motor.rotor.p", "N*m*s"},
    /* 2 */ {"spring.q", "rad"},
    /* 3 */ {"load.p", "N*m*s"},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"current", "A"},
    /* 1 */ {"motor_speed", "rad/s"},
    /* 2 */ {"load_speed", "rad/s"},
    /* 3 */ {"torque", "N*m"},
};

static const char *const model_param_check[] = {
    "the inertia of `motor.winding` must be positive",
    "the inertia of `motor.rotor` must be positive",
    "the inertia of `load` must be positive",
    "`n` must not be zero: the equation of `motor.rotor.p` divides by it",
};

static const int model_jac_row[] = {
    0, 0, 1, 1, 1, 1, 2, 2, 3, 3, 3,
};

static const int model_jac_col[] = {
    0, 1, 0, 1, 2, 3, 1, 3, 1, 2, 3,
};

static const int model_pivot_row[] = {
    0, 1, 2, 3,
};

static const int model_pivot_col[] = {
    0, 1, 2, 3,
};

static const int model_lu_row[] = {
    0, 2, 6, 9, 12,
};

static const int model_lu_pivot[] = {
    0, 3, 7, 11,
};

static const int model_lu_col[] = {
    0, 1, 0, 1, 2, 3, 1, 2, 3, 1, 2, 3,
};

static const int model_lu_jac[] = {
    0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "drive",
    .hash = "of its sources",
    .n_param = 11,
    .n_hoist = 27,
    .n_state = 4,
    .n_input = 0,
    .n_output = 4,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 11,
    .n_mass = 0,
    .n_lu = 12,
    .n_check = 4,
    .n_switch = 0,
    .n_timed = 0,
    .param = model_param,
    .state = model_state,
    .switch_info = NULL,
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
    .duration = 0.5,
    .every = 0.001,
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
