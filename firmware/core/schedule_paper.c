#include "tumble/core.h"

#define HALF_SQRT2 0.70710678118654752440

/* clang-format off */
#define NINE_POSITIONS(mounting)                                                      \
    {(mounting), 1, TUMBLE_USE_FIT, {  0.0,         0.0,         1.0}},               \
    {(mounting), 2, TUMBLE_USE_FIT, { 45.0,  HALF_SQRT2,  HALF_SQRT2}},               \
    {(mounting), 3, TUMBLE_USE_FIT, { 90.0,         1.0,         0.0}},               \
    {(mounting), 4, TUMBLE_USE_FIT, {135.0,  HALF_SQRT2, -HALF_SQRT2}},               \
    {(mounting), 5, TUMBLE_USE_FIT, {180.0,         0.0,        -1.0}},               \
    {(mounting), 6, TUMBLE_USE_FIT, {225.0, -HALF_SQRT2, -HALF_SQRT2}},               \
    {(mounting), 7, TUMBLE_USE_FIT, {270.0,        -1.0,         0.0}},               \
    {(mounting), 8, TUMBLE_USE_FIT, {315.0, -HALF_SQRT2,  HALF_SQRT2}},               \
    {(mounting), 9, TUMBLE_USE_FIT, {360.0,         0.0,         1.0}}

static const tumble_mounting_t mountings[] = {
    {1, {{ 1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, {0.0, 0.0, 1.0}}, /* ( h, n, v) */
    {2, {{-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}}, {0.0, 0.0, 1.0}}, /* (-h, v, n) */
};

static const tumble_position_t positions[] = {
    NINE_POSITIONS(1),
    NINE_POSITIONS(2),
};
/* clang-format on */

const tumble_schedule_t tumble_schedule_paper = {
    .mountings = mountings,
    .positions = positions,
    .mounting_count = sizeof mountings / sizeof mountings[0],
    .position_count = sizeof positions / sizeof positions[0],
};
