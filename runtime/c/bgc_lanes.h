/* bgc_lanes.h: several instances of a model at once, one in each lane of a vector register: arithmetic,
 * the functions of a model, and runs.
 *
 * A `lane` holds as many doubles as a register of this machine: eight with AVX-512, four with AVX, two
 * otherwise. Where the compiler has no vector types, or BGC_LANES_SCALAR is defined, it is one
 * double.
 */
#ifndef BGC_LANES_H
#define BGC_LANES_H

#include "bgc.h"

#include <math.h>
#include <stdint.h>

#if !defined(BGC_LANES_SCALAR) && (!(defined(__GNUC__) || defined(__clang__)) || defined(__TINYC__))
#define BGC_LANES_SCALAR
#endif

#if defined(BGC_LANES_SCALAR)
enum { BGC_LANE_WIDTH = 1 };
typedef double lane;
typedef int lane_mask;
#elif defined(__AVX512F__)
enum { BGC_LANE_WIDTH = 8 };
#elif defined(__AVX__)
enum { BGC_LANE_WIDTH = 4 };
#else
enum { BGC_LANE_WIDTH = 2 };
#endif

#if defined(BGC_LANES_SCALAR)

static inline lane lane_of(double a) { return a; }
static inline double lane_get(lane a, int l) {
    (void)l;
    return a;
}
static inline void lane_set(lane *a, int l, double value) {
    (void)l;
    *a = value;
}
static inline unsigned lane_bits(lane_mask m) { return m != 0; }
static inline lane_mask lane_not(lane_mask m) { return !m; }
static inline lane lane_select(lane_mask m, lane a, lane b) { return m ? a : b; }
static inline lane lane_fabs(lane a) { return fabs(a); }

#else

typedef double lane __attribute__((vector_size(8 * BGC_LANE_WIDTH)));
typedef int64_t lane_mask __attribute__((vector_size(8 * BGC_LANE_WIDTH))); /* all bits, or 0 */

#define BGC_INLINE static inline __attribute__((always_inline))

BGC_INLINE lane lane_of(double a) { return a - (lane){0.0}; }
BGC_INLINE double lane_get(lane a, int l) { return a[l]; }
BGC_INLINE void lane_set(lane *a, int l, double value) { (*a)[l] = value; }
/* The lanes in which a condition holds, as a set: bit l is lane l. One instruction where the processor
 * has it: steps ask often. */
BGC_INLINE unsigned lane_bits(lane_mask m) {
#if defined(__AVX512DQ__)
    typedef long long words __attribute__((vector_size(64)));
    return (unsigned)__builtin_ia32_cvtq2mask512((words)m);
#elif defined(__AVX__) && !defined(__AVX512F__)
    return (unsigned)__builtin_ia32_movmskpd256((lane)m);
#else
    unsigned found = 0;
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        found |= m[l] != 0 ? 1u << l : 0u;
    }
    return found;
#endif
}
BGC_INLINE lane_mask lane_not(lane_mask m) { return ~m; }
BGC_INLINE lane lane_select(lane_mask m, lane a, lane b) {
    return (lane)((m & (lane_mask)a) | (~m & (lane_mask)b));
}
BGC_INLINE lane lane_fabs(lane a) { return (lane)((lane_mask)a & INT64_MAX); }

#endif

/* A NaN operand gives a NaN, as in the scalar functions of a model. */
static inline lane lane_max(lane a, lane b) { return lane_select((a > b) | (a != a), a, b); }
static inline lane lane_min(lane a, lane b) { return lane_select((a < b) | (a != a), a, b); }
static inline lane lane_sign(lane a) {
    const lane one = lane_of(1.0);

    return lane_select(a > lane_of(0.0), one, lane_select(a < lane_of(0.0), -one, a));
}

/* Conditions are 1 or 0, or NaN where undefined; a choice by a NaN is a NaN. */
static inline lane lane_choose(lane condition, lane yes, lane no) {
    return lane_select(condition == lane_of(0.0), no,
                       lane_select(condition == condition, yes, condition));
}
static inline lane lane_truth(lane_mask is, lane_mask is_not) {
    return lane_select(is, lane_of(1.0), lane_select(is_not, lane_of(0.0), lane_of(NAN)));
}
static inline lane_mask lane_is(lane a) { return (a < lane_of(0.0)) | (a > lane_of(0.0)); }

/* Emitted with the other functions of the language; declared here for the runtime. */
lane lane_sqrt(lane a), lane_floor(lane a), lane_ceil(lane a);

/* The functions of bgc_model that a run calls, for all lanes at once. */
typedef struct {
    int n_work;
    void (*rhs)(const lane *h, lane t, const lane *x, const lane *u, lane *f, lane *w);
    void (*jacobian)(const lane *h, lane t, const lane *x, const lane *u, lane *jac, lane *dfdt,
                     lane *w);
    void (*factor)(const lane *m, const lane *jac, lane c, lane *lu, lane *growth); /* or NULL */
    void (*solve)(const lane *lu, lane *b, lane *w);
    void (*outputs)(const lane *h, lane t, const lane *x, const lane *u, lane *y, lane *w);
    void (*energy)(const lane *h, lane t, const lane *x, const lane *u, lane *out, lane *w);
    void (*switches)(const lane *h, lane t, const lane *x, const lane *u, lane *z, lane *w);
    void (*asserts)(const lane *h, lane t, const lane *x, const lane *u, lane *a, lane *w);
    void (*project)(const lane *h, lane t, lane *x, lane *w); /* or NULL */
    void (*watched)(const lane *h, lane t, const lane *x, const lane *u, lane *z, lane *w);
} bgc_lane_model;

const bgc_lane_model *bgc_get_lane_model(void);

/* --- runs -------------------------------------------------------------------------------- */

int bgc_lane_width(void); /* instances in one batch */

/* Runs up to bgc_lane_width() instances together, each as bgc_run would: all take the same steps. They
 * have been reset to the same time and have the same options. rows[k] are those of instance k. Where a
 * switch of an instance may leave its mode, the instance takes that step by itself. Each has its own
 * devices.
 *
 * Bit k of `finished` is set where instance k has all its rows. An instance for which a step fails, an
 * assertion does not hold or static pivots lose digits leaves the batch, and the others go on; it has
 * to be reset and run by bgc_run. The same holds for all instances where batches do not serve the
 * method or the model. Returns BGC_OK, BGC_INTERRUPTED after bgc_stop of the first instance, or
 * BGC_NO_MEMORY. */
bgc_status bgc_run_lanes(const bgc_model *m, bgc_data *const *instance, int count,
                         const double *times, size_t n, double *const *rows, unsigned *finished);

#endif
