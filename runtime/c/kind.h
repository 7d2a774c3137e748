/* kind.h: the kind of numbers of a linear system with W = c M - J: real, or complex where BGC_COMPLEX
 * is defined. A source whose name ends in `_kinds.h` includes this header and is included once for
 * each kind.
 *
 * A `bgc_scalar` is a number of that kind; BGC_KIND(name) is the name of an array or function of it:
 * `lu` and `bgc_solve`, `lu_complex` and `bgc_solve_complex`. The Jacobian and the masses are real.
 * Complex arithmetic is written out (complex_numbers.h). The size of a complex number is |re| + |im|.
 * There is no include guard.
 */
#include "complex_numbers.h"
#include "number.h"

#undef bgc_scalar
#undef BGC_KIND
#undef kind_of
#undef kind_zero
#undef kind_re
#undef kind_with_re
#undef kind_size
#undef kind_is_zero
#undef kind_plus
#undef kind_minus
#undef kind_times
#undef kind_scaled
#undef kind_plus_scaled
#undef kind_minus_product
#undef kind_reciprocal
#undef kind_over

#ifdef BGC_COMPLEX

#define bgc_scalar bgc_complex
#define BGC_KIND(name) name##_complex
#define kind_of(c) (c)
#define kind_zero ((bgc_complex){0.0, 0.0})
#define kind_re(a) ((a).re)
#define kind_with_re(a, part) ((bgc_complex){part, (a).im})
#define kind_size(a) bgc_size_of(a)
#define kind_is_zero(a) ((a).re == 0.0 && (a).im == 0.0)
#define kind_plus(a, b) bgc_plus(a, b)
#define kind_minus(a, b) bgc_minus(a, b)
#define kind_times(a, b) bgc_times(a, b)
#define kind_scaled(part, a) bgc_scaled(part, a)
#define kind_plus_scaled(sum, part, a) bgc_plus(sum, bgc_scaled(part, a))
#define kind_minus_product(sum, a, b) bgc_minus(sum, bgc_times(a, b))
#define kind_reciprocal(a) bgc_reciprocal(a)
#define kind_over(a, b) bgc_times(a, bgc_reciprocal(b))

#else

#define bgc_scalar number
#define BGC_KIND(name) name
#define kind_of(c) number_of(c)
#define kind_zero number_of(0.0)
#define kind_re(a) (a)
#define kind_with_re(a, part) (part)
#define kind_size(a) number_fabs(a)
#define kind_is_zero(a) ((a) == 0.0)
#define kind_plus(a, b) ((a) + (b))
#define kind_minus(a, b) ((a) - (b))
#define kind_times(a, b) ((a) * (b))
#define kind_scaled(part, a) ((part) * (a))
#define kind_plus_scaled(sum, part, a) ((sum) + (part) * (a))
#define kind_minus_product(sum, a, b) ((sum) - (a) * (b))
#define kind_reciprocal(a) (1.0 / (a))
#define kind_over(a, b) ((a) / (b))

#endif
