#include "core/schedule_data.h"

/* clang-format off */
#define FOUR_POSITIONS(mounting)                    \
    {(mounting), 1, TUMBLE_USE_FIT, TUMBLE_AT_45},  \
    {(mounting), 2, TUMBLE_USE_FIT, TUMBLE_AT_135}, \
    {(mounting), 3, TUMBLE_USE_FIT, TUMBLE_AT_225}, \
    {(mounting), 4, TUMBLE_USE_FIT, TUMBLE_AT_315}
#define FIVE_POSITIONS(mounting)                    \
    FOUR_POSITIONS(mounting), {(mounting), 5, TUMBLE_USE_CHECK, TUMBLE_AT_45}
/* clang-format on */

static const tumble_mounting_t mountings[] = {TUMBLE_H_N_V, TUMBLE_MH_V_N, TUMBLE_N_V_H};
static const tumble_position_t positions[] = {FOUR_POSITIONS(1), FOUR_POSITIONS(2), FOUR_POSITIONS(3)};
static const tumble_position_t closed[] = {FIVE_POSITIONS(1), FIVE_POSITIONS(2), FIVE_POSITIONS(3)};

const tumble_schedule_t tumble_schedule_diagonal = TUMBLE_SCHEDULE_OF(positions);
const tumble_schedule_t tumble_schedule_diagonal_closed = TUMBLE_SCHEDULE_OF(closed);
