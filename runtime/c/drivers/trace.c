/* trace.c: the driver `trace`: the recorded motion of an operator from a CSV file; forces are ignored.
 *
 * Options, one a line: file=PATH (required), scale=FACTOR of the positions (1), loop=0|1 (0).
 * In the file, empty lines and lines that start with # are skipped. A header names the columns: time
 * (s), x, y, z (m) are required; qw, qx, qy, qz (a quaternion), gripper (m), button1 .. button8 (0 or 1),
 * vx, vy, vz (m/s) and wx, wy, wz (rad/s) are optional. Columns fx, fy, fz, tx, ty, tz, gripper_force of a
 * recording are ignored. A sample at the time of a row has the bits of that row. Rows of numbers follow, with increasing times. Between rows the motion is
 * linear, and velocities that the file does not give are constant. Before the first row and after the last the device is at
 * rest; with loop the motion repeats.
 */
#include "bgc_internal.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#ifdef BGC_GIVEN_TEXTS
const char *bgc_given_text(const char *name); /* NULL: there is none of this name */
#endif

/* The status of a file with a size of 64 bits. */
#ifdef _WIN32
typedef struct _stat64 file_status;
#define get_status _stat64
#else
typedef struct stat file_status;
#define get_status stat
#endif
#ifndef S_IFMT
#define S_IFMT 0170000 /* as POSIX and Windows have them; strict C11 may hide the names */
#define S_IFREG 0100000
#endif

#define MOST_BYTES 256000000L /* of a file */

enum { MOST_DIGITS = 400 }; /* characters of a number */
enum { TIME, POSITION, ORIENTATION = 4, GRIPPER = 8, BUTTON = 9, VELOCITY = 17, ANGULAR = 20 };
enum { HELD = 23, COLUMNS = 26, WITH_EFFORTS = 33, REQUIRED = 4 };

static const char *const column_name[WITH_EFFORTS] = {
    "time", "x", "y", "z", "qw", "qx", "qy", "qz", "gripper",
    "button1", "button2", "button3", "button4", "button5", "button6", "button7", "button8",
    "vx", "vy", "vz", "wx", "wy", "wz", "hx", "hy", "hz",
    "fx", "fy", "fz", "tx", "ty", "tz", "gripper_force"};

static const char known_columns[] = "time, x, y, z, qw, qx, qy, qz, gripper, button1 .. button8, "
                                    "vx, vy, vz, wx, wy, wz, hx, hy, hz, fx, fy, fz, tx, ty, tz, gripper_force";

typedef struct {
    size_t rows, row; /* row: the one found last */
    int loop, has_velocity, has_angular, has_held;
    double *value; /* rows by COLUMNS */
} trace;

/* Where to write a message about a file. */
typedef struct {
    const char *file;
    char *message;
    size_t size;
} reporter;

static const char no_memory[] = "there is not enough memory";

/* Writes a message with the place in the file; returns 0.
 *
 * `detail` never is text of the file: a model may name any file that its user can read. */
static int fail(const reporter *r, size_t line, const char *what, const char *detail) {
    if (line > 0) {
        snprintf(r->message, r->size, "%s:%zu: %s%s", r->file, line, what, detail);
    } else {
        snprintf(r->message, r->size, "%s: %s%s", r->file, what, detail);
    }
    return 0;
}

/* --- text ---------------------------------------------------------------------------------- */

#ifdef BGC_GIVEN_TEXTS
/* Copies a text that the host of a program without a file system has handed over. */
static char *read_file(const reporter *r) {
    const char *given = bgc_given_text(r->file);
    char *text = given != NULL ? malloc(strlen(given) + 1) : NULL;

    if (text == NULL) {
        fail(r, 0, given != NULL ? no_memory : "this file was not handed over", "");
        return NULL;
    }
    return memcpy(text, given, strlen(given) + 1);
}
#else
/* Reads a regular file of at most MOST_BYTES. Returns its text, or NULL with a message.
 *
 * Pipes, terminals and devices may never end, so they are refused before they are opened. */
static char *read_file(const reporter *r) {
    file_status status;
    char *text;
    FILE *file;
    size_t size;

    if (get_status(r->file, &status) != 0) {
        fail(r, 0, "the file cannot be read: ", strerror(errno));
        return NULL;
    }
    if ((status.st_mode & S_IFMT) != S_IFREG) {
        fail(r, 0, "this is not a regular file", "");
        return NULL;
    }
    if (status.st_size > MOST_BYTES) {
        fail(r, 0, "the file is too large: at most 256 MB", "");
        return NULL;
    }

    /* No more than the size that the system states: files of /proc state 0 and may never end. */
    size = (size_t)status.st_size;
    text = malloc(size + 1);
    if (text == NULL) {
        fail(r, 0, no_memory, "");
        return NULL;
    }
    file = fopen(r->file, "rb");
    if (file == NULL || fread(text, 1, size, file) != size) {
        const int refused = file == NULL || ferror(file);
        fail(r, 0, "the file cannot be read: ", refused ? strerror(errno) : "it was shortened");
        free(text);
        text = NULL;
    } else {
        text[size] = '\0';
    }
    if (file != NULL) {
        fclose(file);
    }
    return text;
}
#endif

/* Returns the next line of the text, terminated, and advances the text; NULL at the end. */
static char *next_line(char **text) {
    char *line = *text, *end;

    if (*line == '\0') {
        return NULL;
    }
    end = line + strcspn(line, "\n");
    *text = *end == '\0' ? end : end + 1;
    *end = '\0';
    if (end > line && end[-1] == '\r') {
        end[-1] = '\0';
    }
    return line;
}

/* Returns the next field of a line, terminated and trimmed, and advances the line; NULL at the end. */
static char *next_field(char **line) {
    char *field = *line, *end;

    if (field == NULL) {
        return NULL;
    }
    end = field + strcspn(field, ",");
    *line = *end == ',' ? end + 1 : NULL;
    *end = '\0';
    field += strspn(field, " \t");
    for (end = field + strlen(field); end > field && strchr(" \t", end[-1]) != NULL;) {
        *--end = '\0';
    }
    return field;
}

/* Whether a line is empty or a comment. */
static int is_blank(const char *line) {
    return line[strspn(line, " \t")] == '\0' || *line == '#';
}

/* Whether the text is one finite decimal number, which goes to *value.
 *
 * `strtod` reads the decimal point of the host's locale, so that is put in place of the `.`. */
static int parse_number(const char *text, double *value) {
    const char *own = localeconv()->decimal_point, *dot = strchr(text, '.');
    const size_t length = strlen(text), point = strlen(own);
    char copy[MOST_DIGITS + 16], *end;

    if (length == 0 || length > MOST_DIGITS || point > 15 ||
        strspn(text, "+-.0123456789eE") != length) {
        return 0;
    }
    memcpy(copy, text, length + 1);
    if (dot != NULL) {
        const size_t before = (size_t)(dot - text);
        memcpy(copy + before, own, point);
        memcpy(copy + before + point, dot + 1, length - before);
    }
    *value = strtod(copy, &end);
    return *end == '\0' && end != copy && isfinite(*value);
}

/* --- the file ------------------------------------------------------------------------------ */

/* Reads the columns that the header names, in its order. Returns 0 on a fault. */
static int parse_header(const reporter *r, size_t line_number, char *line, int *columns, int *count,
                        trace *t) {
    uint64_t seen = 0;

    *count = 0;
    /* Known columns, each once. */
    for (char *field; (field = next_field(&line)) != NULL;) {
        int k = 0;
        while (k < WITH_EFFORTS && strcmp(field, column_name[k]) != 0) {
            k++;
        }
        if (k == WITH_EFFORTS) {
            return fail(r, line_number, "the header names a column that is none of ", known_columns);
        }
        if ((seen >> k & 1u) != 0) {
            return fail(r, line_number, "this column is there twice: ", column_name[k]);
        }
        seen |= UINT64_C(1) << k;
        columns[(*count)++] = k;
    }
    /* Required columns; of a quaternion and of velocities all or none. */
    t->has_velocity = (seen >> VELOCITY & 7u) != 0;
    t->has_angular = (seen >> ANGULAR & 7u) != 0;
    t->has_held = (seen >> HELD & 7u) != 0;
    for (int k = 0; k < COLUMNS; k++) {
        const int orientation = k >= ORIENTATION && k < GRIPPER && (seen & 0xf0u) != 0;
        const int velocity = k >= VELOCITY && k < ANGULAR && t->has_velocity;
        const int angular = k >= ANGULAR && k < HELD && t->has_angular;
        const int held = k >= HELD && t->has_held;
        if ((seen >> k & 1u) == 0 && (k < REQUIRED || orientation || velocity || angular || held)) {
            return fail(r, line_number, "the header lacks the column ", column_name[k]);
        }
    }
    return 1;
}

/* Reads one row of numbers and normalises its quaternion. Returns 0 on a fault. */
static int parse_row(const reporter *r, size_t line_number, char *line, const int *columns, int count,
                     double *row) {
    double length = 0.0, ignored;

    memset(row, 0, COLUMNS * sizeof *row);
    row[ORIENTATION] = 1.0;
    for (int k = 0; k < count; k++) {
        char *field = next_field(&line);
        if (field == NULL) {
            return fail(r, line_number, "this row lacks the column ", column_name[columns[k]]);
        }
        if (!parse_number(field, columns[k] < COLUMNS ? &row[columns[k]] : &ignored)) {
            return fail(r, line_number, "there is no number in the column ", column_name[columns[k]]);
        }
    }
    if (line != NULL) {
        return fail(r, line_number, "this row has more columns than the header", "");
    }

    /* The quaternion. */
    for (int k = 0; k < 4; k++) {
        length += row[ORIENTATION + k] * row[ORIENTATION + k];
    }
    if (!(length > 0.0)) {
        return fail(r, line_number, "this quaternion has no direction", "");
    }
    length = sqrt(length);
    for (int k = 0; k < 4 && fabs(length - 1.0) > 1e-12; k++) { /* a record keeps its bits */
        row[ORIENTATION + k] /= length;
    }
    return 1;
}

/* A quaternion and its negative are the same orientation: takes the one nearer to the row before. */
static void keep_hemisphere(const double *before, double *row) {
    double dot = 0.0;

    for (int k = ORIENTATION; k < GRIPPER; k++) {
        dot += before[k] * row[k];
    }
    for (int k = ORIENTATION; k < GRIPPER && dot < 0.0; k++) {
        row[k] = -row[k];
    }
}

/* Reads all rows of the text. Returns 0 on a fault. */
static int parse_text(const reporter *r, char *text, trace *t) {
    int columns[WITH_EFFORTS], count = 0;
    size_t line_number = 0, room = 0;

    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) {
        text += 3;
    }
    for (char *line; (line = next_line(&text)) != NULL;) {
        double *row;
        line_number++;
        if (is_blank(line)) {
            continue;
        }
        if (count == 0) {
            if (!parse_header(r, line_number, line, columns, &count, t)) {
                return 0;
            }
            continue;
        }

        /* A row of numbers, in memory that grows. */
        if (t->rows == room) {
            double *more = realloc(t->value, (room = 2 * room + 64) * COLUMNS * sizeof *more);
            if (more == NULL) {
                return fail(r, 0, no_memory, "");
            }
            t->value = more;
        }
        row = t->value + t->rows * COLUMNS;
        if (!parse_row(r, line_number, line, columns, count, row)) {
            return 0;
        }
        if (t->rows > 0) {
            if (!(row[TIME] > row[TIME - COLUMNS])) {
                return fail(r, line_number, "times must increase from row to row", "");
            }
            keep_hemisphere(row - COLUMNS, row);
        }
        t->rows++;
    }
    if (count == 0) {
        return fail(r, 0, "the file has no header `time,x,y,z`", "");
    }
    return t->rows > 0 ? 1 : fail(r, 0, "the file has no rows", "");
}

/* --- options ------------------------------------------------------------------------------- */

typedef struct {
    char *file;
    double scale;
    int loop;
} settings;

/* Reads key=value lines. Returns 0 on a fault. */
static int parse_options(char *lines, settings *s, char *message, size_t size) {
    for (char *line; (line = next_line(&lines)) != NULL;) {
        char *value = strchr(line, '=');
        if (is_blank(line)) {
            continue;
        }
        if (value == NULL) {
            snprintf(message, size, "trace: this option has no value: %s", line);
            return 0;
        }
        *value++ = '\0';
        if (strcmp(line, "file") == 0) {
            s->file = value;
        } else if (strcmp(line, "scale") == 0) {
            if (!parse_number(value, &s->scale)) {
                snprintf(message, size, "trace: scale must be a number, not %s", value);
                return 0;
            }
        } else if (strcmp(line, "loop") == 0) {
            double loop;
            if (!parse_number(value, &loop) || (loop != 0.0 && loop != 1.0)) {
                snprintf(message, size, "trace: loop must be 0 or 1, not %s", value);
                return 0;
            }
            s->loop = loop != 0.0;
        } else {
            snprintf(message, size, "trace: there is no option called %s: file, scale, loop", line);
            return 0;
        }
    }
    if (s->file == NULL) {
        snprintf(message, size, "trace: the option `file` is missing");
        return 0;
    }
    return 1;
}

/* --- the driver ---------------------------------------------------------------------------- */

static void trace_close(void *handle) {
    trace *t = handle;

    free(t->value);
    free(t);
}

/* Reads the motion of the file in `s`. Returns NULL on a fault. */
static trace *load(const settings *s, char *message, size_t size) {
    const reporter r = {s->file, message, size};
    trace *t = calloc(1, sizeof *t);
    char *text = NULL;
    int good = 0;

    if (t != NULL) {
        text = read_file(&r);
        good = text != NULL && parse_text(&r, text, t);
    } else {
        fail(&r, 0, no_memory, "");
    }
    free(text);
    if (!good) {
        if (t != NULL) {
            trace_close(t);
        }
        return NULL;
    }
    for (size_t i = 0; i < t->rows; i++) {
        for (int k = 0; k < 3; k++) {
            t->value[i * COLUMNS + POSITION + (size_t)k] *= s->scale;
        }
    }
    t->loop = s->loop && t->rows > 1;
    return t;
}

/* bgc_driver.open. */
static void *trace_open(const char *options, char *message, size_t size) {
    settings s = {NULL, 1.0, 0};
    const size_t length = strlen(options != NULL ? options : "");
    char *lines = malloc(length + 1);
    trace *t = NULL;

    if (lines == NULL) {
        snprintf(message, size, "trace: there is not enough memory");
        return NULL;
    }
    memcpy(lines, options != NULL ? options : "", length + 1);
    if (parse_options(lines, &s, message, size)) {
        t = load(&s, message, size);
    }
    free(lines);
    return t;
}

/* The row at or before a time inside the trace, searched forward from the one found last. */
static size_t find_row(trace *t, double time) {
    const double *value = t->value;
    size_t row = t->row;

    if (value[row * COLUMNS] > time) {
        row = 0;
    }
    while (row + 2 < t->rows && value[(row + 1) * COLUMNS] <= time) {
        row++;
    }
    t->row = row;
    return row;
}

/* Angular velocity w, q' = w q / 2: the vector part of 2 q' conj(q). */
static void angular_velocity(const double *q, const double *rate, double *w) {
    w[0] = 2.0 * (-rate[0] * q[1] + rate[1] * q[0] - rate[2] * q[3] + rate[3] * q[2]);
    w[1] = 2.0 * (-rate[0] * q[2] + rate[1] * q[3] + rate[2] * q[0] - rate[3] * q[1]);
    w[2] = 2.0 * (-rate[0] * q[3] - rate[1] * q[2] + rate[2] * q[1] + rate[3] * q[0]);
}

/* bgc_driver.read: interpolates between the two rows around the time; the force that was held is that of the
 * row before. */
static int trace_read(void *handle, double time, bgc_pose *pose) {
    trace *t = handle;
    const double first = t->value[0], last = t->value[(t->rows - 1) * COLUMNS];
    const double *a, *b;
    double q[4], rate[4], part = 0.0, per_second = 0.0, length = 0.0;

    /* The rows a and b around the time, and the fraction between them. */
    if (t->loop && time > last) {
        time = first + fmod(time - first, last - first);
    }
    a = b = t->value + (time >= last ? (t->rows - 1) * COLUMNS : 0);
    if (time >= first && time < last) {
        a = t->value + find_row(t, time) * COLUMNS;
        b = a + COLUMNS;
        per_second = 1.0 / (b[TIME] - a[TIME]);
        part = (time - a[TIME]) * per_second;
    }

    /* Position and velocity. */
    for (int k = 0; k < 3; k++) {
        const double rise = b[POSITION + k] - a[POSITION + k];
        pose->position[k] = a[POSITION + k] + part * rise;
        pose->velocity[k] =
            t->has_velocity ? a[VELOCITY + k] + part * (b[VELOCITY + k] - a[VELOCITY + k])
                            : per_second * rise;
    }

    /* Orientation, normalised, and angular velocity. */
    for (int k = 0; k < 4; k++) {
        rate[k] = per_second * (b[ORIENTATION + k] - a[ORIENTATION + k]);
        q[k] = a[ORIENTATION + k] + part * (b[ORIENTATION + k] - a[ORIENTATION + k]);
        length += q[k] * q[k];
    }
    length = part > 0.0 ? sqrt(length) : 1.0;
    for (int k = 0; k < 4; k++) {
        q[k] /= length;
        rate[k] /= length;
        pose->orientation[k] = q[k];
    }
    angular_velocity(q, rate, pose->angular_velocity);
    for (int k = 0; k < 3 && t->has_angular; k++) {
        pose->angular_velocity[k] = a[ANGULAR + k] + part * (b[ANGULAR + k] - a[ANGULAR + k]);
    }

    /* Gripper and buttons. */
    pose->gripper[0] = a[GRIPPER] + part * (b[GRIPPER] - a[GRIPPER]);
    for (int k = 0; k < 8; k++) {
        pose->buttons[k] = a[BUTTON + k];
    }
    for (int k = 0; k < 3 && t->has_held; k++) {
        pose->held_force[k] = a[HELD + k];
    }
    return 0;
}

static int trace_write(void *handle, double time, const bgc_effort *effort) {
    (void)handle;
    (void)time;
    (void)effort;
    return 0;
}

static void trace_capabilities(void *handle, bgc_capabilities *can) {
    (void)handle;
    can->sensed = BGC_EVERY_AXIS;
    can->buttons = 8;
}

const bgc_driver bgc_trace_driver = {
    .abi = BGC_DEVICE_ABI,
    .name = "trace",
    .open = trace_open,
    .read = trace_read,
    .write = trace_write,
    .close = trace_close,
    .capabilities = trace_capabilities,
};
