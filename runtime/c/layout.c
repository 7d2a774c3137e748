/* layout.c: the arrays of an instance, one after another in one block of memory. */
#include "bgc_internal.h"
#include "number.h"

/* Allocates the arrays of an instance one after another in `from`, each in cache lines of its own;
 * counts only where `from` is NULL. */
typedef struct {
    double *from;
    size_t used;
} layout;

static double *place(layout *l, size_t count) {
    double *at = l->from == NULL ? NULL : l->from + l->used;

    l->used += (count + BGC_LANES - 1) / BGC_LANES * BGC_LANES;
    return at;
}

static const bgc_closure_info no_closures = {0};

/* Allocates all arrays, those that are saved first. Returns their size in doubles. */
size_t bgc_place_all(const bgc_model *m, bgc_data *d, double *from) {
    const size_t n = (size_t)m->n_state, unknown = (size_t)bgc_unknowns(m);
    const size_t local = (size_t)bgc_local_entries(m).count, slopes = (size_t)m->n_jac;
    const int given = 2 * m->n_given, tested = m->n_assert > m->n_check ? m->n_assert : m->n_check;
    const size_t checks = (size_t)(tested > given ? tested : given);
    const size_t switches = (size_t)m->n_switch;
    const size_t unknowns = (size_t)m->n_start;
    const bgc_closure_info *c = m->closure_info == NULL ? &no_closures : m->closure_info;
    const size_t responses = 2 * (size_t)c->n_row * (size_t)c->n_impulse;
    const size_t choices = (size_t)c->n_row + (size_t)c->n_condition;
    const size_t resets = m->n_jump > 0 ? (size_t)m->jump_first[m->n_jump] : 0;
    const size_t kernel_work = (size_t)m->n_work;
    layout l = {from, 0};

#define ARRAY(type, name, count) \
    d->name = (type *)(void *)place(&l, (count) * sizeof(type) / sizeof(double));
#define NUMBERS(name, count) ARRAY(double, name, count)
#define SCRATCH d->n_saved = l.used;
#include "arrays.h"
#undef ARRAY
#undef NUMBERS
#undef SCRATCH
    return l.used;
}

/* Number of doubles that bgc_save stores. */
size_t bgc_saved_count(const bgc_model *m) {
    bgc_data counted;

    bgc_place_all(m, &counted, NULL);
    return counted.n_saved;
}
