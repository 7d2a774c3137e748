/* frame.h: what a hand-written model needs besides its equations. A model includes it after an
 * `enum { N, P, J }` (states, parameters, entries of the Jacobian) and the tables jac_row and
 * jac_col, and calls MODEL(...) at its end. The factorisation is elimination without pivoting, as
 * the compiler's is: it breaks where that breaks.
 */
#include "bgc.h"

#include <math.h>
#include <string.h>

#ifndef REPORTED
#define REPORTED(growth) growth
#endif

#ifndef MASS
#define MASS 0
static const int mass_row[1] = {0}, mass_col[1] = {0};
#endif

static int factor(const double *m, const double *jac, double c, double *lu, double *growth) {
    double before = 0.0, after = 0.0;

    memset(lu, 0, N * N * sizeof *lu);
    for (int i = 0; i < N && MASS == 0; i++) {
        lu[i * N + i] = c;
    }
    for (int k = 0; k < MASS; k++) {
        lu[mass_row[k] * N + mass_col[k]] += c * m[k];
    }
    for (int k = 0; k < J; k++) {
        lu[jac_row[k] * N + jac_col[k]] -= jac[k];
    }
    for (int k = 0; k < N * N; k++) {
        before = fmax(before, fabs(lu[k]));
    }
    for (int k = 0; k < N; k++) {
        if (lu[k * N + k] == 0.0) {
            return 1;
        }
        for (int i = k + 1; i < N; i++) {
            lu[i * N + k] /= lu[k * N + k];
            for (int j = k + 1; j < N; j++) {
                lu[i * N + j] -= lu[i * N + k] * lu[k * N + j];
            }
        }
    }
    for (int k = 0; k < N * N; k++) {
        after = fmax(after, fabs(lu[k]));
    }
    *growth = REPORTED(after / before);
    return 0;
}

static void solve(const double *lu, double *b, double *w) {
    (void)w;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < i; j++) {
            b[i] -= lu[i * N + j] * b[j];
        }
    }
    for (int i = N - 1; i >= 0; i--) {
        for (int j = i + 1; j < N; j++) {
            b[i] -= lu[i * N + j] * b[j];
        }
        b[i] /= lu[i * N + i];
    }
}

/* The tables of full factors in the models' own order. */
static int own_order[N + 1], lu_row[N + 1], lu_pivot[N + 1], lu_col[N * N + 1], lu_jac[J + 1],
    lu_mass[MASS + 1];

static inline void fill_tables(void) {
    for (int i = 0; i < N; i++) {
        own_order[i] = i;
        lu_row[i] = N * i;
        lu_pivot[i] = N * i + i;
        for (int j = 0; j < N; j++) {
            lu_col[N * i + j] = j;
        }
    }
    lu_row[N] = N * N;
    for (int e = 0; e < J; e++) {
        lu_jac[e] = N * jac_row[e] + jac_col[e];
    }
    for (int e = 0; e < MASS; e++) {
        lu_mass[e] = N * mass_row[e] + mass_col[e];
    }
}

static void prepare(const double *p, double *h, double *w) {
    (void)w;
    memcpy(h, p, P * sizeof *h);
}

static void unit_scale(const double *h, double *scale, double *w) {
    (void)h;
    (void)w;
    for (int i = 0; i < N; i++) {
        scale[i] = 1.0;
    }
}

/* Outputs are the states unless a model says otherwise. */
static inline void states(const double *h, double t, const double *x, const double *u, double *y,
                          double *w) {
    (void)h;
    (void)t;
    (void)u;
    (void)w;
    memcpy(y, x, N * sizeof *y);
}

#define SIGNATURE const double *h, double t, const double *x, const double *u
#define UNUSED (void)h, (void)t, (void)x, (void)u, (void)w

#define MODEL(...)                                                                              \
    const bgc_model *bgc_get_model(void) {                                                     \
        static bgc_var_info info[N + 1];                                                       \
        static const bgc_model model = {.abi = BGC_ABI,                                        \
                                        .name = "test",                                        \
                                        .hash = "0",                                           \
                                        .n_param = P,                                          \
                                        .n_hoist = P,                                          \
                                        .n_state = N,                                          \
                                        .n_output = N,                                         \
                                        .n_jac = J,                                            \
                                        .n_mass = MASS,                                        \
                                        .n_lu = N * N,                                         \
                                        .param = param,                                        \
                                        .state = info,                                         \
                                        .output = info,                                        \
                                        .jac_row = jac_row,                                    \
                                        .jac_col = jac_col,                                    \
                                        .mass_row = mass_row,                                  \
                                        .mass_col = mass_col,                                  \
                                        .pivot_row = own_order,                                \
                                        .pivot_col = own_order,                                \
                                        .lu_row = lu_row,                                      \
                                        .lu_pivot = lu_pivot,                                  \
                                        .lu_col = lu_col,                                      \
                                        .lu_jac = lu_jac,                                      \
                                        .lu_mass = lu_mass,                                    \
                                        .prepare = prepare,                                    \
                                        .initial = initial,                                    \
                                        .scale = unit_scale,                                   \
                                        .rhs = rhs,                                            \
                                        .jacobian = jacobian,                                  \
                                        .factor = factor,                                      \
                                        .solve = solve,                                        \
                                        .outputs = states,                                     \
                                        __VA_ARGS__};                                          \
        fill_tables();                                                                         \
        return &model;                                                                         \
    }
