#include "core/schedule_data.h"

/* clang-format off */
#define LEVEL TUMBLE_AT_0
#define UP    { 45.0,  TUMBLE_HALF_SQRT2, TUMBLE_HALF_SQRT2}
#define DOWN  {-45.0, -TUMBLE_HALF_SQRT2, TUMBLE_HALF_SQRT2}
#define INCLINATION(number, tilt) {(number), {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, tilt, 1}
/* clang-format on */

static const tumble_mounting_t mountings[] = {INCLINATION(1, LEVEL), INCLINATION(2, UP), INCLINATION(3, DOWN),
                                              INCLINATION(4, LEVEL)};
static const tumble_position_t positions[] = {TUMBLE_NINE_POSITIONS(1, CHECK), TUMBLE_NINE_POSITIONS(2, CHECK),
                                              TUMBLE_NINE_POSITIONS(3, CHECK), TUMBLE_NINE_POSITIONS(4, CHECK)};

const tumble_schedule_t tumble_schedule_inclined = {mountings, positions, 3, 27};
const tumble_schedule_t tumble_schedule_inclined_closed = {mountings, positions, 4, 36};
