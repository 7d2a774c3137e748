/* poses.h: which poses of a device the loop takes: finite ones, and of a device with motors plausible ones. */
#ifndef BGC_POSES_H
#define BGC_POSES_H

#include "ledger.h"

#include <stdio.h>

#define UNKNOWN_REACH 10.0 /* m: from the origin, of a device that states no workspace */

/* Whether all numbers of a pose are finite; its quaternion becomes a unit one, of the two the one nearer to
 * that before. */
static inline int bgc_make_valid(bgc_pose *pose, const bgc_pose *before) {
    double values[BGC_POSE_SIZE], length = 0.0, sum = 0.0, dot = 0.0;

    memcpy(values, pose, sizeof values);
    for (int k = 0; k < BGC_POSE_SIZE; k++) {
        sum += 0.0 * values[k];
    }
    for (int k = 0; k < 4; k++) {
        length += pose->orientation[k] * pose->orientation[k];
        dot += pose->orientation[k] * before->orientation[k];
    }
    if (sum != 0.0 || !(length > 0.0) || !isfinite(length)) {
        return 0;
    }
    length = sqrt(length);
    length = fabs(length - 1.0) > 1e-12 ? length : 1.0;
    for (int k = 0; k < 4; k++) {
        pose->orientation[k] /= dot < 0.0 ? -length : length;
    }
    return 1;
}

static inline double bgc_length(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/* The distance of a position from the workspace that a device states, m. */
static inline double bgc_outside(const bgc_capabilities *can, const double position[3]) {
    double beyond[3];

    for (int k = 0; k < 3; k++) {
        const int known = can->workspace_low[k] < can->workspace_high[k];
        const double low = known ? can->workspace_low[k] : -UNKNOWN_REACH;
        const double high = known ? can->workspace_high[k] : UNKNOWN_REACH;
        beyond[k] = fmax(fmax(low - position[k], position[k] - high), 0.0);
    }
    return bgc_length(beyond);
}

/* Whether a hand can have this pose, `elapsed` seconds after the one before, which is NULL for the first; or
 * the reason why not. *speed is that of the displacement, m/s. */
static inline int bgc_is_plausible(const bgc_servo_options *o, const bgc_capabilities *can, const bgc_pose *pose,
                                   const bgc_pose *before, double elapsed, double *speed, char *why,
                                   size_t size) {
    const double outside = bgc_outside(can, pose->position);
    double moved[6] = {0.0}, path, turn;

    *speed = 0.0;
    if (o->workspace_margin > 0.0 && outside > o->workspace_margin) {
        snprintf(why, size, "%.3g m outside its workspace", outside);
        return 0;
    }
    if (before != NULL) {
        bgc_displacement(before, pose, moved);
    }
    path = fmax(bgc_length(moved) - 2.0 * can->resolution, 0.0);
    turn = bgc_length(moved + 3);
    *speed = path / elapsed;
    if (o->max_speed > 0.0 && *speed > o->max_speed) {
        snprintf(why, size, "%.3g m in %.3g ms", path, 1e3 * elapsed);
    } else if (o->max_speed > 0.0 && bgc_length(pose->velocity) > o->max_speed) {
        snprintf(why, size, "a velocity of %.3g m/s", bgc_length(pose->velocity));
    } else if (o->max_turn_rate > 0.0 && turn > o->max_turn_rate * elapsed) {
        snprintf(why, size, "a turn of %.3g rad in %.3g ms", turn, 1e3 * elapsed);
    } else if (o->max_turn_rate > 0.0 && bgc_length(pose->angular_velocity) > o->max_turn_rate) {
        snprintf(why, size, "a turn rate of %.3g rad/s", bgc_length(pose->angular_velocity));
    } else {
        return 1;
    }
    return 0;
}

#endif
