/* rectifier: a bond graph of model Rectifier, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * States x:
 *     0 store.q
 *     1 sharp.e
 *     2 soft.e
 *
 * Outputs y:
 *     0 store.q
 *     1 loop.f
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
    (void)h, (void)u, (void)w;
    const double v1 = 1e-14 * (exp(x[1] * 38.684719535783366) - 1.0);
    f[0] = v1;
    f[1] = 100000.0 * x[0] + (x[2] + (x[1] + (1000.0 * v1 - 5.0 * sin(100.0 * t))));
    f[2] = v1 - 1e-09 * (exp(x[2] * 20.0) - 1.0);
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)h, (void)u, (void)w;
    const double v1 = 1e-14 * (38.684719535783366 * exp(x[1] * 38.684719535783366));
    jac[0] = v1;
    jac[4] = v1;
    jac[2] = 1.0 + 1000.0 * v1;
    jac[5] = -(1e-09 * (20.0 * exp(x[2] * 20.0)));
    dfdt[1] = -(5.0 * (100.0 * cos(100.0 * t)));
    dfdt[0] = 0.0;
    dfdt[2] = 0.0;
    jac[1] = 100000.0;
    jac[3] = 1.0;
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)h, (void)u, (void)w;
    out[0] = 0.5 * (x[0] * (100000.0 * x[0]));
    const double v1 = 1e-14 * (exp(x[1] * 38.684719535783366) - 1.0);
    out[1] = 5.0 * sin(100.0 * t) * v1;
    out[2] = v1 * (1000.0 * v1) + x[1] * v1 + x[2] * v1;
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    y[1] = 1e-14 * (exp(x[1] * 38.684719535783366) - 1.0);
    y[0] = x[0];
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
    (void)h, (void)w;
    m[0] = 1.0;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    x[0] = 0.0;
    x[1] = 0.0;
    x[2] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    scale[0] = 1e-05;
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
    z[0] = x[1] * 38.684719535783366;
    z[1] = x[2] * 20.0;
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
    (void)h, (void)u, (void)w;
    const bgc_range v1 = bgc_range_product(bgc_range_of(100.0), t);
    b[0] = bgc_range_sin(v1);
    b[1] = bgc_range_product(bgc_range_of(100.0), bgc_range_cos(v1));
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict m, const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[0] = 1.0 / (c * m[0]);
    g += fabs(c * m[0]) * fabs(lu[0]);
    lu[1] = -jac[0];
    lu[2] = -jac[1] * lu[0];
    lu[3] = 1.0 / (-jac[2] - lu[2] * lu[1]);
    g += fabs(jac[2]) * fabs(lu[3]);
    lu[4] = -jac[3];
    lu[5] = -jac[4] * lu[3];
    lu[6] = 1.0 / (-jac[5] - lu[5] * lu[4]);
    g += fabs(jac[5]) * fabs(lu[6]);
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
    b[1] = b[1] - lu[2] * b[0];
    b[2] = b[2] - lu[5] * b[1];
    b[2] = b[2] * lu[6];
    b[1] = (b[1] - lu[4] * b[2]) * lu[3];
    b[0] = (b[0] - lu[1] * b[1]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_var_info model_state[] = {
    /* 0 */ {"store.q", ""},
    /* 1 */ {"sharp.e", ""},
    /* 2 */ {"soft.e", ""},
};

static const int model_watch[] = {
    0, 0,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"store.q", ""},
    /* 1 */ {"loop.f", ""},
};

static const int model_jac_row[] = {
    0, 1, 1, 1, 2, 2,
};

static const int model_jac_col[] = {
    1, 0, 1, 2, 1, 2,
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
    0, 2, 5, 7,
};

static const int model_lu_pivot[] = {
    0, 3, 6,
};

static const int model_lu_col[] = {
    0, 1, 0, 1, 2, 1, 2,
};

static const int model_lu_jac[] = {
    1, 2, 3, 4, 5, 6,
};

static const int model_lu_mass[] = {
    0,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "rectifier",
    .hash = "of its sources",
    .n_param = 0,
    .n_hoist = 0,
    .n_state = 3,
    .n_input = 0,
    .n_output = 2,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 6,
    .n_mass = 1,
    .n_lu = 7,
    .n_check = 0,
    .n_given_assert = 0,
    .n_switch = 0,
    .n_timed = 0,
    .param = NULL,
    .state = model_state,
    .switch_info = NULL,
    .watch = model_watch,
    .n_watch = 2,
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
    .duration = 0.1,
    .every = 0.0,
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
    .watched = model_watched,
    .defaults = model_defaults,
    .factor = model_factor,
    .solve = model_solve,
    .ranges = ranges_ranges,
    .n_term = 1,
    .project = NULL,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
