/* sparse.c: elimination over the pattern of W: the real form serves models that are too large for
 * unrolled code, the complex one methods with complex stages. */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

#include "sparse_kinds.h"

#define BGC_COMPLEX
#include "sparse_kinds.h"
#undef BGC_COMPLEX
