/* blocks.c: replaces blocks.c in a model whose matrix has no blocks of rows. */
#include "bgc_internal.h"

int bgc_block_factor(const bgc_model *m, const double *scale, const double *mass,
                     const double *jac, double c, double *lu, double *growth, double *scratch) {
    (void)m, (void)scale, (void)mass, (void)jac, (void)c, (void)lu, (void)growth, (void)scratch;
    return 1;
}

void bgc_block_solve(const bgc_model *m, const double *lu, double *b, double *scratch) {
    (void)m, (void)lu, (void)b, (void)scratch;
}

int bgc_block_factor_complex(const bgc_model *m, const double *scale, const double *mass,
                             const double *jac, bgc_complex c, bgc_complex *factors,
                             double *growth, double *scratch) {
    (void)m, (void)scale, (void)mass, (void)jac, (void)c, (void)factors, (void)growth, (void)scratch;
    return 1;
}

void bgc_block_solve_complex(const bgc_model *m, const bgc_complex *factors, bgc_complex *b,
                             double *scratch) {
    (void)m, (void)factors, (void)b, (void)scratch;
}
