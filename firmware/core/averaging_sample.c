/* averaging_sample.c - what is done for every sample; a target may compile this file for speed, the others for size. */
#include "core/averaging_state.h"

#include <string.h>

static void count(uint32_t *counter, uint32_t by)
{
    *counter = (by <= (UINT32_MAX - *counter)) ? (*counter + by) : UINT32_MAX;
}

/* Deviations are taken from the first sample of a position. */
static void keep_first(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS])
{
    if (tumble_averaging_open_average(averaging)->samples == 0U) {
        (void)memcpy(averaging->open.first, counts, sizeof averaging->open.first);
    }
}

/* A sample that passed, or that the caller vouches for. */
static void add_up(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS])
{
    tumble_average_t *average = tumble_averaging_open_average(averaging);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const int32_t deviation = (int32_t)((int64_t)counts[i] - averaging->open.first[i]);
        average->sum_counts[i] += counts[i];
        averaging->open.square_sum[i] += (int64_t)deviation * deviation;
    }
    average->samples++;
}

void tumble_averaging_accumulate(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS])
{
    keep_first(averaging, counts);
    add_up(averaging, counts);
}

/* Follow the block's own counter: what came twice or backwards is refused, what is missing is counted. */
static tumble_status_t check_counter(tumble_averaging_t *averaging, uint16_t counter)
{
    tumble_open_position_t *open = &averaging->open;
    const uint16_t missing = (uint16_t)(counter - open->last_counter - 1U);
    if ((missing != 0U) && ((open->faults & HAS_COUNTER) != 0U)) {
        if (missing == UINT16_MAX) {
            count(&averaging->counters.repeated, 1U);
            return TUMBLE_E_REPEATED;
        }
        if (missing >= (uint16_t)INT16_MAX) {
            count(&averaging->counters.reordered, 1U);
            return TUMBLE_E_REORDERED;
        }
        count(&open->lost, missing);
        count(&averaging->counters.lost, missing);
    }
    open->last_counter = counter;
    open->faults |= HAS_COUNTER;
    return TUMBLE_OK;
}

/* How far apart two counts are, whatever they are. */
static uint32_t distance(int32_t a, int32_t b)
{
    return (a > b) ? ((uint32_t)a - (uint32_t)b) : ((uint32_t)b - (uint32_t)a);
}

/* Refuse a sample for a fault that the position will be refused for, too. */
static tumble_status_t refuse(tumble_averaging_t *averaging, uint8_t fault, uint32_t *counter, tumble_status_t status)
{
    averaging->open.faults |= fault;
    count(counter, 1U);
    return status;
}

static tumble_status_t check_range(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                   const int32_t counts[TUMBLE_CHANNELS])
{
    const uint32_t highest = (uint32_t)config->saturation_counts - 1U;
    uint32_t largest = 0; /* of the counts, where those from -highest to highest are 0 to 2 highest */
    uint32_t farthest = 0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const uint32_t place = (uint32_t)counts[i] + highest;
        const uint32_t deviation = distance(counts[i], averaging->open.first[i]);
        largest = (place > largest) ? place : largest;
        farthest = (deviation > farthest) ? deviation : farthest;
    }
    if (largest > (2U * highest)) {
        return refuse(averaging, FAULT_SATURATED, &averaging->counters.saturated, TUMBLE_E_SATURATED);
    }
    if (farthest > (uint32_t)TUMBLE_MAX_DEVIATION_COUNTS) {
        return refuse(averaging, FAULT_DEVIATING, &averaging->counters.deviating, TUMBLE_E_DEVIATION);
    }
    return TUMBLE_OK;
}

static void watch_stuck_channels(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                 const int32_t counts[TUMBLE_CHANNELS])
{
    tumble_open_position_t *open = &averaging->open;
    const uint32_t longest = (uint32_t)config->stuck_run - 1U; /* without the gate no run is longer */
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const uint32_t before = (counts[i] == open->last[i]) ? open->run[i] : 0U;
        open->run[i] = (uint16_t)(before + 1U);
        open->last[i] = counts[i];
        if (before >= longest) {
            open->faults |= FAULT_STUCK;
        }
    }
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
    const int32_t *const counts = sample->counts;
    tumble_status_t status = check_counter(averaging, sample->counter);
    if (status != TUMBLE_OK) {
        return status;
    }
    keep_first(averaging, counts);
    status = check_range(averaging, config, counts);
    if (status != TUMBLE_OK) {
        return status;
    }
    watch_stuck_channels(averaging, config, counts);
    add_up(averaging, counts);
    return TUMBLE_OK;
}
