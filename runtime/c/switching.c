/* switching.c: the choice between the implicit method of a run and its explicit partner, step by
 * step.
 *
 * The compiler compares the operations of a step of both (m->explicit_cost). A run begins with the
 * implicit method. It changes to the partner where steps that error control permits resolve all
 * modes, by an estimate of the spectral radius (spectrum.c), and are likely to cost less. Longer
 * ones would excite fast modes, which the implicit method then has to resolve. Each change is a
 * trial: where a second costs more than before, the run returns. From the partner it changes back
 * for a few steps now and then, and for long where its steps no longer resolve all modes, or are
 * short for stability alone: it estimates the dominant eigenvalue from its last two stages, which
 * are at the same time. E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2.
 *
 * A batch of instances, which take their steps together, chooses by the largest radius and product
 * of its instances, for the stiffest one determines its steps.
 */
#include "bgc_internal.h"

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

/* The method that takes the next step. */
const bgc_method *bgc_present_method(const bgc_core *core) {
    return &bgc_methods[core->choice.is_explicit ? core->choice.partner : core->method];
}

/* At the start of a run: the implicit method. It has a partner only where this may pay. */
void bgc_reset_choice(const bgc_model *m, bgc_ivp *d) {
    const char *partner = bgc_methods[d->core.method].partner;

    d->core.choice = (bgc_choice){.partner = -1};
    d->core.spectrum = (bgc_spectrum){.radius = INFINITY};
    for (int k = 0; partner != NULL && m->explicit_cost > 0.0 && k < bgc_method_count; k++) {
        if (strcmp(bgc_methods[k].name, partner) == 0) {
            d->core.choice.partner = k;
        }
    }
}

/* The largest step that the options and samples permit, at most h. */
static double permitted(const bgc_core *option, double h) {
    const double most = option->given.max_step > 0.0 ? fmin(h, option->given.max_step) : h;

    return option->period > 0.0 ? fmin(most, option->period) : most;
}

/* The next step that they permit. */
static double permitted_next(const bgc_ivp *d) { return permitted(&d->core, d->core.h_next); }

/* Changes to the other method at t. A second has cost as many implicit steps as `cost`. */
void bgc_change_method(bgc_ivp *d, double t, double cost, int is_trial) {
    bgc_choice *choice = &d->core.choice;

    choice->is_explicit = !choice->is_explicit;
    choice->is_trial = is_trial;
    choice->attempts = choice->unexcited = choice->limited = choice->look = 0;
    choice->since = t;
    choice->cost = cost;
    d->core.counts.method_changes++;
    d->core.error_old = 1.0;
}

/* After a trial, or a return without one: longer before the next. */
static void wait_longer(bgc_choice *choice) {
    const int twice = choice->wait == 0 ? FIRST_WAIT : 2 * choice->wait;

    choice->wait = twice < LONGEST_WAIT ? twice : LONGEST_WAIT;
}

/* The longest step of the partner, times the dominant eigenvalue, under which error control
 * resolves an oscillation of that frequency whose amplitude is the scale of its states. Where steps
 * are longer, the dominant modes are not excited, and an implicit method need not resolve them. At
 * most the stable one. */
static double longest_resolved(const bgc_core *option) {
    return fmin(margin * pow(error_constant * option->rtol, 1.0 / 6.0), oscillating);
}

/* The largest spectral radius under which wanted steps of the partner resolve all modes. Where
 * samples limit them, stable ones are enough. */
static double resolved_radius(const bgc_core *option, double wanted) {
    const double length = permitted(option, wanted);

    return (length < wanted ? stable : longest_resolved(option)) / length;
}

/* A whole estimate of the spectral radius. */
static double estimate_radius(const bgc_model *m, bgc_ivp *d, double enough) {
    d->core.spectrum.products = 0;
    while (bgc_continue_estimate(m, d, enough) == BGC_ESTIMATING) {
    }
    return d->core.spectrum.radius;
}

/* Whether a new estimate of the spectral radius is within `most`. Each that is not is followed by a
 * longer pause. */
static int is_slow(const bgc_model *m, bgc_ivp *d, double most) {
    bgc_choice *choice = &d->core.choice;
    const int slow = estimate_radius(m, d, most) <= most;
    const int twice = choice->pause == 0 ? FIRST_PAUSE : 2 * choice->pause;

    choice->pause = slow ? FIRST_PAUSE : twice < LONGEST_PAUSE ? twice : LONGEST_PAUSE;
    choice->look = choice->attempts + choice->pause;
    return slow;
}

/* Whether steps of the partner are likely to cost less, after an implicit step of length h. */
static int partner_pays(const bgc_model *m, bgc_ivp *d, double h) {
    const double wanted = shorter * d->core.h_next;

    return d->core.counts.steps > 0 && permitted_next(d) <= steady * h &&
           m->explicit_cost * permitted_next(d) < likely * permitted(&d->core, wanted) &&
           d->core.choice.attempts >= d->core.choice.look &&
           is_slow(m, d, resolved_radius(&d->core, wanted));
}

/* Whether steps of the partner still resolve all modes. The spectral radius is estimated anew now
 * and then. */
static int resolves(const bgc_model *m, bgc_ivp *d, double wanted) {
    const double most = lasting * resolved_radius(&d->core, wanted);

    return d->core.choice.attempts >= d->core.choice.look ? is_slow(m, d, most)
                                                          : d->core.spectrum.radius <= most;
}

/* Judges a trial of the partner by the mean length of its steps. */
static void judge_partner(const bgc_model *m, bgc_ivp *d, double t) {
    bgc_choice *choice = &d->core.choice;
    const double cost = m->explicit_cost * (double)choice->attempts / (t - choice->since);
    const double before = choice->cost;

    if (choice->attempts >= EXPLICIT_TRIAL) {
        choice->is_trial = 0;
        wait_longer(choice);

        /* The implicit method goes on with about the steps it had. */
        if (cost > cheaper * before || 2 * choice->unexcited > EXPLICIT_TRIAL) {
            bgc_change_method(d, t, cost, 0);
            d->core.h_next = fmax(d->core.h_next, fmin(1.0 / before, 2.0 * d->core.h_next));
        }
    }
}

/* Judges a trial of the implicit method after a step of length h: by the next one, for it begins
 * with those of the partner. Where it returns, then with the step before the trial. */
static void judge_implicit(const bgc_model *m, bgc_ivp *d, double t, double h) {
    bgc_choice *choice = &d->core.choice;
    const double cost = 1.0 / permitted_next(d), before = choice->cost;
    const int grows = d->core.h_next > growing * h && choice->attempts < LONGEST_RAMP;

    if (choice->attempts >= IMPLICIT_TRIAL && (cost <= cheaper * before || !grows)) {
        choice->is_trial = 0;
        wait_longer(choice);
        if (cost > cheaper * before) {
            bgc_change_method(d, t, cost, 0);
            d->core.h_next = fmin(d->core.h_next, m->explicit_cost / before);
        }
    }
}

/* From the partner back after many steps that are short for stability alone, or do not resolve all
 * modes; for a trial now and then. */
static void leave_partner(const bgc_model *m, bgc_ivp *d, double t) {
    bgc_choice *choice = &d->core.choice;
    const double cost = m->explicit_cost / permitted_next(d);

    if (choice->unexcited >= LONG_UNEXCITED || choice->limited >= LONG_LIMITED) {
        if (choice->attempts < FIRST_WAIT) {
            wait_longer(choice);
        }
        bgc_change_method(d, t, cost, 0);
    } else if (!choice->is_trial && choice->attempts >= choice->wait) {
        bgc_change_method(d, t, cost, 1);
    }
}

/* The number of steps for which something holds, less twice that of those for which it does not. */
static int count_leakily(int before, int holds) {
    return holds ? before + 1 : before > 2 ? before - 2 : 0;
}

/* Step times the dominant eigenvalue, |M^-1 (f - f')| h / |y - y'|, of the last two stages, which
 * are at the same time: they themselves differ by the numerator. Of a batch, the largest. Scratch:
 * d->point, d->right. */
static double step_times_eigenvalue(const bgc_model *m, bgc_ivp *d) {
    const bgc_tableau *tableau = bgc_present_method(&d->core)->tableau;
    const int n = m->n_state, last = tableau->stages - 1;
    const number *u = d->stages + (size_t)last * bgc_chunked(n), *before = u - bgc_chunked(n);
    double weight[BGC_MAX_STAGES];
    number distance, change;

    for (int j = 0; j < last; j++) {
        weight[j] = tableau->a[last][j] - tableau->a[last - 1][j];
    }
    bgc_combine(n, last, weight, d->stages, NULL, d->point);
    for (int i = 0; i < n; i++) {
        d->right[i] = u[i] - before[i];
    }
    distance = bgc_norm(m, d, d->point, d->x, d->next);
    change = bgc_norm(m, d, d->right, d->x, d->next);
    return bgc_largest_together(d, number_select(distance > number_of(0.0), change / distance,
                                                 number_of(0.0)));
}

/* After an accepted step of length h to d->next at t, by which d->core.h_next is the next one,
 * before that becomes the present: the method that takes it. */
void bgc_choose_method(const bgc_model *m, bgc_ivp *d, double t, double h) {
    bgc_choice *choice = &d->core.choice;

    if (choice->partner < 0 || d->core.algebraic > 0) {
        return;
    }
    choice->attempts++;
    d->core.counts.explicit_steps += choice->is_explicit;

    if (choice->is_explicit) {
        const double product = step_times_eigenvalue(m, d);
        choice->unexcited = count_leakily(choice->unexcited, product > longest_resolved(&d->core));
        choice->limited = resolves(m, d, d->core.h_next) ? 0 : choice->limited + 1;
        if (choice->is_trial) {
            judge_partner(m, d, t);
        }
        if (choice->is_explicit) {
            leave_partner(m, d, t);
        }
    } else if (choice->is_trial) {
        judge_implicit(m, d, t, h);
    } else if (choice->attempts >= choice->wait && partner_pays(m, d, h)) {
        bgc_change_method(d, t, 1.0 / permitted_next(d), 1);
        d->core.h_next *= shorter;
    }
}

/* After a rejected attempt, the present number core.rejected in a row. */
void bgc_count_rejection(bgc_ivp *d) {
    bgc_choice *choice = &d->core.choice;

    choice->attempts++;
    if (choice->is_explicit && d->core.rejected >= MOST_REJECTIONS) {
        wait_longer(choice);
        bgc_change_method(d, d->core.t, 0.0, 0);
    }
}
