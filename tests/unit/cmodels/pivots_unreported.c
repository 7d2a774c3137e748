/* pivots.c with a factorisation that does not notice what it loses. */
#define REPORTED(growth) ((void)(growth), 1.0)
#include "pivots.c"
