/* bridge: a bond graph of model Bridge, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 v
 *
 * States x:
 *     0 lamp.e
 *     1 plain.f
 *     2 detector.f
 *
 * Outputs y:
 *     0 left.e
 *     1 right.e
 *     2 top.e
 */
#include "bgc.h"

#include <math.h>

static inline double model_sign(double a)
{
    return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : a;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    h[0] = p[0];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)w;
    const double v1 = 0.3 * tanh(x[0] * 0.25) + 0.01 * x[0];
    const double v2 = 30.0 * (v1 - x[2]);
    const double v3 = h[0] - 0.1 * (x[1] + v1);
    f[0] = x[0] + v2 - v3;
    const double v4 = x[1] + x[2];
    const double v5 = 15.0 * v4 + 40.0 * v4 * (u[0] >= 1.0 ? v4 : u[0] < 1.0 ? -v4 : fabs(v4));
    f[1] = 20.0 * x[1] + v5 - v3;
    f[2] = 50.0 * x[2] + v5 - v2;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)h, (void)t, (void)w;
    const double v1 = tanh(x[0] * 0.25);
    const double v2 = 0.01 + 0.3 * (0.25 * (1.0 - v1 * v1));
    const double v3 = 30.0 * v2;
    const double v4 = 0.1 * v2;
    jac[3] = v4;
    jac[0] = 1.0 + v3 + v4;
    const double v5 = x[1] + x[2];
    const double v6 = 15.0 + (40.0 * (u[0] >= 1.0 ? v5 : u[0] < 1.0 ? -v5 : fabs(v5)) + 40.0 * v5 *
            (u[0] >= 1.0 ? 1.0 : u[0] < 1.0 ? -1.0 : model_sign(v5)));
    jac[5] = v6;
    jac[7] = v6;
    jac[4] = 20.0 + v6 - -0.1;
    jac[6] = -v3;
    jac[8] = 50.0 + v6 - -30.0;
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    jac[1] = 0.1;
    jac[2] = -30.0;
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
    (void)t, (void)w;
    const double v1 = 0.3 * tanh(x[0] * 0.25) + 0.01 * x[0];
    y[0] = 30.0 * (v1 - x[2]);
    const double v2 = x[1] + x[2];
    y[1] = 15.0 * v2 + 40.0 * v2 * (u[0] >= 1.0 ? v2 : u[0] < 1.0 ? -v2 : fabs(v2));
    y[2] = h[0] - 0.1 * (x[1] + v1);
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
    (void)h, (void)t, (void)u, (void)w;
    z[0] = x[1] + x[2];
}

/* The entries of M in the order of mass_row and mass_col. */
static void model_mass(const double *h, double *m, double *w)
{
    (void)h, (void)w;
    m[0] = 0.0;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    x[0] = 3.3504;
    x[1] = 0.214326;
    x[2] = 0.0187222;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    scale[0] = 1.0;
    scale[1] = 1.0;
    scale[2] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)h, (void)check, (void)w;
}

/* The arguments of functions that may hide pulses. */
static void model_watched(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    z[0] = x[0] * 0.25;
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
static double model_factor_1(const double *restrict m, const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[0] = 1.0 / (c * m[0] - jac[0]);
    g += (fabs(c * m[0]) + fabs(jac[0])) * fabs(lu[0]);
    lu[1] = -jac[1];
    lu[2] = -jac[2];
    lu[3] = -jac[3] * lu[0];
    lu[4] = 1.0 / (-jac[4] - lu[3] * lu[1]);
    g += fabs(jac[4]) * fabs(lu[4]);
    lu[5] = -jac[5] - lu[3] * lu[2];
    lu[6] = -jac[6] * lu[0];
    lu[7] = (-jac[7] - lu[6] * lu[1]) * lu[4];
    lu[8] = 1.0 / (-jac[8] - lu[6] * lu[2] - lu[7] * lu[5]);
    g += fabs(jac[8]) * fabs(lu[8]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    double g = 0.0;
    g += model_factor_1(m, jac, c, lu);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[1] = b[1] - lu[3] * b[0];
    b[2] = b[2] - lu[6] * b[0] - lu[7] * b[1];
    b[2] = b[2] * lu[8];
    b[1] = (b[1] - lu[5] * b[2]) * lu[4];
    b[0] = (b[0] - lu[2] * b[2] - lu[1] * b[1]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"v", "", 10.0, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"lamp.e", ""},
    /* 1 */ {"plain.f", ""},
    /* 2 */ {"detector.f", ""},
};

static const bgc_switch_info model_switch_info[] = {
    {BGC_NOT_BELOW, 0, 0},
};

static const int model_watch[] = {
    1,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"left.e", ""},
    /* 1 */ {"right.e", ""},
    /* 2 */ {"top.e", ""},
};

static const int model_jac_row[] = {
    0, 0, 0, 1, 1, 1, 2, 2, 2,
};

static const int model_jac_col[] = {
    0, 1, 2, 0, 1, 2, 0, 1, 2,
};

static const int model_mass_row[] = {
    0,
};

static const int model_mass_col[] = {
    0,
};

static const int model_pivot_row[] = {
    0, 1, 2,
};

static const int model_pivot_col[] = {
    0, 1, 2,
};

static const int model_lu_row[] = {
    0, 3, 6, 9,
};

static const int model_lu_pivot[] = {
    0, 4, 8,
};

static const int model_lu_col[] = {
    0, 1, 2, 0, 1, 2, 0, 1, 2,
};

static const int model_lu_jac[] = {
    0, 1, 2, 3, 4, 5, 6, 7, 8,
};

static const int model_lu_mass[] = {
    0,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "bridge",
    .hash = "of its sources",
    .n_param = 1,
    .n_hoist = 1,
    .n_state = 3,
    .n_input = 0,
    .n_output = 3,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 9,
    .n_mass = 1,
    .n_lu = 9,
    .n_check = 0,
    .n_switch = 1,
    .n_timed = 0,
    .param = model_param,
    .state = model_state,
    .switch_info = model_switch_info,
    .watch = model_watch,
    .n_watch = 1,
    .output = model_output,
    .input = NULL,
    .command = NULL,
    .device = NULL,
    .assertion = NULL,
    .param_check = NULL,
    .jac_row = model_jac_row,
    .jac_col = model_jac_col,
    .mass_row = model_mass_row,
    .mass_col = model_mass_col,
    .pivot_row = model_pivot_row,
    .pivot_col = model_pivot_col,
    .lu_row = model_lu_row,
    .lu_pivot = model_lu_pivot,
    .lu_col = model_lu_col,
    .lu_jac = model_lu_jac,
    .lu_mass = model_lu_mass,
    .step = 0.0,
    .duration = 1.0,
    .every = 0.0,
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
    .project = NULL,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
