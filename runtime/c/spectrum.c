/* spectrum.c: an estimate of the spectral radius of M^-1 df/dx along a run.
 *
 * Power iteration by differences of f: it needs no Jacobian, so that explicit steps have it too, and a
 * product costs one evaluation of f. Two images of a vector give the two dominant eigenvalues, real or
 * a conjugate pair, by Rayleigh-Ritz projection: Y. Saad, Numerical Methods for Large Eigenvalue Problems,
 * 4.1 and 6.2. The vector is kept from one estimate to the next, with some noise added, so that later
 * estimates need few products and find a mode that has become dominant since. Fixed steps take one product
 * at a time, so that none is much longer than the others.
 */
#include "bgc_internal.h"
#include "spectrum.h"

#include <math.h>
#include <string.h>

enum { FIRST_PRODUCTS = 20, LATER_PRODUCTS = 10 }; /* most of an estimate */
enum { FEWEST_FIRST = 6, FEWEST_LATER = 3 };       /* and fewest */
static const double settled_estimate = 0.05; /* relative change of the estimate in one product */
static const double far_beyond = 4.0;        /* an estimate that exceeds what is asked by this need not settle */

/* At the start of a run: no estimate. */
void bgc_reset_radius(bgc_spectrum *s) {
    s->radius = INFINITY;
    s->products = s->estimates = 0;
}

/* Begins an estimate; returns the part of noise in its vector. The first is noise alone. */
double bgc_begin_estimate(bgc_spectrum *s) {
    s->products = 1;
    s->agreed = 0;
    s->newest = INFINITY;
    return s->estimates == 0 ? 1.0 : bgc_part_noise;
}

/* Ends an estimate. */
bgc_estimate bgc_finish_estimate(bgc_spectrum *s, double radius) {
    s->radius = radius;
    s->products = 0;
    s->estimates++;
    return BGC_ESTIMATED;
}

/* After a product, by which the radius is `newest`, and has changed by `change`. The estimate is complete
 * once it settles, or exceeds `enough` by far. */
bgc_estimate bgc_enter_product(bgc_spectrum *s, double newest, double change, double enough) {
    const int first = s->estimates == 0;
    const double least = fmin(newest, s->newest);

    s->newest = newest;
    s->products++;
    s->agreed = change <= settled_estimate * newest ? s->agreed + 1 : 0;
    if (s->products >= (first ? FIRST_PRODUCTS : LATER_PRODUCTS) ||
        (s->products >= (first ? FEWEST_FIRST : FEWEST_LATER) &&
         (s->agreed >= 2 || least > far_beyond * enough))) {
        return bgc_finish_estimate(s, newest);
    }
    return BGC_ESTIMATING;
}

/* image = M^-1 J v at the present by a difference of f, where |v| = 1; returns whether it is finite. */
static int find_image(const bgc_model *m, bgc_data *d, const double *v, double *image) {
    bgc_find_neighbour(m->n_state, d->x, v, d->point);
    m->rhs(d->h, d->core.t, d->point, d->u_step, image, d->work);
    d->core.counts.rhs++;
    bgc_take_difference(m->n_state, d->f, d->inverse_mass, image);
    return bgc_first_bad(m->n_state, image) < 0;
}

/* The vector of the estimate before, with noise, and its image. */
static bgc_estimate begin_estimate(const bgc_model *m, bgc_data *d) {
    bgc_spectrum *s = &d->core.spectrum;
    double *u = d->direction, norm;

    if (s->estimates == 0) {
        memset(u, 0, (size_t)m->n_state * sizeof *u);
    }
    norm = sqrt(bgc_add_direction_noise(m->n_state, d->scale, bgc_begin_estimate(s), u));
    bgc_scale_direction(m->n_state, u, 1.0 / norm);
    return find_image(m, d, u, d->image) ? BGC_ESTIMATING : bgc_finish_estimate(s, INFINITY);
}

/* After a step from d->x, whose f is d->f: one product of an estimate of the spectral radius there, to
 * know whether it exceeds `enough`; INFINITY where f is not finite nearby. Scratch: d->point, d->right. */
bgc_estimate bgc_continue_estimate(const bgc_model *m, bgc_data *d, double enough) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);
    bgc_spectrum *s = &d->core.spectrum;
    double *u = d->direction, *v = d->image, *w = d->right, norm, newest;

    if (s->products == 0) {
        return begin_estimate(m, d);
    }

    /* The image of the normalised image. */
    norm = sqrt(bgc_multiply_images(n, d->scale, u, v, v).vv);
    if (!(norm > 0.0)) {
        return bgc_finish_estimate(s, 0.0);
    }
    bgc_scale_direction(n, u, 1.0 / norm);
    bgc_scale_direction(n, v, 1.0 / norm);
    if (!find_image(m, d, v, w)) {
        return bgc_finish_estimate(s, INFINITY);
    }
    newest = bgc_larger_of_two(bgc_multiply_images(n, d->scale, u, v, w));
    memcpy(u, v, size);
    memcpy(v, w, size);
    return bgc_enter_product(s, newest, fabs(newest - s->newest), enough);
}
