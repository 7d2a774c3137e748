/* driven: a bond graph of model Driven, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Outputs y:
 *     0 voltage  [V]
 *     1 one  [C]
 *     2 other  [C]
 *     3 current  [A]
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
    (void)h, (void)t, (void)x, (void)u, (void)f, (void)w;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)jac, (void)dfdt, (void)w;
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)h, (void)x, (void)u, (void)w;
    const double v1 = 3.0 * t;
    const double v2 = sin(v1) * 10.0;
    out[0] = 0.5 * (v2 * (v2 * 0.002)) + 0.5 * (v2 * (v2 * 0.003));
    const double v3 = v2 * 0.01;
    const double v4 = 10.0 * (3.0 * cos(v1));
    out[1] = v2 * (v3 + (0.002 * v4 + 0.003 * v4));
    out[2] = v2 * v3;
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)h, (void)x, (void)u, (void)w;
    const double v1 = 3.0 * t;
    const double v2 = sin(v1) * 10.0;
    y[0] = v2;
    y[1] = v2 * 0.002;
    y[2] = v2 * 0.003;
    const double v3 = 10.0 * (3.0 * cos(v1));
    y[3] = v2 * 0.01 + (0.002 * v3 + 0.003 * v3);
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
    (void)h, (void)t, (void)u, (void)x, (void)w;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)scale, (void)w;
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
static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    (void)jac;
    double g = 0.0;
    (void)c;
    (void)lu;
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    (void)lu;
    (void)b;
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_var_info model_output[] = {
    /* 0 */ {"voltage", "V"},
    /* 1 */ {"one", "C"},
    /* 2 */ {"other", "C"},
    /* 3 */ {"current", "A"},
};

static const int model_lu_row[] = {
    0,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "driven",
    .hash = "of its sources",
    .n_param = 0,
    .n_hoist = 0,
    .n_state = 0,
    .n_input = 0,
    .n_output = 4,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 0,
    .n_mass = 0,
    .n_lu = 0,
    .n_check = 0,
    .n_switch = 0,
    .n_timed = 0,
    .param = NULL,
    .state = NULL,
    .switch_info = NULL,
    .output = model_output,
    .input = NULL,
    .command = NULL,
    .device = NULL,
    .assertion = NULL,
    .param_check = NULL,
    .jac_row = NULL,
    .jac_col = NULL,
    .mass_row = NULL,
    .mass_col = NULL,
    .pivot_row = NULL,
    .pivot_col = NULL,
    .lu_row = model_lu_row,
    .lu_pivot = NULL,
    .lu_col = NULL,
    .lu_jac = NULL,
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
