/* haply.c: the driver `haply`: an Inverse3 or Minverse of Haply through the maker's Inverse Service, version
 * 3.5 or later, by its WebSocket (RFC 6455) on this machine: three positions, velocities and forces.
 *
 * The service sends one message on connection, with all devices, and then one for each that it receives, with
 * their states (docs.haply.co/inverseSDK/service/realtime/websocket-protocol). So each write sends the force,
 * and the next read takes the state that answers it. The service holds the last force: the driver sends zero
 * before it closes.
 * The service stamps nothing, but answers the messages in their order: the n-th state behind the inventory
 * answers the n-th force. So the age of a state is the time, by the clock of this machine, on which the
 * service runs too, from the state that its force answered to this one. More states than forces have been
 * sent leave it unknown.
 * Options: port=10001, id=DEVICE (the first one), wait=2 (s): time in which the service has to answer.
 */
#include "bgc_internal.h"
#include "drivers/json.h"
#include "drivers/options.h"

#include <math.h>
#include <stdio.h>

#if (defined(__unix__) || defined(__APPLE__)) && !defined(__wasi__)
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#ifdef MSG_NOSIGNAL
enum { HAPLY_SEND = MSG_NOSIGNAL };
#else
enum { HAPLY_SEND = 0 };
#endif

enum { HAPLY_ROOM = 1 << 17, HAPLY_ID = 64, HAPLY_MESSAGE = 512, HAPLY_MOST_MESSAGES = 64 };
enum { HAPLY_KEPT = 1024 }; /* forces under way */
enum { FRAME_TEXT = 1, FRAME_CLOSE = 8, FRAME_PING = 9, FRAME_PONG = 10 };

typedef struct {
    int socket;
    char id[HAPLY_ID];
    bgc_pose pose;
    char in[HAPLY_ROOM]; /* received, not yet taken */
    size_t held;
    char out[HAPLY_MESSAGE + 16]; /* the rest of a frame that the socket did not take */
    size_t left, sent;
    double answers[HAPLY_KEPT]; /* s: when the state was taken that force n answers, at n mod HAPLY_KEPT */
    uint64_t forces, states;    /* that were sent, and received */
    int uncounted;              /* more states came than forces were sent */
    double age, taken;          /* s: of the last state; when it was taken */
    char fault[160];
} haply_state;

/* --- frames -------------------------------------------------------------------------------------- */

static int haply_fault(haply_state *h, const char *what, const char *detail) {
    snprintf(h->fault, sizeof h->fault, "%s%s", what, detail);
    return -1;
}

/* Sends the rest of a frame. 1: all of it went, 0: the socket is full, -1: a fault. */
static int haply_flush(haply_state *h) {
    while (h->left > 0) {
        const ssize_t count = send(h->socket, h->out + h->sent, h->left, HAPLY_SEND);
        if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            return 0;
        }
        if (count < 0 && errno != EINTR) {
            return haply_fault(h, "the service cannot be reached: ", strerror(errno));
        }
        h->sent += count > 0 ? (size_t)count : 0;
        h->left -= count > 0 ? (size_t)count : 0;
    }
    return 1;
}

/* Sends a frame of at most HAPLY_MESSAGE bytes, masked by zeros, unless the last one still waits. */
static int haply_send(haply_state *h, int opcode, const char *text, size_t size) {
    const int flushed = haply_flush(h);
    unsigned char *to = (unsigned char *)h->out;
    size_t head = 2;

    if (flushed <= 0) {
        return flushed;
    }
    to[0] = (unsigned char)(0x80 | opcode);
    to[1] = (unsigned char)(0x80 | (size < 126 ? size : 126));
    if (size >= 126) {
        to[2] = (unsigned char)(size >> 8);
        to[3] = (unsigned char)size;
        head = 4;
    }
    memset(to + head, 0, 4);
    memcpy(to + head + 4, text, size);
    h->sent = 0;
    h->left = head + 4 + size;
    return haply_flush(h);
}

/* The first frame that was received whole: its opcode, its text and its whole size; 0: none yet. */
static int haply_frame(const haply_state *h, const char **text, size_t *size, size_t *whole) {
    const unsigned char *in = (const unsigned char *)h->in;
    size_t head = 2, length;

    if (h->held < head) {
        return 0;
    }
    length = in[1] & 0x7fu;
    if (length >= 126) {
        const size_t wide = length == 126 ? 2 : 8;
        if (h->held < head + wide) {
            return 0;
        }
        length = 0;
        for (size_t k = 0; k < wide; k++) {
            length = length << 8 | in[head + k];
        }
        head += wide;
    }
    *text = h->in + head;
    *size = length;
    *whole = head + length;
    if (length > HAPLY_ROOM - 16 || (in[0] & 0x80u) == 0 || (in[1] & 0x80u) != 0) {
        return -1; /* too long, in parts, or masked: none of it comes from the service */
    }
    return h->held >= *whole ? in[0] & 0x0f : 0;
}

/* --- states -------------------------------------------------------------------------------------- */

static int haply_vector(json_text object, const char *name, double *v) {
    static const char *const axis[3] = {"x", "y", "z"};
    const json_text vector = json_member(object, name);

    for (int k = 0; k < 3; k++) {
        if (!json_number(json_member(vector, axis[k]), &v[k])) {
            return 0;
        }
    }
    return 1;
}

/* The device of this driver, or the first one, in a message; empty without it. */
static json_text haply_device(const haply_state *h, json_text message) {
    json_text list = json_member(message, "inverse3"), device;

    while ((device = json_next(&list)).from != NULL) {
        if (h->id[0] == '\0' || json_is(json_member(device, "device_id"), h->id)) {
            return device;
        }
    }
    return device;
}

static double haply_now(void) {
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Enters the state that was received last: its age, and the time. */
static void haply_enter(haply_state *h) {
    const double now = haply_now();
    const int is_known = h->states > 0 && h->forces - h->states < HAPLY_KEPT;

    h->uncounted |= h->states > h->forces;
    h->age = is_known && !h->uncounted ? now - h->answers[(h->states - 1) % HAPLY_KEPT] : 0.0;
    h->taken = now;
}

/* Takes the state of a message: 1; -1 with a fault where it has none. */
static int haply_take(haply_state *h, json_text message) {
    const json_text device = haply_device(h, message);
    const json_text state = json_member(device, "state");

    if (device.from == NULL) {
        return haply_fault(h, "the service has no such device any more", "");
    }
    if (!haply_vector(state, "cursor_position", h->pose.position) ||
        !haply_vector(state, "cursor_velocity", h->pose.velocity)) {
        return haply_fault(h, "a message of the service has no position or no velocity", "");
    }
    return 1;
}

/* Receives what has arrived. Returns the number of new states; negative: a fault. The first message goes to
 * *first in place of that, where it is asked for. */
static int haply_drain(haply_state *h, json_text *first) {
    int news = 0;
    ssize_t count;

    do {
        count = recv(h->socket, h->in + h->held, sizeof h->in - h->held, 0);
        h->held += count > 0 ? (size_t)count : 0;
    } while (count < 0 && errno == EINTR);
    if (count == 0 && h->held < sizeof h->in) {
        return haply_fault(h, "the service closed the connection", "");
    }
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) {
        return haply_fault(h, "the service cannot be reached: ", strerror(errno));
    }
    for (int k = 0; k < HAPLY_MOST_MESSAGES; k++) {
        const char *text;
        size_t size, whole;
        const int opcode = haply_frame(h, &text, &size, &whole);
        if (opcode == 0) {
            break;
        }
        if (opcode < 0) {
            return haply_fault(h, "the service sent a frame that is not one of its own", "");
        }
        if (opcode == FRAME_CLOSE) {
            return haply_fault(h, "the service closed the connection", "");
        }
        if (opcode == FRAME_PING && size < 126 && haply_send(h, FRAME_PONG, text, size) < 0) {
            return -1;
        }
        if (opcode == FRAME_TEXT) {
            const json_text message = {text, text + size};
            if (first != NULL) {
                *first = message; /* stays in `in`, and is left there */
                return 1;
            }
            if (haply_take(h, message) < 0) {
                return -1;
            }
            h->states++;
            news++;
        }
        h->held -= whole;
        memmove(h->in, h->in + whole, h->held);
    }
    if (news > 0) {
        haply_enter(h);
    }
    return news;
}

/* --- the driver ---------------------------------------------------------------------------------- */

/* Sends a force in N, to 1e-6 N; without a locale, whose decimal point may be a comma. */
static int haply_command(haply_state *h, const double *force, const char *session) {
    static const char axis[3] = {'x', 'y', 'z'};
    char text[HAPLY_MESSAGE];
    int n = snprintf(text, sizeof text,
                     "{%s\"inverse3\":[{\"device_id\":\"%s\",\"commands\":{\"set_cursor_force\":{\"vector\":{",
                     session, h->id);

    for (int k = 0; k < 3; k++) {
        const double size = fmin(fabs(force[k]), 1e6);
        const long long micro = (long long)(1e6 * size + 0.5);
        n += snprintf(text + n, sizeof text - (size_t)n, "%s\"%c\":%s%lld.%06lld", k > 0 ? "," : "", axis[k],
                      force[k] < 0.0 && micro > 0 ? "-" : "", micro / 1000000, micro % 1000000);
    }
    n += snprintf(text + n, sizeof text - (size_t)n, "},\"execute\":true}}}]}");
    if (haply_flush(h) > 0) { /* it goes, now or in parts */
        h->answers[h->forces++ % HAPLY_KEPT] = h->taken;
    }
    return haply_send(h, FRAME_TEXT, text, (size_t)n);
}

static int haply_wait(const haply_state *h, int events, int ms) {
    struct pollfd ready = {h->socket, (short)events, 0};

    return poll(&ready, 1, ms) > 0;
}

/* Connects and shakes hands: 1; or 0 with the reason in `fault`. The key and its answer are the example of
 * RFC 6455, for nobody listens between two programs on one machine. */
static int haply_connect(haply_state *h, int port, int ms) {
    static const char answer[] = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";
    struct sockaddr_in service = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    char request[256], *end = NULL;
    const int one = 1;
    int n, spent = 0;

    inet_pton(AF_INET, "127.0.0.1", &service.sin_addr);
    h->socket = socket(AF_INET, SOCK_STREAM, 0);
    if (h->socket < 0 || connect(h->socket, (struct sockaddr *)&service, sizeof service) != 0 ||
        fcntl(h->socket, F_SETFL, O_NONBLOCK) != 0) {
        snprintf(h->fault, sizeof h->fault,
                 "no service answers at port %d (%s): start the Haply Hub or the Inverse Service", port,
                 strerror(errno));
        return 0;
    }
    setsockopt(h->socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    n = snprintf(request, sizeof request,
                 "GET / HTTP/1.1\r\nHost: localhost:%d\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n",
                 port);
    if (send(h->socket, request, (size_t)n, HAPLY_SEND) != n) {
        haply_fault(h, "the service cannot be reached: ", strerror(errno));
        return 0;
    }

    /* The header of the answer; a frame may follow it. */
    while (end == NULL && spent < ms && h->held < 4096) {
        ssize_t count;
        spent += haply_wait(h, POLLIN, 10) ? 1 : 10;
        count = recv(h->socket, h->in + h->held, 4096 - h->held, 0);
        h->held += count > 0 ? (size_t)count : 0;
        h->in[h->held] = '\0';
        end = strstr(h->in, "\r\n\r\n");
        if (count == 0) {
            break;
        }
    }
    if (end == NULL || strncmp(h->in, "HTTP/1.1 101", 12) != 0 || strstr(h->in, answer) == NULL ||
        strstr(h->in, answer) > end) {
        haply_fault(h, "the program at this port is not an Inverse Service: it refused a WebSocket", "");
        return 0;
    }
    h->held -= (size_t)(end + 4 - h->in);
    memmove(h->in, end + 4, h->held);
    return 1;
}

/* Waits for the inventory, and chooses the device: 1; or 0 with the reason in `fault`. */
static int haply_choose(haply_state *h, int ms) {
    json_text message = {NULL, NULL}, device;
    int found = 0;

    for (int spent = 0; spent < ms && found == 0; spent += haply_wait(h, POLLIN, 10) ? 1 : 10) {
        found = haply_drain(h, &message);
    }
    if (found < 0) {
        return 0;
    }
    if (found == 0) {
        haply_fault(h, "the service sent no list of its devices", "");
        return 0;
    }
    device = haply_device(h, message);
    if (device.from == NULL) {
        haply_fault(h, h->id[0] == '\0' ? "the service has no Inverse3: connect one and switch it on"
                                        : "the service has no device with the id ",
                    h->id);
        return 0;
    }
    if (!json_string(json_member(device, "device_id"), h->id, sizeof h->id)) {
        haply_fault(h, "the service gave its device no id", "");
        return 0;
    }
    return 1;
}

static void haply_close(void *handle) {
    static const double none[3] = {0.0, 0.0, 0.0};
    haply_state *h = handle;

    /* Zero force, also where the socket was full. */
    for (int k = 0; k < 20 && h->id[0] != '\0' && haply_command(h, none, "") == 0; k++) {
        haply_wait(h, POLLOUT, 5);
    }
    haply_send(h, FRAME_CLOSE, "\x03\xe8", 2);

    /* A socket that closes with states unread resets the connection, and the zero force may be lost. */
    shutdown(h->socket, SHUT_WR);
    for (int k = 0; k < 50 && recv(h->socket, h->in, sizeof h->in, 0) != 0; k++) {
        haply_wait(h, POLLIN, 5);
    }
    close(h->socket);
    free(h);
}

static void *haply_open(const char *options, char *message, size_t size) {
    static const char session[] = "\"session\":{\"configure\":{\"profile\":{\"name\":\"bgc:haptic\"}}},";
    static const double none[3] = {0.0, 0.0, 0.0};
    const double port = bgc_number_option(options, "port", 10001.0);
    const double wait = bgc_number_option(options, "wait", 2.0);
    const int ms = (int)(1000.0 * fmin(fmax(wait, 0.0), 3600.0));
    haply_state *h = calloc(1, sizeof *h);

    if (h == NULL) {
        snprintf(message, size, "haply: there is not enough memory");
        return NULL;
    }
    h->socket = -1;
    h->pose = (bgc_pose){.orientation = {1.0, 0.0, 0.0, 0.0}};
    bgc_text_option(options, "id", h->id, sizeof h->id);
    if (!(port >= 1.0 && port <= 65535.0)) {
        haply_fault(h, "the option `port` must be from 1 to 65535", "");
    } else if (strcspn(h->id, "\"\\") != strlen(h->id)) {
        haply_fault(h, "an id has no quotation marks", "");
    } else if (haply_connect(h, (int)port, ms) && haply_choose(h, ms)) {
        /* The inventory is a state too. Each message that follows is an answer. */
        const int found = haply_drain(h, NULL);
        h->states = 0;
        h->uncounted = 0;
        if (found > 0 && haply_command(h, none, session) > 0) {
            return h;
        }
    }
    snprintf(message, size, "haply: %s", h->fault);
    if (h->socket >= 0) {
        close(h->socket);
    }
    free(h);
    return NULL;
}

static int haply_read(void *handle, double t, bgc_pose *pose) {
    haply_state *h = handle;
    const int news = haply_drain(h, NULL);

    (void)t;
    memcpy(pose->position, h->pose.position, sizeof pose->position);
    memcpy(pose->velocity, h->pose.velocity, sizeof pose->velocity);
    pose->age = h->age > 0.0 ? h->age + haply_now() - h->taken : 0.0;
    return news < 0 ? BGC_DEVICE_LOST : news > 0 ? BGC_DEVICE_FINE : BGC_DEVICE_NO_NEWS;
}

/* A force that finds the socket full is left out: the service stands still, and `read` has no news. */
static int haply_write(void *handle, double t, const bgc_effort *effort) {
    (void)t;
    return haply_command(handle, effort->force, "") < 0 ? BGC_DEVICE_LOST : BGC_DEVICE_FINE;
}

static const char *haply_error(void *handle) { return ((const haply_state *)handle)->fault; }

static void haply_capabilities(void *handle, bgc_capabilities *can) {
    (void)handle;
    can->sensed = can->driven = BGC_TRANSLATIONS;
    snprintf(can->model, sizeof can->model, "Haply Inverse3");
}

const bgc_driver bgc_haply_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "haply",
    .open = haply_open,
    .read = haply_read,
    .write = haply_write,
    .close = haply_close,
    .capabilities = haply_capabilities,
    .last_error = haply_error,
};

#else

static void *haply_open(const char *options, char *message, size_t size) {
    (void)options;
    snprintf(message, size, "haply: this system has no such sockets");
    return NULL;
}

/* A driver that opens nothing is asked for nothing more. */
const bgc_driver bgc_haply_driver = {.abi = BGC_DEVICE_ABI, .name = "haply", .open = haply_open};

#endif
