#include "core/means.h"

#include "core/arith.h"
#include "tumble/core.h"

bool tumble_means_are_numbers(const tumble_schedule_t *schedule, const tumble_means_t *means)
{
    bool numbers = true;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        for (int i = 0; (i < TUMBLE_CHANNELS) && means->measured[p]; i++) {
            numbers = numbers && tumble_within(means->u_v[p][i], TUMBLE_MAX_MEAN_V);
        }
    }
    return numbers;
}

bool tumble_means_are_complete(const tumble_schedule_t *schedule, const tumble_means_t *means)
{
    bool complete = true;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        complete = complete && (means->measured[p] || (schedule->positions[p].use != TUMBLE_USE_FIT));
    }
    return complete;
}

uint8_t tumble_means_fit_positions(const tumble_schedule_t *schedule)
{
    uint8_t count = 0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (schedule->positions[p].use == TUMBLE_USE_FIT) {
            count++;
        }
    }
    return count;
}
