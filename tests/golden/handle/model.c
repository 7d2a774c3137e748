/* rate: a bond graph of model Held, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 x[1]  [m]
 *     1 x[2]  [m]
 *     2 x[3]  [m]
 *     3 handle.stiffness  [N/m]
 *     4 handle.damping  [N*s/m]
 *     5 handle.limit  [N]
 *     6 handle.command.gain  [1/s]
 *     7 handle.command.band  [m]
 *     8 handle.command.limit  [m/s]
 *     9 handle.command.lag  [s]
 *    10 handle.feedback.scale
 *
 * States x:
 *     0 handle.spring.q[1]  [m]
 *     1 handle.spring.q[2]  [m]
 *     2 handle.spring.q[3]  [m]
 *     3 handle.command.reached[1]  [m/s]
 *     4 handle.command.reached[2]  [m/s]
 *     5 handle.command.reached[3]  [m/s]
 *
 * Outputs y:
 *     0 velocity[1]  [m/s]
 *     1 velocity[2]  [m/s]
 *     2 velocity[3]  [m/s]
 *     3 slip[1]  [m/s]
 *     4 slip[2]  [m/s]
 *     5 slip[3]  [m/s]
 *     6 stretch[1]  [m]
 *     7 stretch[2]  [m]
 *     8 stretch[3]  [m]
 *     9 resistance[1]  [N]
 *    10 resistance[2]  [N]
 *    11 resistance[3]  [N]
 *    12 force[1]  [N]
 *    13 force[2]  [N]
 *    14 force[3]  [N]
 */
#include "bgc.h"

#include <math.h>

static inline double model_max(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double model_min(double a, double b)
{
    return a < b || a != a ? a : b;
}

static inline double model_sign(double a)
{
    return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : a;
}

static inline double model_less(double a, double b)
{
    return a < b ? 1.0 : a >= b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    const double v1 = -p[8];
    h[0] = model_min(model_max(p[6] * (model_sign(p[0]) * model_max(fabs(p[0]) - p[7], 0.0)), v1),
            p[8]);
    const double v2 = 1.0 / p[9];
    h[1] = v2;
    h[2] = model_min(model_max(p[6] * (model_sign(p[1]) * model_max(fabs(p[1]) - p[7], 0.0)), v1),
            p[8]);
    h[3] = model_min(model_max(p[6] * (model_sign(p[2]) * model_max(fabs(p[2]) - p[7], 0.0)), v1),
            p[8]);
    h[4] = -v2;
    const double v3 = p[10] * 18000.0;
    const double v4 = model_max(p[5], sqrt(v3 * v3));
    h[7] = -(v3 * (p[5] / v4));
    const double v5 = model_less(0.0, p[3]);
    h[8] = v5 == 0.0 ? 1.0 : v5 == v5 ? 1.0 / p[3] : v5;
    h[9] = fabs(p[9]);
    h[10] = fabs(v4);
    h[5] = p[4];
    h[6] = p[3];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    f[0] = 0.1 - x[3];
    f[1] = -x[4];
    f[2] = -x[5];
    f[3] = (h[0] - x[3]) * h[1];
    f[4] = h[1] * (h[2] - x[4]);
    f[5] = h[1] * (h[3] - x[5]);
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
    dfdt[4] = 0.0;
    dfdt[5] = 0.0;
    jac[0] = -1.0;
    jac[1] = -1.0;
    jac[2] = -1.0;
    jac[3] = h[4];
    jac[4] = h[4];
    jac[5] = h[4];
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
    const double v1 = 0.1 - x[3];
    y[3] = v1;
    y[4] = -x[4];
    y[5] = -x[5];
    y[9] = h[5] * v1 + h[6] * x[0];
    y[10] = h[6] * x[1] - h[5] * x[4];
    y[11] = h[6] * x[2] - h[5] * x[5];
    y[0] = x[3];
    y[1] = x[4];
    y[2] = x[5];
    y[6] = x[0];
    y[7] = x[1];
    y[8] = x[2];
    y[12] = 0.0;
    y[13] = 0.0;
    y[14] = h[7];
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
    x[4] = 0.0;
    x[5] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[8];
    scale[1] = h[8];
    scale[2] = h[8];
    scale[3] = 1.0;
    scale[4] = 1.0;
    scale[5] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[9];
    check[1] = h[10];
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
    lu[2] = 1.0 / c;
    g += c * fabs(lu[2]);
    lu[3] = -jac[1];
    lu[4] = 1.0 / c;
    g += c * fabs(lu[4]);
    lu[5] = -jac[2];
    lu[6] = 1.0 / (c - jac[3]);
    g += (c + fabs(jac[3])) * fabs(lu[6]);
    lu[7] = 1.0 / (c - jac[4]);
    g += (c + fabs(jac[4])) * fabs(lu[7]);
    lu[8] = 1.0 / (c - jac[5]);
    g += (c + fabs(jac[5])) * fabs(lu[8]);
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
    b[5] = b[5] * lu[8];
    b[4] = b[4] * lu[7];
    b[3] = b[3] * lu[6];
    b[2] = (b[2] - lu[5] * b[5]) * lu[4];
    b[1] = (b[1] - lu[3] * b[4]) * lu[2];
    b[0] = (b[0] - lu[1] * b[3]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"x[1]", "m", 0.004, -INFINITY, INFINITY},
    {"x[2]", "m", -0.01, -INFINITY, INFINITY},
    {"x[3]", "m", 0.07, -INFINITY, INFINITY},
    {"handle.stiffness", "N/m", 400000.0, 0.0, 1000000000000.0},
    {"handle.damping", "N*s/m", 80000.0, 0.0, 1000000000000.0},
    {"handle.limit", "N", 12.0, 1e-06, 1000000.0},
    {"handle.command.gain", "1/s", 12.0, -INFINITY, INFINITY},
    {"handle.command.band", "m", 0.005, 0.0, 1.0},
    {"handle.command.limit", "m/s", 0.6, 0.0, 100.0},
    {"handle.command.lag", "s", 0.05, 0.0001, 100.0},
    {"handle.feedback.scale", "", 0.0005555555555555556, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"handle.spring.q[1]", "m"},
    /* 1 */ {"handle.spring.q[2]", "m"},
    /* 2 */ {"handle.spring.q[3]", "m"},
    /* 3 */ {"handle.command.reached[1]", "m/s"},
    /* 4 */ {"handle.command.reached[2]", "m/s"},
    /* 5 */ {"handle.command.reached[3]", "m/s"},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"velocity[1]", "m/s"},
    /* 1 */ {"velocity[2]", "m/s"},
    /* 2 */ {"velocity[3]", "m/s"},
    /* 3 */ {"slip[1]", "m/s"},
    /* 4 */ {"slip[2]", "m/s"},
    /* 5 */ {"slip[3]", "m/s"},
    /* 6 */ {"stretch[1]", "m"},
    /* 7 */ {"stretch[2]", "m"},
    /* 8 */ {"stretch[3]", "m"},
    /* 9 */ {"resistance[1]", "N"},
    /* 10 */ {"resistance[2]", "N"},
    /* 11 */ {"resistance[3]", "N"},
    /* 12 */ {"force[1]", "N"},
    /* 13 */ {"force[2]", "N"},
    /* 14 */ {"force[3]", "N"},
};

static const char *const model_param_check[] = {
    "`handle.command.lag` must not be zero: the equation of `handle.command.reached[1]` divides by it",
    "`max(handle.limit, sqrt(324000000*handle.feedback.scale^2))` must not be zero: `force[3]` divides by it",
};

static const int model_jac_row[] = {
    0, 1, 2, 3, 4, 5,
};

static const int model_jac_col[] = {
    3, 4, 5, 3, 4, 5,
};

static const int model_pivot_row[] = {
    0, 1, 2, 3, 4, 5,
};

static const int model_pivot_col[] = {
    0, 1, 2, 3, 4, 5,
};

static const int model_lu_row[] = {
    0, 2, 4, 6, 7, 8, 9,
};

static const int model_lu_pivot[] = {
    0, 2, 4, 6, 7, 8,
};

static const int model_lu_col[] = {
    0, 3, 1, 4, 2, 5, 3, 4, 5,
};

static const int model_lu_jac[] = {
    1, 3, 5, 6, 7, 8,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "rate",
    .hash = "of its sources",
    .n_param = 11,
    .n_hoist = 11,
    .n_state = 6,
    .n_input = 0,
    .n_output = 15,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 6,
    .n_mass = 0,
    .n_lu = 9,
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
