/* spectrum.c: an estimate of the spectral radius of M^-1 df/dx along a run.
 *
 * Power iteration by differences of f: it needs no Jacobian, so that explicit steps have it too,
 * and a product costs one evaluation of f. Two images of a vector give the two dominant
 * eigenvalues, real or a conjugate pair, by Rayleigh-Ritz projection: Y. Saad, Numerical Methods
 * for Large Eigenvalue Problems, 4.1 and 6.2. The vector is kept from one estimate to the next,
 * with some noise added, so that later estimates need few products and find a mode that has become
 * dominant since. Fixed steps take one product at a time, so that none is much longer than the
 * others.
 */
#include "bgc_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { FIRST_PRODUCTS = 20, LATER_PRODUCTS = 10 }; /* most of an estimate */
enum { FEWEST_FIRST = 6, FEWEST_LATER = 3 };       /* and fewest */
static const double settled_estimate = 0.05; /* relative change of the estimate in one product */
static const double far_beyond = 4.0;        /* an estimate that exceeds what is asked by this need not settle */

static const double part_noise = 0.1; /* of the noise in the vector that an estimate begins with */
static const double nearly_parallel = 1e-10; /* squared sine of the angle between two images */

/* Weighted inner products of the vectors u, v = J u and w = J v. */
typedef struct {
    number uu, uv, vv, uw, vw;
} images;

static images multiply_images(int n, const number *scale, const number *u,
                                             const number *v, const number *w) {
    const number none = number_of(0.0);
    images s = {none, none, none, none, none};

    for (int i = 0; i < n; i++) {
        const number unit = 1.0 / (scale[i] * scale[i]);
        s.uu += u[i] * u[i] * unit;
        s.uv += u[i] * v[i] * unit;
        s.vv += v[i] * v[i] * unit;
        s.uw += u[i] * w[i] * unit;
        s.vw += v[i] * w[i] * unit;
    }
    return s;
}

/* The larger root of lambda^2 = a lambda + b, where w is projected on a v + b u. */
static number larger_of_two(images s) {
    const number none = number_of(0.0);
    const number det = s.vv * s.uu - s.uv * s.uv;
    const number a = (s.vw * s.uu - s.uw * s.uv) / det;
    const number b = (s.uw * s.vv - s.vw * s.uv) / det;
    const number disc = 0.25 * a * a + b;
    const number_mask is_pair = disc < none;
    const number root = number_sqrt(number_select(is_pair, -b, disc));
    const number larger = number_select(is_pair, root, 0.5 * number_fabs(a) + root);

    return number_select(det > nearly_parallel * s.vv * s.uu, larger, number_sqrt(s.vv / s.uu));
}

/* v += noise in every state, relative to its scale, of norm about 1, times a part: sizes and signs
 * follow low-discrepancy sequences, which begin anew. Returns the squared norm of the sum. */
static number add_direction_noise(int n, const number *scale, double part, number *v) {
    const double size_stride = 0.6180339887498949, sign_stride = 0.7548776662466927;
    const double factor = part / sqrt((double)n);
    double size = 0.0, sign = 0.0;
    number sum = number_of(0.0);

    for (int i = 0; i < n; i++) {
        const number off = (0.5 + size) * factor * scale[i];
        v[i] += sign < 0.5 ? off : -off;
        sum += v[i] * v[i] / (scale[i] * scale[i]);
        size = fmod(size + size_stride, 1.0);
        sign = fmod(sign + sign_stride, 1.0);
    }
    return sum;
}

static void scale_direction(int n, number *v, number factor) {
    for (int i = 0; i < n; i++) {
        v[i] *= factor;
    }
}

/* point = x + v times the length of the difference by which images are found, */
static void find_neighbour(int n, const number *x, const number *v, number *point) {
    const double size = sqrt(DBL_EPSILON);

    for (int i = 0; i < n; i++) {
        point[i] = x[i] + size * v[i];
    }
}

/* and image = M^-1 J v, from f at that point, which is in `image`, and at x. */
static void take_difference(int n, const number *f, const number *inverse_mass,
                                       number *image) {
    const double size = sqrt(DBL_EPSILON);

    for (int i = 0; i < n; i++) {
        image[i] = (image[i] - f[i]) * inverse_mass[i] / size;
    }
}

/* Begins an estimate; returns the part of noise in its vector. The first is noise alone. */
static double begin_estimate(bgc_spectrum *s) {
    s->products = 1;
    s->agreed = 0;
    s->newest = INFINITY;
    return s->estimates == 0 ? 1.0 : part_noise;
}

/* Ends an estimate. */
static bgc_estimate finish_estimate(bgc_spectrum *s, double radius) {
    s->radius = radius;
    s->products = 0;
    s->estimates++;
    return BGC_ESTIMATED;
}

/* After a product, by which the radius is `newest`, and has changed by `change`. The estimate is
 * complete once it settles, or exceeds `enough` by far. */
static bgc_estimate enter_product(bgc_spectrum *s, double newest, double change, double enough) {
    const int first = s->estimates == 0;
    const double least = fmin(newest, s->newest);

    s->newest = newest;
    s->products++;
    s->agreed = change <= settled_estimate * newest ? s->agreed + 1 : 0;
    if (s->products >= (first ? FIRST_PRODUCTS : LATER_PRODUCTS) ||
        (s->products >= (first ? FEWEST_FIRST : FEWEST_LATER) &&
         (s->agreed >= 2 || least > far_beyond * enough))) {
        return finish_estimate(s, newest);
    }
    return BGC_ESTIMATING;
}

/* image = M^-1 J v at the start of the step under way by a difference of f, where |v| = 1; returns
 * whether it is finite. */
static int find_image(const bgc_model *m, bgc_ivp *d, const number *v, number *image) {
    find_neighbour(m->n_state, d->x, v, d->point);
    bgc_functions(m, d)->rhs(d->h, number_of(d->core.t), d->point, d->u_step, image, d->work);
    d->core.counts.rhs++;
    take_difference(m->n_state, d->f, d->inverse_mass, image);
    return bgc_is_finite(d, m->n_state, image);
}

/* 1 / norm; 0 where the norm vanishes: that instance of a batch has no part in the estimate. */
static number inverse_or_zero(number norm) {
    return number_select(norm > number_of(0.0), 1.0 / norm, number_of(0.0));
}

/* The vector of the estimate before, with noise, and its image. */
static bgc_estimate begin_with_noise(const bgc_model *m, bgc_ivp *d) {
    bgc_spectrum *s = &d->core.spectrum;
    number *u = d->direction, norm;

    if (s->estimates == 0) {
        memset(u, 0, (size_t)m->n_state * sizeof *u);
    }
    norm = number_sqrt(add_direction_noise(m->n_state, d->scale, begin_estimate(s), u));
    scale_direction(m->n_state, u, inverse_or_zero(norm));
    *bgc_newest_radius(d) = number_of(INFINITY);
    return find_image(m, d, u, d->image) ? BGC_ESTIMATING : finish_estimate(s, INFINITY);
}

/* After a step from d->x, whose f is d->f: one product of an estimate of the spectral radius there,
 * to know whether it exceeds `enough`; INFINITY where f is not finite nearby. Of a batch, the
 * largest radius. Scratch: d->point, d->right. */
bgc_estimate bgc_continue_estimate(const bgc_model *m, bgc_ivp *d, double enough) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(number);
    bgc_spectrum *s = &d->core.spectrum;
    number *u = d->direction, *v = d->image, *w = d->right, norm, factor, newest, change;
    bgc_estimate found;

    if (s->products == 0) {
        return begin_with_noise(m, d);
    }

    /* The image of the normalised image. */
    norm = number_sqrt(multiply_images(n, d->scale, u, v, v).vv);
    if (!bgc_holds_in_any(d, norm > number_of(0.0))) {
        return finish_estimate(s, 0.0);
    }
    factor = inverse_or_zero(norm);
    scale_direction(n, u, factor);
    scale_direction(n, v, factor);
    if (!find_image(m, d, v, w)) {
        return finish_estimate(s, INFINITY);
    }

    /* The radius by both images. */
    newest = number_select(norm > number_of(0.0),
                           larger_of_two(multiply_images(n, d->scale, u, v, w)), number_of(0.0));
    change = number_fabs(newest - *bgc_newest_radius(d));
    memcpy(u, v, size);
    memcpy(v, w, size);
    found = enter_product(s, bgc_largest(d, newest), bgc_largest(d, change), enough);
    *bgc_newest_radius(d) = newest;
    return found;
}
