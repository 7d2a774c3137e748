/* bgc_table_ranges.h: ranges of tables of data over ranges of their arguments.
 *
 * A polynomial lies between the least and the largest of its Bernstein coefficients, which follow from
 * values and slopes at the ends of an interval.
 */
#ifndef BGC_TABLE_RANGES_H
#define BGC_TABLE_RANGES_H

#include "bgc_ranges.h"
#include "bgc_tables.h"

enum { BGC_BLOCK = 64, BGC_MOST_CELLS = 4096 };

/* Where the Bernstein coefficients of a polynomial of a degree, at most 3, are: at the value at one end
 * plus a part of the width times the slope there. Returns their number. */
static inline int bgc_coefficients(int degree, int end[4], double part[4]) {
    static const double first[4] = {0.0, 0.0, 0.5, 1.0 / 3.0};
    const int count = degree > 0 ? degree + 1 : 1;

    for (int i = 0; i < count; i++) {
        end[i] = i > 0 && (i >= 2 || degree == 1);
        part[i] = 0.0;
    }
    if (degree >= 2) {
        part[1] = first[degree];
    }
    if (degree == 3) {
        part[2] = -first[3];
    }
    return count;
}

static inline void bgc_include(bgc_range *range, double value) {
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

/* Of the polynomial of a piece over [a, b], which are finite. */
static inline void bgc_include_piece(const bgc_table *t, int piece, int order, double a, double b,
                                     bgc_range *range) {
    static const int degree[] = {0, 1, 3, 0};
    const double at[2] = {a, b};
    double part[4];
    int end[4];

    const int count = bgc_coefficients(degree[t->method] - order, end, part);
    for (int i = 0; i < count; i++) {
        double value = bgc_polynomial(t, piece, order, at[end[i]]);
        if (part[i] != 0.0) {
            value += part[i] * (b - a) * bgc_polynomial(t, piece, order + 1, at[end[i]]);
        }
        bgc_include(range, value);
    }
}

/* Of all pieces between two arguments, of which a table that repeats has those of one period. */
static inline bgc_range bgc_range_inside(const bgc_table *t, int order, double a, double b) {
    const int first = bgc_piece_at(t, a), last = bgc_piece_at(t, b);
    const int blocks = (bgc_last_piece(t) + BGC_BLOCK) / BGC_BLOCK;
    bgc_range range = {INFINITY, -INFINITY};

    for (int k = first; k <= last; k++) {
        if (t->low && order < 2 && k % BGC_BLOCK == 0 && k > first && k + BGC_BLOCK <= last) {
            bgc_include(&range, t->low[order * blocks + k / BGC_BLOCK]);
            bgc_include(&range, t->high[order * blocks + k / BGC_BLOCK]);
            k += BGC_BLOCK - 1;
        } else {
            bgc_include_piece(t, k, order, k == first ? a : bgc_boundary(t, k - 1),
                              k == last ? b : bgc_boundary(t, k), &range);
        }
    }
    return range;
}

static inline bgc_range bgc_range_lookup(const bgc_table *t, int order, bgc_range x) {
    const double start = t->knots.x[0], end = t->knots.x[t->knots.n - 1];

    if (t->outside == BGC_REPEAT) {
        double a = x.low, b = x.high;

        if (!(b - a < end - start)) {
            return bgc_range_inside(t, order, start, end);
        }
        if (bgc_wrap(t, &a) == bgc_wrap(t, &b)) {
            return bgc_range_inside(t, order, a, b);
        }
        return bgc_range_union(bgc_range_inside(t, order, a, end), bgc_range_inside(t, order, start, b));
    }
    if (!isfinite(x.low) || !isfinite(x.high)) {
        if (t->outside == BGC_EXTRAPOLATE) {
            return bgc_range_unknown();
        }
        x.low = fmax(x.low, start - (end - start));
        x.high = fmin(x.high, end + (end - start));
    }
    return x.low <= x.high ? bgc_range_inside(t, order, x.low, x.high) : bgc_range_unknown();
}

static inline bgc_range bgc_range_place(const bgc_table *t, bgc_range x) {
    return bgc_range_between(bgc_place(t, x.low), bgc_place(t, x.high));
}

/* The segment is that of the argument: modes are open while ranges are computed. */
static inline bgc_range bgc_range_piece(const bgc_table *t, int order, bgc_range x, bgc_range segment) {
    (void)segment;
    return bgc_range_lookup(t, order, x);
}

/* Of the polynomial of a cell over a rectangle. */
static inline void bgc_include_cell(const bgc_grid *g, int i, int j, const int by[2], bgc_range x,
                                    bgc_range y, bgc_range *range) {
    const int degree = g->by[0] ? 3 : 1;
    const double across[2] = {x.low, x.high}, along[2] = {y.low, y.high};
    double part_x[4], part_y[4];
    int end_x[4], end_y[4];

    const int count_x = bgc_coefficients(degree - by[0], end_x, part_x);
    const int count_y = bgc_coefficients(degree - by[1], end_y, part_y);
    for (int a = 0; a < count_x; a++) {
        for (int b = 0; b < count_y; b++) {
            const double u = across[end_x[a]], v = along[end_y[b]];
            const double wx = part_x[a] * (x.high - x.low), wy = part_y[b] * (y.high - y.low);
            double value = bgc_cell(g, i, j, by[0], by[1], u, v);

            if (wx != 0.0) {
                value += wx * bgc_cell(g, i, j, by[0] + 1, by[1], u, v);
            }
            if (wy != 0.0) {
                value += wy * bgc_cell(g, i, j, by[0], by[1] + 1, u, v);
            }
            if (wx != 0.0 && wy != 0.0) {
                value += wx * wy * bgc_cell(g, i, j, by[0] + 1, by[1] + 1, u, v);
            }
            bgc_include(range, value);
        }
    }
}

static inline bgc_range bgc_range_lookup2(const bgc_grid *g, int by_x, int by_y, bgc_range x,
                                          bgc_range y) {
    const int by[2] = {by_x, by_y};
    bgc_range range = {INFINITY, -INFINITY};
    int i0, i1, j0, j1;

    if (!(isfinite(x.low) && isfinite(x.high) && isfinite(y.low) && isfinite(y.high))) {
        return bgc_range_unknown();
    }
    i0 = bgc_interval(&g->x, x.low), i1 = bgc_interval(&g->x, x.high);
    j0 = bgc_interval(&g->y, y.low), j1 = bgc_interval(&g->y, y.high);
    if ((double)(i1 - i0 + 1) * (j1 - j0 + 1) > BGC_MOST_CELLS) {
        return bgc_range_unknown();
    }
    for (int i = i0; i <= i1; i++) {
        const bgc_range in_x = {i == i0 ? x.low : g->x.x[i], i == i1 ? x.high : g->x.x[i + 1]};

        for (int j = j0; j <= j1; j++) {
            const bgc_range in_y = {j == j0 ? y.low : g->y.x[j], j == j1 ? y.high : g->y.x[j + 1]};

            bgc_include_cell(g, i, j, by, in_x, in_y, &range);
        }
    }
    return range;
}

#endif
