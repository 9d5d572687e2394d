/* stand_record.h - what a board declares of its stand: whether it is in range, and of each channel (private to the core). */
#ifndef TUMBLE_CORE_STAND_RECORD_H
#define TUMBLE_CORE_STAND_RECORD_H

#include "tumble/core.h"

#include <stdbool.h>

/* Standard deviations from 0 to the largest that tumble/core.h allows, and at least one sample. */
bool tumble_stand_record_is_valid(const tumble_stand_record_t *stand);

/* Noise of one sample of a channel, and its drift. */
double tumble_stand_noise_v(const tumble_stand_record_t *stand, int channel);
double tumble_stand_drift_v(const tumble_stand_record_t *stand, int channel);

/* Is a drift declared, of any channel? */
bool tumble_stand_drifts(const tumble_stand_record_t *stand);

#endif
