/* trace_file.h: the table of a recorded motion, read from a CSV file for the driver `trace`. */
#ifndef BGC_DRIVER_TRACE_FILE_H
#define BGC_DRIVER_TRACE_FILE_H

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

enum { MOST_DIGITS = 400, MOST_COLUMNS = 1024 }; /* characters of a number; columns of a file */
enum { TIME, POSITION, ORIENTATION = 4, GRIPPER = 8, BUTTON = 9, VELOCITY = 17, ANGULAR = 20 };
enum { HELD = 23, AGE = 26, COLUMNS = 27, WITH_EFFORTS = 34, REQUIRED = 4, UNREAD = -1 };

static const char *const column_name[WITH_EFFORTS] = {
    "time", "x", "y", "z", "qw", "qx", "qy", "qz", "gripper",
    "button1", "button2", "button3", "button4", "button5", "button6", "button7", "button8",
    "vx", "vy", "vz", "wx", "wy", "wz", "hx", "hy", "hz", "age",
    "fx", "fy", "fz", "tx", "ty", "tz", "gripper_force"};

static const char known_columns[] = "time, x, y, z, qw, qx, qy, qz, gripper, button1 .. button8, "
                                    "vx, vy, vz, wx, wy, wz, hx, hy, hz, age, fx, fy, fz, tx, ty, tz, gripper_force";

typedef struct {
    size_t rows, row; /* row: the one found last */
    int loop, has_velocity, has_angular, has_held;
    double *value; /* rows by COLUMNS */
} trace;

/* The names of columns in a file: those above, and others that options give. */
typedef struct {
    const char *of[WITH_EFFORTS];
    int chosen; /* 1: there are others; columns that nothing names are not read */
} column_names;

/* Where to write a message about a file. */
typedef struct {
    const char *file;
    const column_names *names;
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

/* The column of a name in the file, or UNREAD. */
static int find_column(const char *const *names, const char *name) {
    for (int k = 0; k < WITH_EFFORTS; k++) {
        if (strcmp(name, names[k]) == 0) {
            return k;
        }
    }
    return UNREAD;
}

/* Reads the columns that the header names, in its order. Returns 0 on a fault. */
static int parse_header(const reporter *r, size_t line_number, char *line, int *columns, int *count,
                        trace *t) {
    const column_names *names = r->names;
    uint64_t seen = 0;

    *count = 0;
    /* Known columns, each once. */
    for (char *field; (field = next_field(&line)) != NULL;) {
        const int k = find_column(names->of, field);
        if (*count == MOST_COLUMNS) {
            return fail(r, line_number, "the file has too many columns", "");
        }
        columns[(*count)++] = k;
        if (k == UNREAD) {
            if (!names->chosen) {
                return fail(r, line_number,
                            "the header has a column that no option such as x=NAME names, and that is none of ",
                            known_columns);
            }
            continue;
        }
        if ((seen >> k & 1u) != 0) {
            return fail(r, line_number, "this column is there twice: ", names->of[k]);
        }
        seen |= UINT64_C(1) << k;
    }
    /* Required columns, also those of other names; of a quaternion and of velocities all or none. */
    t->has_velocity = (seen >> VELOCITY & 7u) != 0;
    t->has_angular = (seen >> ANGULAR & 7u) != 0;
    t->has_held = (seen >> HELD & 7u) != 0;
    for (int k = 0; k < COLUMNS; k++) {
        const int orientation = k >= ORIENTATION && k < GRIPPER && (seen & 0xf0u) != 0;
        const int velocity = k >= VELOCITY && k < ANGULAR && t->has_velocity;
        const int angular = k >= ANGULAR && k < HELD && t->has_angular;
        const int held = k >= HELD && k < AGE && t->has_held;
        const int required = names->chosen ? k == TIME || names->of[k] != column_name[k] : k < REQUIRED;
        if ((seen >> k & 1u) == 0 && (required || orientation || velocity || angular || held)) {
            return fail(r, line_number, "the header lacks the column ", names->of[k]);
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
        const int column = columns[k];
        if (field == NULL) {
            return fail(r, line_number, "this row lacks the column ",
                        column == UNREAD ? "that its header names" : r->names->of[column]);
        }
        if (column != UNREAD && !parse_number(field, column < COLUMNS ? &row[column] : &ignored)) {
            return fail(r, line_number, "there is no number in the column ", r->names->of[column]);
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
    int columns[MOST_COLUMNS], count = 0;
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

#endif
