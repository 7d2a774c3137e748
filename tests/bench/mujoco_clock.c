/* mujoco_clock.c: seconds a call of mj_forward and of mj_step. */
#include "clock.h"

#include <mujoco/mujoco.h>

/* seconds: mj_forward, mj_step; the least of several batches, from the state at hand. */
void mujoco_seconds(const mjModel *m, mjData *d, int calls, int batches, double seconds[2]) {
    const mjtNum angle = d->qpos[m->nq - 1];

    seconds[0] = seconds[1] = 1e9;
    for (int batch = 0; batch < batches; batch++) {
        double start = clock_now(), each;
        for (int k = 0; k < calls; k++) {
            d->qpos[m->nq - 1] = angle + 1e-12 * k;
            mj_forward(m, d);
        }
        each = (clock_now() - start) / calls;
        seconds[0] = each < seconds[0] ? each : seconds[0];
    }
    for (int batch = 0; batch < batches; batch++) {
        double start = clock_now(), each;
        for (int k = 0; k < calls; k++) {
            mj_step(m, d);
        }
        each = (clock_now() - start) / calls;
        seconds[1] = each < seconds[1] ? each : seconds[1];
    }
}
