/* A row of tanks, each drained into the next at a rate of 1/s, the first one filled: 50,000 states, whose
 * matrix has two entries a row. The content of tank k is exp(-t) t^k / k!. */
#include "bgc.h"

#include <math.h>
#include <string.h>

enum { N = 50000, J = 2 * N - 1, SHOWN = 4 };
static int jac_row[J], jac_col[J];
static bgc_var_info info[N];

#define SIGNATURE const double *h, double t, const double *x, const double *u
#define UNUSED (void)h, (void)t, (void)x, (void)u, (void)w

static void prepare(const double *p, double *h, double *w) { (void)p, (void)h, (void)w; }

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    memset(x, 0, N * sizeof *x);
    x[0] = 1.0;
}

static void scale(const double *h, double *size, double *w) {
    (void)h, (void)w;
    for (int i = 0; i < N; i++) {
        size[i] = 1.0;
    }
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    for (int i = 0; i < N; i++) {
        f[i] = (i > 0 ? x[i - 1] : 0.0) - x[i];
    }
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    memset(dfdt, 0, N * sizeof *dfdt);
    for (int i = 0; i < N; i++) {
        jac[i] = -1.0;
    }
    for (int i = N; i < J; i++) {
        jac[i] = 1.0;
    }
}

static int factor(const double *m, const double *jac, double c, double *lu, double *growth) {
    (void)m;
    for (int i = 0; i < N; i++) {
        lu[i] = c - jac[i];
    }
    *growth = 1.0;
    return 0;
}

static void solve(const double *lu, double *b, double *w) {
    (void)w;
    b[0] /= lu[0];
    for (int i = 1; i < N; i++) {
        b[i] = (b[i] + b[i - 1]) / lu[i];
    }
}

static void outputs(SIGNATURE, double *y, double *w) {
    UNUSED;
    memcpy(y, x, SHOWN * sizeof *y);
}

const bgc_model *bgc_get_model(void) {
    static const bgc_model model = {
        .abi = BGC_ABI, .name = "wide", .hash = "0",
        .n_state = N, .n_output = SHOWN, .n_jac = J, .n_lu = N,
        .state = info, .output = info, .jac_row = jac_row, .jac_col = jac_col,
        .prepare = prepare, .initial = initial, .scale = scale, .rhs = rhs, .jacobian = jacobian,
        .factor = factor, .solve = solve, .outputs = outputs,
    };

    for (int k = 0; k < J; k++) {
        jac_row[k] = k < N ? k : k - N + 1;
        jac_col[k] = k < N ? k : k - N;
    }
    return &model;
}
