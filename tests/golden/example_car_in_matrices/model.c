/* matrices: a bond graph of model MatricesOverBump, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 bump.height  [m]
 *     1 bump.length  [m]
 *     2 bump.speed  [m/s]
 *     3 car.mass[1]  [kg]
 *     4 car.mass[2]  [kg]
 *     5 car.stiffness[1]  [N/m]
 *     6 car.stiffness[2]  [N/m]
 *     7 car.damping[2]  [N*s/m]
 *
 * States x:
 *     0 car.springs.q[1]  [m]
 *     1 car.springs.q[2]  [m]
 *     2 car.inertia.p[1]  [N*s]
 *     3 car.inertia.p[2]  [N*s]
 *     4 car.z[1]  [m]
 *     5 car.z[2]  [m]
 *     6 car.z[3]  [m]
 *
 * Outputs y:
 *     0 z[1]  [m]
 *     1 z[2]  [m]
 *     2 z[3]  [m]
 */
#include "bgc.h"

#include <math.h>

static inline double model_min(double a, double b)
{
    return a < b || a != a ? a : b;
}

static inline double model_less(double a, double b)
{
    return a < b ? 1.0 : a >= b ? 0.0 : (double)NAN;
}

static inline double model_both(double a, double b)
{
    return a == 0.0 || b == 0.0 ? 0.0 : a == a && b == b ? 1.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    const double v1 = p[1] / p[2];
    h[0] = v1;
    const double v2 = 1.0 / v1;
    h[2] = v2;
    h[1] = p[0] * 3.141592653589793 * v2;
    const double v3 = 1.0 / p[3];
    h[3] = v3;
    const double v4 = 1.0 / p[4];
    h[4] = v4;
    h[8] = -v3;
    h[9] = -v4;
    h[10] = -p[6];
    const double v5 = p[7] * v3;
    h[13] = v5;
    h[11] = -v5;
    const double v6 = p[7] * v4;
    h[12] = v6;
    h[14] = -v6;
    h[15] = v2 * 6.283185307179586;
    const double v7 = model_less(0.0, p[5]);
    h[16] = v7 == 0.0 ? 1.0 : v7 == v7 ? sqrt(p[3] / p[5]) : v7;
    const double v8 = model_less(0.0, p[6]);
    h[17] = v8 == 0.0 ? 1.0 : v8 == v8 ? sqrt(model_min(p[3], p[4]) / p[6]) : v8;
    h[20] = fabs(p[2]);
    h[5] = p[5];
    h[6] = p[6];
    h[7] = p[7];
    h[18] = p[3];
    h[19] = p[4];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)w;
    const double v1 = t - 0.5;
    const double v2 = model_both(u[0] == u[0] ? u[0] : model_less(0.0, v1), u[1] == u[1] ? u[1] :
            model_less(v1, h[0]));
    const double v3 = v2 == 0.0 ? 0.0 : v2 == v2 ? h[1] * sin(h[2] * (v1 * 6.283185307179586)) : v2;
    f[4] = v3;
    const double v4 = x[2] * h[3];
    f[5] = v4;
    f[0] = v3 - v4;
    const double v5 = h[4] * x[3];
    f[6] = v5;
    const double v6 = v5 - v4;
    f[1] = -v6;
    const double v7 = h[6] * x[1] - h[7] * v6;
    f[3] = v7;
    f[2] = h[5] * x[0] - v7;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)x, (void)w;
    const double v1 = t - 0.5;
    const double v2 = model_both(u[0] == u[0] ? u[0] : model_less(0.0, v1), u[1] == u[1] ? u[1] :
            model_less(v1, h[0]));
    const double v3 = v2 == 0.0 ? 0.0 : v2 == v2 ? h[1] * (h[15] * cos(h[2] * (v1 *
            6.283185307179586))) : v2;
    dfdt[0] = v3;
    dfdt[4] = v3;
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
    dfdt[5] = 0.0;
    dfdt[6] = 0.0;
    jac[0] = h[8];
    jac[1] = h[3];
    jac[2] = h[9];
    jac[3] = h[5];
    jac[4] = h[10];
    jac[5] = h[11];
    jac[6] = h[12];
    jac[7] = h[6];
    jac[8] = h[13];
    jac[9] = h[14];
    jac[10] = h[3];
    jac[11] = h[4];
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
    (void)h, (void)t, (void)u, (void)w;
    y[0] = x[4];
    y[1] = x[5];
    y[2] = x[6];
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
    const double v1 = t - 0.5;
    z[0] = v1;
    z[1] = h[0] - v1;
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
    x[6] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[16];
    scale[1] = h[17];
    scale[2] = h[18];
    scale[3] = h[19];
    scale[4] = 1.0;
    scale[5] = 1.0;
    scale[6] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[18];
    check[1] = h[19];
    check[2] = h[20];
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
    (void)w;
    const bgc_range v1 = bgc_range_difference(t, bgc_range_of(0.5));
    const bgc_range v2 = bgc_range_both(bgc_range_choice(bgc_range_equal(u[0], u[0]), u[0],
            bgc_range_less(bgc_range_of(0.0), v1)), bgc_range_choice(bgc_range_equal(u[1], u[1]),
            u[1], bgc_range_less(v1, h[0])));
    const bgc_range v3 = bgc_range_product(h[2], bgc_range_product(v1,
            bgc_range_of(6.283185307179586)));
    b[0] = bgc_range_choice(v2, bgc_range_product(h[1], bgc_range_sin(v3)), bgc_range_of(0.0));
    b[1] = bgc_range_choice(v2, bgc_range_product(h[1], bgc_range_product(h[15],
            bgc_range_cos(v3))), bgc_range_of(0.0));
}

#include "bgc_ranges.h"

/* Ranges of the arguments of switches of time alone, and of their derivatives by time. */
static void ranges_timed_ranges(
    const bgc_range *h, bgc_range t, const bgc_range *u, bgc_range *b, bgc_range *w)
{
    (void)u, (void)w;
    const bgc_range v1 = bgc_range_difference(t, bgc_range_of(0.5));
    b[0] = v1;
    b[2] = bgc_range_difference(h[0], v1);
    b[1] = bgc_range_of(1.0);
    b[3] = bgc_range_of(-1.0);
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[-16] = 1.0 / c;
    g += c * fabs(lu[-16]);
    lu[-15] = 1.0 / c;
    g += c * fabs(lu[-15]);
    lu[-14] = -jac[10];
    lu[-13] = 1.0 / c;
    g += c * fabs(lu[-13]);
    lu[-12] = -jac[11];
    lu[-11] = 1.0 / c;
    g += c * fabs(lu[-11]);
    lu[-10] = -jac[0];
    lu[-9] = 1.0 / c;
    g += c * fabs(lu[-9]);
    lu[-8] = -jac[1];
    lu[-7] = -jac[2];
    lu[-6] = -jac[3] * lu[-11];
    lu[-5] = -jac[4] * lu[-9];
    lu[-4] = 1.0 / (c - jac[5] - lu[-6] * lu[-10] - lu[-5] * lu[-8]);
    g += (c + fabs(jac[5])) * fabs(lu[-4]);
    lu[-3] = -jac[6] - lu[-5] * lu[-7];
    lu[-2] = -jac[7] * lu[-9];
    lu[-1] = (-jac[8] - lu[-2] * lu[-8]) * lu[-4];
    lu[0] = 1.0 / (c - jac[9] - lu[-2] * lu[-7] - lu[-1] * lu[-3]);
    g += (c + fabs(jac[9])) * fabs(lu[0]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    double g = 0.0;
    g += model_factor_1(jac, c, lu + 16);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[2] = b[2] - lu[-6] * b[0] - lu[-5] * b[1];
    b[3] = b[3] - lu[-2] * b[1] - lu[-1] * b[2];
    b[3] = b[3] * lu[0];
    b[2] = (b[2] - lu[-3] * b[3]) * lu[-4];
    b[1] = (b[1] - lu[-7] * b[3] - lu[-8] * b[2]) * lu[-9];
    b[0] = (b[0] - lu[-10] * b[2]) * lu[-11];
    b[6] = (b[6] - lu[-12] * b[3]) * lu[-13];
    b[5] = (b[5] - lu[-14] * b[2]) * lu[-15];
    b[4] = b[4] * lu[-16];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu + 16, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"bump.height", "m", 0.05, -INFINITY, INFINITY},
    {"bump.length", "m", 1.0, 0.001, 100.0},
    {"bump.speed", "m/s", 10.0, 0.1, 100.0},
    {"car.mass[1]", "kg", 40.0, -INFINITY, INFINITY},
    {"car.mass[2]", "kg", 300.0, -INFINITY, INFINITY},
    {"car.stiffness[1]", "N/m", 200000.0, -INFINITY, INFINITY},
    {"car.stiffness[2]", "N/m", 20000.0, -INFINITY, INFINITY},
    {"car.damping[2]", "N*s/m", 1500.0, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"car.springs.q[1]", "m"},
    /* 1 */ {"car.springs.q[2]", "m"},
    /* 2 */ {"car.inertia.p[1]", "N*s"},
    /* 3 */ {"car.inertia.p[2]", "N*s"},
    /* 4 */ {"car.z[1]", "m"},
    /* 5 */ {"car.z[2]", "m"},
    /* 6 */ {"car.z[3]", "m"},
};

static const bgc_switch_info model_switch_info[] = {
    {BGC_ABOVE, 1, 1},
    {BGC_ABOVE, 1, 1},
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"z[1]", "m"},
    /* 1 */ {"z[2]", "m"},
    /* 2 */ {"z[3]", "m"},
};

static const char *const model_param_check[] = {
    "the inertia of `car.inertia[1]` must be positive",
    "the inertia of `car.inertia[2]` must be positive",
    "`bump.speed` must not be zero: the equation of `car.springs.q[1]` divides by it",
};

static const int model_jac_row[] = {
    0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 5, 6,
};

static const int model_jac_col[] = {
    2, 2, 3, 0, 1, 2, 3, 1, 2, 3, 2, 3,
};

static const int model_pivot_row[] = {
    4, 5, 6, 0, 1, 2, 3,
};

static const int model_pivot_col[] = {
    4, 5, 6, 0, 1, 2, 3,
};

static const int model_lu_row[] = {
    0, 1, 3, 5, 7, 10, 14, 17,
};

static const int model_lu_pivot[] = {
    0, 1, 3, 5, 7, 12, 16,
};

static const int model_lu_col[] = {
    0, 1, 5, 2, 6, 3, 5, 4, 5, 6, 3, 4, 5, 6, 4, 5,
    6,
};

static const int model_lu_jac[] = {
    6, 8, 9, 10, 11, 12, 13, 14, 15, 16, 2, 4,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "matrices",
    .hash = "of its sources",
    .n_param = 8,
    .n_hoist = 21,
    .n_state = 7,
    .n_input = 0,
    .n_output = 3,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 12,
    .n_mass = 0,
    .n_lu = 17,
    .n_check = 3,
    .n_switch = 2,
    .n_timed = 2,
    .param = model_param,
    .state = model_state,
    .switch_info = model_switch_info,
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
    .duration = 3.0,
    .every = 0.005,
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
    .defaults = model_defaults,
    .factor = model_factor,
    .solve = model_solve,
    .ranges = ranges_ranges,
    .timed_ranges = ranges_timed_ranges,
    .n_term = 1,
    .project = NULL,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
