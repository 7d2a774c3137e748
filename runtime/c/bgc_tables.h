/* bgc_tables.h: look up tables of data: piecewise polynomials of one argument, grids of two.
 *
 * compiler/algebra/table.py computes the same, and defines pieces, breaks and segments. A table has no
 * state: the interval of an argument is guessed by its place between the ends, exactly for even knots
 * and by a list for others, and then searched.
 */
#ifndef BGC_TABLES_H
#define BGC_TABLES_H

#include <math.h>

enum { BGC_NEAREST, BGC_LINEAR, BGC_CUBIC, BGC_STEP };
enum { BGC_HOLD, BGC_EXTRAPOLATE, BGC_REPEAT };

/* Rising knots. `rate` is the number of intervals over the distance of the ends; `guess` is the interval
 * at the start of each of as many equal parts, NULL where this is the number of the part or next to it. */
typedef struct {
    int n;
    double rate;
    const double *x;
    const int *guess;
} bgc_knots;

/* Of one argument. `d` are slopes, of a cubic. `breaks` are the n_break boundaries between segments;
 * NULL where each boundary is one. `low` and `high` are bounds of the values, and behind them of the
 * slopes, over blocks of pieces. */
typedef struct {
    int method, outside, n_break;
    bgc_knots knots;
    const double *y, *d, *low, *high;
    const int *breaks;
} bgc_table;

/* Of two arguments; `by` are the derivatives by x, by y and by both, NULL where it is bilinear. */
typedef struct {
    bgc_knots x, y;
    const double *z, *by[3];
} bgc_grid;

/* The interval of x, counted from 0; the first or last one outside. */
static inline int bgc_interval(const bgc_knots *k, double x) {
    int low, high;

    if (!(x > k->x[0])) {
        return 0;
    }
    if (x >= k->x[k->n - 1]) {
        return k->n - 2;
    }
    low = (int)((x - k->x[0]) * k->rate);
    low = low < k->n - 2 ? low : k->n - 2;
    high = low + 1;
    if (k->guess) {
        high = k->guess[low + 1] + 1;
        low = k->guess[low];
    }
    while (x < k->x[low]) {
        low--;
    }
    while (x >= k->x[high]) {
        high++;
    }
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;

        if (x < k->x[middle]) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

/* A cubic at u from the left end of an interval of length h, or its derivative; `slope` is that of the
 * chord, d0 and d1 are those at the ends. */
static inline double bgc_cubic_at(int order, double h, double u, double low, double slope, double d0,
                                 double d1) {
    const double c = (3.0 * slope - 2.0 * d0 - d1) / h, b = (d0 + d1 - 2.0 * slope) / (h * h);

    switch (order) {
    case 0:
        return low + u * (d0 + u * (c + u * b));
    case 1:
        return d0 + u * (2.0 * c + 3.0 * u * b);
    case 2:
        return 2.0 * c + 6.0 * u * b;
    default:
        return 6.0 * b;
    }
}

/* --- of one argument -------------------------------------------------------------------------- */

/* The number of the last piece; pieces 0 and n of those that do not repeat lie outside. */
static inline int bgc_last_piece(const bgc_table *t) {
    const int n = t->knots.n;

    return t->method == BGC_NEAREST                             ? n - 1
           : t->method == BGC_STEP || t->outside == BGC_REPEAT ? n - 2
                                                                : n;
}

/* The argument between pieces k and k + 1. */
static inline double bgc_boundary(const bgc_table *t, int k) {
    if (t->method == BGC_NEAREST) {
        return 0.5 * (t->knots.x[k] + t->knots.x[k + 1]);
    }
    return t->knots.x[t->method == BGC_STEP || t->outside == BGC_REPEAT ? k + 1 : k];
}

static inline int bgc_break(const bgc_table *t, int k) { return t->breaks ? t->breaks[k] : k; }

static inline int bgc_piece_at(const bgc_table *t, double x) {
    const int k = bgc_interval(&t->knots, x);

    if (t->method == BGC_NEAREST) {
        return x < bgc_boundary(t, k) ? k : k + 1;
    }
    if (t->method == BGC_STEP || t->outside == BGC_REPEAT) {
        return k;
    }
    return x < t->knots.x[0] ? 0 : x >= t->knots.x[t->knots.n - 1] ? t->knots.n : k + 1;
}

/* The straight line beyond one end. */
static inline double bgc_line(const bgc_table *t, int end, int order, double x) {
    const double *knot = t->knots.x;
    const int k = end < t->knots.n - 2 ? end : t->knots.n - 2;
    double slope;

    if (t->outside == BGC_HOLD) {
        return order == 0 ? t->y[end] : 0.0;
    }
    slope = t->method == BGC_CUBIC ? t->d[end] : (t->y[k + 1] - t->y[k]) / (knot[k + 1] - knot[k]);
    return order == 0 ? t->y[end] + slope * (x - knot[end]) : order == 1 ? slope : 0.0;
}

/* The polynomial of a piece, or its derivative. */
static inline double bgc_polynomial(const bgc_table *t, int piece, int order, double x) {
    const double *knot = t->knots.x, *y = t->y;
    double h, slope;

    if (t->method == BGC_NEAREST || t->method == BGC_STEP) {
        return order == 0 ? y[piece] : 0.0;
    }
    if (t->outside != BGC_REPEAT) {
        if (piece == 0 || piece == t->knots.n) {
            return bgc_line(t, piece == 0 ? 0 : t->knots.n - 1, order, x);
        }
        piece--;
    }
    h = knot[piece + 1] - knot[piece];
    slope = (y[piece + 1] - y[piece]) / h;
    if (t->method == BGC_LINEAR) {
        return order == 0 ? y[piece] + slope * (x - knot[piece]) : order == 1 ? slope : 0.0;
    }
    return bgc_cubic_at(order, h, x - knot[piece], y[piece], slope, t->d[piece], t->d[piece + 1]);
}

/* The number of whole periods before x; moves x to the first period. */
static inline double bgc_wrap(const bgc_table *t, double *x) {
    const double start = t->knots.x[0], end = t->knots.x[t->knots.n - 1], period = end - start;
    const double cycle = floor((*x - start) / period);

    *x = isfinite(*x) ? fmin(fmax(*x - cycle * period, start), end) : (double)NAN;
    return cycle;
}

static inline double bgc_lookup(const bgc_table *t, int order, double x) {
    if (t->outside == BGC_REPEAT) {
        bgc_wrap(t, &x);
    }
    return x == x ? bgc_polynomial(t, bgc_piece_at(t, x), order, x) : (double)NAN;
}

/* A continuous rising function whose whole part is the segment of x. */
static inline double bgc_place(const bgc_table *t, double x) {
    const int count = t->n_break, repeats = t->outside == BGC_REPEAT;
    const double span = t->knots.x[t->knots.n - 1] - t->knots.x[0];
    const double cycle = repeats ? bgc_wrap(t, &x) : 0.0;
    int piece, segment, high;
    double left, right, part;

    if (x != x) {
        return (double)NAN;
    }
    piece = bgc_piece_at(t, x);
    segment = t->breaks ? 0 : piece;
    high = t->breaks ? count : piece;
    while (segment < high) { /* the first break that is not before the piece */
        const int middle = segment + (high - segment) / 2;

        if (t->breaks[middle] < piece) {
            segment = middle + 1;
        } else {
            high = middle;
        }
    }
    left = segment > 0 ? bgc_boundary(t, bgc_break(t, segment - 1)) : t->knots.x[0];
    right = segment < count ? bgc_boundary(t, bgc_break(t, segment)) : t->knots.x[t->knots.n - 1];
    if (segment == 0 && !repeats) {
        part = (right - x) / span;
        return isfinite(part) ? 1.0 - 0.5 * part / (1.0 + part) : 0.5;
    }
    if (segment == count && !repeats) {
        part = (x - left) / span;
        return count + (isfinite(part) ? 0.5 * part / (1.0 + part) : 0.5);
    }
    part = fmin(fmax((x - left) / (right - left), 0.0), 1.0 - 0x1p-53);
    return cycle * (count + 1) + segment + part;
}

/* The function on a segment, continued beyond its ends. */
static inline double bgc_piece(const bgc_table *t, int order, double x, double segment) {
    const int count = t->n_break;
    int piece, first, last, s;

    if (x != x || segment != segment) {
        return (double)NAN;
    }
    if (t->outside == BGC_REPEAT) {
        const double cycle = floor(segment / (count + 1));

        segment -= cycle * (count + 1);
        x -= cycle * (t->knots.x[t->knots.n - 1] - t->knots.x[0]);
    }
    s = (int)fmin(fmax(segment, 0.0), count);
    first = s > 0 ? bgc_break(t, s - 1) + 1 : 0;
    last = s < count ? bgc_break(t, s) : bgc_last_piece(t);
    piece = first == last ? first : bgc_piece_at(t, x);
    piece = piece < first ? first : piece > last ? last : piece;
    return bgc_polynomial(t, piece, order, x);
}

/* --- of two arguments ------------------------------------------------------------------------- */

/* The function, or its derivative of these orders, by the polynomial of cell (i, j). */
static inline double bgc_cell(const bgc_grid *g, int i, int j, int by_x, int by_y, double x, double y) {
    const double h = g->x.x[i + 1] - g->x.x[i], u = x - g->x.x[i];
    const double k = g->y.x[j + 1] - g->y.x[j], v = y - g->y.x[j];
    const int at[2] = {i * g->y.n + j, (i + 1) * g->y.n + j};
    double end[2], slope[2];

    if (!g->by[0]) {
        for (int a = 0; a < 2; a++) {
            const double *z = g->z + at[a];

            end[a] = by_y == 0   ? (1.0 - v / k) * z[0] + v / k * z[1]
                     : by_y == 1 ? -1.0 / k * z[0] + 1.0 / k * z[1]
                                 : 0.0;
        }
        return by_x == 0   ? (1.0 - u / h) * end[0] + u / h * end[1]
               : by_x == 1 ? -1.0 / h * end[0] + 1.0 / h * end[1]
                           : 0.0;
    }
    for (int a = 0; a < 2; a++) {
        const int b = at[a];
        const double *z = g->z, *zx = g->by[0], *zy = g->by[1], *zxy = g->by[2];

        end[a] = bgc_cubic_at(by_y, k, v, z[b], (z[b + 1] - z[b]) / k, zy[b], zy[b + 1]);
        slope[a] = bgc_cubic_at(by_y, k, v, zx[b], (zx[b + 1] - zx[b]) / k, zxy[b], zxy[b + 1]);
    }
    return bgc_cubic_at(by_x, h, u, end[0], (end[1] - end[0]) / h, slope[0], slope[1]);
}

static inline double bgc_lookup2(const bgc_grid *g, int by_x, int by_y, double x, double y) {
    if (x != x || y != y) {
        return (double)NAN;
    }
    return bgc_cell(g, bgc_interval(&g->x, x), bgc_interval(&g->y, y), by_x, by_y, x, y);
}

#endif
