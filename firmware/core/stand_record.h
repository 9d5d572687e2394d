/* stand_record.h - what a board declares of its stand: whether it is in range, and of each channel (private to the core). */
#ifndef TUMBLE_CORE_STAND_RECORD_H
#define TUMBLE_CORE_STAND_RECORD_H

#include "core/arith.h"
#include "tumble/core.h"

#include <stdbool.h>

/* Standard deviations from 0 to the largest that tumble/core.h allows, and at least one sample. */
bool tumble_stand_record_is_valid(const tumble_stand_record_t *stand);

/* Noise of one sample of a channel, and its drift. */
static inline double tumble_stand_noise_v(const tumble_stand_record_t *stand, int channel)
{
    const double own_v = stand->channel_noise_v[channel];
    return tumble_is_positive(own_v) ? own_v : stand->noise_v;
}

static inline double tumble_stand_drift_v(const tumble_stand_record_t *stand, int channel)
{
    const double own_v = stand->channel_drift_v[channel];
    return tumble_is_positive(own_v) ? own_v : stand->drift_v;
}

/* Is a drift declared, of any channel? */
static inline bool tumble_stand_drifts(const tumble_stand_record_t *stand)
{
    bool drifts = tumble_is_positive(stand->drift_v);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        drifts = drifts || tumble_is_positive(stand->channel_drift_v[i]);
    }
    return drifts;
}

#endif
