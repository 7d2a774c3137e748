/* The masses of springs.c, whose explicit step costs more than half of an implicit one. */
#define COST 0.58
#include "springs.c"
