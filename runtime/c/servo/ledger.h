/* ledger.h: the energy that the loop gives to a hand, and what of it the loop itself has created.
 *
 * The loop gives less or another effort than the model asks for: the gain of the ramp, limits of rate and
 * power. A spring that a hand has pressed at half its force, and that pushes back with all of it, gives out
 * energy that nobody has paid. With the effort h that was written, the effort w that the model asked for, within
 * the limits of size, and the displacement dx of the hand until the next pose,
 *
 *     given += h dx,   created += (h - w) dx,   owed = max(owed + (h - w) dx, 0),
 *
 * exact for an effort that is held between two writes. Where several writes lie between two poses, the less
 * favourable of the first and the last counts. No credit is kept. What the hand has received since the force
 * last rose from zero is owed at most: a damper on the device takes it back,
 *
 *     f -= a v,   a = min(due/(T v^2), brake),   due = min(owed, given since then).
 *
 * Steps of a position within its resolution are no motion for the damper. Forces and torques count; the force of
 * a gripper does not.
 */
#ifndef BGC_LEDGER_H
#define BGC_LEDGER_H

#include "servo.h"

#include <math.h>
#include <string.h>

#define BRAKE 30.0      /* N s/m: the largest damping that takes back */
#define LIGHT_HAND 0.25 /* kg: of a device that states no mass */

typedef struct {
    int begun;               /* there is a pose */
    int risen;               /* the gain is above zero */
    bgc_pose pose;           /* the last one with news */
    int fresh;               /* nothing was written since that pose */
    double first[6], last[6]; /* N, N m: written less wanted, by the first and the last write since the pose */
    double written[6];
    double play[3];          /* m: displacement for the damper */
    double resolution, brake; /* m, N s/m; brake 0: nothing is taken back */
    double given, base;      /* J: into the hand since the start, and up to the last rise from zero */
    double created, taken;   /* J: sums of what was created, and of what was taken back of it */
    double owed;             /* J: created - taken */
} bgc_ledger;

/* The damping that a device bears, N s/m. */
static inline double bgc_bearable_brake(const bgc_capabilities *can, double period) {
    const double mass = can->mass > 0.0 ? can->mass : LIGHT_HAND;

    return fmin(BRAKE, mass / (2.0 * period * (can->lag + 0.5)));
}

/* Displacement (m) and rotation (rad, about the axes of the device) from one pose to another. */
static inline void bgc_displacement(const bgc_pose *from, const bgc_pose *to, double moved[6]) {
    const double *p = from->orientation, *q = to->orientation;
    const double scalar = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
    const double vector[3] = {p[0] * q[1] - q[0] * p[1] - q[2] * p[3] + q[3] * p[2],
                              p[0] * q[2] - q[0] * p[2] - q[3] * p[1] + q[1] * p[3],
                              p[0] * q[3] - q[0] * p[3] - q[1] * p[2] + q[2] * p[1]};
    const double sine = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    const double angle = 2.0 * atan2(sine, fabs(scalar));
    const double turn = sine > 0.0 ? (scalar < 0.0 ? -angle : angle) / sine : 0.0;

    for (int k = 0; k < 3; k++) {
        moved[k] = to->position[k] - from->position[k];
        moved[k + 3] = turn * vector[k];
    }
}

static inline double bgc_work(const double effort[6], const double moved[6]) {
    double sum = 0.0;

    for (int k = 0; k < 6; k++) {
        sum += effort[k] * moved[k];
    }
    return sum;
}

/* Books the displacement to a pose with news. */
static inline void bgc_ledger_read(bgc_ledger *l, const bgc_pose *pose) {
    double moved[6], change, before = l->owed;

    if (l->begun) {
        bgc_displacement(&l->pose, pose, moved);
        change = fmax(bgc_work(l->first, moved), bgc_work(l->last, moved));
        l->given += bgc_work(l->written, moved);
        l->created += fmax(change, 0.0);
        l->owed = fmax(l->owed + change, 0.0);
        l->taken += change < 0.0 ? before - l->owed : 0.0;
        for (int k = 0; k < 3; k++) {
            l->play[k] += moved[k];
        }
    }
    l->begun = 1;
    l->fresh = 1;
    l->pose = *pose;
}

/* Books what was written instead of what the model wanted. */
static inline void bgc_ledger_write(bgc_ledger *l, const bgc_effort *given, const bgc_effort *wanted) {
    for (int k = 0; k < 3; k++) {
        l->written[k] = given->force[k];
        l->written[k + 3] = given->torque[k];
        l->last[k] = given->force[k] - wanted->force[k];
        l->last[k + 3] = given->torque[k] - wanted->torque[k];
    }
    if (l->fresh) {
        memcpy(l->first, l->last, sizeof l->first);
        l->fresh = 0;
    }
}

/* What the hand has received and the loop has created, J. */
static inline double bgc_ledger_due(const bgc_ledger *l) {
    return fmax(fmin(l->owed, l->given - l->base), 0.0);
}

/* Adds the force of the damper that takes back what is due. */
static inline void bgc_ledger_brake(bgc_ledger *l, double gain, double period, double force[3]) {
    const double r = sqrt(l->play[0] * l->play[0] + l->play[1] * l->play[1] + l->play[2] * l->play[2]);
    const double part = r > l->resolution ? 1.0 - l->resolution / r : 0.0; /* of the play: motion */
    const double v = part * r / period, due = bgc_ledger_due(l);
    const double damping = v > 0.0 ? fmin(due / (period * v * v), l->brake) : 0.0;

    l->base = gain > 0.0 && !l->risen ? l->given : l->base;
    l->risen = gain > 0.0;
    for (int k = 0; k < 3; k++) {
        force[k] -= gain > 0.0 ? damping * part * l->play[k] / period : 0.0;
        l->play[k] *= 1.0 - part;
    }
}

#endif
