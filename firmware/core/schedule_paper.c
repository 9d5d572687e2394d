#include "core/schedule_data.h"

static const tumble_mounting_t mountings[] = {TUMBLE_H_N_V, TUMBLE_MH_V_N};
static const tumble_position_t positions[] = {TUMBLE_NINE_POSITIONS(1, FIT), TUMBLE_NINE_POSITIONS(2, FIT)};

const tumble_schedule_t tumble_schedule_paper = TUMBLE_SCHEDULE_OF(mountings, positions);
