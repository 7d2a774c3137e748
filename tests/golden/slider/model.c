/* slider: a bond graph of model Slider, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 slope  [rad]
 *
 * States x:
 *     0 sliding.p  [N*s]
 *     1 moving.p[1]  [N*s]
 *
 * Outputs y:
 *     0 cart  [m/s]
 *     1 slider
 *     2 momentum[1]  [N*s]
 *     3 momentum[2]  [N*s]
 */
#include "bgc.h"

#include <math.h>

static inline double model_max(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double model_at_most(double a, double b)
{
    return a <= b ? 1.0 : a > b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    const double v1 = sin(p[0]);
    h[6] = v1;
    const double v2 = cos(p[0]);
    h[3] = v2;
    h[0] = -(14.715 * v1 + 3.0 * v2);
    const double v3 = 4.0 * v2;
    h[5] = v3;
    const double v4 = v1 * (1.5 * v1);
    const double v5 = v2 * v3;
    const double v6 = v4 + v5;
    const double v7 = 1.0 / v6;
    h[4] = v7;
    const double v8 = v3 * v7;
    h[1] = v8;
    const double v9 = v3 * v8;
    const double v10 = 5.5 - v9;
    h[2] = 1.0 / v10;
    h[7] = model_max(v5, v4);
    h[8] = fabs(v6) - 3.552713678800501e-15 * (fabs(v5) + fabs(v4));
    const double v11 = fabs(v10);
    const double v12 = model_at_most(v11, 1.7976931348623157e+308);
    h[9] = v12 == 0.0 ? v11 : v12 == v12 ? v11 - 3.552713678800501e-15 * (5.5 + fabs(v9)) : v12;
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)x, (void)u, (void)w;
    f[0] = h[0];
    f[1] = 3.0;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)jac, (void)w;
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = (x[1] + h[1] * x[0]) * h[2];
    const double v2 = h[4] * (x[0] + h[5] * v1);
    const double v3 = v1 - h[3] * v2;
    const double v4 = h[6] * v2;
    out[0] = 0.5 * (v3 * (4.0 * v3)) + 0.5 * (v1 * (1.5 * v1) + v4 * (1.5 * v4));
    out[1] = 3.0 * v3 - 14.715 * v4;
    out[2] = 0.0;
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = (x[1] + h[1] * x[0]) * h[2];
    const double v2 = h[4] * (x[0] + h[5] * v1);
    y[1] = v2;
    y[0] = v1 - h[3] * v2;
    y[2] = 1.5 * v1;
    y[3] = 1.5 * (h[6] * v2);
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
    scale[0] = h[7];
    scale[1] = 4.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[8];
    check[1] = h[9];
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
static double model_factor_1(double c, double *restrict lu)
{
    double g = 0.0;
    lu[0] = 1.0 / c;
    g += c * fabs(lu[0]);
    lu[1] = 1.0 / c;
    g += c * fabs(lu[1]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    (void)jac;
    double g = 0.0;
    g += model_factor_1(c, lu);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
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
    {"slope", "rad", 0.6981317007977318, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"sliding.p", "N*s"},
    /* 1 */ {"moving.p[1]", "N*s"},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"cart", "m/s"},
    /* 1 */ {"slider", ""},
    /* 2 */ {"momentum[1]", "N*s"},
    /* 3 */ {"momentum[2]", "N*s"},
};

static const char *const model_param_check[] = {
    "`1.5*sin(slope)^2 + 4*cos(slope)^2` must not be zero: `cart` divides by it",
    "`5.5 - 16*cos(slope)^2/(1.5*sin(slope)^2 + 4*cos(slope)^2)` must not be zero: `cart` divides by it",
};

static const int model_pivot_row[] = {
    0, 1,
};

static const int model_pivot_col[] = {
    0, 1,
};

static const int model_lu_row[] = {
    0, 1, 2,
};

static const int model_lu_pivot[] = {
    0, 1,
};

static const int model_lu_col[] = {
    0, 1,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "slider",
    .hash = "of its sources",
    .n_param = 1,
    .n_hoist = 10,
    .n_state = 2,
    .n_input = 0,
    .n_output = 4,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 0,
    .n_mass = 0,
    .n_lu = 2,
    .n_check = 2,
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
    .jac_row = NULL,
    .jac_col = NULL,
    .mass_row = NULL,
    .mass_col = NULL,
    .pivot_row = model_pivot_row,
    .pivot_col = model_pivot_col,
    .lu_row = model_lu_row,
    .lu_pivot = model_lu_pivot,
    .lu_col = model_lu_col,
    .lu_jac = NULL,
    .lu_mass = NULL,
    .step = 0.0,
    .duration = 2.0,
    .every = 0.2,
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
