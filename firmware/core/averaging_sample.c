/* averaging_sample.c - what is done for every sample; a target may compile this file for speed, the others for size. */
#include "core/accumulator.h"

void tumble_averaging_accumulate(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS])
{
    tumble_open_position_t *open = &averaging->open;
    const tumble_accumulator_t into = {&averaging->averages[open->index], open, &averaging->counters};
    if (into.average->samples == 0U) {
        (void)memcpy(open->first, counts, sizeof open->first);
    }
    tumble_accumulator_add_up(into, counts);
}

tumble_status_t tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                     const tumble_sample_t *sample)
{
    tumble_open_position_t *open = &averaging->open;
    if (open->index == NONE_OPEN) {
        return TUMBLE_E_NOT_OPEN;
    }
    const tumble_accumulator_t into = {&averaging->averages[open->index], open, &averaging->counters};
    if (into.average->samples >= (uint32_t)TUMBLE_MAX_SAMPLES) {
        return TUMBLE_E_FULL;
    }
    return tumble_accumulator_take(into, config, sample);
}
