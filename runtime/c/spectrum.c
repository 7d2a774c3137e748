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

#include <float.h>
#include <math.h>
#include <string.h>

enum { FIRST_PRODUCTS = 20, LATER_PRODUCTS = 10 }; /* most of an estimate */
enum { FEWEST_FIRST = 6, FEWEST_LATER = 3 };       /* and fewest */
static const double settled_estimate = 0.05;    /* relative change of the estimate in one product */
static const double part_noise = 0.1;  /* of the noise in the vector that an estimate begins with */
static const double nearly_parallel = 1e-10; /* squared sine of the angle between a vector and its image */
static const double far_beyond = 4.0;      /* an estimate that exceeds what is asked by this need not settle */

/* At the start of a run: no estimate. */
void bgc_reset_radius(bgc_data *d) {
    d->core.spectral_radius = INFINITY;
    d->core.products = d->core.estimates = 0;
}

/* Weighted inner products of the vectors u, v = J u and w = J v. */
typedef struct {
    double uu, uv, vv, uw, vw;
} bgc_images;

static bgc_images multiply_images(const bgc_model *m, const bgc_data *d, const double *u, const double *v,
                             const double *w) {
    bgc_images s = {0};

    for (int i = 0; i < m->n_state; i++) {
        const double unit = 1.0 / (d->scale[i] * d->scale[i]);
        s.uu += u[i] * u[i] * unit;
        s.uv += u[i] * v[i] * unit;
        s.vv += v[i] * v[i] * unit;
        s.uw += u[i] * w[i] * unit;
        s.vw += v[i] * w[i] * unit;
    }
    return s;
}

/* The larger root of lambda^2 = a lambda + b, where w is projected on a v + b u. */
static double larger_of_two(bgc_images s) {
    const double det = s.vv * s.uu - s.uv * s.uv;
    double a, b, disc;

    if (!(det > nearly_parallel * s.vv * s.uu)) {
        return sqrt(s.vv / s.uu);
    }
    a = (s.vw * s.uu - s.uw * s.uv) / det;
    b = (s.uw * s.vv - s.vw * s.uv) / det;
    disc = 0.25 * a * a + b;
    return disc < 0.0 ? sqrt(-b) : 0.5 * fabs(a) + sqrt(disc);
}

/* image = M^-1 J v at the present by a difference of f, where |v| = 1; returns whether it is finite. */
static int find_image(const bgc_model *m, bgc_data *d, const double *v, double *image) {
    const double size = sqrt(DBL_EPSILON);

    for (int i = 0; i < m->n_state; i++) {
        d->point[i] = d->x[i] + size * v[i];
    }
    m->rhs(d->h, d->core.t, d->point, d->u_step, image, d->work);
    d->core.counts.rhs++;
    for (int i = 0; i < m->n_state; i++) {
        image[i] = (image[i] - d->f[i]) * d->inverse_mass[i] / size;
    }
    return bgc_first_bad(m->n_state, image) < 0;
}

static void scale_direction(int n, double *v, double factor) {
    for (int i = 0; i < n; i++) {
        v[i] *= factor;
    }
}

/* Noise in every state, relative to its scale, of norm about 1: sizes and signs follow low-discrepancy
 * sequences, which begin anew. Returns the squared norm of the sum. */
static double add_direction_noise(const bgc_model *m, const bgc_data *d, double part, double *v) {
    const double size_stride = 0.6180339887498949, sign_stride = 0.7548776662466927;
    const double factor = part / sqrt((double)m->n_state);
    double size = 0.0, sign = 0.0, sum = 0.0;

    for (int i = 0; i < m->n_state; i++) {
        const double off = (0.5 + size) * factor * d->scale[i];
        v[i] += sign < 0.5 ? off : -off;
        sum += v[i] * v[i] / (d->scale[i] * d->scale[i]);
        size = fmod(size + size_stride, 1.0);
        sign = fmod(sign + sign_stride, 1.0);
    }
    return sum;
}

/* Ends an estimate. */
static bgc_estimate finish_estimate(bgc_core *core, double radius) {
    core->spectral_radius = radius;
    core->products = 0;
    core->estimates++;
    return BGC_ESTIMATED;
}

/* Begins an estimate by the vector of the one before, with noise, and its image. */
static bgc_estimate begin_estimate(const bgc_model *m, bgc_data *d) {
    const int first = d->core.estimates == 0;
    const size_t size = (size_t)m->n_state * sizeof(double);
    double *u = d->direction, norm;

    if (first) {
        memset(u, 0, size);
    }
    norm = sqrt(add_direction_noise(m, d, first ? 1.0 : part_noise, u));
    scale_direction(m->n_state, u, 1.0 / norm);
    d->core.products = 1;
    d->core.agreed = 0;
    d->core.newest = INFINITY;
    return find_image(m, d, u, d->image) ? BGC_ESTIMATING : finish_estimate(&d->core, INFINITY);
}

/* After a step from d->x, whose f is d->f: one product of an estimate of the spectral radius there. The
 * estimate is complete once it settles, or exceeds `enough` by far; INFINITY where f is not finite nearby.
 * Scratch: d->point, d->right. */
bgc_estimate bgc_continue_estimate(const bgc_model *m, bgc_data *d, double enough) {
    const int n = m->n_state;
    const size_t size = (size_t)n * sizeof(double);
    bgc_core *core = &d->core;
    const int first = core->estimates == 0;
    double *u = d->direction, *v = d->image, *w = d->right, norm, before;

    if (core->products == 0) {
        return begin_estimate(m, d);
    }

    /* The image of the normalised image. */
    norm = sqrt(multiply_images(m, d, u, v, v).vv);
    if (!(norm > 0.0)) {
        return finish_estimate(core, 0.0);
    }
    scale_direction(n, u, 1.0 / norm);
    scale_direction(n, v, 1.0 / norm);
    if (!find_image(m, d, v, w)) {
        return finish_estimate(core, INFINITY);
    }
    before = core->newest;
    core->newest = larger_of_two(multiply_images(m, d, u, v, w));
    core->products++;
    core->agreed = fabs(core->newest - before) <= settled_estimate * core->newest ? core->agreed + 1 : 0;
    memcpy(u, v, size);
    memcpy(v, w, size);
    if (core->products >= (first ? FIRST_PRODUCTS : LATER_PRODUCTS) ||
        (core->products >= (first ? FEWEST_FIRST : FEWEST_LATER) &&
         (core->agreed >= 2 || fmin(core->newest, before) > far_beyond * enough))) {
        return finish_estimate(core, core->newest);
    }
    return BGC_ESTIMATING;
}

/* A whole estimate. */
double bgc_estimate_radius(const bgc_model *m, bgc_data *d, double enough) {
    d->core.products = 0;
    while (bgc_continue_estimate(m, d, enough) == BGC_ESTIMATING) {
    }
    return d->core.spectral_radius;
}
