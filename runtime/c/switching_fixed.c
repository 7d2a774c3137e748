/* switching_fixed.c: the choice between the implicit method of a run with fixed steps and its explicit
 * partner.
 *
 * A run begins with the implicit method and becomes explicit while the step resolves all modes: both give
 * about the same error then, and an explicit step needs no Jacobian. The spectral radius is estimated
 * along the run (spectrum.c), by one evaluation of f in some of the steps, so that no step takes much
 * longer than the others. A law that stiffens between two estimates shows in the stages of the explicit
 * method: that calls for an estimate at once, or the implicit method takes the step again. A batch chooses
 * likewise.
 */
#include "bgc_internal.h"
#include "switching.h"

#include <math.h>

/* Steps between two products of an estimate, and between an estimate and the next, while steps are
 * explicit; after one that steps do not resolve more, up to the longest pause. */
enum { BETWEEN_PRODUCTS = 7, BETWEEN_ESTIMATES = 16, LONG_PAUSE = 64, LONGEST_FIXED_PAUSE = 256 };
/* Step times the spectral radius up to which a run becomes, and stays, explicit. */
static const double resolved_to_enter = 0.35, resolved_to_stay = 0.5;
/* The same by the stages of a step, over that at the last estimate: that which calls for another at once,
 * and that which rejects the step. The latter at least `unstable`: a norm may be larger than the radius. */
static const double grown = 2.0, far_grown = 4.0, unstable = 1.0;

static void change_fixed_method(const bgc_chooser *of, double t) {
    bgc_change_method(of->choice, of->counts, t, 0.0, 0);
    of->choice->usual = -1.0;
    *of->held = 0;
}

/* After a fixed step from t that failed: whether it was explicit, so that the implicit method tries it again. */
int bgc_return_to_implicit(const bgc_chooser *of, double t) {
    if (!of->choice->is_explicit) {
        return 0;
    }
    change_fixed_method(of, t);
    of->choice->look = of->choice->pause = LONG_PAUSE;
    of->spectrum->products = 0;
    return 1;
}

/* After an explicit step from t, before it is accepted: whether a law has stiffened so much that it may be
 * unstable. The implicit method tries it again. */
int bgc_rejects_product(const bgc_chooser *of, double t) {
    bgc_choice *choice = of->choice;

    if (!choice->is_explicit) {
        return 0;
    }
    choice->product = of->find_product(of->run);
    if (choice->usual < 0.0) {
        choice->usual = choice->product;
    }
    return choice->product > fmax(unstable, far_grown * choice->usual) &&
           bgc_return_to_implicit(of, t);
}

/* After an accepted fixed step to t: explicit where the steps resolve all modes, by an estimate of the
 * spectral radius that takes one product at a time. There is a partner. */
void bgc_choose_fixed(const bgc_chooser *of, double t) {
    bgc_choice *choice = of->choice;
    const double most =
        (choice->is_explicit ? resolved_to_stay : resolved_to_enter) / of->option->step;

    choice->attempts++;
    of->counts->explicit_steps += choice->is_explicit;
    if (choice->is_explicit && choice->product > fmax(resolved_to_stay, grown * choice->usual)) {
        choice->look = choice->attempts;
    }
    if (choice->attempts < choice->look) {
        return;
    }

    /* One product. */
    if (of->continue_estimate(of->run, most) == BGC_ESTIMATING) {
        choice->look = choice->attempts + (of->spectrum->estimates > 0 ? BETWEEN_PRODUCTS : 1);
        return;
    }
    if ((of->spectrum->radius <= most) != choice->is_explicit) {
        change_fixed_method(of, t);
    }
    if (choice->is_explicit) {
        choice->pause = BETWEEN_ESTIMATES;
        choice->usual = choice->usual < 0.0 ? choice->usual : choice->product;
    } else {
        choice->pause = 2 * choice->pause > LONG_PAUSE ? 2 * choice->pause : LONG_PAUSE;
        choice->pause = choice->pause < LONGEST_FIXED_PAUSE ? choice->pause : LONGEST_FIXED_PAUSE;
    }
    choice->look = choice->attempts + choice->pause;
}

/* --- one instance -------------------------------------------------------------------------- */

static double middle_product(void *run) {
    const bgc_single *single = run;
    const bgc_data *d = single->d;
    const size_t width = bgc_padded(single->m->n_state);

    return bgc_product_of_middle(single->m->n_state, d->scale, d->stages, d->stages + width,
                                 d->stages + 2 * width);
}

static bgc_chooser fixed_chooser_of(bgc_single *single) {
    bgc_chooser of = bgc_chooser_of(single);

    of.find_product = middle_product;
    return of;
}

int bgc_return_from_partner(const bgc_model *m, bgc_data *d) {
    bgc_single single = {m, d};
    const bgc_chooser of = fixed_chooser_of(&single);

    return bgc_return_to_implicit(&of, d->core.t);
}

int bgc_rejects_explicit_step(const bgc_model *m, bgc_data *d) {
    bgc_single single = {m, d};
    const bgc_chooser of = fixed_chooser_of(&single);

    return bgc_rejects_product(&of, d->core.t);
}

/* After an accepted step to d->next, before that becomes the present. */
void bgc_choose_fixed_method(const bgc_model *m, bgc_data *d) {
    bgc_single single = {m, d};

    if (d->core.choice.partner >= 0 && d->core.algebraic == 0) {
        const bgc_chooser of = fixed_chooser_of(&single);
        bgc_choose_fixed(&of, d->core.t);
    }
}
