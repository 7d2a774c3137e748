/* udp.c: the driver `udp`: a device on another machine or in another program, by datagrams. Little-endian:
 *
 *   to the loop      "BGCP", u32 version 1, u64 sequence, f64 stamp (s), f64 position[3] (m),
 *                    orientation[4], velocity[3], angular_velocity[3], gripper, buttons[8]        200 bytes
 *                    in version 2 also f64 work (J) of the held force on the hand since the start 208 bytes
 *                    in version 3 then u64 sequence of the pose that the held force answers        216 bytes
 *   to the device    "BGCF", u32 version 1, u64 sequence, u64 sequence of the pose it answers,
 *                    f64 time (s), f64 force[3] (N), torque[3] (N m), gripper_force               88 bytes
 *
 * The sequence of poses starts above 0 and grows; one that is not above the last is old and is dropped. A
 * lost pose leaves the one before. Force goes to the sender of the last pose. Of a flood, 64 datagrams are
 * read per sample.
 * Options: port=PORT (required), host=ADDRESS of the device. Without it only this machine may send; with it
 * that address alone. wait=2 (s): time in which the first pose has to arrive. lag=0: samples, at worst, from a
 * pose to the force that answers it, which the check of passivity before a loop compares with the model's.
 */
#include "bgc_internal.h"
#include "drivers/options.h"

#include <math.h>
#include <stdio.h>

#if (defined(__unix__) || defined(__APPLE__)) && !defined(__wasi__)
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

enum { POSE_NUMBERS = 22, POSE_BYTES = 24 + 8 * POSE_NUMBERS, ECHO_BYTES = POSE_BYTES + 8 };
enum { LAG_BYTES = ECHO_BYTES + 8, FORCE_BYTES = 88, MOST_DATAGRAMS = 64, KEPT = 1024 };

typedef struct {
    int socket, lag, answers; /* answers: the address of the device is known */
    struct sockaddr_in device;
    struct in_addr allowed;
    uint64_t sequence, sent;
    bgc_pose pose;
    int echoes, is_booked;    /* the device sends the work of its force; the pose has been read */
    double work;              /* J: as the device has it */
    double booked_work, booked[3]; /* work and position up to which held_force has accounted for it */
    double age, news_at; /* s: of the pose that the held force answers; time of the loop at the last pose */
    struct {
        uint64_t sequence;
        double stamp;
    } kept[KEPT]; /* poses that were read, by their sequence */
    char fault[160];
} udp_state;

/* Eight bytes, the lowest first, and back. */
static uint64_t udp_get(const unsigned char *from) {
    uint64_t value = 0;

    for (int k = 7; k >= 0; k--) {
        value = value << 8 | from[k];
    }
    return value;
}

static void udp_put(unsigned char *to, uint64_t value) {
    for (int k = 0; k < 8; k++, value >>= 8) {
        to[k] = (unsigned char)(value & 255u);
    }
}

static double udp_get_number(const unsigned char *from) {
    const uint64_t bits = udp_get(from);
    double value;

    memcpy(&value, &bits, sizeof value);
    return value;
}

static void udp_put_number(unsigned char *to, double value) {
    uint64_t bits;

    memcpy(&bits, &value, sizeof bits);
    udp_put(to, bits);
}

/* The time on the device's clock from the pose `answered` to the present one; 0: not known. */
static double udp_age(udp_state *u, uint64_t sequence, uint64_t answered) {
    const double stamp = u->pose.stamp;
    const int found = answered > 0 && u->kept[answered % KEPT].sequence == answered;
    const double age = stamp - u->kept[answered % KEPT].stamp;

    u->kept[sequence % KEPT].sequence = sequence;
    u->kept[sequence % KEPT].stamp = stamp;
    return found && isfinite(age) ? fmax(age, 0.0) : 0.0;
}

/* Takes a datagram that is a pose newer than the last one: 1; or 0. */
static int udp_take(udp_state *u, const unsigned char *bytes, ssize_t count,
                    const struct sockaddr_in *from) {
    static const unsigned char head[4] = {'B', 'G', 'C', 'P'}, zeros[3] = {0};
    const int has_lag = count == LAG_BYTES && bytes[4] == 3;
    const int echoes = has_lag || (count == ECHO_BYTES && bytes[4] == 2);
    double values[POSE_NUMBERS];
    uint64_t sequence;

    if ((!echoes && (count != POSE_BYTES || bytes[4] != 1)) || memcmp(bytes, head, sizeof head) != 0 ||
        memcmp(bytes + 5, zeros, sizeof zeros) != 0 ||
        from->sin_addr.s_addr != u->allowed.s_addr) {
        return 0;
    }
    sequence = udp_get(bytes + 8);
    if (sequence <= u->sequence) {
        return 0;
    }
    u->sequence = sequence;
    u->echoes = echoes;
    u->work = echoes ? udp_get_number(bytes + POSE_BYTES) : 0.0;
    u->device = *from;
    u->answers = 1;
    u->pose.stamp = udp_get_number(bytes + 16);
    u->age = udp_age(u, sequence, has_lag ? udp_get(bytes + ECHO_BYTES) : 0);
    for (int k = 0; k < POSE_NUMBERS; k++) {
        values[k] = udp_get_number(bytes + 24 + 8 * k);
    }
    memcpy(&u->pose, values, sizeof values);
    return 1;
}

/* Reads what has arrived, at most MOST_DATAGRAMS. Returns the number of new poses; negative: a fault. */
static int udp_drain(udp_state *u) {
    int news = 0;

    for (int k = 0; k < MOST_DATAGRAMS; k++) {
        unsigned char bytes[LAG_BYTES + 1];
        struct sockaddr_in from;
        socklen_t size = sizeof from;
        const ssize_t count =
            recvfrom(u->socket, bytes, sizeof bytes, 0, (struct sockaddr *)&from, &size);
        if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            break;
        }
        if (count < 0 && errno != ECONNREFUSED && errno != EINTR) {
            snprintf(u->fault, sizeof u->fault, "the socket fails: %s", strerror(errno));
            return -1;
        }
        news += count >= 0 && udp_take(u, bytes, count, &from);
    }
    return news;
}

/* Waits for the first pose: 1; or 0 after `seconds`. */
static int udp_wait(udp_state *u, double seconds) {
    for (int left = (int)(1000.0 * seconds); left > 0; left -= 10) {
        struct pollfd ready = {u->socket, POLLIN, 0};
        if (poll(&ready, 1, 10) > 0 && udp_drain(u) > 0) {
            return 1;
        }
    }
    return 0;
}

static void *udp_fail(udp_state *u, char *message, size_t size, const char *reason) {
    snprintf(message, size, "udp: %s", reason);
    if (u != NULL && u->socket >= 0) {
        close(u->socket);
    }
    free(u);
    return NULL;
}

static void *udp_open(const char *options, char *message, size_t size) {
    const double port = bgc_number_option(options, "port", 0.0);
    const double wait = bgc_number_option(options, "wait", 2.0);
    const double lag = ceil(bgc_number_option(options, "lag", 0.0));
    struct sockaddr_in here = {.sin_family = AF_INET};
    char host[64] = "127.0.0.1", text[160];
    const int is_remote = bgc_text_option(options, "host", host, sizeof host);
    udp_state *u = calloc(1, sizeof *u);

    if (u == NULL) {
        return udp_fail(u, message, size, "there is not enough memory");
    }
    u->socket = -1;
    u->pose = (bgc_pose){.orientation = {1.0, 0.0, 0.0, 0.0}};
    u->lag = lag >= 0.0 && lag <= 1e6 ? (int)lag : -1;
    if (u->lag < 0) {
        return udp_fail(u, message, size, "the option `lag` must be a number of samples from 0 on");
    }
    if (!(port >= 1.0 && port <= 65535.0)) {
        return udp_fail(u, message, size, "the option `port` must be from 1 to 65535");
    }
    if (inet_pton(AF_INET, host, &u->allowed) != 1) {
        return udp_fail(u, message, size, "`host` must be an address such as 192.168.0.7");
    }
    u->socket = socket(AF_INET, SOCK_DGRAM, 0);
    here.sin_port = htons((uint16_t)port);
    if (!is_remote) { /* else any address of this machine: zero */
        here.sin_addr = u->allowed;
    }
    if (u->socket < 0 || bind(u->socket, (struct sockaddr *)&here, sizeof here) != 0 ||
        fcntl(u->socket, F_SETFL, O_NONBLOCK) != 0) {
        snprintf(text, sizeof text, "port %.0f cannot be opened: %s", port, strerror(errno));
        return udp_fail(u, message, size, text);
    }
    if (!udp_wait(u, wait)) {
        snprintf(text, sizeof text, "no pose from %s arrived at port %.0f within %g s", host, port, wait);
        return udp_fail(u, message, size, text);
    }
    return u;
}

/* Of a device that sends the work of its force: the force along the displacement since the last one with the
 * work since then, so that nothing is lost with a datagram. */
static void udp_echo(udp_state *u, bgc_pose *pose) {
    double moved[3], square = 0.0;

    for (int k = 0; k < 3; k++) {
        moved[k] = u->is_booked ? u->pose.position[k] - u->booked[k] : 0.0;
        square += moved[k] * moved[k];
    }
    if (u->is_booked && !(square > 0.0)) {
        return; /* no displacement: what was done on the way is booked with the next one */
    }
    for (int k = 0; k < 3; k++) {
        pose->held_force[k] = u->is_booked ? (u->work - u->booked_work) * moved[k] / square : 0.0;
    }
    memcpy(u->booked, u->pose.position, sizeof u->booked);
    u->booked_work = u->work;
    u->is_booked = 1;
}

static int udp_read(void *handle, double t, bgc_pose *pose) {
    udp_state *u = handle;
    const int news = udp_drain(u);

    memcpy(pose, &u->pose, offsetof(bgc_pose, held_force));
    /* Until something new comes, the force that the device holds grows older. */
    if (news > 0) {
        u->news_at = t;
    }
    pose->age = u->age > 0.0 ? u->age + fmax(t - u->news_at, 0.0) : 0.0;
    if (u->echoes) {
        udp_echo(u, pose);
    }
    return news < 0 ? BGC_DEVICE_LOST : news > 0 ? BGC_DEVICE_FINE : BGC_DEVICE_NO_NEWS;
}

static int udp_write(void *handle, double t, const bgc_effort *effort) {
    udp_state *u = handle;
    unsigned char bytes[FORCE_BYTES] = {'B', 'G', 'C', 'F', 1};
    double values[8] = {t};

    memcpy(values + 1, effort, sizeof *effort);
    udp_put(bytes + 8, ++u->sent);
    udp_put(bytes + 16, u->sequence);
    for (int k = 0; k < 8; k++) {
        udp_put_number(bytes + 24 + 8 * k, values[k]);
    }
    /* A datagram that is lost here is one of those that may be lost on the way. */
    if (sendto(u->socket, bytes, sizeof bytes, 0, (struct sockaddr *)&u->device,
               sizeof u->device) < 0 &&
        errno != EAGAIN && errno != EWOULDBLOCK && errno != ECONNREFUSED && errno != ENOBUFS &&
        errno != EINTR) {
        snprintf(u->fault, sizeof u->fault, "the force cannot be sent: %s", strerror(errno));
        return BGC_DEVICE_LOST;
    }
    return BGC_DEVICE_FINE;
}

static void udp_close(void *handle) {
    udp_state *u = handle;

    close(u->socket);
    free(u);
}

static const char *udp_error(void *handle) { return ((const udp_state *)handle)->fault; }

static void udp_capabilities(void *handle, bgc_capabilities *can) {
    can->echoes = ((const udp_state *)handle)->echoes;
    can->lag = ((const udp_state *)handle)->lag;
    can->sensed = can->driven = BGC_EVERY_AXIS;
    can->buttons = 8;
}

const bgc_driver bgc_udp_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "udp",
    .open = udp_open,
    .read = udp_read,
    .write = udp_write,
    .close = udp_close,
    .capabilities = udp_capabilities,
    .last_error = udp_error,
};

#else

static void *udp_open(const char *options, char *message, size_t size) {
    (void)options;
    snprintf(message, size, "udp: this system has no such sockets");
    return NULL;
}

/* A driver that opens nothing is asked for nothing more. */
const bgc_driver bgc_udp_driver = {.abi = BGC_DEVICE_ABI, .name = "udp", .open = udp_open};

#endif
