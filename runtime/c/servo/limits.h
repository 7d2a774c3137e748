/* limits.h: what the loop lets through of the effort of a model: axes, size, rate, power. */
#ifndef BGC_LIMITS_H
#define BGC_LIMITS_H

#include "ledger.h"

#define FULL_RISE 5e-3    /* s: in which an effort reaches its full size, where no rate is given */
#define USUAL_RATE 2400.0 /* N/s, N m/s: where no size is known either */

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

/* The fastest change of an effort of a size, N/s or N m/s; 0: any. */
static inline double bgc_rate_of(const bgc_servo_options *o, double size) {
    return o->max_force_rate >= 0.0 ? o->max_force_rate : size > 0.0 ? size / FULL_RISE : USUAL_RATE;
}

/* An effort without the axes that have no motor, within its sizes. Returns whether a size was cut. */
static inline int bgc_limit_size(const bgc_capabilities *can, const double size[3], bgc_effort *e) {
    for (int k = 0; k < 3; k++) {
        e->force[k] = (can->driven >> k & 1u) != 0 ? e->force[k] : 0.0;
        e->torque[k] = (can->driven >> (k + 3) & 1u) != 0 ? e->torque[k] : 0.0;
    }
    e->gripper_force[0] = (can->driven & BGC_AXIS_GRIPPER) != 0 ? e->gripper_force[0] : 0.0;
    return bgc_clip(e->force, 3, size[0]) | bgc_clip(e->torque, 3, size[1]) |
           bgc_clip(e->gripper_force, 1, size[2]);
}

/* The effort that goes to a device, in *e, which comes with that of the model: the gain of the ramp, less the
 * damping of the ledger, within the limits of size, of rate against the effort before, and of the power into
 * the hand; zero at once for a device that `is_free`. *power is that power, W. Books the difference to the
 * model's. Returns whether a limit acted. */
static inline int bgc_limit_effort(const bgc_servo_options *o, const bgc_capabilities *can,
                                   const bgc_pose *pose, const bgc_effort *before, double gain,
                                   int is_free, bgc_ledger *ledger, bgc_effort *e, double *power) {
    const double size[3] = {bgc_stricter(o->max_force, can->max_force),
                            bgc_stricter(o->max_torque, can->max_torque),
                            bgc_stricter(o->max_gripper_force, can->max_gripper_force)};
    bgc_effort wanted = *e;
    int acted;

    bgc_limit_size(can, size, &wanted);
    for (int k = 0; k < 3; k++) {
        e->force[k] *= gain;
        e->torque[k] *= gain;
    }
    e->gripper_force[0] *= gain;
    bgc_ledger_brake(ledger, gain, o->period, e->force);
    acted = bgc_limit_size(can, size, e);
    if (!is_free) {
        acted |= bgc_slew(e->force, before->force, 3, bgc_rate_of(o, size[0]) * o->period);
        acted |= bgc_slew(e->torque, before->torque, 3, bgc_rate_of(o, size[1]) * o->period);
        acted |= bgc_slew(e->gripper_force, before->gripper_force, 1, bgc_rate_of(o, size[2]) * o->period);
    }

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
    bgc_ledger_write(ledger, e, &wanted);
    return acted;
}

#endif
