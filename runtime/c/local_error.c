/* local_error.c: the error that a step adds.
 *
 * Deferred correction of the step: its collocation equations at Lobatto's five points are swept
 * from the dense output, node after node, each by an implicit step with the factors of W, whose 1/c
 * is close to the distance of the points. Two sweeps leave little more than the collocation's own
 * error, of order 8, also in parts with |h J| of 1 to 10, oscillating or stiff, where a quadrature
 * of f along the dense output sees a tenth of the local error. The end moves by the local error.
 * A. Dutt, L. Greengard, V. Rokhlin, BIT 40 (2000) 241; M. Minion, Comm. Math. Sci. 1 (2003) 471.
 *
 * That costs as much as the step, so it is not done in each. In smooth motion the local error is that of the last
 * measurement times the power of the step's length that the order of the method gives. It is taken for the steps
 * between, twice as many each time that the next measurement confirms it, and that corrects their sum by the
 * trapezoidal rule. At an event, and where the method's own error estimate or the step's length have changed, the step
 * is measured.
 */
#include "global_error.h"
#include "interpolation.h"

#include <math.h>
#include <string.h>

enum { NODES = INSIDE_NODES + 1 }; /* of Lobatto, but the start */
enum { LONGEST_UNMEASURED = 8 };   /* steps to the next measurement */
static const double alike = 2.0;   /* ratio up to which two steps are alike */
/* Difference of local errors, relative, up to which one foretells the next. */
static const double held_gap = 0.2, held_explicit = 0.05;
static const double node[NODES] = {0.172673164646011428, 0.5, 0.827326835353988572, 1.0};
static const double quadrature[NODES][NODES + 1] = { /* of f at the start and at the nodes */
    {0.067728432186156898, 0.119744769343411683, -0.0217357218665581137, 0.0106358242254154919,
     -0.0037001392424145306},
    {-0.027103432186156898, 0.183439413979631096, 0.199513499644335891, -0.0415977853262360477,
     0.0130751392424145306},
    {0.0130751392424145306, -0.0415977853262360477, 0.199513499644335891, 0.183439413979631096,
     -0.027103432186156898},
    {-0.0037001392424145306, 0.0106358242254154919, -0.0217357218665581137, 0.119744769343411683,
     0.067728432186156898}};

/* The next step is measured, and nothing is known of it. */
void bgc_forget_local_error(bgc_core *core) {
    core->off_every = 1;
    core->off_since = 0;
    core->off_step = core->off_scale = core->off_size = 0.0;
    core->off_error = 1.0;
}

/* --- solutions --------------------------------------------------------------------------------- */

/* v := M v. */
void bgc_apply_mass_to_error(const bgc_model *m, bgc_data *d, double *v) {
    if (m->n_mass > 0) {
        bgc_multiply_mass(m, d, v, d->magnitude);
        memcpy(v, d->magnitude, (size_t)m->n_state * sizeof *v);
    }
}

/* v := W^-1 c v. A vector that cannot be solved for becomes NaN, and so do the errors. */
void bgc_solve_for_error(const bgc_model *m, bgc_data *d, double *v) {
    for (int i = 0; i < m->n_state; i++) {
        v[i] *= d->core.c;
    }
    if (bgc_solve(m, d, v) != BGC_OK) {
        v[0] = (double)NAN;
    }
}

/* --- measurement ------------------------------------------------------------------------------- */

/* The states at node k, and f there; the last node is the end. */
static double *node_state(const bgc_model *m, bgc_data *d, int k) { return bgc_error_vector(m, d, k); }
static double *node_slope(const bgc_model *m, bgc_data *d, int k) { return bgc_error_vector(m, d, NODES + k); }

static void evaluate_nodes(const bgc_model *m, bgc_data *d, const bgc_error_step *s, int nodes) {
    for (int k = 0; k < nodes; k++) {
        m->rhs(d->h, s->t + node[k] * s->h, node_state(m, d, k), d->u, node_slope(m, d, k), d->work);
    }
}

/* One sweep: from node to node, M (y_new - y_new before) = integral of f between them, f from the sweep before, by one
 * simplified Newton iteration. */
static void sweep_nodes(const bgc_model *m, bgc_data *d, const bgc_error_step *s, const double *f_end) {
    double *change = bgc_error_vector(m, d, 11);
    const double *before = d->x, *f[NODES];

    for (int k = 0; k < NODES; k++) {
        f[k] = k < NODES - 1 ? node_slope(m, d, k) : f_end;
    }
    for (int k = 0; k < NODES; k++) {
        const double *w = quadrature[k];
        double *y = node_state(m, d, k);
        for (int i = 0; i < m->n_state; i++) {
            change[i] = before[i] - y[i];
        }
        if (s->implicit) {
            bgc_apply_mass_to_error(m, d, change);
        }
        for (int i = 0; i < m->n_state; i++) {
            const double integral =
                s->h * (w[0] * s->f_start[i] + w[1] * f[0][i] + w[2] * f[1][i] + w[3] * f[2][i] + w[4] * f[3][i]);
            change[i] += s->implicit ? integral : d->inverse_mass[i] * integral;
        }
        if (s->implicit) {
            bgc_solve_for_error(m, d, change);
        }
        for (int i = 0; i < m->n_state; i++) {
            y[i] += change[i];
        }
        before = y;
    }
}

/* Sweeps from the dense output until the end is exact to one order more than the step's end. */
static int needed_sweeps(const bgc_method *method) {
    const int quartic = method->tableau != NULL && method->tableau->dense == BGC_MAX_DENSE;
    const int needed = method->order - (quartic ? 3 : 2);

    return needed > 1 ? needed : 1;
}

/* The local error, to `local`, and the errors of the dense output at the inner nodes. */
static void measure(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double *local) {
    const size_t size = (size_t)m->n_state * sizeof *local;
    const double *f_end = s->f_end;
    double *end = node_state(m, d, NODES - 1);

    for (int k = 0; k < NODES - 1; k++) {
        bgc_interpolate_all(m, d, s->t + node[k] * s->h, node_state(m, d, k));
        memcpy(bgc_error_inside(m, d, k), node_state(m, d, k), size);
    }
    memcpy(end, d->next, size);
    evaluate_nodes(m, d, s, NODES - 1);
    for (int sweep = needed_sweeps(s->method); sweep > 0; sweep--) {
        sweep_nodes(m, d, s, f_end);
        if (sweep > 1) {
            evaluate_nodes(m, d, s, NODES);
            f_end = node_slope(m, d, NODES - 1);
        }
    }
    for (int i = 0; i < m->n_state; i++) {
        local[i] = end[i] - d->next[i];
    }
    for (int k = 0; k < NODES - 1; k++) {
        double *inside = bgc_error_inside(m, d, k);
        const double *y = node_state(m, d, k);
        for (int i = 0; i < m->n_state; i++) {
            inside[i] = y[i] - inside[i] - node[k] * local[i];
        }
    }
}

/* --- between measurements ---------------------------------------------------------------------- */

/* By how much the local error of the measured step is multiplied in one of length h. */
static double scale_by_length(const bgc_core *core, int order, double h) {
    const double ratio = core->off_step > 0.0 ? h / core->off_step : 0.0;
    double power = ratio;

    for (int k = 0; k < order; k++) {
        power *= ratio;
    }
    return power;
}

/* Tests that the present step resembles the measured one: in length, and in the estimate of its error that the method
 * has. */
static int is_foreseen(const bgc_core *core) {
    const double error = core->error_old / (core->off_error * core->off_scale);

    return core->off_since < core->off_every && !core->event && core->off_scale < alike &&
           core->off_scale * alike > 1.0 && error < alike && error * alike > 1.0;
}

/* Steps to the next measurement: twice as many where the last one was foretold; every second one of implicit steps
 * where the local error has turned by less than 60 degrees and kept its size, as in oscillations. */
static int plan_next(const bgc_core *core, int implicit, double apart, double foreseen, double now) {
    const double larger = fmax(now, foreseen);
    const int twice = 2 * core->off_since;

    if (apart <= (implicit ? held_gap : held_explicit) * larger) {
        return twice < LONGEST_UNMEASURED ? twice : LONGEST_UNMEASURED;
    }
    return implicit && apart < larger && larger < alike * fmin(now, foreseen) ? 2 : 1;
}

/* After a measurement of `local`: to `missed` what it says of the steps since the last one by the trapezoidal rule. */
static void enter_measurement(const bgc_model *m, bgc_data *d, int implicit, const double *local,
                              double *missed) {
    bgc_core *core = &d->core;
    const double part = 0.5 * (core->off_since - 1), now = bgc_norm(m, d, local, d->x, d->next);
    double apart;

    for (int i = 0; i < m->n_state; i++) {
        missed[i] = local[i] - core->off_scale * d->off_local[i];
    }
    apart = bgc_norm(m, d, missed, d->x, d->next);
    for (int i = 0; i < m->n_state; i++) {
        missed[i] *= part;
        d->off_local[i] = local[i];
    }
    core->off_every = plan_next(core, implicit, apart, core->off_scale * core->off_size, now);
    core->off_size = now;
    core->off_error = core->error_old;
    core->off_since = 0;
}

/* The error that this step adds, to `local`, and with a measurement what it says of the steps before, to `missed`.
 * Returns whether it has been measured. */
int bgc_local_error(const bgc_model *m, bgc_data *d, const bgc_error_step *s, double *local, double *missed) {
    bgc_core *core = &d->core;

    core->off_since++;
    core->off_scale = scale_by_length(core, s->method->order, s->h);
    if (is_foreseen(core)) {
        for (int i = 0; i < m->n_state; i++) {
            local[i] = core->off_scale * d->off_local[i];
        }
        return 0;
    }
    measure(m, d, s, local);
    enter_measurement(m, d, s->implicit, local, missed);
    core->off_step = s->h;
    core->off_scale = 1.0;
    return 1;
}

/* The part of the correction at inner node k in that of the dense output at a part s of the step. */
double bgc_inside_part(double s, int k) {
    double part = s * (1.0 - s) / (node[k] * (1.0 - node[k]));

    for (int j = 0; j < NODES - 1; j++) {
        part *= j == k ? 1.0 : (s - node[j]) / (node[k] - node[j]);
    }
    return part;
}
