/* tangent_jacobian.c: products of the change of the Jacobian along each direction with the stages of a step.
 *
 * J' U_i is the derivative of f along U_i, differentiated along the derivatives of the states. Each lane holds a
 * pair of a direction and a stage: number `direction * stages + stage` of all pairs, in groups that fill a
 * register. */
#include "tangents/sensitivities.h"

#include <string.h>

static int groups_of(const bgc_sensitivities *s, int stages) {
    return (s->count * stages + BGC_LANE_WIDTH - 1) / BGC_LANE_WIDTH;
}

/* The direction of lane l of group g; the last one where there are no more pairs. */
static int direction_of(const bgc_sensitivities *s, int stages, int g, int l) {
    const int k = (g * BGC_LANE_WIDTH + l) / stages;

    return k < s->count ? k : s->count - 1;
}

/* Copies n elements of lane `other` to all lanes. */
static void fill_lanes(size_t n, const lane *from, int other, lane *to) {
    for (size_t i = 0; i < n; i++) {
        to[i] = lane_of(lane_get(from[i], other));
    }
}

/* Copies n elements of lane `other` to lane l. */
static void copy_lane(size_t n, const lane *from, int other, lane *to, int l) {
    for (size_t i = 0; i < n; i++) {
        lane_set(&to[i], l, lane_get(from[i], other));
    }
}

void bgc_note_jacobian(const bgc_model *m, bgc_sensitivities *s, double t, int stages) {
    const size_t n = (size_t)m->n_state, hoisted = (size_t)m->n_hoist, held = (size_t)m->n_held;

    s->t_jac = t;
    memcpy(s->x_jac, s->points, n * sizeof *s->x_jac);
    memcpy(s->u_jac, s->u, (size_t)(m->n_input + m->n_switch) * sizeof *s->u);
    for (int g = 0; g < groups_of(s, stages); g++) {
        lane *d = s->pair_d + (size_t)g * (n + 1), *q = s->pair_q + (size_t)g * (hoisted + held);
        for (int l = 0; l < BGC_LANE_WIDTH; l++) {
            const int k = direction_of(s, stages, g, l), other = k % BGC_LANE_WIDTH;
            const bgc_sensitivity_block *b = &s->block[k / BGC_LANE_WIDTH];
            if (stages % BGC_LANE_WIDTH != 0) {
                copy_lane(n, b->now, other, d, l);
            } else if (l == 0) {
                fill_lanes(n, b->now, other, d);
            }
            copy_lane(held, b->q + hoisted, other, q + hoisted, l);
            if (s->pair_stages != stages) {
                copy_lane(hoisted, b->q, other, q, l);
            }
        }
    }
    s->pair_stages = stages;
}

/* The stages of group g, with the factors of df/dt, to s->pair_r. */
static void gather_stages(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s, int stages, int g,
                          const double *slope) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        const int i = (g * BGC_LANE_WIDTH + l) % stages;
        const double *u = d->stages + (size_t)i * bgc_chunked(m->n_state);
        for (int k = 0; k < m->n_state; k++) {
            lane_set(&s->pair_r[k], l, u[k]);
        }
        lane_set(&s->pair_r[m->n_state], l, slope[i]);
    }
}

void bgc_multiply_change_of_jacobian(const bgc_model *m, const bgc_data *d, bgc_sensitivities *s,
                                     int stages, const double *slope) {
    const size_t n = (size_t)m->n_state, changes = (size_t)(m->n_hoist + m->n_held);
    const lane t = lane_of(s->t_jac);

    for (int g = 0; g < groups_of(s, stages); g++) {
        const int first = g * BGC_LANE_WIDTH;
        if (g == 0 || first % stages != (first - BGC_LANE_WIDTH) % stages) {
            gather_stages(m, d, s, stages, g, slope);
            s->kernel->curvature_shared(s->h, t, s->x_jac, s->u_jac, s->pair_r, s->work);
        }
        s->kernel->curvature(s->h, t, s->x_jac, s->u_jac, s->pair_d + (size_t)g * (n + 1),
                             s->pair_q + (size_t)g * changes, s->pair_r, s->result, s->work);
        for (int l = 0; l < BGC_LANE_WIDTH && first + l < s->count * stages; l++) {
            const int k = (first + l) / stages, i = (first + l) % stages;
            lane *to = s->block[k / BGC_LANE_WIDTH].products + (size_t)i * n;
            copy_lane(n, s->result, l, to, k % BGC_LANE_WIDTH);
        }
    }
}
