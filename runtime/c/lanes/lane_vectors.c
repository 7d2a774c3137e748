/* lane_vectors.c: sums, norms and checks of vectors of a batch, f and the assertions, as in vectors.c,
 * evaluate.c and linear.c. */
#include "lanes/batch.h"
#include "tolerance.h"

#include <string.h>

/* out += sum of weight[j] times vector j; the vectors are n apart. Zero weights are skipped. */
void bgc_batch_combine(int n, int count, const double *weight, const lane *vectors, lane *out) {
    double w[BGC_MAX_STAGES];
    const lane *v[BGC_MAX_STAGES];
    int filled = 0;

    for (int j = 0; j < count; j++) {
        if (weight[j] != 0.0) {
            w[filled] = weight[j];
            v[filled++] = vectors + (size_t)j * (size_t)n;
        }
    }
    for (int i = 0; i < n; i++) {
        lane sum = out[i];
        for (int j = 0; j < filled; j++) {
            sum += w[j] * v[j][i];
        }
        out[i] = sum;
    }
}

/* out += M v. */
void bgc_batch_multiply_mass(const bgc_batch *b, const lane *v, lane *out) {
    const bgc_model *m = b->m;

    for (int k = 0; k < m->n_mass; k++) {
        out[m->mass_row[k]] += b->mass[k] * v[m->mass_col[k]];
    }
}

/* The active lanes with an entry that is not finite. */
unsigned bgc_batch_bad(const bgc_batch *b, int n, const lane *v) {
    lane sum = lane_of(0.0);

    for (int i = 0; i < n; i++) {
        sum += v[i] - v[i];
    }
    return bgc_lanes_where(b, sum != lane_of(0.0));
}

/* The largest number in a set of lanes. */
double bgc_batch_largest(unsigned lanes, lane v) {
    double found = -INFINITY;

    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        if ((lanes >> l & 1u) != 0) {
            found = fmax(found, lane_get(v, l));
        }
    }
    return found;
}

/* Of each lane: root mean square of v over tolerances at a state between p and q. */
lane bgc_batch_norm_within(const bgc_batch *b, const lane *v, const lane *p, const lane *q,
                           double rtol, double atol, lane reached) {
    lane sum = lane_of(0.0);

    for (int i = 0; i < b->m->n_state; i++) {
        const lane size = lane_max(lane_fabs(p[i]), lane_fabs(q[i]));
        const lane r = v[i] / bgc_step_tolerance(size, b->scale[i], reached, rtol, atol);
        sum += r * r;
    }
    return lane_sqrt(sum / (double)b->m->n_state);
}

/* The same over the tolerances of steps with error control. */
lane bgc_batch_norm(const bgc_batch *b, const lane *v, const lane *p, const lane *q) {
    return bgc_batch_norm_within(b, v, p, q, b->option->rtol, b->option->atol, b->scale_reached);
}

/* b->f at the present, unless it is valid. */
void bgc_batch_evaluate_f(bgc_batch *b) {
    if (b->f_valid) {
        return;
    }
    b->f_valid = 1;
    if (b->f_last_at == b->t) {
        memcpy(b->f, b->f_last, (size_t)b->m->n_state * sizeof *b->f);
        return;
    }
    b->kernel->rhs(b->h, lane_of(b->t), b->x, b->u, b->f, b->work);
    b->counts.rhs++;
}

/* After a change of the state or of inputs at the present. */
void bgc_batch_forget_f(bgc_batch *b) {
    b->f_valid = 0;
    b->f_last_at = (double)INFINITY;
}

/* Lanes in which an assertion fails at (t, x) leave the batch. */
void bgc_batch_check(bgc_batch *b, double t, const lane *x) {
    if (b->m->n_assert == 0) {
        return;
    }
    b->kernel->asserts(b->h, lane_of(t), x, b->u, b->check, b->work);
    for (int k = 0; k < b->m->n_assert; k++) {
        b->active &= ~bgc_lanes_where(b, lane_not(lane_is(b->check[k])));
    }
}
