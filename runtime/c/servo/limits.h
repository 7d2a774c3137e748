/* limits.h: what the loop lets through of the effort of a model: axes, size, rate, power. */
#ifndef BGC_LIMITS_H
#define BGC_LIMITS_H

#include "servo.h"

#include <math.h>

/* Scales a vector to at most the length `most`; 0: any. Returns whether it did. */
static inline int bgc_clip(double *v, int n, double most) {
    double length = 0.0;

    for (int k = 0; k < n; k++) {
        length += v[k] * v[k];
    }
    length = sqrt(length);
    if (!(most > 0.0) || length <= most) {
        return 0;
    }
    for (int k = 0; k < n; k++) {
        v[k] *= most / length;
    }
    return 1;
}

/* Lets a vector go at most by `most` from the one before. */
static inline int bgc_slew(double *v, const double *before, int n, double most) {
    double change[3] = {0.0};
    int is_cut;

    for (int k = 0; k < n; k++) {
        change[k] = v[k] - before[k];
    }
    is_cut = bgc_clip(change, n, most);
    for (int k = 0; k < n && is_cut; k++) {
        v[k] = before[k] + change[k];
    }
    return is_cut;
}

/* The smaller of two limits, of which 0 is none. */
static inline double bgc_stricter(double a, double b) {
    return a > 0.0 && b > 0.0 ? fmin(a, b) : fmax(a, b);
}

/* The effort that goes to a device: axes without a motor, the gain of the ramp, limits of size, of rate
 * against the effort before, and of the power into the hand. *power is that power, W. Returns whether a
 * limit acted. */
static inline int bgc_limit_effort(const bgc_servo_options *o, const bgc_capabilities *can,
                                   const bgc_pose *pose, const bgc_effort *before, double gain,
                                   bgc_effort *e, double *power) {
    const double force_step = o->max_force_rate * o->period;
    int acted = 0;

    for (int k = 0; k < 3; k++) {
        e->force[k] = (can->driven >> k & 1u) != 0 ? gain * e->force[k] : 0.0;
        e->torque[k] = (can->driven >> (k + 3) & 1u) != 0 ? gain * e->torque[k] : 0.0;
    }
    e->gripper_force[0] = (can->driven & BGC_AXIS_GRIPPER) != 0 ? gain * e->gripper_force[0] : 0.0;

    acted |= bgc_clip(e->force, 3, bgc_stricter(o->max_force, can->max_force));
    acted |= bgc_clip(e->torque, 3, bgc_stricter(o->max_torque, can->max_torque));
    acted |= bgc_clip(e->gripper_force, 1,
                      bgc_stricter(o->max_gripper_force, can->max_gripper_force));
    acted |= bgc_slew(e->force, before->force, 3, force_step);
    acted |= bgc_slew(e->torque, before->torque, 3, force_step);
    acted |= bgc_slew(e->gripper_force, before->gripper_force, 1, force_step);

    *power = 0.0;
    for (int k = 0; k < 3; k++) {
        *power += e->force[k] * pose->velocity[k] + e->torque[k] * pose->angular_velocity[k];
    }
    if (o->max_power > 0.0 && *power > o->max_power) {
        for (int k = 0; k < 3; k++) {
            e->force[k] *= o->max_power / *power;
            e->torque[k] *= o->max_power / *power;
        }
        *power = o->max_power;
        acted = 1;
    }
    return acted;
}

#endif
