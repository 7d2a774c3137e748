/* tanks: a bond graph of model TwoTanks, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 area  [m^2]
 *     1 slope
 *     2 level0[1]  [m]
 *     3 level0[2]  [m]
 *     4 hole[1]  [m^2]
 *     5 hole[2]  [m^2]
 *     6 small  [Pa]
 *     7 pumped  [m^3/s]
 *     8 pumped_later  [m^3/s]
 *     9 change  [s]
 *
 * States x:
 *     0 water.q  [m^3]
 *     1 funnel.q  [m^3]
 *
 * Outputs y:
 *     0 level[1]  [m]
 *     1 level[2]  [m]
 *     2 between  [m^3/s]
 *     3 out  [m^3/s]
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
    const double v1 = sqrt(0.002);
    h[0] = p[4] * v1;
    const double v2 = p[1] * p[1];
    const double v3 = 7357.5 * pow(3.0 / (3.141592653589793 * v2), 0.3333333333333333);
    h[1] = v3;
    const double v4 = p[0] * 0.00010193679918450561;
    h[12] = v4;
    const double v5 = 1.0 / v4;
    h[2] = v5;
    h[3] = p[6] * p[6];
    h[7] = p[5] * v1;
    h[8] = v3 * 1.3333333333333333;
    h[9] = p[0] * p[2];
    h[10] = 1.0471975511965976 * v2 * (p[3] * (p[3] * p[3]));
    const double v6 = model_less(0.0, v5);
    h[11] = v6 == 0.0 ? 1.0 : v6 == v6 ? v4 : v6;
    h[13] = fabs(p[1]);
    h[4] = p[9];
    h[5] = p[7];
    h[6] = p[8];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)w;
    const double v1 = h[1] * (1.3333333333333333 * pow(x[1], 0.3333333333333333));
    const double v2 = v1 - h[2] * x[0];
    const double v3 = h[0] * (v2 / pow(h[3] + v2 * v2, 0.25));
    const double v4 = u[0] == u[0] ? u[0] : model_less(t, h[4]);
    f[0] = v3 + (v4 == 0.0 ? h[6] : v4 == v4 ? h[5] : v4);
    f[1] = -(v3 + h[7] * (v1 / pow(h[3] + v1 * v1, 0.25)));
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = h[1] * (1.3333333333333333 * pow(x[1], 0.3333333333333333));
    const double v2 = v1 - h[2] * x[0];
    const double v3 = h[3] + v2 * v2;
    const double v4 = 1.0 / pow(v3, 0.25);
    const double v5 = h[0] * (v4 - (v2 + v2) * ((v3 == 0.0 ? 0.0 : v3 == v3 ? 0.25 * pow(v3, -0.75)
            : v3) * (v2 * (v4 * v4))));
    const double v6 = h[2] * v5;
    jac[2] = v6;
    jac[0] = -v6;
    const double v7 = (x[1] == 0.0 ? 0.0 : x[1] == x[1] ? 0.3333333333333333 * pow(x[1],
            -0.6666666666666666) : x[1]) * h[8];
    const double v8 = v5 * v7;
    jac[1] = v8;
    const double v9 = h[3] + v1 * v1;
    const double v10 = 1.0 / pow(v9, 0.25);
    jac[3] = -(h[7] * (v10 - (v1 + v1) * ((v9 == 0.0 ? 0.0 : v9 == v9 ? 0.25 * pow(v9, -0.75) : v9)
            * (v1 * (v10 * v10)))) * v7 + v8);
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)w;
    const double v1 = h[2] * x[0];
    out[0] = h[1] * pow(x[1], 1.3333333333333333) + 0.5 * (x[0] * v1);
    const double v2 = u[0] == u[0] ? u[0] : model_less(t, h[4]);
    out[1] = v1 * (v2 == 0.0 ? h[6] : v2 == v2 ? h[5] : v2);
    const double v3 = h[1] * (1.3333333333333333 * pow(x[1], 0.3333333333333333));
    const double v4 = v3 - v1;
    out[2] = v4 * (h[0] * (v4 / pow(h[3] + v4 * v4, 0.25))) + v3 * (h[7] * (v3 / pow(h[3] + v3 *
            v3, 0.25)));
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = h[2] * x[0];
    y[0] = 0.00010193679918450561 * v1;
    const double v2 = h[1] * (1.3333333333333333 * pow(x[1], 0.3333333333333333));
    y[1] = 0.00010193679918450561 * v2;
    const double v3 = v2 - v1;
    y[2] = -(h[0] * (v3 / pow(h[3] + v3 * v3, 0.25)));
    y[3] = h[7] * (v2 / pow(h[3] + v2 * v2, 0.25));
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
    (void)x, (void)u, (void)w;
    z[0] = h[4] - t;
}

/* The entries of M in the order of mass_row and mass_col. */
static void model_mass(const double *h, double *m, double *w)
{
    (void)h, (void)m, (void)w;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)t, (void)u, (void)w;
    x[0] = h[9];
    x[1] = h[10];
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[11];
    scale[1] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[12];
    check[1] = h[13];
}

/* The arguments of functions that may hide pulses. */
static void model_watched(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = h[1] * (1.3333333333333333 * pow(x[1], 0.3333333333333333));
    const double v2 = v1 - h[2] * x[0];
    z[0] = pow(h[3] + v2 * v2, 0.25);
    z[1] = pow(h[3] + v1 * v1, 0.25);
}

/* Defaults of the parameters that are given by other parameters. */
static void model_defaults(double *p, const unsigned char *is_set, double *w)
{
    (void)p;
    (void)is_set;
    (void)w;
}

#include "bgc_ranges.h"

/* Ranges of the arguments of switches of time alone, and of their derivatives by time. */
static void ranges_timed_ranges(
    const bgc_range *h, bgc_range t, const bgc_range *u, bgc_range *b, bgc_range *w)
{
    (void)u, (void)w;
    b[0] = bgc_range_difference(h[4], t);
    b[1] = bgc_range_of(-1.0);
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
    {"area", "m^2", 0.5, 0.001, 1000.0},
    {"slope", "", 0.5, 0.01, 100.0},
    {"level0[1]", "m", 1.0, -INFINITY, INFINITY},
    {"level0[2]", "m", 0.5, -INFINITY, INFINITY},
    {"hole[1]", "m^2", 0.002, -INFINITY, INFINITY},
    {"hole[2]", "m^2", 0.002, -INFINITY, INFINITY},
    {"small", "Pa", 1.0, -INFINITY, INFINITY},
    {"pumped", "m^3/s", 0.008, -INFINITY, INFINITY},
    {"pumped_later", "m^3/s", 0.004, -INFINITY, INFINITY},
    {"change", "s", 200.0, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"water.q", "m^3"},
    /* 1 */ {"funnel.q", "m^3"},
};

static const bgc_switch_info model_switch_info[] = {
    {BGC_ABOVE, 1, 1},
};

static const int model_watch[] = {
    2, 2,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"level[1]", "m"},
    /* 1 */ {"level[2]", "m"},
    /* 2 */ {"between", "m^3/s"},
    /* 3 */ {"out", "m^3/s"},
};

static const char *const model_param_check[] = {
    "the compliance of `water` must be positive",
    "`slope` must not be zero: the equation of `water.q` divides by it",
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
    .name = "tanks",
    .hash = "of its sources",
    .n_param = 10,
    .n_hoist = 14,
    .n_state = 2,
    .n_input = 0,
    .n_output = 4,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 4,
    .n_mass = 0,
    .n_lu = 4,
    .n_check = 2,
    .n_switch = 1,
    .n_timed = 1,
    .param = model_param,
    .state = model_state,
    .switch_info = model_switch_info,
    .watch = model_watch,
    .n_watch = 2,
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
    .duration = 400.0,
    .every = 1.0,
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
    .timed_ranges = ranges_timed_ranges,
    .project = NULL,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
