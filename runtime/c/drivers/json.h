/* json.h: values in a JSON text (RFC 8259), found where they stand: no memory, no recursion. Text that is not
 * JSON gives no value. */
#ifndef BGC_DRIVER_JSON_H
#define BGC_DRIVER_JSON_H

#include <math.h>
#include <stddef.h>
#include <string.h>

/* A value, or the rest of a list; `from` is NULL without one. */
typedef struct {
    const char *from, *end;
} json_text;

static inline const char *json_blank(const char *p, const char *end) {
    while (p < end && strchr(" \t\r\n", *p) != NULL && *p != '\0') {
        p++;
    }
    return p;
}

/* The end of a string that starts at p; NULL without one. */
static inline const char *json_quoted(const char *p, const char *end) {
    for (p++; p < end && *p != '"'; p++) {
        p += *p == '\\';
    }
    return p < end ? p + 1 : NULL;
}

/* The end of the value that starts at p; NULL without one. */
static inline const char *json_end(const char *p, const char *end) {
    int depth = 0;

    while (p != NULL && p < end) {
        if (*p == '"') {
            p = json_quoted(p, end);
        } else if (*p == '{' || *p == '[') {
            depth++, p++;
        } else if (*p == '}' || *p == ']') {
            if (depth == 0) {
                return p;
            }
            depth--, p++;
        } else if (depth == 0 && (*p == ',' || strchr(" \t\r\n", *p) != NULL)) {
            return p;
        } else {
            p++;
            continue;
        }
        if (depth == 0) {
            return p;
        }
    }
    return depth == 0 ? p : NULL;
}

/* Takes the next element of a list, or the next key or value of an object, whose bracket or comma comes first. */
static inline json_text json_next(json_text *list) {
    json_text value = {NULL, NULL};
    const char *p = list->from;

    if (p == NULL) {
        return value;
    }
    p = json_blank(p, list->end);
    if (p < list->end && strchr("[{,:", *p) != NULL) {
        p = json_blank(p + 1, list->end);
        if (p < list->end && *p != ']' && *p != '}') {
            value = (json_text){p, json_end(p, list->end)};
        }
    }
    if (value.end == NULL) {
        value.from = NULL;
    }
    list->from = value.end;
    return value;
}

/* Whether a value is this string, which needs no escapes. */
static inline int json_is(json_text value, const char *string) {
    const size_t length = strlen(string);

    return value.from != NULL && (size_t)(value.end - value.from) == length + 2 && *value.from == '"' &&
           memcmp(value.from + 1, string, length) == 0;
}

/* The value of a key of an object. */
static inline json_text json_member(json_text object, const char *name) {
    json_text key, value = {NULL, NULL};

    if (object.from != NULL) {
        object.from = json_blank(object.from, object.end);
    }
    if (object.from == NULL || object.from == object.end || *object.from != '{') {
        return value;
    }
    while ((key = json_next(&object)).from != NULL) {
        /* A key ends at its quotation mark. */
        key.end = *key.from == '"' ? json_quoted(key.from, object.end) : NULL;
        if (key.end == NULL) {
            break;
        }
        object.from = key.end;
        value = json_next(&object);
        if (json_is(key, name)) {
            return value;
        }
    }
    return (json_text){NULL, NULL};
}

/* A string without escapes, copied; 0 where the value is none or has no room. */
static inline int json_string(json_text value, char *to, size_t size) {
    const size_t length = value.from != NULL ? (size_t)(value.end - value.from) : 0;

    if (length < 3 || length - 2 >= size || *value.from != '"' ||
        memchr(value.from, '\\', length) != NULL) {
        return 0;
    }
    memcpy(to, value.from + 1, length - 2);
    to[length - 2] = '\0';
    return 1;
}

/* A number, without the locale of strtod, to a few units of its last digit; 0 where the value is none. */
static inline int json_number(json_text value, double *to) {
    const char *p = value.from;
    double sum = 0.0;
    int scale = 0, exponent = 0, digits = 0, sign = 1, below = 1;

    if (p == NULL) {
        return 0;
    }
    sign = *p == '-' ? -1 : 1;
    p += *p == '-';
    for (int after = 0; p < value.end && ((*p >= '0' && *p <= '9') || (*p == '.' && !after)); p++) {
        if (*p == '.') {
            after = 1;
            continue;
        }
        sum = digits < 300 ? 10.0 * sum + (*p - '0') : sum;
        scale += digits < 300 ? -after : 1 - after;
        digits++;
    }
    if (digits > 0 && p < value.end && (*p == 'e' || *p == 'E')) {
        p++;
        below = p < value.end && *p == '-' ? -1 : 1;
        p += p < value.end && (*p == '-' || *p == '+');
        for (; p < value.end && *p >= '0' && *p <= '9'; p++) {
            exponent = exponent < 10000 ? 10 * exponent + (*p - '0') : exponent;
        }
    }
    scale += below * exponent;
    *to = sign * (scale < 0 ? sum / pow(10.0, -scale) : sum * pow(10.0, scale));
    return digits > 0 && p == value.end && isfinite(*to);
}

#endif
