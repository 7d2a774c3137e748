/* planar: a bond graph of model Planar, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 arm.l1  [m]
 *     1 arm.l2  [m]
 *
 * States x:
 *     0 angles[1]
 *     1 angles[2]
 *     2 travelled[1]
 *     3 travelled[2]
 *
 * Outputs y:
 *     0 position[1]  [m]
 *     1 position[2]  [m]
 *     2 travelled[1]
 *     3 travelled[2]
 *     4 torque[1]
 *     5 torque[2]
 *     6 velocity[1]
 *     7 velocity[2]
 */
#include "bgc.h"

#include <math.h>

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    h[2] = p[1] * 0.3;
    h[0] = p[0];
    h[1] = p[1];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[0] + x[1];
    const double v2 = h[1] * sin(v1);
    f[2] = -(0.7 * (h[0] * sin(x[0]) + v2) - 0.4 * v2);
    const double v3 = h[1] * cos(v1);
    f[3] = 0.7 * (h[0] * cos(x[0]) + v3) - 0.4 * v3;
    f[0] = 0.7;
    f[1] = -0.4;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[0] + x[1];
    const double v2 = cos(v1);
    const double v3 = h[1] * v2;
    jac[0] = -(0.7 * (h[0] * cos(x[0]) + v3) - 0.4 * v3);
    jac[1] = -(v2 * h[2]);
    const double v4 = sin(v1);
    const double v5 = h[1] * v4;
    jac[2] = -(0.7 * (h[0] * sin(x[0]) + v5) - 0.4 * v5);
    jac[3] = -(v4 * h[2]);
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
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
    const double v1 = x[0] + x[1];
    const double v2 = h[1] * cos(v1);
    const double v3 = h[0] * cos(x[0]) + v2;
    y[0] = v3;
    const double v4 = h[1] * sin(v1);
    const double v5 = h[0] * sin(x[0]) + v4;
    y[1] = v5;
    y[4] = -(v3 * 20.0 + v5 * 30.0);
    y[5] = -(v2 * 20.0 + v4 * 30.0);
    y[6] = -(0.7 * v5 - 0.4 * v4);
    y[7] = 0.7 * v3 - 0.4 * v2;
    y[2] = x[2];
    y[3] = x[3];
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
    x[0] = 0.3;
    x[1] = 0.5;
    x[2] = 0.0;
    x[3] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    scale[0] = 1.0;
    scale[1] = 1.0;
    scale[2] = 1.0;
    scale[3] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)h, (void)check, (void)w;
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
    lu[0] = 1.0 / c;
    g += c * fabs(lu[0]);
    lu[1] = 1.0 / c;
    g += c * fabs(lu[1]);
    lu[2] = -jac[0] * lu[0];
    lu[3] = -jac[1] * lu[1];
    lu[4] = 1.0 / c;
    g += c * fabs(lu[4]);
    lu[5] = -jac[2] * lu[0];
    lu[6] = -jac[3] * lu[1];
    lu[7] = 1.0 / c;
    g += c * fabs(lu[7]);
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
    b[2] = b[2] - lu[2] * b[0] - lu[3] * b[1];
    b[3] = b[3] - lu[5] * b[0] - lu[6] * b[1];
    b[3] = b[3] * lu[7];
    b[2] = b[2] * lu[4];
    b[1] = b[1] * lu[1];
    b[0] = b[0] * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"arm.l1", "m", 2.0, -INFINITY, INFINITY},
    {"arm.l2", "m", 1.5, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"angles[1]", ""},
    /* 1 */ {"angles[2]", ""},
    /* 2 */ {"travelled[1]", ""},
    /* 3 */ {"travelled[2]", ""},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"position[1]", "m"},
    /* 1 */ {"position[2]", "m"},
    /* 2 */ {"travelled[1]", ""},
    /* 3 */ {"travelled[2]", ""},
    /* 4 */ {"torque[1]", ""},
    /* 5 */ {"torque[2]", ""},
    /* 6 */ {"velocity[1]", ""},
    /* 7 */ {"velocity[2]", ""},
};

static const int model_jac_row[] = {
    2, 2, 3, 3,
};

static const int model_jac_col[] = {
    0, 1, 0, 1,
};

static const int model_pivot_row[] = {
    0, 1, 2, 3,
};

static const int model_pivot_col[] = {
    0, 1, 2, 3,
};

static const int model_lu_row[] = {
    0, 1, 2, 5, 8,
};

static const int model_lu_pivot[] = {
    0, 1, 4, 7,
};

static const int model_lu_col[] = {
    0, 1, 0, 1, 2, 0, 1, 3,
};

static const int model_lu_jac[] = {
    2, 3, 5, 6,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "planar",
    .hash = "of its sources",
    .n_param = 2,
    .n_hoist = 3,
    .n_state = 4,
    .n_input = 0,
    .n_output = 8,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 4,
    .n_mass = 0,
    .n_lu = 8,
    .n_check = 0,
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
    .param_check = NULL,
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
    .duration = 2.0,
    .every = 0.1,
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
