#include "first.h"
#include "second.h"
#include <stdio.h>

#define RUN(prefix)                                                    \
    do {                                                               \
        const prefix##_model *m = prefix##_get_model();                \
        prefix##_data *d = prefix##_new(m);                            \
        const double times[2] = {0.0, 1.0};                            \
        double rows[2];                                                \
        size_t done;                                                   \
        if (prefix##_reset(m, d, 0.0) != 0 ||                          \
            prefix##_run(m, d, times, 2, rows, &done) != 0) {          \
            return 1;                                                  \
        }                                                              \
        printf("%s %.6f\n", m->param[0].name, rows[1]);                \
        prefix##_free(m, d);                                           \
    } while (0)

int main(void) {
    RUN(left);
    RUN(right_hand);
    return 0;
}
