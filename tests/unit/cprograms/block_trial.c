#include "bgc_internal.h"
#include <string.h>

static bgc_model model_of(const bgc_block_info *info, int n_state, int n_mass) {
    bgc_model m;
    memset(&m, 0, sizeof m);
    m.n_state = n_state;
    m.n_mass = n_mass;
    m.blocks = info;
    return m;
}

/* b := (c M - J)^-1 b by real factors; returns the status of the factorisation. */
int trial(const bgc_block_info *info, int n_state, int n_mass, const double *scale,
          const double *mass, const double *jac, double c, double *lu, double *growth, double *work,
          double *b) {
    const bgc_model m = model_of(info, n_state, n_mass);
    const int status = bgc_block_factor(&m, scale, mass, jac, c, lu, growth, work);
    if (status == 0) {
        bgc_block_solve(&m, lu, b, work);
    }
    return status;
}

/* The same for a complex c, and b of complex numbers. */
int complex_trial(const bgc_block_info *info, int n_state, int n_mass, const double *scale,
                  const double *mass, const double *jac, double re, double im, double *lu,
                  double *growth, double *work, double *b) {
    const bgc_model m = model_of(info, n_state, n_mass);
    bgc_complex *factors = (bgc_complex *)(void *)lu;
    const bgc_complex c = {re, im};
    const int status = bgc_block_factor_complex(&m, scale, mass, jac, c, factors, growth, work);
    if (status == 0) {
        bgc_block_solve_complex(&m, factors, (bgc_complex *)(void *)b, work);
    }
    return status;
}
