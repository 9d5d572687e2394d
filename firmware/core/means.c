#include "core/means.h"

#include "core/arith.h"
#include "tumble/core.h"

#include <stddef.h>

tumble_status_t tumble_means_check(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                   const tumble_coefficients_t *coefficients)
{
    if ((schedule == NULL) || (means == NULL) || (coefficients == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    uint64_t largest = 0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        for (int i = 0; (i < TUMBLE_CHANNELS) && means->measured[p]; i++) {
            const uint64_t size = tumble_bits(tumble_abs(means->u_v[p][i]));
            largest = (size > largest) ? size : largest;
        }
    }
    return (largest <= tumble_bits(TUMBLE_MAX_MEAN_V)) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
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
