/* lane_switching.c: the choice between the implicit method and its explicit partner, of a batch:
 * switching.c. There is one choice for all instances, which take their steps together: by the largest
 * spectral radius of theirs, and the largest product of the step and a dominant eigenvalue.
 */
#include "lanes/batch.h"
#include "spectrum.h"
#include "switching.h"

#include <string.h>

/* Steps that an instance takes by itself, within one of the batch, before it makes a choice of its own. */
enum { STEPS_WITHOUT_CHOICE = 32 };

/* --- the spectral radius: spectrum.c --------------------------------------------------------- */

/* image = M^-1 J v at the start of the last step by a difference of f, where |v| = 1. b->f is f there: no
 * method with a partner needs f at the end for its dense output. Returns whether it is finite in all
 * active lanes. */
static int find_image(bgc_batch *b, const lane *v, lane *image) {
    bgc_find_neighbour(b->m->n_state, b->y0, v, b->point);
    b->kernel->rhs(b->h, lane_of(b->t_old), b->point, b->u, image, b->work);
    b->counts.rhs++;
    bgc_take_difference(b->m->n_state, b->f, b->inverse_mass, image);
    return bgc_batch_bad(b, b->m->n_state, image) == 0;
}

/* 1 / norm; 0 in lanes where the norm vanishes, which have no part in an estimate then. */
static lane inverse_or_zero(lane norm) {
    return lane_select(norm > lane_of(0.0), 1.0 / norm, lane_of(0.0));
}

static bgc_estimate begin_estimate(bgc_batch *b) {
    const int n = b->m->n_state;
    lane norm;

    if (b->spectrum.estimates == 0) {
        memset(b->direction, 0, (size_t)n * sizeof *b->direction);
    }
    norm = lane_sqrt(bgc_add_direction_noise(n, b->scale, bgc_begin_estimate(&b->spectrum),
                                             b->direction));
    bgc_scale_direction(n, b->direction, inverse_or_zero(norm));
    b->newest = lane_of(INFINITY);
    return find_image(b, b->direction, b->image) ? BGC_ESTIMATING
                                                 : bgc_finish_estimate(&b->spectrum, INFINITY);
}

/* One product for every lane. Scratch: b->point, b->error. */
static bgc_estimate continue_estimate(bgc_batch *b, double enough) {
    const int n = b->m->n_state;
    const size_t size = (size_t)n * sizeof(lane);
    lane *u = b->direction, *v = b->image, *w = b->error, norm, factor, before = b->newest;

    norm = lane_sqrt(bgc_multiply_images(n, b->scale, u, v, v).vv);
    if (bgc_lanes_where(b, norm > lane_of(0.0)) == 0) {
        return bgc_finish_estimate(&b->spectrum, 0.0);
    }
    factor = inverse_or_zero(norm);
    bgc_scale_direction(n, u, factor);
    bgc_scale_direction(n, v, factor);
    if (!find_image(b, v, w)) {
        return bgc_finish_estimate(&b->spectrum, INFINITY);
    }
    b->newest = lane_select(norm > lane_of(0.0),
                            bgc_larger_of_two(bgc_multiply_images(n, b->scale, u, v, w)),
                            lane_of(0.0));
    memcpy(u, v, size);
    memcpy(v, w, size);
    return bgc_enter_product(&b->spectrum, bgc_batch_largest(b->active, b->newest),
                             bgc_batch_largest(b->active, lane_fabs(b->newest - before)), enough);
}

/* A whole estimate. */
static double estimate_largest_radius(void *run, double enough) {
    bgc_batch *b = run;

    if (begin_estimate(b) == BGC_ESTIMATING) {
        while (continue_estimate(b, enough) == BGC_ESTIMATING) {
        }
    }
    return b->spectrum.radius;
}

/* --- the choice ------------------------------------------------------------------------------ */

/* Step times the dominant eigenvalue, of the lanes that take the last step together. Scratch: b->point,
 * b->error. */
static double largest_product(void *run) {
    bgc_batch *b = run;
    const bgc_tableau *tableau = b->method->tableau;
    const int n = b->m->n_state, last = tableau->stages - 1;
    const lane *u = b->stages + (size_t)last * (size_t)n, *before = u - n;
    double weight[BGC_MAX_STAGES] = {0.0};
    lane distance, change;

    bgc_weigh_distance(tableau, weight);
    memset(b->point, 0, (size_t)n * sizeof *b->point);
    bgc_batch_combine(n, last, weight, b->stages, b->point);
    for (int i = 0; i < n; i++) {
        b->error[i] = u[i] - before[i];
    }
    distance = bgc_batch_norm(b, b->point, b->y0, b->x);
    change = bgc_batch_norm(b, b->error, b->y0, b->x);
    return fmax(0.0, bgc_batch_largest(b->active & ~b->single,
                                       lane_select(distance > lane_of(0.0), change / distance,
                                                   lane_of(0.0))));
}

static bgc_chooser chooser_of_batch(bgc_batch *b) {
    return (bgc_chooser){
        .option = b->option,
        .explicit_cost = b->m->explicit_cost,
        .choice = &b->choice,
        .counts = &b->counts,
        .spectrum = &b->spectrum,
        .h_next = &b->h_next,
        .error_old = &b->error_old,
        .find_product = largest_product,
        .estimate = estimate_largest_radius,
        .run = b,
    };
}

/* At the start of a run. */
void bgc_batch_begin_choice(bgc_batch *b) {
    bgc_begin_choice(b->m, b->option->method, &b->choice, &b->spectrum);
}

/* After an accepted step of length h, before it enters the counts. */
void bgc_batch_choose_method(bgc_batch *b, double h) {
    if (b->choice.partner >= 0) {
        const bgc_chooser of = chooser_of_batch(b);
        bgc_choose(&of, b->t, h);
    }
}

/* After a rejected attempt. */
void bgc_batch_count_rejection(bgc_batch *b) {
    const bgc_chooser of = chooser_of_batch(b);

    bgc_enter_rejection(&of, b->t, b->rejected);
}

/* Before an attempt: by the method that has been chosen. The dense output of the last step is made by the
 * method which took that step. */
void bgc_batch_take_method(bgc_batch *b) {
    const bgc_method *chosen = bgc_chosen(&b->choice, b->option->method);

    if (chosen != b->method && !b->rejected) {
        bgc_batch_interpolate(b, b->t);
    }
    b->method = chosen;
}

/* Gives an instance, which takes the last step by itself, the method of that step. */
void bgc_batch_give_method(const bgc_batch *b, bgc_data *d) {
    bgc_choice *choice = &d->core.choice;

    *choice = (bgc_choice){.partner = b->choice.partner,
                           .is_explicit = b->method != &bgc_methods[b->option->method],
                           .wait = STEPS_WITHOUT_CHOICE,
                           .look = STEPS_WITHOUT_CHOICE};
    d->core.spectrum.radius = b->spectrum.radius;
}
