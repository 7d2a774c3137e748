/* lane_rows.c: dense output, energies and rows of a batch, as in dense.c, accounts.c and run.c. */
#include "lanes/batch.h"
#include "accounts.h"
#include "interpolation.h"

#include <string.h>

/* Cubic Hermite polynomials through the states and slopes at both ends. */
static void store_cubic(bgc_batch *b) {
    const int n = b->m->n_state;
    const double h = b->t - b->t_old;
    lane *k1 = b->k, *k2 = k1 + n;

    /* b->f is f at the start of the step until it is evaluated at the end. */
    memcpy(k1, b->f, (size_t)n * sizeof *k1);
    bgc_batch_evaluate_f(b);
    for (int i = 0; i < n; i++) {
        const lane scale = h * b->inverse_mass[i];
        bgc_hermite(b->x[i] - b->y0[i], scale * k1[i], scale * b->f[i], scale != lane_of(0.0),
                    k1 + i, k2 + i);
    }
    memset(k2 + n, 0, (size_t)n * sizeof *k2);
}

/* Coefficients of the dense output of the last step: the method's own, or Hermite polynomials. */
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
    const double s = (t - b->t_old) / (b->t - b->t_old);

    if (!b->dense) {
        store_dense(b);
    }
    for (int i = 0; i < n; i++) {
        b->point[i] = bgc_interpolated(s, b->y0[i], b->x[i], k1[i], k2[i], k3[i]);
    }
    if (b->m->project != NULL) {
        b->kernel->project(b->h, lane_of(t), b->point, b->work);
    }
}

/* The same for some states, which are not projected; the others in b->point stay as they are. */
void bgc_batch_interpolate_some(bgc_batch *b, double t, int count, const int *state) {
    const int n = b->m->n_state;
    const lane *k1 = b->k, *k2 = k1 + n, *k3 = k2 + n;
    const double s = (t - b->t_old) / (b->t - b->t_old);

    if (!b->dense) {
        store_dense(b);
    }
    for (int j = 0; j < count; j++) {
        const int i = state[j];
        b->point[i] = bgc_interpolated(s, b->y0[i], b->x[i], k1[i], k2[i], k3[i]);
    }
}

/* The error of the dense output in the middle of the last step, over the tolerances: dense_error of
 * step.c. */
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

    /* The defect f - M y'. */
    for (int i = 0; i < n; i++) {
        b->point[i] = -bgc_middle_slope(b->y0[i], b->x[i], k2[i], k3[i]) / h;
        b->error[i] += m->n_mass == 0 ? b->point[i] : lane_of(0.0);
    }
    bgc_batch_multiply_mass(b, b->point, b->error);

    /* One simplified Newton iteration. */
    bgc_batch_solve(b, b->error);
    for (int i = 0; i < n; i++) {
        b->error[i] = bgc_defect(b->error[i], b->y0[i], b->x[i], middle, h);
    }
    return bgc_batch_norm(b, b->error, b->y0, b->x);
}

/* --- energies ------------------------------------------------------------------------------ */

/* Stored energy, supplied and dissipated power at a time inside the last step. */
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

/* Lobatto quadrature of the powers from the start of the last step to t inside it. */
static void lobatto(bgc_batch *b, double t, lane energy[4][3], lane power[2]) {
    const double start = b->t_old, length = t - start;

    power[0] = power[1] = lane_of(0.0);
    for (int k = 0; k < 4; k++) {
        energy_at(b, k == 3 ? t : start + bgc_lobatto_node[k] * length, energy[k]);
        power[0] += bgc_lobatto_weight[k] * length * energy[k][1];
        power[1] += bgc_lobatto_weight[k] * length * energy[k][2];
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
        const lane moved = bgc_moved(length, first, energy[1][k + 1], energy[2][k + 1], last);
        const lane error = bgc_quadrature_error(length, power[k], first, middle[k + 1], last);
        balance->moved = number_larger(balance->moved, moved);
        balance->error = number_larger(balance->error, error);
    }
}

/* --- rows ---------------------------------------------------------------------------------- */

/* Writes the next row of every active lane that does not have it. Lanes whose energies are not finite leave
 * the batch, and end by themselves. */
void bgc_batch_row(bgc_batch *b) {
    const int n_output = b->m->n_output, accounts = b->option->accounts;
    const size_t width = bgc_batch_row_width(b);
    const double t = b->times[b->row];
    unsigned lanes = b->active & ~b->written;
    const int inside = t < b->t - bgc_batch_slack(b);
    lane power[2] = {lane_of(0.0), lane_of(0.0)};
    lane *account = b->output + n_output;
    const lane *x = b->x;

    /* The state at t. */
    if (inside) {
        if (accounts) {
            lane energy[4][3];
            lobatto(b, t, energy, power);
        }
        bgc_batch_interpolate(b, t);
        x = b->point;
    }

    /* Outputs and accounts, then a row for each lane. */
    b->kernel->outputs(b->h, lane_of(t), x, b->u, b->output, b->work);
    if (accounts) {
        lane energy[3];
        b->kernel->energy(b->h, lane_of(t), x, b->u, energy, b->work);
        bgc_account_row(energy[0] - b->stored0,
                        inside ? b->supplied_old + power[0] : b->supplied,
                        inside ? b->dissipated_old + power[1] : b->dissipated, account);
        for (int k = 0; k < 4; k++) {
            b->active &= ~bgc_lanes_where(b, lane_not(number_is_finite(account[k])));
        }
        lanes &= b->active;
    }
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        for (size_t j = 0; (lanes >> l & 1u) != 0 && j < width; j++) {
            b->rows[l][b->row * width + j] = lane_get(b->output[j], l);
        }
    }
}
