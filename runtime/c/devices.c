/* devices.c: inputs from haptic devices and commands to them. Forces are set to zero on a fault, after
 * a failed run, and when a device is closed. */
#include "bgc_internal.h"
#include "drivers/drivers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define DECLARED(driver) extern const bgc_driver driver;
BGC_DRIVERS(DECLARED)

#define LISTED(driver) &driver,
static const bgc_driver *const drivers[] = {BGC_DRIVERS(LISTED)};

const bgc_driver *bgc_find_driver(const char *name) {
    for (size_t k = 0; k < sizeof drivers / sizeof *drivers; k++) {
        if (strcmp(drivers[k]->name, name) == 0) {
            return drivers[k];
        }
    }
    return NULL;
}

/* A pose at rest in the middle of the workspace, for a device that is not open. */
static const bgc_pose resting_pose = {.orientation = {1.0, 0.0, 0.0, 0.0}};

/* The component of a pose that an input reads. */
static double input_of(const bgc_pose *pose, const bgc_channel_use *use) {
    switch (use->channel) {
    case BGC_POSITION:
        return pose->position[use->component];
    case BGC_ORIENTATION:
        return pose->orientation[use->component];
    case BGC_VELOCITY:
        return pose->velocity[use->component];
    case BGC_ANGULAR_VELOCITY:
        return pose->angular_velocity[use->component];
    case BGC_GRIPPER:
        return pose->gripper[use->component];
    case BGC_BUTTONS:
        return pose->buttons[use->component];
    case BGC_HELD_FORCE:
        return pose->held_force[use->component];
    case BGC_AGE:
        return pose->age;
    default:
        return 0.0;
    }
}

/* The component of an effort that a command writes. */
static double *command_of(bgc_effort *effort, const bgc_channel_use *use) {
    switch (use->channel) {
    case BGC_FORCE:
        return &effort->force[use->component];
    case BGC_TORQUE:
        return &effort->torque[use->component];
    default:
        return &effort->gripper_force[use->component];
    }
}

/* Whether input k comes from a device; the caller writes the others. */
static int from_device(const bgc_model *m, int k) {
    return m->input != NULL && m->input[k].device >= 0;
}

/* Inputs with devices at rest; those that the caller writes are zero. */
void bgc_default_inputs(const bgc_model *m, double *u) {
    for (int k = 0; k < m->n_input; k++) {
        u[k] = from_device(m, k) ? input_of(&resting_pose, &m->input[k]) : 0.0;
    }
}

/* Writes zero force to all open devices. */
void bgc_zero_devices(const bgc_model *m, bgc_data *d) {
    static const bgc_effort none = {{0.0}, {0.0}, {0.0}};

    for (int k = 0; k < m->n_device; k++) {
        bgc_device *device = &d->device[k];
        if (device->driver != NULL) {
            device->driver->write(device->handle, d->core.t, &none);
            device->given = none;
        }
    }
}

/* Notes which device reported a fault and why, and sets all forces to zero. */
static bgc_status fail_device(const bgc_model *m, bgc_data *d, int k) {
    const bgc_device *device = &d->device[k];
    const char *reason =
        device->driver->last_error != NULL ? device->driver->last_error(device->handle) : NULL;

    d->failed_device = k;
    snprintf(d->device_reason, sizeof d->device_reason, "%s", reason != NULL ? reason : "");
    bgc_zero_devices(m, d);
    return BGC_DEVICE;
}

int bgc_failed_device(const bgc_data *d) { return d->failed_device; }

const char *bgc_device_reason(const bgc_data *d) { return d->device_reason; }

/* Reads poses at the present time to the inputs of the model. A fault, or a value that is not finite, sets all
 * forces to zero. */
bgc_status bgc_read_devices(const bgc_model *m, bgc_data *d) {
    /* A pose from each open device. */
    for (int k = 0; k < m->n_device; k++) {
        bgc_device *device = &d->device[k];
        if (device->driver == NULL) {
            continue;
        }
        device->pose = resting_pose;
        memcpy(device->pose.held_force, device->given.force, sizeof device->given.force);
        if (bgc_is_fault(device->driver->read(device->handle, d->core.t, &device->pose))) {
            return fail_device(m, d, k);
        }
    }

    /* Their components, where inputs read them. */
    for (int k = 0; k < m->n_input; k++) {
        const bgc_device *device = from_device(m, k) ? &d->device[m->input[k].device] : NULL;
        if (device != NULL && device->driver != NULL) {
            d->u[k] = input_of(&device->pose, &m->input[k]);
            if (!isfinite(d->u[k])) {
                const bgc_status status = fail_device(m, d, m->input[k].device);
                snprintf(d->device_reason, sizeof d->device_reason, "a value that it reads is not finite");
                return status;
            }
        }
    }
    return BGC_OK;
}

/* Writes the commands of the model at the present time and state to the devices. */
bgc_status bgc_write_devices(const bgc_model *m, bgc_data *d) {
    int open = 0;

    for (int k = 0; k < m->n_device; k++) {
        open |= d->device[k].driver != NULL;
    }
    if (!open) {
        return BGC_OK;
    }

    /* Commands; undefined ones are a failure of the model. */
    if (m->n_command > 0) {
        m->commands(d->h, d->core.t, d->x, d->u, d->command, d->work);
    }
    if (bgc_first_bad(m->n_command, d->command) >= 0) {
        bgc_zero_devices(m, d);
        return BGC_NOT_FINITE;
    }

    /* Efforts of each open device. */
    for (int k = 0; k < m->n_device; k++) {
        bgc_device *device = &d->device[k];
        bgc_effort effort = {{0.0}, {0.0}, {0.0}};
        if (device->driver == NULL) {
            continue;
        }
        for (int i = 0; i < m->n_command; i++) {
            if (m->command[i].device == k) {
                *command_of(&effort, &m->command[i]) = d->command[i];
            }
        }
        device->given = effort;
        if (bgc_is_fault(device->driver->write(device->handle, d->core.t, &effort))) {
            return fail_device(m, d, k);
        }
    }
    return BGC_OK;
}

/* Writes zero force and closes the driver, where it is open. */
static void close_device(bgc_data *d, bgc_device *device) {
    static const bgc_effort none = {{0.0}, {0.0}, {0.0}};

    if (device->driver != NULL) {
        device->driver->write(device->handle, d->core.t, &none);
        device->driver->close(device->handle);
        device->driver = NULL;
        device->handle = NULL;
    }
}

bgc_status bgc_open_device(const bgc_model *m, bgc_data *d, int k, const bgc_driver *driver,
                           const char *options, char *message, size_t size) {
    void *handle;

    /* The device and its driver. */
    if (size > 0) {
        message[0] = '\0';
    }
    if (k < 0 || k >= m->n_device) {
        snprintf(message, size, "the model has no device %d", k);
        return BGC_BAD_ARGUMENT;
    }
    if (driver == NULL) {
        driver = bgc_find_driver(m->device[k].driver);
    }
    if (driver == NULL) {
        snprintf(message, size, "there is no driver called `%s`", m->device[k].driver);
        return BGC_BAD_ARGUMENT;
    }
    if (driver->abi != BGC_DEVICE_ABI) {
        snprintf(message, size, "the driver has version %u of the interface of devices, this runtime has %d",
                 (unsigned)driver->abi, BGC_DEVICE_ABI);
        return BGC_BAD_ARGUMENT;
    }

    /* Open it, in the place of the one before. */
    close_device(d, &d->device[k]);
    handle = driver->open(options != NULL ? options : m->device[k].options, message, size);
    if (handle == NULL) {
        return BGC_DEVICE;
    }
    d->device[k].driver = driver;
    d->device[k].handle = handle;
    d->device[k].pose = resting_pose;
    d->device[k].given = (bgc_effort){{0.0}, {0.0}, {0.0}};
    return BGC_OK;
}

void *bgc_device_handle(const bgc_model *m, const bgc_data *d, int k) {
    return k >= 0 && k < m->n_device ? d->device[k].handle : NULL;
}

void bgc_close_devices(const bgc_model *m, bgc_data *d) {
    for (int k = 0; k < m->n_device; k++) {
        close_device(d, &d->device[k]);
    }
}
