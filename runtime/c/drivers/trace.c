/* trace.c: the driver `trace`: the recorded motion of an operator from a CSV file; forces are ignored.
 *
 * Options, one a line: file=PATH (required), scale=FACTOR of the positions (1), loop=0|1 (0), and
 * COLUMN=NAME for a column that has another name in the file, clock=NAME for that of the time. With one of these, columns that nothing names
 * are not read, and x, y, z that the file lacks are 0.
 * In the file, empty lines and lines that start with # are skipped. A header names the columns: time
 * (s), x, y, z (m) are required; qw, qx, qy, qz (a quaternion), gripper (m), button1 .. button8 (0 or 1),
 * vx, vy, vz (m/s), wx, wy, wz (rad/s) and hx, hy, hz (the force that the device held, N) are optional. Columns
 * fx, fy, fz, tx, ty, tz, gripper_force of a recording are ignored. Rows of numbers follow, with increasing times.
 * A sample at the time of a row has the bits of that row. Between rows the motion is linear, and velocities that
 * the file does not give are constant. Before the first row and after the last the device is at rest; with loop
 * the motion repeats. trace_file.h reads the file.
 */
#include "drivers/trace_file.h"

/* --- options ------------------------------------------------------------------------------- */

typedef struct {
    char *file;
    double scale;
    int loop;
    column_names names;
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
            const int column = strcmp(line, "clock") == 0 ? TIME : find_column(column_name, line);
            if (column == UNREAD || column >= COLUMNS || strcmp(line, column_name[TIME]) == 0) {
                snprintf(message, size,
                         "trace: there is no option called %s: file, scale, loop, clock, or a column: %s", line,
                         known_columns);
                return 0;
            }
            s->names.of[column] = value;
            s->names.chosen = 1;
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
    const reporter r = {s->file, &s->names, message, size};
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
    settings s = {NULL, 1.0, 0, {{NULL}, 0}};
    const size_t length = strlen(options != NULL ? options : "");
    char *lines = malloc(length + 1);
    trace *t = NULL;

    if (lines == NULL) {
        snprintf(message, size, "trace: there is not enough memory");
        return NULL;
    }
    memcpy(lines, options != NULL ? options : "", length + 1);
    memcpy(s.names.of, column_name, sizeof column_name);
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
    pose->age = a[AGE];
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
