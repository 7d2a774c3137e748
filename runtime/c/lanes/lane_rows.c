/* lane_rows.c: rows of all lanes, at the present or inside the last step, as dense.c and run.c have
 * them. */
#include "lanes/batch.h"

#include <string.h>

/* Where a cubic through these slopes is to be trusted: is_smooth of dense.c. */
static lane_mask is_smooth(lane start, lane end) {
    const double most = 10.0;

    return (lane_fabs(start) <= most * lane_fabs(end)) & (lane_fabs(end) <= most * lane_fabs(start));
}

/* The cubic of Hermite through the states and slopes at both ends. */
static void store_cubic(bgc_batch *b) {
    const int n = b->m->n_state;
    const double h = b->t - b->t_old;
    lane *k1 = b->k, *k2 = k1 + n;

    /* f is still that at the start of the step. */
    memcpy(k1, b->f, (size_t)n * sizeof *k1);
    bgc_batch_evaluate_f(b);
    for (int i = 0; i < n; i++) {
        const lane rise = b->x[i] - b->y0[i], scale = h * b->inverse_mass[i];
        const lane start = scale * k1[i] - rise, end = scale * b->f[i] - rise;
        const lane_mask smooth = (scale != lane_of(0.0)) & is_smooth(start, end);
        k1[i] = lane_select(smooth, start, lane_of(0.0));
        k2[i] = lane_select(smooth, -(start + end), lane_of(0.0));
    }
    memset(k2 + n, 0, (size_t)n * sizeof *k2);
}

static void store_dense(bgc_batch *b) {
    const bgc_tableau *tableau = b->method->tableau;
    const int n = b->m->n_state;

    b->dense = 1;
    if (tableau->dense == 0) {
        store_cubic(b);
        return;
    }
    memset(b->k, 0, (size_t)(BGC_MAX_DENSE * n) * sizeof *b->k);
    for (int l = 0; l < tableau->dense; l++) {
        bgc_batch_combine(n, tableau->stages, tableau->h[l], b->stages, b->k + (size_t)(l * n));
    }
}

/* x at time t inside the last step, to b->point. */
void bgc_batch_interpolate(bgc_batch *b, double t) {
    const int n = b->m->n_state;
    const lane *k1 = b->k, *k2 = k1 + n, *k3 = k2 + n;
    const double s = (t - b->t_old) / (b->t - b->t_old), r = 1.0 - s;

    if (!b->dense) {
        store_dense(b);
    }
    for (int i = 0; i < n; i++) {
        b->point[i] = r * b->y0[i] + s * (b->x[i] + r * (k1[i] + s * (k2[i] + s * k3[i])));
    }
    if (b->m->project != NULL) {
        b->kernel->project(b->h, lane_of(t), b->point, b->work);
    }
}

/* How far the dense output is from the equations in the middle of the last step, over the
 * tolerances: dense_error of step.c. */
lane bgc_batch_dense_error(bgc_batch *b) {
    const bgc_model *m = b->m;
    const int n = m->n_state;
    const double h = b->t - b->t_old, middle = b->t_old + 0.5 * h;
    const lane *k2 = b->k + n, *k3 = k2 + n;

    if (!b->method->check_dense || b->method->tableau->dense == 0) {
        return lane_of(0.0);
    }
    bgc_batch_interpolate(b, middle);
    b->kernel->rhs(b->h, lane_of(middle), b->point, b->u, b->error, b->work);
    b->counts.rhs++;
    for (int i = 0; i < n; i++) { /* less M times its rate */
        b->point[i] = -(b->x[i] - b->y0[i] + 0.25 * (k2[i] + k3[i])) / h;
        b->error[i] += m->n_mass == 0 ? b->point[i] : lane_of(0.0);
    }
    bgc_batch_multiply_mass(b, b->point, b->error);
    bgc_batch_solve(b, b->error);
    return bgc_batch_norm(b, b->error, b->y0, b->x);
}

/* --- energies ------------------------------------------------------------------------------ */

/* Stored energy, and supplied and dissipated power, at a time inside the last step. */
static void energy_at(bgc_batch *b, double t, lane energy[3]) {
    const lane *x = b->point;

    if (t == b->t_old) {
        x = b->y0;
    } else if (t == b->t) {
        x = b->x;
    } else {
        bgc_batch_interpolate(b, t);
    }
    b->kernel->energy(b->h, lane_of(t), x, b->u, energy, b->work);
}

/* The rule of Lobatto with four points from the start of the last step to t inside it. */
static void lobatto(bgc_batch *b, double t, lane energy[4][3], lane power[2]) {
    static const double node[4] = {0.0, 0.27639320225002103, 0.72360679774997897, 1.0};
    static const double weight[4] = {1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0};
    const double start = b->t_old, length = t - start;

    power[0] = power[1] = lane_of(0.0);
    for (int k = 0; k < 4; k++) {
        energy_at(b, k == 3 ? t : start + node[k] * length, energy[k]);
        power[0] += weight[k] * length * energy[k][1];
        power[1] += weight[k] * length * energy[k][2];
    }
}

/* The energies of the last step and, under error control, their error: bgc_balance_step. */
void bgc_batch_balance(bgc_batch *b, bgc_lane_balance *balance) {
    const double length = b->t - b->t_old;
    lane energy[4][3], middle[3], power[2];

    lobatto(b, b->t, energy, power);
    *balance = (bgc_lane_balance){power[0], power[1], lane_of(0.0), lane_of(0.0), energy[3][0]};
    if (!bgc_is_adaptive(b->method)) {
        return;
    }
    energy_at(b, b->t_old + 0.5 * length, middle);
    for (int k = 0; k < 2; k++) {
        const lane first = energy[0][k + 1], last = energy[3][k + 1];
        const lane inner = lane_fabs(energy[1][k + 1]) + lane_fabs(energy[2][k + 1]);
        const lane simpson = length / 6.0 * (first + last + 4.0 * middle[k + 1]);
        balance->moved = lane_max(
            balance->moved, length / 12.0 * (lane_fabs(first) + 5.0 * inner + lane_fabs(last)));
        balance->error = lane_max(balance->error, lane_fabs(power[k] - simpson));
    }
}

/* What energies are small: settle_energy_scale of step.c. */
void bgc_batch_settle_energy_scale(bgc_batch *b) {
    const int n = b->m->n_state;
    lane present[3], energy[3];

    memcpy(b->point, b->x, (size_t)n * sizeof *b->point);
    b->kernel->energy(b->h, lane_of(b->t), b->point, b->u, present, b->work);
    for (int i = 0; i < n; i++) {
        lane change;
        b->point[i] = b->x[i] + b->scale[i];
        b->kernel->energy(b->h, lane_of(b->t), b->point, b->u, energy, b->work);
        b->point[i] = b->x[i];
        change = lane_fabs(energy[0] - present[0]);
        change = lane_select(bgc_is_finite(change), change, lane_of(0.0));
        b->energy_scale = lane_max(b->energy_scale, change);
    }
}

/* --- rows ---------------------------------------------------------------------------------- */

/* Writes the next row of every live lane that does not have it. */
void bgc_batch_row(bgc_batch *b) {
    const int n_output = b->m->n_output, accounts = b->option->accounts;
    const size_t width = bgc_batch_row_width(b);
    const double t = b->times[b->row];
    const unsigned lanes = b->live & ~b->written;
    const int inside = t < b->t - bgc_batch_slack(b);
    lane power[2] = {lane_of(0.0), lane_of(0.0)};
    lane *account = b->output + n_output;
    const lane *x = b->x;

    if (inside) {
        if (accounts) {
            lane energy[4][3];
            lobatto(b, t, energy, power);
        }
        bgc_batch_interpolate(b, t);
        x = b->point;
    }
    b->kernel->outputs(b->h, lane_of(t), x, b->u, b->output, b->work);
    if (accounts) {
        lane energy[3];
        b->kernel->energy(b->h, lane_of(t), x, b->u, energy, b->work);
        account[0] = energy[0] - b->stored0;
        account[1] = inside ? b->supplied_old + power[0] : b->supplied;
        account[2] = inside ? b->dissipated_old + power[1] : b->dissipated;
        account[3] = account[0] - account[1] + account[2];
    }
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        for (size_t j = 0; (lanes >> l & 1u) != 0 && j < width; j++) {
            b->rows[l][b->row * width + j] = lane_get(b->output[j], l);
        }
    }
}
