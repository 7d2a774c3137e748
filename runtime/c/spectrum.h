/* spectrum.h: power iteration for the spectral radius of M^-1 df/dx, of one instance and of a batch:
 * spectrum.c has the method. Vectors are n states; norms are over the scales of the states.
 */
#ifndef BGC_SPECTRUM_H
#define BGC_SPECTRUM_H

#include "instance.h"
#include "number.h"

#include <float.h>
#include <math.h>

static const double bgc_part_noise = 0.1; /* of the noise in the vector that an estimate begins with */
static const double bgc_nearly_parallel = 1e-10; /* squared sine of the angle between two images */

/* Weighted inner products of the vectors u, v = J u and w = J v. */
typedef struct {
    number uu, uv, vv, uw, vw;
} bgc_images;

static inline bgc_images bgc_multiply_images(int n, const number *scale, const number *u,
                                             const number *v, const number *w) {
    const number none = number_of(0.0);
    bgc_images s = {none, none, none, none, none};

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
static inline number bgc_larger_of_two(bgc_images s) {
    const number none = number_of(0.0);
    const number det = s.vv * s.uu - s.uv * s.uv;
    const number a = (s.vw * s.uu - s.uw * s.uv) / det;
    const number b = (s.uw * s.vv - s.vw * s.uv) / det;
    const number disc = 0.25 * a * a + b;
    const number_mask is_pair = disc < none;
    const number root = number_sqrt(number_select(is_pair, -b, disc));
    const number larger = number_select(is_pair, root, 0.5 * number_fabs(a) + root);

    return number_select(det > bgc_nearly_parallel * s.vv * s.uu, larger, number_sqrt(s.vv / s.uu));
}

/* v += noise in every state, relative to its scale, of norm about 1, times a part: sizes and signs follow
 * low-discrepancy sequences, which begin anew. Returns the squared norm of the sum. */
static inline number bgc_add_direction_noise(int n, const number *scale, double part, number *v) {
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

static inline void bgc_scale_direction(int n, number *v, number factor) {
    for (int i = 0; i < n; i++) {
        v[i] *= factor;
    }
}

/* point = x + v times the length of the difference by which images are found, */
static inline void bgc_find_neighbour(int n, const number *x, const number *v, number *point) {
    const double size = sqrt(DBL_EPSILON);

    for (int i = 0; i < n; i++) {
        point[i] = x[i] + size * v[i];
    }
}

/* and image = M^-1 J v, from f at that point, which is in `image`, and at x. */
static inline void bgc_take_difference(int n, const number *f, const number *inverse_mass,
                                       number *image) {
    const double size = sqrt(DBL_EPSILON);

    for (int i = 0; i < n; i++) {
        image[i] = (image[i] - f[i]) * inverse_mass[i] / size;
    }
}

#endif
