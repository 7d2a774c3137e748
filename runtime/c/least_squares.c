/* least_squares.c: the Levenberg-Marquardt method for a small dense system of equations.
 *
 * It needs no regular Jacobian and takes residuals over many powers of ten, where Newton's method
 * stops. Of equations that are monotone it approaches the one solution from afar; the last digits
 * are left to Newton's method. */
#include "bgc_internal.h"

#include <math.h>
#include <string.h>

enum { MAX_MARQUARDT = 150 };

static const double first_weight = 1e-3;   /* of the identity, against scaled rows */
static const double least_weight = 1e-16;
static const double largest_weight = 1e20; /* where no shorter step helps */
static const double least_gain = 1e-6;     /* relative decrease of the residual in a step */
static const double begins_newton = 1e-12;   /* scaled residual at which Newton's method takes over */

/* Least-squares solution of the 2n by n system in `a` (rows [A; w I]), with right-hand side b (2n),
 * by Householder reflections; the solution is left in b. Returns whether it is finite. */
static int solve_least_squares(int n, double *a, double *b) {
    const int rows = 2 * n;

    for (int k = 0; k < n; k++) {
        double norm = 0.0, head;
        for (int i = k; i < rows; i++) {
            norm = hypot(norm, a[i * n + k]);
        }
        if (!(norm > 0.0) || !isfinite(norm)) {
            return 0;
        }

        /* The reflection that turns column k onto its diagonal entry; its vector replaces the column. */
        norm = a[k * n + k] > 0.0 ? -norm : norm;
        head = a[k * n + k] - norm;
        for (int j = k + 1; j <= n; j++) {
            double dot = 0.0;
            for (int i = k; i < rows; i++) {
                const double v = i == k ? head : a[i * n + k];
                dot += v * (j < n ? a[i * n + j] : b[i]);
            }
            dot /= norm * head;
            for (int i = k; i < rows; i++) {
                const double v = i == k ? head : a[i * n + k];
                *(j < n ? &a[i * n + j] : &b[i]) += v * dot;
            }
        }
        a[k * n + k] = norm;
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) {
            b[i] -= a[i * n + j] * b[j];
        }
        b[i] /= a[i * n + i];
    }
    return bgc_first_bad(n, b) < 0;
}

/* Euclidean norm of the residual, rows scaled. */
static double scaled_norm(int n, const double *residual, const double *row_scale) {
    double sum = 0.0;

    for (int k = 0; k < n; k++) {
        sum = hypot(sum, residual[k] * row_scale[k]);
    }
    return isfinite(sum) ? sum : (double)INFINITY;
}

/* Moves y towards a zero of the residual, until it is near or no step helps; `scale` are the sizes
 * of the unknowns. Returns whether residual and matrix are finite where it begins. */
int bgc_least_squares(const bgc_dense_system *s, double *y, const double *scale) {
    const int n = s->n;
    double *residual = s->work, *row_scale = residual + n, *trial = row_scale + n;
    double *next = trial + n, *step = next + n, *matrix = step + 2 * n, *wide = matrix + n * n;
    double weight = first_weight;

    if (!s->residual(s->of, y, residual)) {
        return 0;
    }
    for (int k = 0; k < MAX_MARQUARDT; k++) {
        double length;

        /* Rows scaled to the sum of their entries, columns by the size of the unknowns. */
        if (!s->matrix(s->of, y, matrix)) {
            return k > 0;
        }
        for (int i = 0; i < n; i++) {
            double sum = 0.0;
            for (int j = 0; j < n; j++) {
                matrix[i * n + j] *= fmax(fabs(y[j]), 1e-3 * scale[j]);
                sum += fabs(matrix[i * n + j]);
            }
            row_scale[i] = sum > 0.0 && isfinite(sum) ? 1.0 / sum : 1.0;
        }
        length = scaled_norm(n, residual, row_scale);
        if (length <= begins_newton) {
            return 1;
        }

        /* The longest step that makes the residual smaller. */
        for (;; weight = fmax(4.0 * weight, 1e-12)) {
            if (weight > largest_weight) {
                return 1;
            }
            for (int i = 0; i < n; i++) {
                for (int j = 0; j < n; j++) {
                    wide[i * n + j] = matrix[i * n + j] * row_scale[i];
                    wide[(n + i) * n + j] = i == j ? sqrt(weight) : 0.0;
                }
                step[i] = -residual[i] * row_scale[i];
                step[n + i] = 0.0;
            }
            if (!solve_least_squares(n, wide, step)) {
                continue;
            }
            for (int i = 0; i < n; i++) {
                trial[i] = y[i] + step[i] * fmax(fabs(y[i]), 1e-3 * scale[i]);
            }
            if (s->residual(s->of, trial, next) &&
                scaled_norm(n, next, row_scale) < (1.0 - least_gain) * length) {
                break;
            }
        }
        memcpy(y, trial, (size_t)n * sizeof *y);
        memcpy(residual, next, (size_t)n * sizeof *residual);
        weight = fmax(weight / 8.0, least_weight);
    }
    return 1;
}
