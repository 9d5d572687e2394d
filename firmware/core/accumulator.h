/* accumulator.h - a mean in the making: exact integer sums of the samples that pass every gate (private to the
 * firmware).
 *
 * The positions of a run (averaging_sample.c) and a measurement at rest (sample/at_rest.c) share it, so a gate on
 * samples is written once, here. The sums stand in a tumble_average_t, what only an open mean needs in a
 * tumble_open_position_t; both all zero: nothing has come yet. The functions are inline because every sample goes
 * through them: one function that is told where the sums lie takes a fifth more instructions.
 *
 * Most gates refuse a single sample. A gate that leaves a fault makes averaging.c refuse the whole mean when the
 * position is closed: without that sample the mean would be biased.
 */
#ifndef TUMBLE_CORE_ACCUMULATOR_H
#define TUMBLE_CORE_ACCUMULATOR_H

#include "core/count.h"
#include "tumble/core.h"

#include <string.h>

#define NONE_OPEN UINT8_MAX

static inline bool tumble_averaging_has_mean(const tumble_averaging_t *averaging, uint8_t index)
{
    return (averaging->averages[index].samples != 0U) && (averaging->open.index != index);
}

/* The mean of three channels, correctly rounded in counts, times `unit`. It has samples. */
void tumble_average_mean(const tumble_average_t *average, double mean[TUMBLE_CHANNELS], double unit);

enum { FAULT_SATURATED = 1, FAULT_DEVIATING = 2, FAULT_STUCK = 4, HAS_COUNTER = 8 };

/* Where samples go, and where those are counted that a gate refuses. */
typedef struct {
    tumble_average_t *average;
    tumble_open_position_t *open;
    tumble_averaging_counters_t *counters;
} tumble_accumulator_t;

/* Follow the block's own counter: what came twice or backwards is refused, what is missing is counted. */
static inline tumble_status_t tumble_gate_counter(tumble_accumulator_t into, uint16_t counter)
{
    tumble_open_position_t *open = into.open;
    const uint16_t missing = (uint16_t)(counter - open->last_counter - 1U);
    if ((missing != 0U) && ((open->faults & HAS_COUNTER) != 0U)) {
        if (missing == UINT16_MAX) {
            tumble_add_up_here(&into.counters->repeated, 1U);
            return TUMBLE_E_REPEATED;
        }
        if (missing >= (uint16_t)INT16_MAX) {
            tumble_add_up_here(&into.counters->reordered, 1U);
            return TUMBLE_E_REORDERED;
        }
        tumble_add_up_here(&open->lost, missing);
        tumble_add_up_here(&into.counters->lost, missing);
    }
    open->last_counter = counter;
    open->faults |= HAS_COUNTER;
    return TUMBLE_OK;
}

/* Saturated, far from the first sample, or one value for too long: the last refuses no sample, but the mean. */
static inline tumble_status_t tumble_gate_counts(tumble_accumulator_t into, const tumble_averaging_config_t *config,
                                                 const int32_t counts[TUMBLE_CHANNELS])
{
    tumble_open_position_t *open = into.open;
    const uint32_t highest = (uint32_t)config->saturation_counts - 1U;
    uint32_t largest = 0; /* of the counts, where those from -highest to highest are 0 to 2 highest */
    uint32_t farthest = 0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const int32_t first = into.open->first[i];
        const uint32_t place = (uint32_t)counts[i] + highest;
        const uint32_t deviation =
            (counts[i] > first) ? ((uint32_t)counts[i] - (uint32_t)first) : ((uint32_t)first - (uint32_t)counts[i]);
        largest = (place > largest) ? place : largest;
        farthest = (deviation > farthest) ? deviation : farthest;
    }
    if (largest > (2U * highest)) {
        open->faults |= FAULT_SATURATED;
        tumble_add_up_here(&into.counters->saturated, 1U);
        return TUMBLE_E_SATURATED;
    }
    if (farthest > (uint32_t)TUMBLE_MAX_DEVIATION_COUNTS) {
        open->faults |= FAULT_DEVIATING;
        tumble_add_up_here(&into.counters->deviating, 1U);
        return TUMBLE_E_DEVIATION;
    }
    const uint32_t longest = (uint32_t)config->stuck_run - 1U; /* without the gate no run is longer */
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const uint32_t before = (counts[i] == open->last[i]) ? open->run[i] : 0U;
        open->run[i] = (uint16_t)(before + 1U);
        open->last[i] = counts[i];
        if (before >= longest) {
            open->faults |= FAULT_STUCK;
        }
    }
    return TUMBLE_OK;
}

/* A sample that passed, or that the caller vouches for. */
static inline void tumble_accumulator_add_up(tumble_accumulator_t into, const int32_t counts[TUMBLE_CHANNELS])
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const int32_t deviation = (int32_t)((int64_t)counts[i] - into.open->first[i]);
        into.average->sum_counts[i] += counts[i];
        into.open->square_sum[i] += (int64_t)deviation * deviation;
    }
    into.average->samples++;
}

/* One sample through all gates. The caller guarantees that there are fewer than TUMBLE_MAX_SAMPLES so far. After
 * TUMBLE_E_UNHEALTHY a caller that goes on must put that sample through the gate of the counter itself. Returns as
 * tumble_averaging_add for an open position that is not full: TUMBLE_OK, TUMBLE_E_UNHEALTHY, TUMBLE_E_REPEATED,
 * TUMBLE_E_REORDERED, TUMBLE_E_SATURATED, TUMBLE_E_DEVIATION. */
static inline tumble_status_t tumble_accumulator_take(tumble_accumulator_t into,
                                                      const tumble_averaging_config_t *config,
                                                      const tumble_sample_t *sample)
{
    const int32_t *const counts = sample->counts;
    if (sample->status != 0U) {
        return TUMBLE_E_UNHEALTHY;
    }
    tumble_status_t status = tumble_gate_counter(into, sample->counter);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (into.average->samples == 0U) { /* deviations are taken from the first sample */
        (void)memcpy(into.open->first, counts, sizeof into.open->first);
    }
    status = tumble_gate_counts(into, config, counts);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_accumulator_add_up(into, counts);
    return TUMBLE_OK;
}

#endif
