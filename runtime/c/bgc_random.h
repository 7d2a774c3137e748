/* bgc_random.h: random numbers that are functions of a seed and an index, the same on every machine.
 *
 * Counter-based: the number at an index is that of a SplitMix64 sequence at this place, and the start of
 * the sequence is the mixed seed (G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number
 * generators, OOPSLA 2014, with variant 13 of the mixers of D. Stafford).
 * compiler/algebra/random.py computes the same numbers.
 */
#ifndef BGC_RANDOM_H
#define BGC_RANDOM_H

#include <math.h>
#include <stdint.h>

static inline uint64_t bgc_mixed(uint64_t z) {
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

/*
 * A number in [0, 1) with 53 random bits; NaN unless both arguments are whole and below 2^53. The
 * bits are converted as a signed integer: for an unsigned one tcc calls a function of libgcc.
 */
static inline double bgc_random(double seed, double index) {
    const uint64_t step = UINT64_C(0x9E3779B97F4A7C15);
    uint64_t start;

    if (!(fabs(seed) < 0x1p53 && fabs(index) < 0x1p53 && seed == trunc(seed) && index == trunc(index))) {
        return (double)NAN;
    }
    start = bgc_mixed(bgc_mixed((uint64_t)(int64_t)seed + step) + step);
    return (double)(int64_t)(bgc_mixed(start + step * ((uint64_t)(int64_t)index + 1)) >> 11) * 0x1p-53;
}

#endif
