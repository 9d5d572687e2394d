/* schedule_data.h - what the built-in schedules are made of (private to the core). */
#ifndef TUMBLE_CORE_SCHEDULE_DATA_H
#define TUMBLE_CORE_SCHEDULE_DATA_H

#include "tumble/core.h"

#define TUMBLE_HALF_SQRT2 0.70710678118654752440

/* clang-format off */
#define TUMBLE_AT_0   {  0.0,                0.0,                1.0}
#define TUMBLE_AT_45  { 45.0,  TUMBLE_HALF_SQRT2,  TUMBLE_HALF_SQRT2}
#define TUMBLE_AT_90  { 90.0,                1.0,                0.0}
#define TUMBLE_AT_135 {135.0,  TUMBLE_HALF_SQRT2, -TUMBLE_HALF_SQRT2}
#define TUMBLE_AT_180 {180.0,                0.0,               -1.0}
#define TUMBLE_AT_225 {225.0, -TUMBLE_HALF_SQRT2, -TUMBLE_HALF_SQRT2}
#define TUMBLE_AT_270 {270.0,               -1.0,                0.0}
#define TUMBLE_AT_315 {315.0, -TUMBLE_HALF_SQRT2,  TUMBLE_HALF_SQRT2}
#define TUMBLE_AT_360 {360.0,                0.0,                1.0}

/* Of the last one, where the first was, the use: FIT or CHECK. */
#define TUMBLE_NINE_POSITIONS(mounting, last)       \
    {(mounting), 1, TUMBLE_USE_FIT, TUMBLE_AT_0},   \
    {(mounting), 2, TUMBLE_USE_FIT, TUMBLE_AT_45},  \
    {(mounting), 3, TUMBLE_USE_FIT, TUMBLE_AT_90},  \
    {(mounting), 4, TUMBLE_USE_FIT, TUMBLE_AT_135}, \
    {(mounting), 5, TUMBLE_USE_FIT, TUMBLE_AT_180}, \
    {(mounting), 6, TUMBLE_USE_FIT, TUMBLE_AT_225}, \
    {(mounting), 7, TUMBLE_USE_FIT, TUMBLE_AT_270}, \
    {(mounting), 8, TUMBLE_USE_FIT, TUMBLE_AT_315}, \
    {(mounting), 9, TUMBLE_USE_##last, TUMBLE_AT_360}

/* x, y, z along: */
#define TUMBLE_H_N_V {1, {{ 1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, TUMBLE_AT_0, 0} /* ( h, n, v) */
#define TUMBLE_MH_V_N {2, {{-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}}, TUMBLE_AT_0, 0} /* (-h, v, n) */
#define TUMBLE_N_V_H {3, {{ 0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}}, TUMBLE_AT_0, 0} /* ( n, v, h) */
/* clang-format on */

/* The schedule of these mountings and positions, which are arrays. */
#define TUMBLE_SCHEDULE_OF(mountings_of, positions_of)                                                                 \
    {.mountings = (mountings_of),                                                                                      \
     .positions = (positions_of),                                                                                      \
     .mounting_count = sizeof(mountings_of) / sizeof(mountings_of)[0],                                                 \
     .position_count = sizeof(positions_of) / sizeof(positions_of)[0]}

#endif
