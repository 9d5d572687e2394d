/* averaging_sample.c - what is done for every sample; a target may compile this file for speed, the others for size. */
#include "core/accumulator.h"
#include "core/averaging_state.h"

static tumble_accumulator_t open_of(tumble_averaging_t *averaging)
{
    return (tumble_accumulator_t){tumble_averaging_open_average(averaging), &averaging->open, &averaging->counters};
}

void tumble_averaging_accumulate(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS])
{
    const tumble_accumulator_t into = open_of(averaging);
    tumble_accumulator_keep_first(into, counts);
    tumble_accumulator_add_up(into, counts);
}

tumble_status_t tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                     const tumble_sample_t *sample)
{
    if (!tumble_averaging_is_open(averaging)) {
        return TUMBLE_E_NOT_OPEN;
    }
    if (tumble_averaging_open_average(averaging)->samples >= (uint32_t)TUMBLE_MAX_SAMPLES) {
        return TUMBLE_E_FULL;
    }
    return tumble_accumulator_take(open_of(averaging), config, sample);
}
