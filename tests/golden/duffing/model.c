/* release: a bond graph of model Duffing, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * States x:
 *     0 body.p
 *     1 spring.q
 *
 * Outputs y:
 *     0 position
 *     1 momentum
 */
#include "bgc.h"

#include <math.h>

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)p, (void)h, (void)w;
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    const double v1 = 0.25 * (x[1] * x[1]);
    const double v2 = x[1] * (0.5 + (v1 + v1));
    f[0] = -(v2 + v2);
    f[1] = x[0];
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    const double v1 = x[1] * x[1];
    const double v2 = 0.25 * v1;
    const double v3 = v1 + (0.5 + (v2 + v2));
    jac[0] = -(v3 + v3);
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    jac[1] = 1.0;
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    const double v1 = x[1] * x[1];
    const double v2 = 0.25 * v1;
    out[0] = v2 + v2 + 0.25 * (v1 * v1) + 0.5 * (x[0] * x[0]);
    out[1] = 0.0;
    out[2] = 0.0;
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    y[0] = x[1];
    y[1] = x[0];
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
    x[1] = 1.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    scale[0] = 1.0;
    scale[1] = 1.0;
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
    lu[1] = -jac[0];
    lu[2] = -jac[1] * lu[0];
    lu[3] = 1.0 / (c - lu[2] * lu[1]);
    g += c * fabs(lu[3]);
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

static const bgc_var_info model_state[] = {
    /* 0 */ {"body.p", ""},
    /* 1 */ {"spring.q", ""},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"position", ""},
    /* 1 */ {"momentum", ""},
};

static const int model_jac_row[] = {
    0, 1,
};

static const int model_jac_col[] = {
    1, 0,
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
    1, 2,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "release",
    .hash = "of its sources",
    .n_param = 0,
    .n_hoist = 0,
    .n_state = 2,
    .n_input = 0,
    .n_output = 2,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 2,
    .n_mass = 0,
    .n_lu = 4,
    .n_check = 0,
    .n_given_assert = 0,
    .n_switch = 0,
    .n_timed = 0,
    .param = NULL,
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
    .duration = 10.0,
    .every = 0.5,
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
