/* lane_switching.c: the choice between the implicit method and its explicit partner, of a batch:
 * switching.c, switching_fixed.c. There is one choice for all instances, which take their steps together: by the largest
 * spectral radius of theirs, and the largest product of the step and a dominant eigenvalue.
 */
#include "lanes/batch.h"
#include "spectrum.h"
#include "switching.h"

#include <string.h>

/* Steps that an instance takes by itself, within one of the batch, before it makes a choice of its own. */
enum { STEPS_WITHOUT_CHOICE = 32 };

/* --- the spectral radius: spectrum.c --------------------------------------------------------- */

/* image = M^-1 J v at the start of the last step by a difference of f, where |v| = 1. b->f is f there: under
 * error control no method with a partner needs f at the end for its dense output, and after a fixed step
 * nothing has yet. Returns whether it is finite in all active lanes. */
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

static bgc_estimate begin_largest(bgc_batch *b) {
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
static bgc_estimate continue_largest(void *run, double enough) {
    bgc_batch *b = run;
    const int n = b->m->n_state;
    const size_t size = (size_t)n * sizeof(lane);
    lane *u = b->direction, *v = b->image, *w = b->error, norm, factor, before = b->newest;

    if (b->spectrum.products == 0) {
        return begin_largest(b);
    }
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

/* --- the choice ------------------------------------------------------------------------------ */

/* The largest product, of the lanes that take the last step together. */
static double largest_of_together(const bgc_batch *b, lane products) {
    return fmax(0.0, bgc_batch_largest(b->active & ~b->single, products));
}

/* Step times the dominant eigenvalue, under error control. Scratch: b->point, b->error. */
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
    return largest_of_together(
        b, lane_select(distance > lane_of(0.0), change / distance, lane_of(0.0)));
}

/* The same of a fixed step. */
static double largest_middle_product(void *run) {
    const bgc_batch *b = run;
    const int n = b->m->n_state;

    return largest_of_together(b, bgc_product_of_middle(n, b->scale, b->stages, b->stages + n,
                                                        b->stages + 2 * n));
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
        .held = &b->held,
        .find_product = bgc_is_adaptive(b->method) ? largest_product : largest_middle_product,
        .continue_estimate = continue_largest,
        .run = b,
    };
}

/* At the start of a run. */
void bgc_batch_begin_choice(bgc_batch *b) {
    bgc_begin_choice(b->m, b->option->method, &b->choice, &b->spectrum);
}

/* After an accepted step under error control, of length h, before it enters the counts. */
void bgc_batch_choose_method(bgc_batch *b, double h) {
    if (b->choice.partner >= 0) {
        const bgc_chooser of = chooser_of_batch(b);
        bgc_choose(&of, b->t, h);
    }
}

/* After a fixed step that is accepted, while b->f is f at its start. */
void bgc_batch_choose_fixed_method(bgc_batch *b) {
    if (b->choice.partner >= 0) {
        const bgc_chooser of = chooser_of_batch(b);
        bgc_choose_fixed(&of, b->t);
    }
}

/* After a fixed step, before it is accepted: whether it was explicit, and is tried again by the implicit
 * method because these lanes are bad or it may be unstable. */
int bgc_batch_rejects_explicit_step(bgc_batch *b, unsigned bad) {
    const bgc_chooser of = chooser_of_batch(b);

    return bad != 0 ? bgc_return_to_implicit(&of, b->t) : bgc_rejects_product(&of, b->t);
}

/* After a rejected attempt. */
void bgc_batch_count_rejection(bgc_batch *b) {
    const bgc_chooser of = chooser_of_batch(b);

    bgc_enter_rejection(&of, b->t, b->rejected);
}

/* Before an attempt: by the method that has been chosen. A dense output of the last step's own method is
 * made before. */
void bgc_batch_take_method(bgc_batch *b) {
    const bgc_method *chosen = bgc_chosen(&b->choice, b->option->method);

    if (chosen == b->method) {
        return;
    }
    if (b->method->tableau->dense > 0 && !b->rejected) {
        bgc_batch_interpolate(b, b->t);
    }
    b->method = chosen;
    bgc_batch_begin_corrections(b);
}

/* Gives an instance, which takes the last step by itself, the method of that step. */
void bgc_batch_give_method(const bgc_batch *b, bgc_data *d) {
    bgc_choice *choice = &d->core.choice;

    *choice = (bgc_choice){.partner = b->choice.partner,
                           .is_explicit = b->method != &bgc_methods[b->option->method],
                           .usual = b->choice.usual,
                           .wait = STEPS_WITHOUT_CHOICE,
                           .look = STEPS_WITHOUT_CHOICE};
    d->core.spectrum.radius = b->spectrum.radius;
}
