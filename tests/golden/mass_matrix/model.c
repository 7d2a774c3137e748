/* ivp: a bond graph of model TransistorAmplifier, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * States x:
 *     0 y[1]
 *     1 y[2]
 *     2 y[3]
 *     3 y[4]
 *     4 y[5]
 *     5 y[6]
 *     6 y[7]
 *     7 y[8]
 *
 * Outputs y:
 *     0 y[1]
 *     1 y[2]
 *     2 y[3]
 *     3 y[4]
 *     4 y[5]
 *     5 y[6]
 *     6 y[7]
 *     7 y[8]
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
    const double v1 = (x[0] - 0.1 * sin(628.3185307179587 * t)) * 0.001;
    f[1] = v1;
    const double v2 = 1e-06 * (exp((x[1] - x[2]) * 38.46153846153846) - 1.0);
    f[0] = v1 + ((x[1] * 2.0 - 6.0) * 0.00011111111111111112 + v2 * 0.01);
    f[2] = x[2] * 0.00011111111111111112 - v2;
    const double v3 = 0.00011111111111111112 * (x[3] - 6.0) + 0.99 * v2;
    f[4] = v3;
    const double v4 = 1e-06 * (exp(38.46153846153846 * (x[4] - x[5])) - 1.0);
    f[3] = v3 + (0.00011111111111111112 * (x[4] * 2.0 - 6.0) + v4 * 0.01);
    f[5] = x[5] * 0.00011111111111111112 - v4;
    const double v5 = 0.00011111111111111112 * (x[6] - 6.0) + 0.99 * v4;
    f[7] = v5;
    f[6] = v5 + x[7] * 0.00011111111111111112;
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)h, (void)u, (void)w;
    const double v1 = 1e-06 * (38.46153846153846 * exp((x[1] - x[2]) * 38.46153846153846));
    const double v2 = 0.01 * v1;
    jac[1] = 0.00022222222222222223 + v2;
    jac[2] = -v2;
    jac[4] = -v1;
    jac[5] = 0.00011111111111111112 + v1;
    const double v3 = 0.99 * v1;
    jac[6] = v3;
    jac[11] = v3;
    const double v4 = -v3;
    jac[7] = v4;
    jac[12] = v4;
    const double v5 = 1e-06 * (38.46153846153846 * exp(38.46153846153846 * (x[4] - x[5])));
    const double v6 = 0.01 * v5;
    jac[9] = 0.00022222222222222223 + v6;
    jac[10] = -v6;
    jac[14] = -v5;
    jac[15] = 0.00011111111111111112 + v5;
    const double v7 = 0.99 * v5;
    jac[16] = v7;
    jac[20] = v7;
    const double v8 = -v7;
    jac[17] = v8;
    jac[21] = v8;
    const double v9 = -(0.001 * (0.1 * (628.3185307179587 * cos(628.3185307179587 * t))));
    dfdt[0] = v9;
    dfdt[1] = v9;
    dfdt[2] = 0.0;
    dfdt[3] = 0.0;
    dfdt[4] = 0.0;
    dfdt[5] = 0.0;
    dfdt[6] = 0.0;
    dfdt[7] = 0.0;
    jac[0] = 0.001;
    jac[3] = 0.001;
    jac[8] = 0.00011111111111111112;
    jac[13] = 0.00011111111111111112;
    jac[18] = 0.00011111111111111112;
    jac[19] = 0.00011111111111111112;
    jac[22] = 0.00011111111111111112;
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
    for (int k = 0; k < 8; k++) y[k] = x[k];
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
    m[0] = -1e-06;
    m[1] = 1e-06;
    m[2] = -2e-06;
    m[3] = -3e-06;
    m[4] = 3e-06;
    m[5] = -4e-06;
    m[6] = -5e-06;
    m[7] = 5e-06;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    x[0] = 0.0;
    x[1] = 3.0;
    x[2] = 3.0;
    x[3] = 6.0;
    x[4] = 3.0;
    x[5] = 3.0;
    x[6] = 6.0;
    x[7] = 0.0;
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)h, (void)w;
    for (int k = 0; k < 8; k++) scale[k] = 1.0;
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
    z[0] = (x[1] - x[2]) * 38.46153846153846;
    z[1] = 38.46153846153846 * (x[4] - x[5]);
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
    const bgc_range v1 = bgc_range_product(bgc_range_of(628.3185307179587), t);
    b[0] = bgc_range_sin(v1);
    b[1] = bgc_range_product(bgc_range_of(628.3185307179587), bgc_range_cos(v1));
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict m, const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[-16] = 1.0 / (c * m[2] - jac[-11]);
    g += (fabs(c * m[2]) + fabs(jac[-11])) * fabs(lu[-16]);
    lu[-15] = -jac[-12];
    lu[-14] = -jac[-14] * lu[-16];
    lu[-13] = 1.0 / -jac[-16];
    g += fabs(jac[-16]) * fabs(lu[-13]);
    lu[-12] = -jac[-15] - lu[-14] * lu[-15];
    lu[-11] = (c * m[0] - jac[-13]) * lu[-13];
    lu[-10] = 1.0 / (c * m[1] - lu[-11] * lu[-12]);
    g += fabs(c * m[1]) * fabs(lu[-10]);
    lu[-9] = 1.0 / (c * m[5] - jac[-1]);
    g += (fabs(c * m[5]) + fabs(jac[-1])) * fabs(lu[-9]);
    lu[-8] = -jac[-2];
    lu[-7] = -jac[-9] * lu[-16];
    lu[-6] = (-jac[-10] - lu[-7] * lu[-15]) * lu[-10];
    lu[-5] = -jac[-6] * lu[-9];
    lu[-4] = 1.0 / -jac[-8];
    g += fabs(jac[-8]) * fabs(lu[-4]);
    lu[-3] = -jac[-7] - lu[-5] * lu[-8];
    lu[-2] = -jac[-4] * lu[-16];
    lu[-1] = (-jac[-5] - lu[-2] * lu[-15]) * lu[-10];
    lu[0] = (c * m[3] - jac[-3]) * lu[-4];
    lu[1] = 1.0 / (c * m[4] - lu[0] * lu[-3]);
    g += fabs(c * m[4]) * fabs(lu[1]);
    lu[2] = -jac[1] * lu[-9];
    lu[3] = (-jac[0] - lu[2] * lu[-8]) * lu[1];
    lu[4] = 1.0 / -jac[2];
    g += fabs(jac[2]) * fabs(lu[4]);
    lu[5] = -jac[3];
    lu[6] = -jac[5] * lu[-9];
    lu[7] = (-jac[4] - lu[6] * lu[-8]) * lu[1];
    lu[8] = (c * m[6] - jac[6]) * lu[4];
    lu[9] = 1.0 / (c * m[7] - lu[8] * lu[5]);
    g += fabs(c * m[7]) * fabs(lu[9]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    double g = 0.0;
    g += model_factor_1(m, jac + 16, c, lu + 16);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[0] = b[0] - lu[-14] * b[2];
    b[1] = b[1] - lu[-11] * b[0];
    b[3] = b[3] - lu[-7] * b[2] - lu[-6] * b[1] - lu[-5] * b[5];
    b[4] = b[4] - lu[-2] * b[2] - lu[-1] * b[1] - lu[0] * b[3];
    b[6] = b[6] - lu[2] * b[5] - lu[3] * b[4];
    b[7] = b[7] - lu[6] * b[5] - lu[7] * b[4] - lu[8] * b[6];
    b[7] = b[7] * lu[9];
    b[6] = (b[6] - lu[5] * b[7]) * lu[4];
    b[4] = b[4] * lu[1];
    b[3] = (b[3] - lu[-3] * b[4]) * lu[-4];
    b[5] = (b[5] - lu[-8] * b[4]) * lu[-9];
    b[1] = b[1] * lu[-10];
    b[0] = (b[0] - lu[-12] * b[1]) * lu[-13];
    b[2] = (b[2] - lu[-15] * b[1]) * lu[-16];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu + 16, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_var_info model_state[] = {
    /* 0 */ {"y[1]", ""},
    /* 1 */ {"y[2]", ""},
    /* 2 */ {"y[3]", ""},
    /* 3 */ {"y[4]", ""},
    /* 4 */ {"y[5]", ""},
    /* 5 */ {"y[6]", ""},
    /* 6 */ {"y[7]", ""},
    /* 7 */ {"y[8]", ""},
};

static const int model_watch[] = {
    0, 0,
};

static const int model_watch_state[] = {
    1, 2, 4, 5,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"y[1]", ""},
    /* 1 */ {"y[2]", ""},
    /* 2 */ {"y[3]", ""},
    /* 3 */ {"y[4]", ""},
    /* 4 */ {"y[5]", ""},
    /* 5 */ {"y[6]", ""},
    /* 6 */ {"y[7]", ""},
    /* 7 */ {"y[8]", ""},
};

static const int model_jac_row[] = {
    0, 0, 0, 1, 2, 2, 3, 3, 3, 3, 3, 4, 4, 4, 5, 5,
    6, 6, 6, 6, 7, 7, 7,
};

static const int model_jac_col[] = {
    0, 1, 2, 0, 1, 2, 1, 2, 3, 4, 5, 1, 2, 3, 4, 5,
    4, 5, 6, 7, 4, 5, 6,
};

static const int model_mass_row[] = {
    1, 1, 2, 4, 4, 5, 7, 7,
};

static const int model_mass_col[] = {
    0, 1, 2, 3, 4, 5, 6, 7,
};

static const int model_pivot_row[] = {
    2, 0, 1, 5, 3, 4, 6, 7,
};

static const int model_pivot_col[] = {
    2, 0, 1, 5, 3, 4, 6, 7,
};

static const int model_lu_row[] = {
    0, 2, 5, 7, 9, 14, 18, 22, 26,
};

static const int model_lu_pivot[] = {
    0, 3, 6, 7, 12, 17, 20, 25,
};

static const int model_lu_col[] = {
    0, 2, 0, 1, 2, 1, 2, 3, 5, 0, 2, 3, 4, 5, 0, 2,
    4, 5, 3, 5, 6, 7, 3, 5, 6, 7,
};

static const int model_lu_jac[] = {
    3, 4, 2, 5, 1, 0, 10, 9, 12, 13, 11, 15, 14, 16, 8, 7,
    19, 18, 20, 21, 23, 22, 24,
};

static const int model_lu_mass[] = {
    5, 6, 0, 16, 17, 7, 24, 25,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "ivp",
    .hash = "of its sources",
    .n_param = 0,
    .n_hoist = 0,
    .n_state = 8,
    .n_input = 0,
    .n_output = 8,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 23,
    .n_mass = 8,
    .n_lu = 26,
    .n_check = 0,
    .n_given_assert = 0,
    .n_switch = 0,
    .n_timed = 0,
    .param = NULL,
    .state = model_state,
    .switch_info = NULL,
    .watch = model_watch,
    .n_watch = 2,
    .watch_state = model_watch_state,
    .n_watch_state = 4,
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
    .duration = 0.2,
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
