/* bgc_lane_tables.h: tables of data on vector registers, lane by lane. */
#ifndef BGC_LANE_TABLES_H
#define BGC_LANE_TABLES_H

#include "bgc_lanes.h"
#include "bgc_tables.h"

static inline lane lane_lookup(const bgc_table *t, int order, lane x) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        lane_set(&x, l, bgc_lookup(t, order, lane_get(x, l)));
    }
    return x;
}
static inline lane lane_place(const bgc_table *t, lane x) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        lane_set(&x, l, bgc_place(t, lane_get(x, l)));
    }
    return x;
}
static inline lane lane_piece(const bgc_table *t, int order, lane x, lane segment) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        lane_set(&x, l, bgc_piece(t, order, lane_get(x, l), lane_get(segment, l)));
    }
    return x;
}
static inline lane lane_lookup2(const bgc_grid *g, int by_x, int by_y, lane x, lane y) {
    for (int l = 0; l < BGC_LANE_WIDTH; l++) {
        lane_set(&x, l, bgc_lookup2(g, by_x, by_y, lane_get(x, l), lane_get(y, l)));
    }
    return x;
}

#endif
