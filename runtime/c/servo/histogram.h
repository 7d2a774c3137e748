/* histogram.h: times in classes that grow by 1/32 of an octave, from 1 ns to minutes, counted without a lock. */
#ifndef BGC_HISTOGRAM_H
#define BGC_HISTOGRAM_H

#include "servo.h"

#include <math.h>
#include <stdatomic.h>

enum { BGC_CLASSES = 35 * 32 };

typedef struct {
    atomic_int_fast64_t count[BGC_CLASSES];
    atomic_int_fast64_t number, sum, worst; /* ns */
} bgc_histogram;

/* The class of a time: its octave and the five bits below the leading one. */
static inline int bgc_class_of(int64_t ns) {
    int octave = 0;

    if (ns < 32) {
        return ns < 0 ? 0 : (int)ns;
    }
    for (int64_t rest = ns; rest >= 64; rest >>= 1) {
        octave++;
    }
    octave = octave * 32 + (int)(ns >> octave);
    return octave < BGC_CLASSES ? octave : BGC_CLASSES - 1;
}

/* The upper end of a class, ns. */
static inline double bgc_class_end(int k) {
    return k < 64 ? k + 1.0 : ldexp(k % 32 + 33.0, k / 32 - 1);
}

/* By its one writer. */
static inline void bgc_count_time(bgc_histogram *h, int64_t ns) {
    const int64_t time = ns > 0 ? ns : 0;

    atomic_fetch_add_explicit(&h->count[bgc_class_of(time)], 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&h->number, 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&h->sum, time, memory_order_relaxed);
    if (time > atomic_load_explicit(&h->worst, memory_order_relaxed)) {
        atomic_store_explicit(&h->worst, time, memory_order_relaxed);
    }
}

/* The time that a part of all counted times does not exceed, s. */
static inline double bgc_quantile(const bgc_histogram *h, double part) {
    const double number = (double)atomic_load_explicit(&h->number, memory_order_relaxed);
    const double worst = 1e-9 * (double)atomic_load_explicit(&h->worst, memory_order_relaxed);
    double sum = 0.0;

    for (int k = 0; k < BGC_CLASSES; k++) {
        sum += (double)atomic_load_explicit(&h->count[k], memory_order_relaxed);
        if (sum >= part * number && number > 0.0) {
            return fmin(1e-9 * bgc_class_end(k), worst);
        }
    }
    return worst;
}

static inline bgc_servo_times bgc_times_of(const bgc_histogram *h) {
    const double number = (double)atomic_load_explicit(&h->number, memory_order_relaxed);
    const double sum = 1e-9 * (double)atomic_load_explicit(&h->sum, memory_order_relaxed);

    return (bgc_servo_times){number > 0.0 ? sum / number : 0.0, bgc_quantile(h, 0.5),
                             bgc_quantile(h, 0.99), bgc_quantile(h, 0.999), bgc_quantile(h, 1.0)};
}

#endif
