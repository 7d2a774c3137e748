/* forcedimension.c: the driver `forcedimension`: omega, delta, sigma, lambda and Falcon through libdrd of the
 * maker's SDK, which also exports the dhd functions. The library is opened at run time; nothing of it is
 * compiled in. The device's own time guard, watchdog and velocity threshold stay as they are.
 *
 * Options: library=PATH (by default $FDSDK, then the system's folders; not from a scene, which loads no
 * code), id=N (the first device),
 * gravity=0|1 (1: its weight is compensated), smooth=0.005 (s, filter of velocities).
 *
 * Velocities are filtered differences of the positions, since those of the SDK are means over 20 ms.
 * Facts: Force Dimension SDK 3.17, reference of drdc.h and dhdc.h.
 */
#include "bgc_internal.h"
#include "drivers/options.h"

#include <math.h>
#include <stdio.h>

#if (defined(__unix__) || defined(__APPLE__)) && !defined(__wasi__)
#include <dlfcn.h>

/* Functions of the library: result, name without prefix, arguments. The last one is the device, -1 for
 * the one that was opened last. */
typedef unsigned char fd_bool; /* `bool` of C++: one byte */
#define FD_FUNCTIONS(F)                                                                          \
    F(int, drdOpenID, (char))                                                                    \
    F(int, drdOpen, (void))                                                                      \
    F(fd_bool, drdIsInitialized, (char))                                                         \
    F(int, drdAutoInit, (char))                                                                  \
    F(int, drdStop, (fd_bool, char))                                                             \
    F(int, dhdClose, (char))                                                                     \
    F(int, dhdStop, (char))                                                                      \
    F(int, dhdErrorGetLast, (void))                                                              \
    F(const char *, dhdErrorGetLastStr, (void))                                                  \
    F(int, dhdGetSystemType, (char))                                                             \
    F(fd_bool, dhdHasBase, (char))                                                               \
    F(fd_bool, dhdHasWrist, (char))                                                              \
    F(fd_bool, dhdHasActiveWrist, (char))                                                        \
    F(fd_bool, dhdHasGripper, (char))                                                            \
    F(fd_bool, dhdHasActiveGripper, (char))                                                      \
    F(fd_bool, dhdIsLeftHanded, (char))                                                          \
    F(int, dhdEnableForce, (unsigned char, char))                                                \
    F(int, dhdSetGravityCompensation, (int, char))                                               \
    F(int, dhdGetPosition, (double *, double *, double *, char))                                 \
    F(int, dhdGetOrientationFrame, (double[3][3], char))                                         \
    F(int, dhdGetGripperGap, (double *, char))                                                   \
    F(int, dhdGetButton, (int, char))                                                            \
    F(int, dhdSetForceAndTorqueAndGripperForce,                                                  \
      (double, double, double, double, double, double, double, char))

#define FD_MEMBER(result, name, arguments) result(*name) arguments;
typedef struct {
    FD_FUNCTIONS(FD_MEMBER)
} fd_library;

/* A family of devices by its system type: continuous limits and workspace, from the maker's data sheets. */
typedef struct {
    int type;
    const char *model;
    double force, torque, gripper; /* N, N m, N; 0: not known */
    double radius;                 /* m, of the workspace */
} fd_model;

static const fd_model fd_models[] = {
    {33, "omega.3", 12.0, 0.0, 0.0, 0.075},          {34, "omega.6", 12.0, 0.0, 0.0, 0.075},
    {36, "omega.6 (left)", 12.0, 0.0, 0.0, 0.075},   {35, "omega.7", 12.0, 0.0, 8.0, 0.075},
    {37, "omega.7 (left)", 12.0, 0.0, 8.0, 0.075},   {60, "Falcon", 8.0, 0.0, 0.0, 0.05},
    {104, "sigma.7", 20.0, 0.4, 8.0, 0.095},         {105, "sigma.7 (left)", 20.0, 0.4, 8.0, 0.095},
    {108, "lambda.7", 20.0, 0.2, 8.0, 0.12},         {109, "lambda.7 (left)", 20.0, 0.2, 8.0, 0.12},
};

enum { FD_BUTTONS = 8 };

typedef struct {
    void *library;
    fd_library f;
    char id;
    bgc_capabilities can;
    int has_wrist, has_gripper, is_left, is_open;
    double smooth;
    double time; /* s: of the last read; negative: none */
    double position[3], rotation[3][3], velocity[3], angular[3];
    char fault[160];
} fd_state;

/* --- the library ----------------------------------------------------------------------------- */

/* Opens the library at the path of the option, else where the SDK puts it. */
static void *fd_find_library(const char *options, char *tried, size_t size) {
    static const char *const names[] = {"libdrd.so.3", "libdrd.so", "libdrd.dylib"};
    static const char *const folders[] = {"/lib", "/lib/release/lin-x86_64-gcc",
                                          "/lib/release/lin-aarch64-gcc", ""};
    const char *sdk = getenv("FDSDK"), *home = getenv("HOME");
    char path[512];

    if (bgc_text_option(options, "library", path, sizeof path)) {
        void *found = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        const char *reason = found == NULL ? dlerror() : NULL;
        snprintf(tried, size, "%s", reason != NULL ? reason : path);
        return found;
    }
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        void *found = NULL;
        for (size_t k = 0; sdk != NULL && k < sizeof folders / sizeof *folders && !found; k++) {
            snprintf(path, sizeof path, "%s%s/%s", sdk, folders[k], names[n]);
            found = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        }
        if (found == NULL && home != NULL) {
            snprintf(path, sizeof path, "%s/.local/lib/%s", home, names[n]);
            found = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        }
        if (found == NULL) {
            snprintf(path, sizeof path, "/usr/local/lib/%s", names[n]);
            found = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        }
        if (found == NULL) {
            found = dlopen(names[n], RTLD_NOW | RTLD_LOCAL);
        }
        if (found != NULL) {
            return found;
        }
    }
    snprintf(tried, size, "libdrd.so is not in $FDSDK, ~/.local/lib or /usr/local/lib (`bgc devices`)");
    return NULL;
}

/* Takes a function of the library; 0 where it lacks it. POSIX gives functions as `void *`. */
static int fd_take(void *library, const char *name, void *function, char *message, size_t size) {
    void *found = dlsym(library, name);

    memcpy(function, &found, sizeof found);
    if (found == NULL) {
        snprintf(message, size, "forcedimension: the library lacks %s: the SDK is too old", name);
    }
    return found != NULL;
}

/* --- the device ------------------------------------------------------------------------------ */

static const char *fd_reason(fd_state *s, const char *what) {
    const char *reason = s->f.dhdErrorGetLastStr();

    snprintf(s->fault, sizeof s->fault, "%s: %s (error %d)", what, reason != NULL ? reason : "no reason",
             s->f.dhdErrorGetLast());
    return s->fault;
}

static void fd_note_capabilities(fd_state *s) {
    const int type = s->f.dhdGetSystemType(s->id);
    bgc_capabilities *can = &s->can;

    can->sensed = can->driven = s->f.dhdHasBase(s->id) ? BGC_TRANSLATIONS : 0;
    s->has_wrist = s->f.dhdHasWrist(s->id) != 0;
    s->has_gripper = s->f.dhdHasGripper(s->id) != 0;
    s->is_left = s->f.dhdIsLeftHanded(s->id) != 0;
    can->sensed |= s->has_wrist ? BGC_ROTATIONS : 0u;
    can->driven |= s->f.dhdHasActiveWrist(s->id) ? BGC_ROTATIONS : 0u;
    can->sensed |= s->has_gripper ? BGC_AXIS_GRIPPER : 0u;
    can->driven |= s->f.dhdHasActiveGripper(s->id) ? BGC_AXIS_GRIPPER : 0u;
    can->buttons = FD_BUTTONS;
    can->slowest = 500.0;
    can->fastest = 4000.0;
    snprintf(can->model, sizeof can->model, "Force Dimension, system type %d", type);
    for (size_t k = 0; k < sizeof fd_models / sizeof *fd_models; k++) {
        const fd_model *model = &fd_models[k];
        if (model->type == type) {
            can->max_force = model->force;
            can->max_torque = model->torque;
            can->max_gripper_force = model->gripper;
            for (int i = 0; i < 3; i++) {
                can->workspace_high[i] = model->radius;
                can->workspace_low[i] = -model->radius;
            }
            snprintf(can->model, sizeof can->model, "%s", model->model);
        }
    }
}

/* Opens the device, calibrates it where it is not, and enables zero force. 0: a fault, in s->fault. */
static int fd_begin(fd_state *s, double id, int gravity) {
    const int opened = id >= 0.0 ? s->f.drdOpenID((char)id) : s->f.drdOpen();

    if (opened < 0) {
        fd_reason(s, "no device could be opened");
        return 0;
    }
    s->is_open = 1;
    s->id = (char)opened;
    fd_note_capabilities(s);
    if (!s->f.drdIsInitialized(s->id) && s->f.drdAutoInit(s->id) < 0) {
        fd_reason(s, "the calibration failed");
        return 0;
    }
    if (s->f.drdStop(1, s->id) < 0 || s->f.dhdSetGravityCompensation(gravity, s->id) < 0 ||
        s->f.dhdEnableForce(1, s->id) < 0 ||
        s->f.dhdSetForceAndTorqueAndGripperForce(0, 0, 0, 0, 0, 0, 0, s->id) < 0) {
        fd_reason(s, "forces could not be enabled");
        return 0;
    }
    return 1;
}

static void fd_close(void *handle) {
    fd_state *s = handle;

    if (s->is_open) {
        s->f.dhdSetForceAndTorqueAndGripperForce(0, 0, 0, 0, 0, 0, 0, s->id);
        s->f.dhdStop(s->id);
        s->f.dhdClose(s->id);
    }
    dlclose(s->library);
    free(s);
}

static void *fd_open(const char *options, char *message, size_t size) {
    char tried[600];
    fd_state *s = calloc(1, sizeof *s);
    int good = 1;

    if (s == NULL) {
        snprintf(message, size, "forcedimension: there is not enough memory");
        return NULL;
    }
    s->library = fd_find_library(options, tried, sizeof tried);
    if (s->library == NULL) {
        snprintf(message, size, "forcedimension: %s", tried);
        free(s);
        return NULL;
    }
#define FD_TAKE(result, name, arguments) \
    good = good && fd_take(s->library, #name, &s->f.name, message, size);
    FD_FUNCTIONS(FD_TAKE)
    s->smooth = bgc_number_option(options, "smooth", 0.005);
    s->time = -1.0;
    if (good && !fd_begin(s, bgc_number_option(options, "id", -1.0),
                          bgc_number_option(options, "gravity", 1.0) != 0.0)) {
        snprintf(message, size, "forcedimension: %s", s->fault);
        good = 0;
    }
    if (good) {
        return s;
    }
    fd_close(s);
    return NULL;
}

/* The unit quaternion of a rotation, by the largest of its components (S. W. Shepperd, J. Guidance and
 * Control 1, 1978). */
static void fd_quaternion(double r[3][3], double *q) {
    const double trace = r[0][0] + r[1][1] + r[2][2];
    int i = 0, j, k;
    double largest;

    if (trace >= r[0][0] && trace >= r[1][1] && trace >= r[2][2]) {
        q[0] = 0.5 * sqrt(1.0 + trace);
        q[1] = 0.25 * (r[2][1] - r[1][2]) / q[0];
        q[2] = 0.25 * (r[0][2] - r[2][0]) / q[0];
        q[3] = 0.25 * (r[1][0] - r[0][1]) / q[0];
        return;
    }
    i = r[1][1] > r[0][0] ? 1 : 0;
    i = r[2][2] > r[i][i] ? 2 : i;
    j = (i + 1) % 3;
    k = (i + 2) % 3;
    largest = 0.5 * sqrt(1.0 + r[i][i] - r[j][j] - r[k][k]);
    q[1 + i] = largest;
    q[0] = 0.25 * (r[k][j] - r[j][k]) / largest;
    q[1 + j] = 0.25 * (r[j][i] + r[i][j]) / largest;
    q[1 + k] = 0.25 * (r[k][i] + r[i][k]) / largest;
}

/* Filtered velocities from the poses of this sample and the one before: the rotation between them is small,
 * so that its vector is half the skew part of R R_before'. */
static void fd_differentiate(fd_state *s, double t, const double *position, double r[3][3]) {
    const double step = t - s->time;
    const double part = 1.0 - exp(-step / fmax(s->smooth, 1e-9));

    for (int k = 0; k < 3 && s->time >= 0.0 && step > 0.0; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        double turn = 0.0;
        for (int c = 0; c < 3; c++) {
            turn += 0.5 * (r[j][c] * s->rotation[i][c] - r[i][c] * s->rotation[j][c]);
        }
        s->velocity[k] += part * ((position[k] - s->position[k]) / step - s->velocity[k]);
        s->angular[k] += part * (turn / step - s->angular[k]);
    }
    memcpy(s->position, position, sizeof s->position);
    memcpy(s->rotation, r, sizeof s->rotation);
    s->time = t;
}

static int fd_read(void *handle, double t, bgc_pose *pose) {
    fd_state *s = handle;
    double *p = pose->position, r[3][3] = {{1.0, 0, 0}, {0, 1.0, 0}, {0, 0, 1.0}};

    /* 0 and above are successes: the time guard gave the last value again, or a motor is saturated. */
    if (s->f.dhdGetPosition(&p[0], &p[1], &p[2], s->id) < 0 ||
        (s->has_wrist && s->f.dhdGetOrientationFrame(r, s->id) < 0) ||
        (s->has_gripper && s->f.dhdGetGripperGap(pose->gripper, s->id) < 0)) {
        fd_reason(s, "the device does not answer");
        return BGC_DEVICE_LOST;
    }
    fd_quaternion(r, pose->orientation);
    for (int k = 0; k < FD_BUTTONS; k++) {
        pose->buttons[k] = s->f.dhdGetButton(k, s->id) == 1;
    }
    fd_differentiate(s, t, pose->position, r);
    memcpy(pose->velocity, s->velocity, sizeof s->velocity);
    memcpy(pose->angular_velocity, s->angular, sizeof s->angular);
    return BGC_DEVICE_FINE;
}

static int fd_write(void *handle, double t, const bgc_effort *e) {
    fd_state *s = handle;
    const double gripper = s->is_left ? -e->gripper_force[0] : e->gripper_force[0];
    const int answer = s->f.dhdSetForceAndTorqueAndGripperForce(
        e->force[0], e->force[1], e->force[2], e->torque[0], e->torque[1], e->torque[2], gripper, s->id);

    (void)t;
    if (answer < 0) {
        fd_reason(s, "the force could not be written");
        return BGC_DEVICE_LOST;
    }
    return answer == 2 ? BGC_DEVICE_SATURATED : BGC_DEVICE_FINE; /* 2: DHD_MOTOR_SATURATED */
}

static void fd_capabilities(void *handle, bgc_capabilities *can) {
    *can = ((const fd_state *)handle)->can;
}

static const char *fd_error(void *handle) { return ((const fd_state *)handle)->fault; }

const bgc_driver bgc_forcedimension_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "forcedimension",
    .open = fd_open,
    .read = fd_read,
    .write = fd_write,
    .close = fd_close,
    .capabilities = fd_capabilities,
    .last_error = fd_error,
};

#else

static void *fd_open(const char *options, char *message, size_t size) {
    (void)options;
    snprintf(message, size, "forcedimension: not on this system");
    return NULL;
}

/* A driver that opens nothing is asked for nothing more. */
const bgc_driver bgc_forcedimension_driver = {.abi = BGC_DEVICE_ABI, .name = "forcedimension", .open = fd_open};

#endif
