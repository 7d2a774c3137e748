/* mine.c: a driver of one's own: a handle that swings by itself along x and whose motor feels the force.
 *
 * `make`, then `bgc run scene.bg --device hand=./mine.so`. Replace swing() by the calls of the device's
 * library. Options: amplitude=0.05 (m), frequency=0.5 (Hz).
 */
#include "bgc_device.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double amplitude, frequency; /* m, Hz */
    double force[3];             /* N: the last one that was written */
} handle;

static void *open_mine(const char *options, char *message, size_t size) {
    handle *h = calloc(1, sizeof *h);
    const char *amplitude = strstr(options, "amplitude="), *frequency = strstr(options, "frequency=");

    if (h == NULL) {
        snprintf(message, size, "there is not enough memory");
        return NULL;
    }
    h->amplitude = amplitude != NULL ? atof(amplitude + strlen("amplitude=")) : 0.05;
    h->frequency = frequency != NULL ? atof(frequency + strlen("frequency=")) : 0.5;
    return h;
}

static int read_mine(void *handle_of, double t, bgc_pose *pose) {
    const handle *h = handle_of;
    const double rate = 2.0 * 3.14159265358979323846 * h->frequency;

    pose->position[0] = h->amplitude * sin(rate * t);
    pose->velocity[0] = h->amplitude * rate * cos(rate * t);
    pose->stamp = t;
    return BGC_DEVICE_FINE; /* BGC_DEVICE_LOST where the device does not answer */
}

static int write_mine(void *handle_of, double t, const bgc_effort *effort) {
    (void)t;
    memcpy(((handle *)handle_of)->force, effort->force, sizeof effort->force);
    return BGC_DEVICE_FINE;
}

static void close_mine(void *handle_of) { free(handle_of); }

static void capabilities_of_mine(void *handle_of, bgc_capabilities *can) {
    (void)handle_of;
    can->sensed = can->driven = BGC_TRANSLATIONS;
    can->max_force = 10.0;
    snprintf(can->model, sizeof can->model, "a swinging handle");
}

const bgc_driver *bgc_device_driver(void) {
    static const bgc_driver driver = {
        .abi = BGC_DEVICE_ABI, .name = "mine", .open = open_mine, .read = read_mine, .write = write_mine,
        .close = close_mine, .capabilities = capabilities_of_mine};

    return &driver;
}
