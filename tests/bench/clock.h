/* clock.h: what the C programs of the benchmarks share. */
#ifndef CLOCK_H
#define CLOCK_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#endif

#include "bgc.h"

double clock_now(void);
void clock_kernels(const bgc_model *m, const double *p, const double *x0, const double *u, double t,
                   int calls, int batches, double seconds[4]);

#endif
