/* A point that follows a hand with a lag of 0.1 s; the hand feels 10 N/m times the distance. */
enum { N = 3, P = 1, J = 3 };
static const int jac_row[] = {0, 1, 2}, jac_col[] = {0, 1, 2};
#include "frame.h"

static const bgc_param_info param[] = {{"unused", "", 0.0, -INFINITY, INFINITY}};
static const bgc_channel_use input[] = {
    {0, BGC_POSITION, 0}, {0, BGC_POSITION, 1}, {0, BGC_POSITION, 2}, {0, BGC_ORIENTATION, 0}};
static const bgc_channel_use command[] = {
    {0, BGC_FORCE, 0}, {0, BGC_FORCE, 1}, {0, BGC_FORCE, 2}, {0, BGC_GRIPPER_FORCE, 0}};
static const bgc_device_info device[] = {{"hand", "trace", "file=hand.csv"}};

static void initial(const double *h, double t, const double *u, double *x, double *w) {
    UNUSED;
    memcpy(x, u, N * sizeof *x);
}

static void rhs(SIGNATURE, double *f, double *w) {
    UNUSED;
    for (int i = 0; i < N; i++) {
        f[i] = 10.0 * (u[i] - x[i]);
    }
}

static void jacobian(SIGNATURE, double *jac, double *dfdt, double *w) {
    UNUSED;
    for (int i = 0; i < N; i++) {
        jac[i] = -10.0;
        dfdt[i] = 0.0;
    }
}

static void commands(SIGNATURE, double *c, double *w) {
    UNUSED;
    for (int i = 0; i < N; i++) {
        c[i] = 10.0 * (x[i] - u[i]);
    }
    c[3] = u[3];
}

/* A device that the tests watch: at x = t, faulty when told to be. */
double test_written[4], test_faulty_from = INFINITY, test_endless_from = INFINITY;
int test_writes, test_open;

static void *test_device_open(const char *options, char *message, size_t size) {
    (void)options;
    (void)message;
    (void)size;
    test_open++;
    return &test_open;
}

static int test_device_read(void *handle, double t, bgc_pose *pose) {
    (void)handle;
    pose->position[0] = t >= test_endless_from ? INFINITY : t;
    return t >= test_faulty_from ? BGC_DEVICE_LOST : BGC_DEVICE_NO_NEWS;
}

static int test_device_write(void *handle, double t, const bgc_effort *effort) {
    (void)handle;
    (void)t;
    test_writes++;
    memcpy(test_written, effort->force, sizeof effort->force);
    test_written[3] = effort->gripper_force[0];
    return 0;
}

static void test_device_close(void *handle) {
    (void)handle;
    test_open--;
}

static const char *test_device_error(void *handle) {
    (void)handle;
    return "the cable is out";
}

const bgc_driver test_driver = {.abi = BGC_DEVICE_ABI, .name = "test", .open = test_device_open,
                                .read = test_device_read, .write = test_device_write,
                                .close = test_device_close, .last_error = test_device_error};
const bgc_driver old_driver = {.abi = BGC_DEVICE_ABI + 1, .name = "old", .open = test_device_open};

MODEL(.step = 0.01, .n_input = 4, .n_command = 4, .n_device = 1, .input = input,
      .command = command, .device = device, .commands = commands)
