/* switching.c: the choice between the implicit method of a run and its explicit partner, step by step.
 *
 * The compiler compares the operations of a step of both (m->explicit_cost). A run begins with the
 * implicit method. It changes to the partner where steps that error control permits resolve all modes, by
 * an estimate of the spectral radius (spectrum.c), and are likely to cost less. Longer ones would excite
 * fast modes, which the implicit method then has to resolve. Each change is a trial: where a second costs
 * more than before, the run returns. From the partner it changes back for a few steps now and then, and
 * for long where its steps no longer resolve all modes, or are short for stability alone: it estimates the
 * dominant eigenvalue from its last two stages, which are at the same time.
 * E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2.
 *
 * A batch of instances, which take their steps together, chooses likewise (lanes/lane_switching.c): by the
 * largest radius and product of its instances, for the stiffest one determines its steps.
 */
#include "bgc_internal.h"
#include "switching.h"

#include <math.h>
#include <string.h>

enum { EXPLICIT_TRIAL = 16, IMPLICIT_TRIAL = 3 }; /* steps after which a change is judged, */
enum { LONGEST_RAMP = 12 };    /* the latter at most so many while they grow */
enum { LONG_LIMITED = 6 };     /* consecutive steps at the limit after which the run returns */
enum { LONG_UNEXCITED = 16 };  /* the same, where the dominant modes are not excited */
enum { MOST_REJECTIONS = 4 };  /* of the partner in a row */
enum { FIRST_WAIT = 32, LONGEST_WAIT = 2048 }; /* attempts before a trial: twice as many each time */
enum { FIRST_PAUSE = 16, LONGEST_PAUSE = 64 }; /* the same between estimates of the spectral radius */
static const double steady = 1.3;      /* growth of steps that are no longer those of the start */
static const double shorter = 0.7;     /* steps of the partner over implicit ones of the same error */
static const double oscillating = 1.2; /* stable steps of the partner times the frequency of an oscillation */
static const double stable = 1.5;      /* the same times the radius, where samples limit steps */
static const double lasting = 1.25;     /* longest steps of the partner over the longest first one */
static const double growing = 1.1;     /* growth of implicit steps that are judged later */
static const double likely = 0.82;     /* predicted cost of the partner over that of the implicit method */
static const double cheaper = 0.9;     /* cost of a second over that before, above which a trial fails */
static const double error_constant = 4e3, margin = 1.45; /* of longest_resolved */

const bgc_method *bgc_present_method(const bgc_core *core) {
    return bgc_chosen(&core->choice, core->method);
}

/* No choice yet: the implicit method. It has a partner only where this may pay. */
void bgc_begin_choice(const bgc_model *m, int method, bgc_choice *choice, bgc_spectrum *spectrum) {
    const char *partner = bgc_methods[method].partner;

    *choice = (bgc_choice){.partner = -1};
    bgc_reset_radius(spectrum);
    for (int k = 0; partner != NULL && m->explicit_cost > 0.0 && k < bgc_method_count; k++) {
        if (strcmp(bgc_methods[k].name, partner) == 0) {
            choice->partner = k;
        }
    }
}

/* At the start of a run. */
void bgc_reset_choice(const bgc_model *m, bgc_data *d) {
    bgc_begin_choice(m, d->core.method, &d->core.choice, &d->core.spectrum);
}

/* The largest step that the options and samples permit, at most h. */
static double permitted(const bgc_core *option, double h) {
    const double most = option->given.max_step > 0.0 ? fmin(h, option->given.max_step) : h;

    return option->period > 0.0 ? fmin(most, option->period) : most;
}

/* The next step that they permit. */
static double permitted_next(const bgc_chooser *of) { return permitted(of->option, *of->h_next); }

/* Changes to the other method at t. A second has cost as many implicit steps as `cost`. */
void bgc_change_method(bgc_choice *choice, bgc_counts *counts, double t, double cost, int is_trial) {
    choice->is_explicit = !choice->is_explicit;
    choice->is_trial = is_trial;
    choice->attempts = choice->unexcited = choice->limited = choice->look = 0;
    choice->since = t;
    choice->cost = cost;
    counts->method_changes++;
}

static void change_method(const bgc_chooser *of, double t, double cost, int is_trial) {
    bgc_change_method(of->choice, of->counts, t, cost, is_trial);
    *of->error_old = 1.0;
}

/* After a trial, or a return without one: longer before the next. */
static void wait_longer(bgc_choice *choice) {
    const int twice = choice->wait == 0 ? FIRST_WAIT : 2 * choice->wait;

    choice->wait = twice < LONGEST_WAIT ? twice : LONGEST_WAIT;
}

/* The longest step of the partner, times the dominant eigenvalue, under which error control resolves an
 * oscillation of that frequency whose amplitude is the scale of its states. Where steps are longer, the
 * dominant modes are not excited, and an implicit method need not resolve them. At most the stable one. */
static double longest_resolved(const bgc_core *option) {
    return fmin(margin * pow(error_constant * option->rtol, 1.0 / 6.0), oscillating);
}

/* The largest spectral radius under which wanted steps of the partner resolve all modes. Where samples limit
 * them, stable ones are enough. */
static double resolved_radius(const bgc_core *option, double wanted) {
    const double length = permitted(option, wanted);

    return (length < wanted ? stable : longest_resolved(option)) / length;
}

/* A whole estimate of the spectral radius. */
static double estimate_radius(const bgc_chooser *of, double enough) {
    of->spectrum->products = 0;
    while (of->continue_estimate(of->run, enough) == BGC_ESTIMATING) {
    }
    return of->spectrum->radius;
}

/* Whether a new estimate of the spectral radius is within `most`. Each that is not is followed by a longer
 * pause. */
static int is_slow(const bgc_chooser *of, double most) {
    bgc_choice *choice = of->choice;
    const int slow = estimate_radius(of, most) <= most;
    const int twice = choice->pause == 0 ? FIRST_PAUSE : 2 * choice->pause;

    choice->pause = slow ? FIRST_PAUSE : twice < LONGEST_PAUSE ? twice : LONGEST_PAUSE;
    choice->look = choice->attempts + choice->pause;
    return slow;
}

/* Whether steps of the partner are likely to cost less, after an implicit step of length h. */
static int partner_pays(const bgc_chooser *of, double h) {
    const double wanted = shorter * *of->h_next;

    return of->counts->steps > 0 && permitted_next(of) <= steady * h &&
           of->explicit_cost * permitted_next(of) < likely * permitted(of->option, wanted) &&
           of->choice->attempts >= of->choice->look && is_slow(of, resolved_radius(of->option, wanted));
}

/* Whether steps of the partner still resolve all modes. The spectral radius is estimated anew now and then. */
static int resolves(const bgc_chooser *of, double wanted) {
    const double most = lasting * resolved_radius(of->option, wanted);

    return of->choice->attempts >= of->choice->look ? is_slow(of, most)
                                                    : of->spectrum->radius <= most;
}

/* Judges a trial of the partner by the mean length of its steps. */
static void judge_partner(const bgc_chooser *of, double t) {
    bgc_choice *choice = of->choice;
    const double cost = of->explicit_cost * (double)choice->attempts / (t - choice->since);
    const double before = choice->cost;

    if (choice->attempts >= EXPLICIT_TRIAL) {
        choice->is_trial = 0;
        wait_longer(choice);

        /* The implicit method goes on with about the steps it had. */
        if (cost > cheaper * before || 2 * choice->unexcited > EXPLICIT_TRIAL) {
            change_method(of, t, cost, 0);
            *of->h_next = fmax(*of->h_next, fmin(1.0 / before, 2.0 * *of->h_next));
        }
    }
}

/* Judges a trial of the implicit method after a step of length h: by the next one, for it begins with those
 * of the partner. Where it returns, then with the step before the trial. */
static void judge_implicit(const bgc_chooser *of, double t, double h) {
    bgc_choice *choice = of->choice;
    const double cost = 1.0 / permitted_next(of), before = choice->cost;
    const int grows = *of->h_next > growing * h && choice->attempts < LONGEST_RAMP;

    if (choice->attempts >= IMPLICIT_TRIAL && (cost <= cheaper * before || !grows)) {
        choice->is_trial = 0;
        wait_longer(choice);
        if (cost > cheaper * before) {
            change_method(of, t, cost, 0);
            *of->h_next = fmin(*of->h_next, of->explicit_cost / before);
        }
    }
}

/* From the partner back after many steps that are short for stability alone, or do not resolve all modes;
 * for a trial now and then. */
static void leave_partner(const bgc_chooser *of, double t) {
    bgc_choice *choice = of->choice;
    const double cost = of->explicit_cost / permitted_next(of);

    if (choice->unexcited >= LONG_UNEXCITED || choice->limited >= LONG_LIMITED) {
        if (choice->attempts < FIRST_WAIT) {
            wait_longer(choice);
        }
        change_method(of, t, cost, 0);
    } else if (!choice->is_trial && choice->attempts >= choice->wait) {
        change_method(of, t, cost, 1);
    }
}

/* The number of steps for which something holds, less twice that of those for which it does not. */
static int count_leakily(int before, int holds) {
    return holds ? before + 1 : before > 2 ? before - 2 : 0;
}

/* After an accepted step of length h to t, by which *of->h_next is the next one: the method that takes it.
 * There is a partner. */
void bgc_choose(const bgc_chooser *of, double t, double h) {
    bgc_choice *choice = of->choice;

    choice->attempts++;
    of->counts->explicit_steps += choice->is_explicit;

    if (choice->is_explicit) {
        const double product = of->find_product(of->run);
        choice->unexcited = count_leakily(choice->unexcited, product > longest_resolved(of->option));
        choice->limited = resolves(of, *of->h_next) ? 0 : choice->limited + 1;
        if (choice->is_trial) {
            judge_partner(of, t);
        }
        if (choice->is_explicit) {
            leave_partner(of, t);
        }
    } else if (choice->is_trial) {
        judge_implicit(of, t, h);
    } else if (choice->attempts >= choice->wait && partner_pays(of, h)) {
        change_method(of, t, 1.0 / permitted_next(of), 1);
        *of->h_next *= shorter;
    }
}

/* After a rejected attempt at t, the present number `rejected` in a row. */
void bgc_enter_rejection(const bgc_chooser *of, double t, int rejected) {
    of->choice->attempts++;
    if (of->choice->is_explicit && rejected >= MOST_REJECTIONS) {
        wait_longer(of->choice);
        change_method(of, t, 0.0, 0);
    }
}

/* --- one instance -------------------------------------------------------------------------- */

/* Step times the dominant eigenvalue: |M^-1 (f - f')| h / |y - y'| of the last two stages. */
static double step_times_eigenvalue(void *run) {
    const bgc_model *m = ((const bgc_single *)run)->m;
    bgc_data *d = ((const bgc_single *)run)->d;
    const bgc_tableau *tableau = bgc_present_method(&d->core)->tableau;
    const int n = m->n_state, last = tableau->stages - 1;
    const double *u = d->stages + (size_t)last * bgc_padded(n), *before = u - bgc_padded(n);
    double weight[BGC_MAX_STAGES], distance;

    bgc_weigh_distance(tableau, weight);
    memset(d->point, 0, (size_t)n * sizeof *d->point);
    bgc_combine(n, last, weight, d->stages, d->point);
    for (int i = 0; i < n; i++) {
        d->right[i] = u[i] - before[i];
    }
    distance = bgc_norm(m, d, d->point, d->x, d->next);
    return distance > 0.0 ? bgc_norm(m, d, d->right, d->x, d->next) / distance : 0.0;
}

static bgc_estimate continue_estimate(void *run, double enough) {
    const bgc_single *single = run;

    return bgc_continue_estimate(single->m, single->d, enough);
}

/* The chooser of a run with error control. */
bgc_chooser bgc_chooser_of(bgc_single *single) {
    bgc_core *core = &single->d->core;

    return (bgc_chooser){
        .option = core,
        .explicit_cost = single->m->explicit_cost,
        .choice = &core->choice,
        .counts = &core->counts,
        .spectrum = &core->spectrum,
        .h_next = &core->h_next,
        .error_old = &core->error_old,
        .held = &core->held,
        .find_product = step_times_eigenvalue,
        .continue_estimate = continue_estimate,
        .run = single,
    };
}

/* After an accepted step of length h to d->next at t, before that becomes the present. */
void bgc_choose_method(const bgc_model *m, bgc_data *d, double t, double h) {
    bgc_single single = {m, d};

    if (d->core.choice.partner >= 0 && d->core.algebraic == 0) {
        const bgc_chooser of = bgc_chooser_of(&single);
        bgc_choose(&of, t, h);
    }
}

/* After a rejected attempt, the present number core->rejected in a row. */
void bgc_count_rejection(const bgc_model *m, bgc_data *d) {
    bgc_single single = {m, d};
    const bgc_chooser of = bgc_chooser_of(&single);

    bgc_enter_rejection(&of, d->core.t, d->core.rejected);
}
