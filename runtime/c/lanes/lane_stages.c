/* lane_stages.c: one step of a Rosenbrock or explicit method for a batch, and its linear systems, as in
 * rosenbrock.c, explicit.c and linear.c. Solutions are checked as often as there. A lane whose solution
 * is not acceptable leaves the batch: refinement and pivoting are left to bgc_run.
 */
#include "lanes/batch.h"
#include "solutions.h"

#include <string.h>

/* --- linear systems ------------------------------------------------------------------------ */

/* Factorises W = c M - J, and decides how solutions are checked. */
static void factorise(bgc_batch *b, double c) {
    lane growth;

    b->kernel->factor(b->mass, b->jac, lane_of(c), b->lu, &growth);
    b->counts.factorisations++;
    b->c = c;
    b->active &= bgc_lanes_where(b, growth < lane_of(INFINITY));
    if (bgc_lanes_where(b, growth > lane_of(bgc_growth_limit)) != 0) {
        b->watched = BGC_WATCH_FOR;
    }
    b->checked = b->watched > 0 || b->counts.factorisations % BGC_CHECK_EVERY == 1;
    b->watched -= b->watched > 0;
}

/* Adds the product of an entry of W and x[col] to a row of W x, and its size to b->magnitude. */
static void add_term(bgc_batch *b, int row, int col, lane entry, const lane *x) {
    b->residual[row] += entry * x[col];
    b->magnitude[row] += lane_fabs(entry) * b->reach[col];
}

/* b->reach = the sizes of x that count in its check, as in linear.c. */
static void measure_reach(bgc_batch *b, const lane *x) {
    lane largest = lane_of(0.0);

    for (int i = 0; i < b->m->n_state; i++) {
        largest = lane_max(lane_fabs(x[i]) / b->scale[i], largest);
    }
    for (int i = 0; i < bgc_unknowns(b->m); i++) {
        b->reach[i] = lane_fabs(x[i]) + bgc_least_part * largest * b->scale[i];
    }
}

/* The componentwise backward error of the solution x of W x = right, as in linear.c. */
static lane backward_error(bgc_batch *b, const lane *right, const lane *x) {
    const bgc_model *m = b->m;
    const bgc_entries j = bgc_local_entries(m);
    const int n = bgc_unknowns(m), alone = m->n_mass == 0 ? m->n_state : 0;
    lane worst = lane_of(0.0);

    measure_reach(b, x);
    for (int i = 0; i < n; i++) {
        b->residual[i] = i < alone ? b->c * x[i] : lane_of(0.0);
        b->magnitude[i] = i < alone ? lane_fabs(lane_of(b->c)) * b->reach[i] : lane_of(0.0);
    }
    for (int k = 0; k < m->n_mass; k++) {
        add_term(b, m->mass_row[k], m->mass_col[k], b->c * b->mass[k], x);
    }
    for (int k = 0; k < j.count; k++) {
        add_term(b, j.row[k], j.col[k], -b->jac[k], x);
    }
    for (int i = 0; i < n; i++) {
        const lane given = i < m->n_state ? right[i] : lane_of(0.0);
        const lane size = b->magnitude[i] + lane_fabs(given);
        const lane error = lane_fabs(given - b->residual[i]) / size;
        worst = lane_max(lane_select(size == lane_of(0.0), lane_of(0.0), error), worst);
    }
    return worst;
}

/* v := W^-1 v. Lanes whose right-hand side is not finite are not checked. */
void bgc_batch_solve(bgc_batch *b, lane *v) {
    const int n = b->m->n_state;
    unsigned finite;
    lane error;

    b->counts.solves++;
    if (!b->checked) {
        b->kernel->solve(b->lu, v, b->work);
        return;
    }
    finite = b->active & ~bgc_batch_bad(b, n, v);
    memcpy(b->b, v, (size_t)n * sizeof *v);
    b->kernel->solve(b->lu, v, b->work);
    memcpy(b->wide, v, (size_t)n * sizeof *v);
    memcpy(b->wide + n, b->work, (size_t)b->m->n_inner * sizeof *v);
    error = backward_error(b, b->b, b->wide);
    b->active &= ~(finite & ~bgc_lanes_where(b, error <= lane_of(bgc_acceptable)));
    b->checked = b->watched > 0;
}

/* --- methods ------------------------------------------------------------------------------- */

/* right += M (sum of c_ij U_j) / h. */
static void add_earlier_stages(bgc_batch *b, const double *c, int stage, double h, lane *right) {
    const bgc_model *m = b->m;
    double weight[BGC_MAX_STAGES];

    for (int j = 0; j < stage; j++) {
        weight[j] = c[j] / h;
    }
    if (m->n_mass == 0) {
        bgc_batch_combine(m->n_state, stage, weight, b->stages, right);
        return;
    }
    memset(b->point, 0, (size_t)m->n_state * sizeof *b->point);
    bgc_batch_combine(m->n_state, stage, weight, b->stages, b->point);
    bgc_batch_multiply_mass(b, b->point, right);
}

/* out = f at the point of a stage. */
static void evaluate_stage(bgc_batch *b, int stage, double h, lane *out) {
    const bgc_tableau *tableau = b->method->tableau;
    const size_t size = (size_t)b->m->n_state * sizeof *out;

    if (stage == 0) {
        memcpy(out, b->f, size);
        return;
    }
    memcpy(b->point, b->x, size);
    bgc_batch_combine(b->m->n_state, stage, tableau->a[stage], b->stages, b->point);
    b->kernel->rhs(b->h, lane_of(b->t + tableau->alpha[stage] * h), b->point, b->u, out, b->work);
    b->counts.rhs++;
    if (stage == tableau->stages - 1 && bgc_ends_at_last_stage(b->m, tableau)) {
        memcpy(b->f_last, out, size);
        b->f_last_at = b->t + h;
    }
}

/* The stage of a Rosenbrock method from f at its point, in place. */
static void rosenbrock_stage(bgc_batch *b, int stage, double h, lane *out) {
    const bgc_tableau *tableau = b->method->tableau;
    const double slope = tableau->g[stage] * h;

    add_earlier_stages(b, tableau->c[stage], stage, h, out);
    for (int i = 0; slope != 0.0 && i < b->m->n_state; i++) {
        out[i] += slope * b->dfdt[i];
    }
    bgc_batch_solve(b, out);
}

/* The Jacobian and the factors of W at the present, for steps of length h. */
void bgc_batch_factorise(bgc_batch *b, double h) {
    b->kernel->jacobian(b->h, lane_of(b->t), b->x, b->u, b->jac, b->dfdt, b->work);
    b->counts.jacobians++;
    factorise(b, 1.0 / (h * b->method->tableau->gamma));
}

/* One step of length h from b->x at b->t, with f there in b->f, to b->next; the error estimate, where
 * the method has one, to b->error. */
void bgc_batch_advance(bgc_batch *b, double h) {
    const bgc_tableau *tableau = b->method->tableau;
    const int n = b->m->n_state;
    const size_t size = (size_t)n * sizeof(lane);

    b->f_last_at = (double)INFINITY;
    if (b->method->family->jacobian && b->held == 0) {
        bgc_batch_factorise(b, h);
    }

    /* Stages. */
    for (int s = 0; s < tableau->stages; s++) {
        lane *stage = b->stages + (size_t)s * (size_t)n;
        evaluate_stage(b, s, h, stage);
        if (b->method->family->jacobian) {
            rosenbrock_stage(b, s, h, stage);
            continue;
        }
        for (int i = 0; i < n; i++) {
            stage[i] *= h * b->inverse_mass[i];
        }
    }

    /* Solution and error estimate. */
    memcpy(b->next, b->x, size);
    bgc_batch_combine(n, tableau->stages, tableau->m, b->stages, b->next);
    if (bgc_is_adaptive(b->method)) {
        memset(b->error, 0, size);
        bgc_batch_combine(n, tableau->stages, tableau->e, b->stages, b->error);
    }
}
