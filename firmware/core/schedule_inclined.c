#include "core/schedule_data.h"

/* clang-format off */
#define LEVEL TUMBLE_AT_0
#define UP    { 45.0,  TUMBLE_HALF_SQRT2, TUMBLE_HALF_SQRT2}
#define DOWN  {-45.0, -TUMBLE_HALF_SQRT2, TUMBLE_HALF_SQRT2}
#define INCLINATION(number, tilt) {(number), {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, tilt, 1}
#define EIGHT_POSITIONS(mounting)                   \
    {(mounting), 1, TUMBLE_USE_FIT, TUMBLE_AT_0},   \
    {(mounting), 2, TUMBLE_USE_FIT, TUMBLE_AT_45},  \
    {(mounting), 3, TUMBLE_USE_FIT, TUMBLE_AT_90},  \
    {(mounting), 4, TUMBLE_USE_FIT, TUMBLE_AT_135}, \
    {(mounting), 5, TUMBLE_USE_FIT, TUMBLE_AT_180}, \
    {(mounting), 6, TUMBLE_USE_FIT, TUMBLE_AT_225}, \
    {(mounting), 7, TUMBLE_USE_FIT, TUMBLE_AT_270}, \
    {(mounting), 8, TUMBLE_USE_FIT, TUMBLE_AT_315}, \
    {(mounting), 9, TUMBLE_USE_CHECK, TUMBLE_AT_360}
/* clang-format on */

static const tumble_mounting_t mountings[] = {INCLINATION(1, LEVEL), INCLINATION(2, UP), INCLINATION(3, DOWN),
                                              INCLINATION(4, LEVEL)};
static const tumble_position_t positions[] = {EIGHT_POSITIONS(1), EIGHT_POSITIONS(2), EIGHT_POSITIONS(3),
                                              EIGHT_POSITIONS(4)};

const tumble_schedule_t tumble_schedule_inclined = {mountings, positions, 3, 27};
const tumble_schedule_t tumble_schedule_inclined_closed = {mountings, positions, 4, 36};
