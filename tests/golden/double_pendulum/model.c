/* double: a bond graph of model Double, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 mass1  [kg]
 *     1 mass2  [kg]
 *
 * States x:
 *     0 first.p  [N*s]
 *     1 second.p  [N*s]
 *     2 a  [rad]
 *     3 b  [rad]
 *
 * Outputs y:
 *     0 a  [rad]
 *     1 b  [rad]
 *     2 a_rate
 *     3 b_rate
 */
#include "bgc.h"

#include <math.h>

/* Everything that depends on parameters alone. */
static void model_prepare(const double *p, double *h, double *w)
{
    (void)w;
    h[1] = 1.0 / (p[0] + p[1]);
    const double v1 = p[0] * 9.81;
    h[5] = v1;
    const double v2 = p[1] * 9.81;
    h[4] = v2;
    h[3] = v1 + v2;
    h[0] = p[0];
    h[2] = p[1];
}

/* The right-hand sides f of M y' = f. */
static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = sin(x[2]);
    const double v2 = 0.7 * sin(x[3]);
    const double v3 = 0.7 * cos(x[3]);
    const double v4 = cos(x[2]);
    const double v5 = v2 * (h[2] * v1) + v3 * (h[2] * v4);
    const double v6 = v5 * h[1];
    const double v7 = (x[1] - x[0] * v6) / (v2 * (h[2] * v2) + v3 * (h[2] * v3) - v5 * v6);
    f[3] = v7;
    const double v8 = h[1] * (x[0] - v5 * v7);
    f[2] = v8;
    const double v9 = v1 * v8;
    const double v10 = v4 * v8;
    const double v11 = (h[0] * v9 + h[2] * (v9 + v2 * v7)) * v10 - v9 * (h[0] * v10 + h[2] * (v10 +
            v3 * v7));
    f[0] = v11 - h[3] * v1;
    f[1] = -(v11 + h[4] * v2);
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = cos(x[2]);
    const double v2 = sin(x[2]);
    const double v3 = 0.7 * sin(x[3]);
    const double v4 = 0.7 * cos(x[3]);
    const double v5 = v3 * (h[2] * v2) + v4 * (h[2] * v1);
    const double v6 = v5 * h[1];
    const double v7 = x[1] - x[0] * v6;
    const double v8 = h[2] * v3;
    const double v9 = h[2] * v4;
    const double v10 = 1.0 / (v3 * v8 + v4 * v9 - v5 * v6);
    jac[13] = v10;
    const double v11 = v7 * v10;
    const double v12 = h[1] * (x[0] - v5 * v11);
    const double v13 = v2 * v12;
    const double v14 = h[0] * v13;
    const double v15 = h[2] * v13;
    const double v16 = v14 + h[2] * (v13 + v3 * v11) - (v14 + v15);
    const double v17 = v1 * v12;
    const double v18 = h[2] * v17;
    const double v19 = v18 - h[2] * (v17 + v4 * v11);
    const double v20 = v1 * v16 + v2 * v19;
    const double v21 = h[1] * v20;
    const double v22 = v6 * v10;
    const double v23 = v3 * v18 - v4 * v15 - v5 * v21;
    const double v24 = v21 - v22 * v23;
    jac[0] = v24;
    jac[11] = v24;
    const double v25 = ((v6 + v6) * (v7 * (v10 * v10)) - v10 * (x[0] * h[1])) * (v1 * v8 - v2 * v9);
    jac[5] = v25;
    jac[14] = v25;
    const double v26 = -v25;
    jac[1] = v26;
    jac[15] = v26;
    const double v27 = v1 * (v12 * v19) - v2 * (v12 * v16) - v20 * v21 + v25 * v23;
    jac[2] = v27 - h[3] * v1;
    const double v28 = -v27;
    jac[3] = v28;
    jac[6] = v28;
    const double v29 = -v24;
    jac[4] = v29;
    jac[10] = v29;
    jac[7] = -(h[4] * v4 - v27);
    jac[8] = h[1] + v6 * v22;
    const double v30 = -v22;
    jac[9] = v30;
    jac[12] = v30;
    dfdt[0] = 0.0;
    dfdt[1] = 0.0;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = cos(x[2]);
    const double v2 = 0.7 * sin(x[3]);
    const double v3 = sin(x[2]);
    const double v4 = 0.7 * cos(x[3]);
    const double v5 = v2 * (h[2] * v3) + v4 * (h[2] * v1);
    const double v6 = v5 * h[1];
    const double v7 = (x[1] - x[0] * v6) / (v2 * (h[2] * v2) + v4 * (h[2] * v4) - v5 * v6);
    const double v8 = h[1] * (x[0] - v5 * v7);
    const double v9 = v1 * v8;
    const double v10 = v3 * v8;
    const double v11 = v9 + v4 * v7;
    const double v12 = v10 + v2 * v7;
    out[0] = 0.5 * (v9 * (h[0] * v9) + v10 * (h[0] * v10)) + 0.5 * (v11 * (h[2] * v11) + v12 *
            (h[2] * v12));
    out[1] = -(h[5] * v10 + h[4] * v12);
    out[2] = 0.0;
}

/* What the scene observes. */
static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = 0.7 * sin(x[3]);
    const double v2 = 0.7 * cos(x[3]);
    const double v3 = v1 * (h[2] * sin(x[2])) + v2 * (h[2] * cos(x[2]));
    const double v4 = v3 * h[1];
    const double v5 = (x[1] - x[0] * v4) / (v1 * (h[2] * v1) + v2 * (h[2] * v2) - v3 * v4);
    y[3] = v5;
    y[2] = h[1] * (x[0] - v3 * v5);
    y[0] = x[2];
    y[1] = x[3];
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

/* Divisors of the right-hand sides that may vanish. */
static void model_divisors(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = 0.7 * sin(x[3]);
    const double v2 = 0.7 * cos(x[3]);
    const double v3 = v1 * (h[2] * sin(x[2])) + v2 * (h[2] * cos(x[2]));
    z[0] = v1 * (h[2] * v1) + v2 * (h[2] * v2) - v3 * (v3 * h[1]);
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
    x[2] = 2.0;
    x[3] = -1.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    scale[0] = 1.0;
    scale[1] = 1.0;
    scale[2] = 1.0;
    scale[3] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    check[0] = h[0];
    check[1] = h[2];
}

/* The arguments of functions that may hide pulses. */
static void model_watched(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = 0.7 * sin(x[3]);
    const double v2 = 0.7 * cos(x[3]);
    const double v3 = v1 * (h[2] * sin(x[2])) + v2 * (h[2] * cos(x[2]));
    z[0] = v1 * (h[2] * v1) + v2 * (h[2] * v2) - v3 * (v3 * h[1]);
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
    lu[2] = -jac[2];
    lu[3] = -jac[3];
    lu[4] = -jac[4] * lu[0];
    lu[5] = 1.0 / (c - jac[5] - lu[4] * lu[1]);
    g += (c + fabs(jac[5])) * fabs(lu[5]);
    lu[6] = -jac[6] - lu[4] * lu[2];
    lu[7] = -jac[7] - lu[4] * lu[3];
    lu[8] = -jac[8] * lu[0];
    lu[9] = (-jac[9] - lu[8] * lu[1]) * lu[5];
    lu[10] = 1.0 / (c - jac[10] - lu[8] * lu[2] - lu[9] * lu[6]);
    g += (c + fabs(jac[10])) * fabs(lu[10]);
    lu[11] = -jac[11] - lu[8] * lu[3] - lu[9] * lu[7];
    lu[12] = -jac[12] * lu[0];
    lu[13] = (-jac[13] - lu[12] * lu[1]) * lu[5];
    lu[14] = (-jac[14] - lu[12] * lu[2] - lu[13] * lu[6]) * lu[10];
    lu[15] = 1.0 / (c - jac[15] - lu[12] * lu[3] - lu[13] * lu[7] - lu[14] * lu[11]);
    g += (c + fabs(jac[15])) * fabs(lu[15]);
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
    b[1] = b[1] - lu[4] * b[0];
    b[2] = b[2] - lu[8] * b[0] - lu[9] * b[1];
    b[3] = b[3] - lu[12] * b[0] - lu[13] * b[1] - lu[14] * b[2];
    b[3] = b[3] * lu[15];
    b[2] = (b[2] - lu[11] * b[3]) * lu[10];
    b[1] = (b[1] - lu[7] * b[3] - lu[6] * b[2]) * lu[5];
    b[0] = (b[0] - lu[3] * b[3] - lu[2] * b[2] - lu[1] * b[1]) * lu[0];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"mass1", "kg", 1.0, -INFINITY, INFINITY},
    {"mass2", "kg", 0.6, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"first.p", "N*s"},
    /* 1 */ {"second.p", "N*s"},
    /* 2 */ {"a", "rad"},
    /* 3 */ {"b", "rad"},
};

static const int model_watch[] = {
    2,
};

static const int model_watch_state[] = {
    2, 3,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"a", "rad"},
    /* 1 */ {"b", "rad"},
    /* 2 */ {"a_rate", ""},
    /* 3 */ {"b_rate", ""},
};

static const char *const model_param_check[] = {
    "the inertia of `one[2]` must be positive",
    "the inertia of `other[2]` must be positive",
};

static const int model_jac_row[] = {
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3,
};

static const int model_jac_col[] = {
    0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3,
};

static const int model_pivot_row[] = {
    0, 1, 2, 3,
};

static const int model_pivot_col[] = {
    0, 1, 2, 3,
};

static const int model_lu_row[] = {
    0, 4, 8, 12, 16,
};

static const int model_lu_pivot[] = {
    0, 5, 10, 15,
};

static const int model_lu_col[] = {
    0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3,
};

static const int model_lu_jac[] = {
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,
};

static const char *const model_divisor[] = {
    "the common inertia of `one` and `other`",
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "double",
    .hash = "of its sources",
    .n_param = 2,
    .n_hoist = 6,
    .n_state = 4,
    .n_input = 0,
    .n_output = 4,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 16,
    .n_mass = 0,
    .n_lu = 16,
    .n_check = 2,
    .n_switch = 0,
    .n_timed = 0,
    .param = model_param,
    .state = model_state,
    .switch_info = NULL,
    .watch = model_watch,
    .n_watch = 1,
    .watch_state = model_watch_state,
    .n_watch_state = 2,
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
    .duration = 5.0,
    .every = 0.25,
    .divisor = model_divisor,
    .n_divisor = 1,
    .n_work = 0,
    .prepare = model_prepare,
    .rhs = model_rhs,
    .jacobian = model_jacobian,
    .energy = model_energy,
    .outputs = model_outputs,
    .commands = model_commands,
    .asserts = model_asserts,
    .divisors = model_divisors,
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
