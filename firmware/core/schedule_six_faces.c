#include "core/schedule_data.h"

static const tumble_mounting_t mountings[] = {TUMBLE_H_N_V, TUMBLE_MH_V_N};
static const tumble_position_t positions[] = {
    {1, 1, TUMBLE_USE_FIT, TUMBLE_AT_0},   /* z up */
    {1, 3, TUMBLE_USE_FIT, TUMBLE_AT_90},  /* x up */
    {1, 5, TUMBLE_USE_FIT, TUMBLE_AT_180}, /* z down */
    {1, 7, TUMBLE_USE_FIT, TUMBLE_AT_270}, /* x down */
    {2, 1, TUMBLE_USE_FIT, TUMBLE_AT_0},   /* y up */
    {2, 5, TUMBLE_USE_FIT, TUMBLE_AT_180}, /* y down */
};

const tumble_schedule_t tumble_schedule_six_faces = TUMBLE_SCHEDULE_OF(positions);
