#define UNLOCATED
#include "stop.c"
