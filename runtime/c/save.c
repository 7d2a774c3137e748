/* save.c: saving and restoring the whole instance, except its devices: a restored run continues with
 * the same bits. */
#include "bgc_internal.h"

#include <string.h>

/* Identifies the model, so that the state of another one is refused. */
typedef struct {
    uint64_t size, model;
    bgc_core core;
} header;

/* FNV-1a of the model's name and content hash. */
static uint64_t identify(const bgc_model *m) {
    const char *text[2] = {m->name, m->hash};
    uint64_t hash = 14695981039346656037u;

    for (int k = 0; k < 2; k++) {
        for (const char *c = text[k]; c != NULL && *c != '\0'; c++) {
            hash = (hash ^ (unsigned char)*c) * 1099511628211u;
        }
    }
    return hash;
}

size_t bgc_save_size(const bgc_model *m) {
    return sizeof(header) + bgc_saved_count(m) * sizeof(double) + (size_t)m->n_param;
}

bgc_status bgc_save(const bgc_model *m, const bgc_data *d, void *memory) {
    const header head = {bgc_save_size(m), identify(m), d->core};
    unsigned char *to = memory;

    /* Header with the core, vectors, flags of parameters. */
    memcpy(to, &head, sizeof head);
    to += sizeof head;
    memcpy(to, d->memory, d->n_saved * sizeof(double));
    to += d->n_saved * sizeof(double);
    memcpy(to, d->is_set, (size_t)m->n_param);
    return BGC_OK;
}

bgc_status bgc_restore(const bgc_model *m, bgc_data *d, const void *memory) {
    const unsigned char *from = memory;
    bgc_status status;
    header head;

    memcpy(&head, from, sizeof head);
    if (head.size != bgc_save_size(m) || head.model != identify(m)) {
        return BGC_BAD_ARGUMENT;
    }
    from += sizeof head;
    d->core = head.core;
    memcpy(d->memory, from, d->n_saved * sizeof(double));
    from += d->n_saved * sizeof(double);
    memcpy(d->is_set, from, (size_t)m->n_param);

    bgc_classify_states(m, d);
    status = bgc_reserve_complex(m, d, &bgc_methods[d->core.method]);
    /* Dense factors are not saved: the same matrix gives the same factors. */
    if (status == BGC_OK && d->core.held > 0 && d->core.pivoting == BGC_DENSE) {
        status = bgc_refactorise_dense(m, d);
    }
    if (status == BGC_OK && d->core.held > 0 && d->core.pivoting_complex == BGC_DENSE) {
        status = bgc_refactorise_dense_complex(m, d);
    }
    return status;
}
