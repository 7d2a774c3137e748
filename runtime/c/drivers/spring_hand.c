/* spring_hand.c: the driver `spring_hand`: a simulated hand that holds the handle. The handle, a mass with a
 * damper, is pulled by a spring to where the hand wants it, and by the force of the loop:
 *
 *     m x'' + b x' + k (x - w(t)) = F + push,   w = amplitude sin(2 pi frequency t) along one axis, 0 along others
 *
 * in simulated time, F held between samples. So a scene closes its loop through a hand without hardware.
 * Options: mass=0.3 (kg), damping=3 (N s/m), stiffness=150 (N/m), amplitude=0.05 (m), frequency=0.3 (Hz),
 * axis=1, 2 or 3 (1), push=0 (N) and start=0 (m) along the axis, resolution=0 (m) of the position that it
 * gives. Each interval is integrated by the classical Runge-Kutta method in steps of at most
 * 1/40 of the period of the hand's own swing.
 */
#include "bgc_internal.h"
#include "drivers/options.h"

#include <math.h>
#include <stdio.h>

typedef struct {
    double mass, damping, stiffness, amplitude, rate; /* rate: rad/s */
    double push, resolution;
    int axis;                                         /* 0 to 2 */
    double time, longest;                             /* s: now, and the longest step */
    double position[3], velocity[3], force[3];
} spring_hand;

static void *hand_open(const char *options, char *message, size_t size) {
    spring_hand *h = calloc(1, sizeof *h);

    if (h == NULL) {
        snprintf(message, size, "spring_hand: there is not enough memory");
        return NULL;
    }
    h->mass = bgc_number_option(options, "mass", 0.3);
    h->damping = bgc_number_option(options, "damping", 3.0);
    h->stiffness = bgc_number_option(options, "stiffness", 150.0);
    h->amplitude = bgc_number_option(options, "amplitude", 0.05);
    h->rate = 6.283185307179586 * bgc_number_option(options, "frequency", 0.3);
    h->push = bgc_number_option(options, "push", 0.0);
    h->resolution = bgc_number_option(options, "resolution", 0.0);
    h->axis = (int)bgc_number_option(options, "axis", 1.0) - 1;
    if (!(h->mass > 0.0) || !(h->damping >= 0.0) || !(h->stiffness >= 0.0) ||
        !(h->resolution >= 0.0) || !isfinite(h->mass + h->damping + h->stiffness + h->amplitude + h->rate) ||
        !isfinite(h->push + h->resolution + bgc_number_option(options, "start", 0.0))) {
        snprintf(message, size,
                 "spring_hand: mass must be positive, damping, stiffness and resolution not negative");
    } else if (h->axis < 0 || h->axis > 2) {
        snprintf(message, size, "spring_hand: axis must be 1, 2 or 3");
    } else {
        h->position[h->axis] = bgc_number_option(options, "start", 0.0);
        h->longest = 0.025 * 6.28 / (sqrt(h->stiffness / h->mass) + h->damping / h->mass + h->rate + 1.0);
        return h;
    }
    free(h);
    return NULL;
}

/* The acceleration along axis k. */
static double hand_acceleration(const spring_hand *h, int k, double t, double x, double v) {
    const double wanted = k == h->axis ? h->amplitude * sin(h->rate * t) : 0.0;
    const double push = k == h->axis ? h->push : 0.0;

    return (h->force[k] + push - h->damping * v - h->stiffness * (x - wanted)) / h->mass;
}

/* A Runge-Kutta step of axis k from time t. */
static void hand_step(spring_hand *h, int k, double t, double step) {
    const double x = h->position[k], v = h->velocity[k], half = 0.5 * step;
    const double a1 = hand_acceleration(h, k, t, x, v);
    const double v2 = v + half * a1;
    const double a2 = hand_acceleration(h, k, t + half, x + half * v, v2);
    const double v3 = v + half * a2;
    const double a3 = hand_acceleration(h, k, t + half, x + half * v2, v3);
    const double v4 = v + step * a3;
    const double a4 = hand_acceleration(h, k, t + step, x + step * v3, v4);

    h->position[k] = x + step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    h->velocity[k] = v + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
}

static int hand_read(void *handle, double t, bgc_pose *pose) {
    spring_hand *h = handle;
    const double span = t - h->time;
    const int steps = span > 0.0 ? (int)ceil(span / h->longest) : 0;

    for (int i = 0; i < steps; i++) {
        for (int k = 0; k < 3; k++) {
            hand_step(h, k, h->time + i * span / steps, span / steps);
        }
    }
    h->time = t;
    for (int k = 0; k < 3; k++) {
        pose->position[k] = h->resolution > 0.0 ? round(h->position[k] / h->resolution) * h->resolution
                                                : h->position[k];
    }
    memcpy(pose->velocity, h->velocity, sizeof h->velocity);
    return BGC_DEVICE_FINE;
}

static int hand_write(void *handle, double t, const bgc_effort *effort) {
    spring_hand *h = handle;

    (void)t;
    memcpy(h->force, effort->force, sizeof h->force);
    return BGC_DEVICE_FINE;
}

static void hand_close(void *handle) { free(handle); }

static void hand_capabilities(void *handle, bgc_capabilities *can) {
    can->sensed = can->driven = BGC_TRANSLATIONS;
    can->mass = ((const spring_hand *)handle)->mass;
    can->damping = ((const spring_hand *)handle)->damping;
    can->resolution = ((const spring_hand *)handle)->resolution;
    snprintf(can->model, sizeof can->model, "a simulated hand");
}

const bgc_driver bgc_spring_hand_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "spring_hand",
    .open = hand_open,
    .read = hand_read,
    .write = hand_write,
    .close = hand_close,
    .capabilities = hand_capabilities,
};
