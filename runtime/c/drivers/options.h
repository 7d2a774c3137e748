/* options.h: the "key=value" lines that a driver is opened with. */
#ifndef BGC_DRIVER_OPTIONS_H
#define BGC_DRIVER_OPTIONS_H

#include <stdlib.h>
#include <string.h>

/* The value of an option, up to the end of its line, in `value`; 0 without it. */
static inline int bgc_text_option(const char *options, const char *key, char *value, size_t size) {
    const size_t length = strlen(key);

    for (const char *line = options; line != NULL && *line != '\0';) {
        const size_t end = strcspn(line, "\n");
        if (end > length && strncmp(line, key, length) == 0 && line[length] == '=') {
            const size_t count = end - length - 1;
            const size_t kept = count < size ? count : size - 1;
            memcpy(value, line + length + 1, kept);
            value[kept] = '\0';
            return 1;
        }
        line += end + (line[end] == '\n');
    }
    return 0;
}

/* The value of an option that is a number, or another one without it. */
static inline double bgc_number_option(const char *options, const char *key, double without) {
    char value[64];

    return bgc_text_option(options, key, value, sizeof value) ? strtod(value, NULL) : without;
}

#endif
