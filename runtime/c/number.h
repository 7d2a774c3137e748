/* number.h: the arithmetic of formulas that serve one instance and a batch of instances alike.
 *
 * A `number` is a double. In a file that defines BGC_IN_LANES it is a lane (bgc_lanes.h): the same
 * quantity of every instance of a batch, and a formula is evaluated for all of them at once.
 */
#ifndef BGC_NUMBER_H
#define BGC_NUMBER_H

#ifdef BGC_IN_LANES

#include "bgc_lanes.h"

typedef lane number;
typedef lane_mask number_mask;
enum { BGC_CHUNK = 1 };

static inline number number_of(double a) { return lane_of(a); }
static inline number number_select(number_mask m, number a, number b) {
    return lane_select(m, a, b);
}
static inline number_mask number_not(number_mask m) { return lane_not(m); }
static inline number number_fabs(number a) { return lane_fabs(a); }
static inline number number_floor(number a) { return lane_floor(a); }
static inline number number_ceil(number a) { return lane_ceil(a); }
static inline number number_sqrt(number a) { return lane_sqrt(a); }

#else

#include <math.h>
#include <stddef.h>

typedef double number;
typedef int number_mask; /* 1 or 0 */
enum { BGC_CHUNK = 8 };

static inline number number_of(double a) { return a; }
static inline number number_select(number_mask m, number a, number b) { return m ? a : b; }
static inline number_mask number_not(number_mask m) { return !m; }
static inline number number_fabs(number a) { return fabs(a); }
static inline number number_floor(number a) { return floor(a); }
static inline number number_ceil(number a) { return ceil(a); }
static inline number number_sqrt(number a) { return sqrt(a); }

#endif

/* Vectors are stored and processed in chunks of so many numbers: loops of fixed length, which
 * compilers vectorise at every level of optimisation. Entries beyond n are zero. */
static inline size_t bgc_chunked(int n) {
    return ((size_t)n + BGC_CHUNK - 1) / BGC_CHUNK * BGC_CHUNK;
}

/* The larger and the smaller of two; the first where the second is undefined. */
static inline number number_larger(number a, number b) { return number_select(b > a, b, a); }
static inline number number_smaller(number a, number b) { return number_select(b < a, b, a); }

static inline number_mask number_is_finite(number a) { return a - a == number_of(0.0); }

#endif
