/* tangent_steps.c: the stages of a step, differentiated, in the variables of methods.h:
 *
 *   W U_i' = f_x (y + sum a_ij U_j)' + f_p + g_i h (df/dt)' + J' U_i
 *            + M sum c_ij U_j' / h + M' (sum c_ij U_j / h - U_i / (h gamma)),
 *
 * where ' is the derivative along the run by a parameter: W' U_i has gone to the right-hand side. */
#include "tangents/sensitivities.h"

#include <string.h>

/* A step, its method and what is at hand. */
typedef struct {
    const bgc_tableau *tableau;
    double t, h;
    int implicit;
} step;

static const double *stage_of(const bgc_model *m, const bgc_data *d, int i) {
    return d->stages + (size_t)i * bgc_chunked(m->n_state);
}

/* out = base + sum of weight_j v_j. */
static void combine(int n, int count, const double *weight, const lane *vectors, const lane *base,
                    lane *out) {
    const lane *from[BGC_MAX_STAGES];
    lane part[BGC_MAX_STAGES];
    int used = 0;

    for (int j = 0; j < count; j++) {
        if (weight[j] != 0.0) {
            from[used] = vectors + (size_t)j * (size_t)n;
            part[used++] = lane_of(weight[j]);
        }
    }
    for (int i = 0; i < n; i++) {
        lane sum = base[i];
        for (int j = 0; j < used; j++) {
            sum += part[j] * from[j][i];
        }
        out[i] = sum;
    }
}

/* The point of stage i to d->point, as the step has found it. At those of an explicit method the algebraic
 * equations are solved from the values at the stage before, which is there. */
static bgc_status find_point(const bgc_model *m, bgc_data *d, const bgc_sensitivities *s, const step *of,
                             int i) {
    const int n = m->n_state;
    const lane *before = s->points + (size_t)(i - 1) * (size_t)n;

    bgc_combine(n, i, of->tableau->a[i], d->stages, d->x, d->point);
    if (of->implicit || d->core.algebraic == 0 || i == 0) {
        return BGC_OK;
    }
    for (int k = 0; k < d->n_block; k++) {
        d->point[d->block[k]] = lane_get(before[d->block[k]], 0);
    }
    return bgc_satisfy(m, d, of->t + of->tableau->alpha[i] * of->h, d->point);
}

/* The points of the stages, and the inputs of the step, to all lanes. */
static bgc_status spread_step(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, const step *of) {
    const int n = m->n_state;
    bgc_status status = BGC_OK;

    bgc_spread(m->n_input + m->n_switch, d->u_step, s->u);
    for (int i = 0; i < of->tableau->stages && status == BGC_OK; i++) {
        status = find_point(m, d, s, of, i);
        bgc_spread(n, d->point, s->points + (size_t)i * (size_t)n);
    }
    return status;
}

/* s->right := W^-1 s->right. Solutions that are to be checked are made one by one. */
static bgc_status solve(const bgc_model *m, bgc_data *d, bgc_sensitivities *s) {
    bgc_status status = BGC_OK;

    if (s->kernel->solve != NULL &&
        (d->core.pivoting == BGC_STATIC || d->core.pivoting == BGC_CHECKED_ONCE)) {
        s->kernel->solve(d->lu, s->right, s->solve_work);
        return BGC_OK;
    }
    for (int l = 0; l < BGC_LANE_WIDTH && status == BGC_OK; l++) {
        for (int i = 0; i < m->n_state; i++) {
            s->column[i] = lane_get(s->right[i], l);
        }
        status = bgc_solve(m, d, s->column);
        for (int i = 0; i < m->n_state; i++) {
            lane_set(&s->right[i], l, s->column[i]);
        }
    }
    return status;
}

/* --- the parts of a right-hand side ---------------------------------------------------------------- */

/* The products of the change of the Jacobian, which the step has evaluated or holds, with its stages. */
static void multiply_by_change(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s, const step *of) {
    double slope[BGC_MAX_STAGES];

    if (s->jacobians != d->core.counts.jacobians) {
        s->jacobians = d->core.counts.jacobians;
        bgc_note_jacobian(m, s, of->t, of->tableau->stages);
    }
    for (int i = 0; i < of->tableau->stages; i++) {
        slope[i] = of->tableau->g[i] * of->h;
    }
    bgc_multiply_change_of_jacobian(m, d, s, of->tableau->stages, slope);
}

/* s->right += M sum c_ij U_j' / h + M' (sum c_ij U_j / h - U_i / (h gamma)). */
static void add_earlier(const bgc_model *m, bgc_data *d, bgc_sensitivities *s, bgc_sensitivity_block *b,
                        const step *of, int i) {
    const int n = m->n_state;
    double weight[BGC_MAX_STAGES];
    lane *sum = s->along;

    for (int j = 0; j < i; j++) {
        weight[j] = of->tableau->c[i][j] / of->h;
    }
    combine(n, i, weight, s->stages, s->no_change, sum);
    if (m->n_mass == 0) {
        for (int k = 0; k < n; k++) {
            s->right[k] += sum[k];
        }
        return;
    }
    weight[i] = -1.0 / (of->h * of->tableau->gamma);
    bgc_combine(n, i + 1, weight, d->stages, NULL, d->point);
    for (int k = 0; k < m->n_mass; k++) {
        s->right[m->mass_row[k]] += d->mass[k] * sum[m->mass_col[k]] + b->mass[k] * d->point[m->mass_col[k]];
    }
}

/* --- one step ------------------------------------------------------------------------------------ */

/* The derivatives of the states at the point of stage i of an explicit method, to s->change, in which those
 * combined from the stages are. */
static bgc_status satisfy_stage(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                bgc_sensitivity_block *b, const step *of, int i) {
    const size_t n = (size_t)m->n_state;
    const lane *point = s->points + (size_t)i * n;
    const bgc_moment at = {of->t + of->tableau->alpha[i] * of->h, s->rate, d->u_step};
    bgc_status status;

    for (size_t k = 0; k < n; k++) {
        s->rate[k] = lane_get(point[k], 0);
    }
    memcpy(s->along, s->change, n * sizeof *s->along);
    status = bgc_satisfy_sensitivity(m, d, s, b, &at, NULL, lane_of(0.0), s->along);
    memcpy(s->change, s->along, n * sizeof *s->change);
    return status;
}

/* s->stages[i] := U_i', with those before it at hand. */
static bgc_status differentiate_stage(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                      bgc_sensitivity_block *b, const step *of, int i) {
    const int n = m->n_state;
    const bgc_tableau *tableau = of->tableau;
    bgc_status status = BGC_OK;

    combine(n, i, tableau->a[i], s->stages, b->now, s->change);
    if (!of->implicit && d->core.algebraic > 0 && i > 0) {
        status = satisfy_stage(m, d, s, b, of, i);
    }
    s->change[n] = lane_of(0.0);
    s->kernel->rhs(s->h, lane_of(of->t + tableau->alpha[i] * of->h), s->points + (size_t)i * (size_t)n,
                   s->u, s->change, b->q, s->right, s->work);
    if (of->implicit) {
        for (int k = 0; k < n; k++) {
            s->right[k] += b->products[i * n + k];
        }
        add_earlier(m, d, s, b, of, i);
        status = solve(m, d, s);
    } else if (status == BGC_OK) {
        for (int k = 0; k < n; k++) {
            s->right[k] *= of->h;
        }
        for (int k = 0; k < m->n_mass; k++) {
            s->right[m->mass_row[k]] -= stage_of(m, d, i)[m->mass_col[k]] * b->mass[k];
        }
        for (int k = 0; k < n; k++) {
            s->right[k] *= d->inverse_mass[k];
        }
    }
    memcpy(s->stages + (size_t)i * (size_t)n, s->right, (size_t)n * sizeof *s->right);
    return status;
}

/* Tests that the end of the step, which the stages give as d->point, was corrected by the algebraic
 * equations. */
static int was_corrected(const bgc_data *d) {
    int corrected = 0;

    for (int k = 0; k < d->n_block; k++) {
        corrected |= d->y1[d->block[k]] != d->point[d->block[k]];
    }
    return corrected;
}

/* The derivatives at the end of the step, and its dense output, from the stages. */
static bgc_status finish(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                         bgc_sensitivity_block *b, const step *of) {
    const int n = m->n_state, stages = of->tableau->stages;
    const bgc_moment end = {of->t + of->h, d->y1, d->u_step};
    bgc_status status = BGC_OK;

    combine(n, stages, of->tableau->m, s->stages, b->start, b->end);
    if (m->project != NULL || m->closure_info != NULL || d->core.algebraic > 0) {
        bgc_combine(n, stages, of->tableau->m, d->stages, d->x, d->point);
        bgc_project_sensitivity(m, s, b, end.t, d->point, b->end);
        status = bgc_close_sensitivity(m, d, s, b, &end, d->point, lane_of(0.0), b->end);
    }
    if (status == BGC_OK && d->core.algebraic > 0 && (!of->implicit || was_corrected(d))) {
        status = bgc_satisfy_sensitivity(m, d, s, b, &end, d->point, lane_of(0.0), b->end);
    }
    b->has_dense = of->tableau->dense > 0;
    for (int l = 0; l < BGC_MAX_DENSE && b->has_dense; l++) {
        combine(n, stages, of->tableau->h[l], s->stages, s->no_change, b->k + (size_t)l * (size_t)n);
    }
    return status;
}

/* The derivatives over a step of the method. */
static bgc_status differentiate_stages(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                       bgc_sensitivity_block *b, const step *of) {
    bgc_status status = BGC_OK;

    bgc_spread(m->n_input + m->n_switch, d->u_step, s->u);
    for (int i = 0; i < of->tableau->stages && status == BGC_OK; i++) {
        status = differentiate_stage(m, d, s, b, of, i);
    }
    return status == BGC_OK ? finish(m, d, s, b, of) : status;
}

/* The same over a step of Euler's method off a root of the algebraic equations (bgc_leave_root), with the
 * derivatives of f at its end: at its start f has none. */
static bgc_status differentiate_departure(const bgc_model *m, bgc_data *d, bgc_sensitivities *s,
                                          bgc_sensitivity_block *b, const step *of) {
    const int n = m->n_state;
    const bgc_moment end = {of->t + of->h, d->y1, d->u_step};
    bgc_status status;

    memcpy(b->end, b->start, (size_t)n * sizeof *b->end);
    status = bgc_satisfy_sensitivity(m, d, s, b, &end, NULL, lane_of(0.0), b->end);
    if (status != BGC_OK) {
        return status;
    }
    bgc_slope_sensitivity(m, s, b, &end, b->end, lane_of(0.0));
    for (int k = 0; k < m->n_mass; k++) {
        const int i = m->mass_row[k];
        s->right[i] -= b->mass[k] * ((d->y1[i] - d->x[i]) / of->h);
    }
    for (int i = 0; i < n; i++) {
        b->end[i] += of->h * d->inverse_mass[i] * s->right[i];
    }
    b->has_dense = 0;
    return bgc_satisfy_sensitivity(m, d, s, b, &end, NULL, lane_of(0.0), b->end);
}

/* Before d->next, to which a step of the method leads, becomes the present at t. The counts, and how
 * solutions are checked, stay those of the step. */
bgc_status bgc_differentiate_step(const bgc_model *m, bgc_data *d, void *given,
                                  const bgc_method *method, double t) {
    bgc_sensitivities *s = given;
    const step of = {method->tableau, d->core.t_old, d->core.t_end - d->core.t_old,
                     method->family->jacobian};
    const int n = m->n_state, watched = d->core.watched;
    const bgc_pivoting pivoting = d->core.pivoting;
    const bgc_counts counts = d->core.counts;
    bgc_status status = BGC_OK;

    if (of.tableau == NULL) {
        return BGC_BAD_ARGUMENT;
    }
    s->jumps = 0;
    bgc_follow_chosen_rows(m, d, s);
    if (!d->core.left) {
        status = spread_step(m, d, s, &of);
    }
    if (of.implicit && !d->core.left) {
        multiply_by_change(m, d, s, &of);
    }
    for (int k = 0; k < s->blocks && status == BGC_OK; k++) {
        bgc_sensitivity_block *b = &s->block[k];
        memcpy(b->start, b->now, (size_t)n * sizeof *b->now);
        status = d->core.left ? differentiate_departure(m, d, s, b, &of)
                              : differentiate_stages(m, d, s, b, &of);
        if (status == BGC_OK && t < d->core.t_end) {
            status = bgc_interpolate_sensitivity(m, d, s, b, t, d->next, b->now);
        } else {
            memcpy(b->now, b->end, (size_t)n * sizeof *b->now);
        }
    }
    d->core.counts = counts;
    d->core.watched = watched;
    d->core.pivoting = pivoting;
    return status;
}
