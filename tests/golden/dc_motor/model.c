/* start: a bond graph of model DcMotor, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 L  [H]
 *     1 R  [ohm]
 *     2 k  [V*s]
 *     3 J  [kg*m^2]
 *     4 b  [N*m*s]
 *
 * States x:
 *     0 winding.p  [V*s]
 *     1 rotor.p  [N*m*s]
 *
 * Outputs y:
 *     0 current  [A]
 *     1 speed  [rad/s]
 */
#include "bgc.h"

#include <math.h>

static inline double model_less(double a, double b)
{
    return a < b ? 1.0 : a >= b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    const double v1 = 1.0 / p[0];
    h[1] = v1;
    const double v2 = 1.0 / p[3];
    h[3] = v2;
    h[5] = -(p[1] * v1);
    h[6] = -(p[2] * v2);
    h[7] = p[2] * v1;
    h[8] = -(p[4] * v2);
    const double v3 = model_less(0.0, v2);
    h[10] = v3 == 0.0 ? 1.0 : v3 == v3 ? sqrt(p[0] * p[3]) : v3;
    h[0] = p[1];
    h[2] = p[2];
    h[4] = p[4];
    h[9] = p[0];
    h[11] = p[3];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = h[1] * x[0];
    const double v2 = h[3] * x[1];
    f[0] = 1.0 - h[0] * v1 - h[2] * v2;
    f[1] = h[2] * v1 - h[4] * v2;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)x, (void)u, (void)w;
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    jac[0] = h[5];
    jac[1] = h[6];
    jac[2] = h[7];
    jac[3] = h[8];
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
    y[0] = h[1] * x[0];
    y[1] = h[3] * x[1];
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
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[9];
    scale[1] = h[10];
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[9];
    check[1] = h[11];
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
    b[1] = b[1] * lu[3];
    b[0] = (b[0] - lu[1] * b[1]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"L", "H", 0.5, -INFINITY, INFINITY},
    {"R", "ohm", 1.0, -INFINITY, INFINITY},
    {"k", "V*s", 0.01, -INFINITY, INFINITY},
    {"J", "kg*m^2", 0.01, -INFINITY, INFINITY},
    {"b", "N*m*s", 0.1, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"winding.p", "V*s"},
    /* 1 */ {"rotor.p", "N*m*s"},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"current", "A"},
    /* 1 */ {"speed", "rad/s"},
};

static const char *const model_param_check[] = {
    "the inertia of `winding` must be positive",
    "the inertia of `rotor` must be positive",
};

static const int model_jac_row[] = {
    0, 0, 1, 1,
};

static const int model_jac_col[] = {
    0, 1, 0, 1,
};

static const int model_pivot_row[] = {
    0, 1,
};

static const int model_pivot_col[] = {
    0, 1,
};

static const int model_lu_row[] = {
    0, 2, 4,
};

static const int model_lu_pivot[] = {
    0, 3,
};

static const int model_lu_col[] = {
    0, 1, 0, 1,
};

static const int model_lu_jac[] = {
    0, 1, 2, 3,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "start",
    .hash = "of its sources",
    .n_param = 5,
    .n_hoist = 12,
    .n_state = 2,
    .n_input = 0,
    .n_output = 2,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 4,
    .n_mass = 0,
    .n_lu = 4,
    .n_check = 2,
    .n_given_assert = 0,
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
    .duration = 4.0,
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
