/* ladder: a bond graph of model Ladder, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 r1
 *     1 r2
 *     2 r3
 *
 * States x:
 *     0 store.q
 *
 * Outputs y:
 *     0 store.q
 */
#include "bgc.h"

#include <math.h>

static inline double model_at_most(double a, double b)
{
    return a <= b ? 1.0 : a > b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    const double v1 = p[0] + p[1];
    const double v2 = 1.0 / v1;
    h[3] = v2;
    const double v3 = p[0] * v2;
    h[0] = v3;
    const double v4 = p[0] * v3;
    const double v5 = p[0] + p[2] - v4;
    const double v6 = 1.0 / v5;
    h[1] = v6;
    h[2] = -v6;
    const double v7 = fabs(p[0]);
    h[7] = fabs(v1) - 3.552713678800501e-15 * (fabs(p[1]) + v7);
    const double v8 = fabs(v5);
    const double v9 = model_at_most(v8, 1.7976931348623157e+308);
    h[8] = v9 == 0.0 ? v8 : v9 == v9 ? v8 - 3.552713678800501e-15 * (v7 + (fabs(v4) + fabs(p[2])))
            : v9;
    h[4] = p[0];
    h[5] = p[1];
    h[6] = p[2];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    f[0] = -((x[0] - 1.0 + h[0]) * h[1]);
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)x, (void)u, (void)w;
    dfdt[0] = 0.0;
    jac[0] = h[2];
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)t, (void)u, (void)w;
    out[0] = 0.5 * (x[0] * x[0]);
    const double v1 = (x[0] - 1.0 + h[0]) * h[1];
    const double v2 = h[3] * (1.0 + h[4] * v1);
    const double v3 = v2 - v1;
    out[1] = v3;
    out[2] = v3 * (h[4] * v3) + v2 * (h[5] * v2) + v1 * (h[6] * v1);
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
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
    (void)h, (void)m, (void)w;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    x[0] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    scale[0] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[7];
    check[1] = h[8];
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
    b[0] = b[0] * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"r1", "", 1.0, -INFINITY, INFINITY},
    {"r2", "", 2.0, -INFINITY, INFINITY},
    {"r3", "", 3.0, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"store.q", ""},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"store.q", ""},
};

static const char *const model_param_check[] = {
    "the algebraic loop at `shunt.f` is singular",
    "the algebraic loop at `shunt.f` is singular",
};

static const int model_jac_row[] = {
    0,
};

static const int model_jac_col[] = {
    0,
};

static const int model_pivot_row[] = {
    0,
};

static const int model_pivot_col[] = {
    0,
};

static const int model_lu_row[] = {
    0, 1,
};

static const int model_lu_pivot[] = {
    0,
};

static const int model_lu_col[] = {
    0,
};

static const int model_lu_jac[] = {
    0,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "ladder",
    .hash = "of its sources",
    .n_param = 3,
    .n_hoist = 9,
    .n_state = 1,
    .n_input = 0,
    .n_output = 1,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 1,
    .n_mass = 0,
    .n_lu = 1,
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
