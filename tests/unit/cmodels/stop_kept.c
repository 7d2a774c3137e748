#define KEPT
#include "stop.c"
