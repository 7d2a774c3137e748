/* switching.c: the choice between the implicit method of a run and its explicit partner, step by step.
 *
 * The compiler compares the operations of a step of both (m->explicit_cost). A run begins with the
 * implicit method, whose Jacobian gives a bound on the spectral radius (stiffness.c). It changes to the
 * partner where steps that are stable, and about as long as error control permits, are likely to cost
 * less. Each change is a trial: where a second costs more than before, the run returns. From the partner
 * it changes back for a few steps now and then, and for long where its steps are short for stability
 * alone: it estimates the dominant eigenvalue from its last two stages, which are at the same time.
 * E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2.
 */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

enum { EXPLICIT_TRIAL = 16, IMPLICIT_TRIAL = 3 }; /* steps after which a change is judged */
enum { LONG_UNEXCITED = 24 }; /* consecutive steps after which the run returns */
enum { MOST_REJECTIONS = 4 }; /* of the partner in a row */
enum { FIRST_WAIT = 32, LONGEST_WAIT = 2048 }; /* attempts before a trial: twice as many each time */
static const double steady = 1.3;    /* growth of steps that are no longer those of the start */
static const double shorter = 0.7;    /* steps of the partner over implicit ones of the same error */
static const double stable = 5.0;     /* step times the bound, which may be twice the radius or more */
static const double likely = 0.8;     /* predicted cost of the partner over that of the implicit method */
static const double cheaper = 0.9;    /* cost of a second over that before, above which a trial fails */
static const double error_constant = 4e3, margin = 1.25; /* of longest_resolved */

const bgc_method *bgc_present_method(const bgc_core *core) {
    return &bgc_methods[core->choice.is_explicit ? core->choice.partner : core->method];
}

/* At the start of a run: the implicit method. */
void bgc_reset_choice(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;
    const char *partner = bgc_methods[core->method].partner;

    core->choice = (bgc_choice){.partner = -1};
    for (int k = 0; partner != NULL && m->explicit_cost > 0.0 && k < bgc_method_count; k++) {
        if (strcmp(bgc_methods[k].name, partner) == 0) {
            core->choice.partner = k;
        }
    }
}

/* The largest step that the options and samples permit, at most h. */
static double permitted(const bgc_core *core, double h) {
    const double most = core->max_step > 0.0 ? fmin(h, core->max_step) : h;

    return core->period > 0.0 ? fmin(most, core->period) : most;
}

/* Changes to the other method at t. A second has cost as many implicit steps as `cost`. */
static void change_method(bgc_core *core, double t, double cost, int is_trial) {
    bgc_choice *choice = &core->choice;

    choice->is_explicit = !choice->is_explicit;
    choice->is_trial = is_trial;
    choice->attempts = choice->unexcited = 0;
    choice->since = t;
    choice->cost = cost;
    core->error_old = 1.0;
    core->counts.method_changes++;
}

/* After a trial, or a return without one: longer before the next. */
static void wait_longer(bgc_choice *choice) {
    const int twice = choice->wait == 0 ? FIRST_WAIT : 2 * choice->wait;

    choice->wait = twice < LONGEST_WAIT ? twice : LONGEST_WAIT;
}

/* Step times the dominant eigenvalue: |M^-1 (f - f')| h / |y - y'| of the last two stages. */
static double step_times_eigenvalue(const bgc_model *m, bgc_data *d, const bgc_method *method) {
    const bgc_tableau *tableau = method->tableau;
    const int n = m->n_state, last = tableau->stages - 1;
    const double *u = d->stages + (size_t)last * bgc_padded(n), *before = u - bgc_padded(n);
    double weight[BGC_MAX_STAGES] = {0.0}, distance;

    for (int j = 0; j < last; j++) {
        weight[j] = tableau->a[last][j] - tableau->a[last - 1][j];
    }
    memset(d->point, 0, (size_t)n * sizeof *d->point);
    bgc_combine(n, last, weight, d->stages, d->point);
    for (int i = 0; i < n; i++) {
        d->right[i] = u[i] - before[i];
    }
    distance = bgc_norm(m, d, d->point, d->x, d->next);
    return distance > 0.0 ? bgc_norm(m, d, d->right, d->x, d->next) / distance : 0.0;
}

/* The longest step of the partner, times the dominant eigenvalue, under which error control resolves an
 * oscillation of that frequency whose amplitude is the scale of its states. Where steps are longer, the
 * dominant modes are not excited, and an implicit method need not resolve them. */
static double longest_resolved(const bgc_core *core) {
    return margin * pow(error_constant * core->rtol, 1.0 / 6.0);
}

/* Whether steps of the partner are likely to cost less, after an implicit step of length h. */
static int partner_pays(const bgc_model *m, const bgc_core *core, double h) {
    const double wanted = shorter * core->h_next, bound = core->spectral_bound;
    const double length = permitted(core, wanted * bound > stable ? stable / bound : wanted);

    return core->counts.steps > 0 && core->h_next <= steady * h &&
           m->explicit_cost * permitted(core, core->h_next) < likely * length;
}

/* After an accepted step of length h to d->next at t, before that becomes the present. */
void bgc_choose_method(const bgc_model *m, bgc_data *d, double t, double h) {
    bgc_core *core = &d->core;
    bgc_choice *choice = &core->choice;
    const double each = choice->is_explicit ? m->explicit_cost : 1.0;
    double cost;

    if (choice->partner < 0 || core->algebraic > 0) {
        return;
    }
    choice->attempts++;
    core->counts.explicit_steps += choice->is_explicit;
    cost = each / permitted(core, core->h_next);

    if (choice->is_explicit) {
        const double product = step_times_eigenvalue(m, d, bgc_present_method(core));
        choice->unexcited = product > longest_resolved(core) ? choice->unexcited + 1 : 0;
    }

    /* A trial: of the partner by the mean length of its steps, of the implicit method by the next one, for
     * it has begun with short ones. */
    if (choice->is_trial) {
        if (choice->attempts < (choice->is_explicit ? EXPLICIT_TRIAL : IMPLICIT_TRIAL)) {
            return;
        }
        if (choice->is_explicit) {
            cost = each * (double)choice->attempts / (t - choice->since);
        }
        choice->is_trial = 0;
        wait_longer(choice);
        if (cost > cheaper * choice->cost || 2 * choice->unexcited > EXPLICIT_TRIAL) {
            change_method(core, t, cost, 0);
        }
        return;
    }
    if (choice->is_explicit) {
        if (choice->unexcited >= LONG_UNEXCITED) {
            wait_longer(choice);
            change_method(core, t, cost, 0);
        } else if (choice->attempts >= choice->wait) {
            change_method(core, t, cost, 1);
        }
    } else if (choice->attempts >= choice->wait && partner_pays(m, core, h)) {
        change_method(core, t, cost, 1);
        core->h_next *= shorter;
    }
}

/* After a rejected attempt, the present number core->rejected in a row. */
void bgc_count_rejection(bgc_core *core) {
    bgc_choice *choice = &core->choice;

    choice->attempts++;
    if (choice->is_explicit && core->rejected >= MOST_REJECTIONS) {
        wait_longer(choice);
        change_method(core, core->t, 0.0, 0);
    }
}
