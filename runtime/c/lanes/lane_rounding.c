/* lane_rounding.c: detection of runs whose steps are limited by the rounding of f, of a batch:
 * rounding.c. */
#include "lanes/batch.h"
#include "rounding.h"

#include <string.h>

/* Whether the next attempt is a sample. */
int bgc_batch_samples_rounding(const bgc_batch *b) {
    return b->counts.steps > 0 && b->counts.steps % BGC_ROUNDING_INTERVAL == 0 && !b->rejected &&
           b->m->n_input == 0;
}

/* Exchanges two arrays. */
static void swap(lane **a, lane **b) {
    lane *other = *a;

    *a = *b;
    *b = other;
}

/* Puts the shifted state in the place of the state, or back, and the estimate of an attempt from there
 * apart. */
static void exchange_states(bgc_batch *b) {
    swap(&b->x, &b->shifted);
    swap(&b->f, &b->shifted_f);
    swap(&b->error, &b->noise);
}

/* The state at a part of the last step before its end, to b->shifted; returns that time. Where an instance
 * took that step by itself, the state and the time of the present. */
static double find_shifted(bgc_batch *b) {
    const int n = b->m->n_state;
    const double shift = b->apart ? 0.0 : bgc_shift_of_step * (b->t - b->t_old);

    if (shift == 0.0) {
        memcpy(b->shifted, b->x, (size_t)n * sizeof *b->x);
    } else if (b->method->family->jacobian) { /* with stiff equations, a tangent leaves the solution */
        bgc_batch_interpolate(b, b->t - shift);
        memcpy(b->shifted, b->point, (size_t)n * sizeof *b->x);
    } else {
        for (int i = 0; i < n; i++) {
            b->shifted[i] = b->x[i] - shift * b->inverse_mass[i] * b->f[i];
        }
    }
    return b->t - shift;
}

/* Makes the attempt of length h from a perturbed state, and keeps its error estimate in b->noise. Nothing
 * else of the batch changes but scratch. */
void bgc_batch_try_perturbed(bgc_batch *b, double h) {
    const bgc_batch before = *b;

    b->t = find_shifted(b);
    exchange_states(b);
    if (b->method->family->jacobian) { /* before the rounding errors change */
        bgc_batch_factorise(b, h);
        b->held = 1;
    }
    bgc_shift_states(b->m->n_state, b->x, b->scale, b->scale_reached, b->option->rtol,
                     b->option->atol, b->x);
    bgc_batch_forget_f(b);
    bgc_batch_evaluate_f(b);
    bgc_batch_advance(b, h);
    *b = before;
}

/* After the same attempt from the state itself, with these errors over the tolerances. */
void bgc_batch_judge_rounding(bgc_batch *b, lane errors) {
    lane noise;
    lane_mask found;

    for (int i = 0; i < b->m->n_state; i++) {
        b->noise[i] -= b->error[i];
    }
    noise = bgc_batch_norm(b, b->noise, b->x, b->next);
    found = bgc_rounding_dominates(noise, errors);
    b->counts.rounding_samples++;
    b->rounding += lane_select(found, lane_of(1.0), lane_of(0.0));
    b->largest_rounding =
        lane_select(found, number_larger(b->largest_rounding, noise), b->largest_rounding);
}

/* At the end of a run: adds the samples of lane l to those of the steps which it took by itself. */
void bgc_batch_report_rounding(const bgc_batch *b, int l, bgc_counts *counts) {
    counts->rounding_samples += b->counts.rounding_samples;
    counts->rounding += (long)lane_get(b->rounding, l);
    counts->largest_rounding = fmax(counts->largest_rounding, lane_get(b->largest_rounding, l));
}
