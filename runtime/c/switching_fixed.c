/* switching_fixed.c: the choice between the implicit method of a run with fixed steps and its
 * explicit partner.
 *
 * A run begins with the implicit method and becomes explicit while the step resolves all modes:
 * both give about the same error then, and an explicit step needs no Jacobian. The spectral radius
 * is estimated along the run (spectrum.c), by one evaluation of f in some of the steps, so that no
 * step takes much longer than the others. A law that stiffens between two estimates shows in the
 * stages of the explicit method: that calls for an estimate at once, or the implicit method takes
 * the step again. A batch chooses by its stiffest instance.
 */
#include "bgc_internal.h"

#include <math.h>

/* Steps between two products of an estimate, and between an estimate and the next, while steps are
 * explicit; after one that steps do not resolve more, up to the longest pause. */
enum { BETWEEN_PRODUCTS = 7, BETWEEN_ESTIMATES = 16, LONG_PAUSE = 64, LONGEST_FIXED_PAUSE = 256 };
/* Step times the spectral radius up to which a run becomes, and stays, explicit. */
static const double resolved_to_enter = 0.35, resolved_to_stay = 0.5;
/* The same by the stages of a step, over that at the last estimate: that which calls for another at
 * once, and that which rejects the step. The latter at least `unstable`: a norm may be larger than
 * the radius. */
static const double grown = 2.0, far_grown = 4.0, unstable = 1.0;

static void change_fixed_method(bgc_ivp *d, double t) {
    bgc_change_method(d, t, 0.0, 0);
    d->core.choice.usual = -1.0;
    d->core.held = 0;
}

/* After a fixed step that failed: whether it was explicit, so that the implicit method tries it
 * again. */
int bgc_return_from_partner(bgc_ivp *d) {
    bgc_choice *choice = &d->core.choice;

    if (!choice->is_explicit) {
        return 0;
    }
    change_fixed_method(d, d->core.t);
    choice->look = choice->pause = LONG_PAUSE;
    d->core.spectrum.products = 0;
    return 1;
}

/* Step times the dominant eigenvalue, from the two stages in the middle of a step of rk4, which are
 * U_2 at x + U_1 / 2 and U_3 at x + U_2 / 2. Of a batch, the largest. */
static double middle_product(const bgc_model *m, const bgc_ivp *d) {
    const size_t width = bgc_chunked(m->n_state);
    const number *first = d->stages, *second = first + width, *third = second + width;
    const number none = number_of(0.0);
    number change = none, distance = none;

    for (int i = 0; i < m->n_state; i++) {
        const number unit = 1.0 / d->scale[i];
        const number rise = (third[i] - second[i]) * unit, apart = (second[i] - first[i]) * unit;
        change += rise * rise;
        distance += apart * apart;
    }
    return bgc_largest_together(
        d, number_select(distance > none, 2.0 * number_sqrt(change / distance), none));
}

/* After an explicit step, before it is accepted: whether a law has stiffened so much that it may be
 * unstable. The implicit method tries it again. */
int bgc_rejects_explicit_step(const bgc_model *m, bgc_ivp *d) {
    bgc_choice *choice = &d->core.choice;

    if (!choice->is_explicit) {
        return 0;
    }
    choice->product = middle_product(m, d);
    if (choice->usual < 0.0) {
        choice->usual = choice->product;
    }
    return choice->product > fmax(unstable, far_grown * choice->usual) &&
           bgc_return_from_partner(d);
}

/* After an accepted fixed step to d->next, before that becomes the present: explicit where the
 * steps resolve all modes, by an estimate of the spectral radius that takes one product at a
 * time. */
void bgc_choose_fixed_method(const bgc_model *m, bgc_ivp *d) {
    bgc_choice *choice = &d->core.choice;
    const double most = (choice->is_explicit ? resolved_to_stay : resolved_to_enter) / d->core.step;

    if (choice->partner < 0 || d->core.algebraic > 0) {
        return;
    }
    choice->attempts++;
    d->core.counts.explicit_steps += choice->is_explicit;
    if (choice->is_explicit && choice->product > fmax(resolved_to_stay, grown * choice->usual)) {
        choice->look = choice->attempts;
    }
    if (choice->attempts < choice->look) {
        return;
    }

    /* One product. */
    if (bgc_continue_estimate(m, d, most) == BGC_ESTIMATING) {
        choice->look = choice->attempts + (d->core.spectrum.estimates > 0 ? BETWEEN_PRODUCTS : 1);
        return;
    }
    if ((d->core.spectrum.radius <= most) != choice->is_explicit) {
        change_fixed_method(d, d->core.t);
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
