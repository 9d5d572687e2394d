#include "tumble/core.h"

#include "core/accumulator.h"
#include "core/arith.h"

#include <stddef.h>

/* From 0 on, and finite. */
static TUMBLE_ONE_COPY bool is_size(float x)
{
    const double size = (double)x;
    return tumble_is_finite(size) && !tumble_is_positive(-size);
}

static bool config_is_valid(const tumble_averaging_config_t *config)
{
    const double ratio = (double)config->stillness_ratio;
    const bool gates = (config->saturation_counts >= 1) && (config->stuck_run != 1U);
    const bool samples = (config->min_samples >= 1U) && ((int64_t)config->min_samples <= TUMBLE_MAX_SAMPLES);
    const bool stillness = is_size(config->noise_counts) && tumble_is_positive(ratio);
    return gates && samples && stillness;
}

tumble_status_t tumble_averaging_init(tumble_averaging_t *averaging, const tumble_averaging_config_t *config)
{
    if ((averaging == NULL) || (config == NULL) || !config_is_valid(config)) {
        return TUMBLE_E_ARGUMENT;
    }
    *averaging = (tumble_averaging_t){.open.index = NONE_OPEN};
    return TUMBLE_OK;
}

tumble_status_t tumble_averaging_begin(tumble_averaging_t *averaging, uint8_t index)
{
    if ((averaging == NULL) || (index >= TUMBLE_MAX_POSITIONS)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (averaging->open.index != NONE_OPEN) {
        averaging->averages[averaging->open.index] = (tumble_average_t){0};
    }
    averaging->averages[index] = (tumble_average_t){0};
    averaging->open = (tumble_open_position_t){.index = index};
    return TUMBLE_OK;
}

/* s^2 = (Q - D^2 / n) / (n - 1), with deviations taken from the first sample: D their sum, Q the sum of their squares.
 * The first sample lies within the scatter, so little cancels. */
static double scatter_of_open(const tumble_averaging_t *averaging, int channel)
{
    const tumble_average_t *average = &averaging->averages[averaging->open.index];
    if (average->samples < 2U) {
        return 0.0;
    }
    const double n = (double)average->samples;
    const int64_t offset = (int64_t)average->samples * averaging->open.first[channel];
    const double d = (double)(average->sum_counts[channel] - offset);
    const double q = (double)averaging->open.square_sum[channel];
    const double variance = (q - ((d * d) / n)) / (n - 1.0);
    return tumble_is_positive(variance) ? tumble_sqrt(variance) : 0.0;
}

/* A position with fewer samples than the gate counts cannot show a run that long. There a channel is stuck that never
 * changed. */
static bool never_changed(const tumble_average_t *average, const tumble_averaging_config_t *config)
{
    bool changed = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        changed = changed && tumble_is_positive((double)average->scatter_counts[i]);
    }
    return !changed && (average->samples >= 2U) && (average->samples < config->stuck_run);
}

static tumble_status_t judge_open(const tumble_averaging_t *averaging, const tumble_averaging_config_t *config)
{
    const tumble_open_position_t *open = &averaging->open;
    const tumble_average_t *average = &averaging->averages[open->index];
    if ((open->faults & FAULT_SATURATED) != 0U) {
        return TUMBLE_E_SATURATED;
    }
    if ((open->faults & FAULT_DEVIATING) != 0U) {
        return TUMBLE_E_DEVIATION;
    }
    if (open->lost > config->max_lost) {
        return TUMBLE_E_LOST;
    }
    if (average->samples < config->min_samples) {
        return TUMBLE_E_TOO_FEW;
    }
    if (((open->faults & FAULT_STUCK) != 0U) || never_changed(average, config)) {
        return TUMBLE_E_STUCK;
    }
    const double still_counts = (double)config->stillness_ratio * (double)config->noise_counts;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        if (tumble_is_positive(still_counts) && tumble_exceeds((double)average->scatter_counts[i], still_counts)) {
            return TUMBLE_E_NOT_STILL;
        }
    }
    return TUMBLE_OK;
}

tumble_status_t tumble_averaging_finish(tumble_averaging_t *averaging, const tumble_averaging_config_t *config)
{
    if (averaging->open.index == NONE_OPEN) {
        return TUMBLE_E_NOT_OPEN;
    }
    tumble_average_t *average = &averaging->averages[averaging->open.index];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        average->scatter_counts[i] = tumble_to_float(scatter_of_open(averaging, i));
    }
    const tumble_status_t status = judge_open(averaging, config);
    if (status != TUMBLE_OK) {
        *average = (tumble_average_t){0};
    }
    averaging->open.index = NONE_OPEN;
    return status;
}

/* Could samples that passed the gates have left these numbers? */
static bool is_possible(const tumble_average_t *average, const tumble_averaging_config_t *config)
{
    const int64_t largest = (int64_t)average->samples * (config->saturation_counts - 1);
    bool possible = (int64_t)average->samples <= TUMBLE_MAX_SAMPLES;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        possible = possible && (average->sum_counts[i] >= -largest) && (average->sum_counts[i] <= largest) &&
                   is_size(average->scatter_counts[i]);
    }
    return possible;
}

tumble_status_t tumble_averaging_restore(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                         uint8_t index, const tumble_average_t *average)
{
    if ((config == NULL) || (average == NULL) || (tumble_averaging_begin(averaging, index) != TUMBLE_OK)) {
        return TUMBLE_E_ARGUMENT;
    }
    averaging->averages[index] = *average;
    const tumble_status_t status = is_possible(average, config) ? judge_open(averaging, config) : TUMBLE_E_ARGUMENT;
    if (status != TUMBLE_OK) {
        averaging->averages[index] = (tumble_average_t){0};
    }
    averaging->open.index = NONE_OPEN;
    return status;
}

uint32_t tumble_averaging_samples(const tumble_averaging_t *averaging)
{
    return (averaging->open.index != NONE_OPEN) ? averaging->averages[averaging->open.index].samples : 0U;
}

/* S / n: both are exact as doubles (core.h), so the division rounds once. */
void tumble_average_mean(const tumble_average_t *average, double mean[TUMBLE_CHANNELS], double unit)
{
    const double n = (double)average->samples;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        mean[i] = tumble_divide((double)average->sum_counts[i], n) * unit;
    }
}

tumble_status_t tumble_averaging_running(const tumble_averaging_t *averaging, double mean_counts[TUMBLE_CHANNELS],
                                         double standard_error_counts[TUMBLE_CHANNELS])
{
    if ((averaging == NULL) || (mean_counts == NULL) || (standard_error_counts == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (averaging->open.index == NONE_OPEN) {
        return TUMBLE_E_NOT_OPEN;
    }
    const tumble_average_t *average = &averaging->averages[averaging->open.index];
    if (average->samples < 2U) {
        return TUMBLE_E_TOO_FEW;
    }
    tumble_average_mean(average, mean_counts, 1.0);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        standard_error_counts[i] = scatter_of_open(averaging, i) / tumble_sqrt((double)average->samples);
    }
    return TUMBLE_OK;
}

tumble_status_t tumble_averaging_mean(const tumble_averaging_t *averaging, uint8_t index,
                                      double mean_counts[TUMBLE_CHANNELS],
                                      double standard_error_counts[TUMBLE_CHANNELS])
{
    if ((averaging == NULL) || (mean_counts == NULL) || (index >= TUMBLE_MAX_POSITIONS)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!tumble_averaging_has_mean(averaging, index)) {
        return TUMBLE_E_MISSING_POSITION;
    }
    const tumble_average_t *average = &averaging->averages[index];
    tumble_average_mean(average, mean_counts, 1.0);
    if (standard_error_counts != NULL) {
        const double root_n = tumble_sqrt((double)average->samples);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            standard_error_counts[i] = (double)average->scatter_counts[i] / root_n;
        }
    }
    return TUMBLE_OK;
}

tumble_status_t tumble_averaging_means(const tumble_averaging_t *averaging, double v_per_count, tumble_means_t *means)
{
    if ((averaging == NULL) || (means == NULL) || !tumble_is_positive(tumble_abs(v_per_count))) {
        return TUMBLE_E_ARGUMENT;
    }
    *means = (tumble_means_t){.measured = {false}};
    for (uint8_t p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        means->measured[p] = tumble_averaging_has_mean(averaging, p);
        if (means->measured[p]) {
            tumble_average_mean(&averaging->averages[p], means->u_v[p], v_per_count);
        }
    }
    return TUMBLE_OK;
}
