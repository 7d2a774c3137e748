/* bgc_device.h: the interface between a haptic device and everything that reads and drives one.
 *
 * A driver is a constant bgc_driver. Drivers of the runtime lie in runtime/c/drivers and are found by
 * their names. A driver of one's own is a shared object that exports
 *
 *     const bgc_driver *bgc_device_driver(void);
 *
 * and is named by its path: `device hand = driver("./mine.so");` in a scene, or `--device hand=./mine.so`.
 * It needs this header alone. Quantities are SI; position, velocity, force and torque are in the axes of
 * the device; force and torque are those that act on the operator's hand.
 *
 * read, write and last_error are called from one thread at a time, at the rate of the servo loop: they
 * allocate nothing, wait for no lock and return well within a period.
 *
 * In real time a driver runs in a process of its own. Where that hangs or ends, another process calls open,
 * write with zero force, and close; so open must succeed again once the first process is gone.
 */
#ifndef BGC_DEVICE_H
#define BGC_DEVICE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface. A driver of another version is refused. */
#define BGC_DEVICE_ABI 2

/* Axes, as bits of `sensed` and `driven`. */
enum {
    BGC_AXIS_X = 1,
    BGC_AXIS_Y = 2,
    BGC_AXIS_Z = 4,
    BGC_TRANSLATIONS = 7,
    BGC_AXIS_A = 8, /* rotation about x */
    BGC_AXIS_B = 16,
    BGC_AXIS_C = 32,
    BGC_ROTATIONS = 56,
    BGC_AXIS_GRIPPER = 64,
    BGC_EVERY_AXIS = 127
};

/* What a call of read or write returns. Any other value, and any negative one, is a fault: the force goes
 * to zero and the run ends. */
enum {
    BGC_DEVICE_FINE = 0,
    BGC_DEVICE_SATURATED = 1, /* a motor gives less than was asked for */
    BGC_DEVICE_NO_NEWS = 2,   /* of read: the pose is the last one known; nothing new has arrived */
    BGC_DEVICE_LOST = -1
};

static inline int bgc_is_fault(int answer) {
    return answer < BGC_DEVICE_FINE || answer > BGC_DEVICE_NO_NEWS;
}

typedef struct {
    double position[3], orientation[4], velocity[3], angular_velocity[3], gripper[1], buttons[8];
    double stamp; /* s, on the device's clock: when this was measured; 0: not known */
    /* N: the force that the hand really held since the pose before, such that its product with the
     * displacement is the work on the hand. It comes set to the force of the last write; only a driver that
     * knows better writes it. */
    double held_force[3];
    /* s, on the device's clock: from the pose that the force held now answers to this pose. 0: not known. A
     * device that answers at once has its own period here. */
    double age;
} bgc_pose;

typedef struct {
    double force[3], torque[3], gripper_force[1];
} bgc_effort;

/* What a device can do; a number that is not known is 0. */
typedef struct {
    uint32_t sensed, driven;       /* bits of axes */
    double max_force;              /* N, of the vector, continuous */
    double max_torque;             /* N m */
    double max_gripper_force;      /* N */
    double workspace_low[3], workspace_high[3]; /* m */
    double resolution;             /* m, of the position */
    double mass;                   /* kg, that the hand feels */
    double slowest, fastest;       /* Hz: rates at which it may be driven */
    int buttons;                   /* their number, at most 8 */
    char model[64];                /* as the maker calls it */
    double damping;                /* N s/m, of its own and of the hand */
    int lag;                       /* samples, at worst, from a pose to the force that answers it */
    int echoes;                    /* 1: held_force is measured at the device */
} bgc_capabilities;

typedef struct {
    uint32_t abi; /* BGC_DEVICE_ABI */
    const char *name;

    /* Opens the device. `options` are lines "key=value" in SI units without the unit. Returns a handle, or
     * NULL with the reason in `message`, of `size` bytes. Force and torque are zero until the first
     * write. May allocate and take its time. */
    void *(*open)(const char *options, char *message, size_t size);

    /* The pose at time t, s of simulated time. It comes set to zero and to the identity quaternion, so
     * that only what the device senses is written. Called once per sample, before write. */
    int (*read)(void *handle, double t, bgc_pose *pose);

    /* Drives the device until the next write. */
    int (*write)(void *handle, double t, const bgc_effort *effort);

    /* Sets the force to zero and releases the device, also after a fault. Called once. */
    void (*close)(void *handle);

    /* Fills what the device can do, which comes set to zero. NULL: six sensed axes without a limit, and
     * forces and torques that are ignored. */
    void (*capabilities)(void *handle, bgc_capabilities *can);

    /* The reason of the last fault, valid until the next call; NULL, or a driver without it: none. */
    const char *(*last_error)(void *handle);
} bgc_driver;

/* What a shared object with a driver exports. */
const bgc_driver *bgc_device_driver(void);

#ifdef __cplusplus
}
#endif
#endif
