#include "tumble/core.h"

#include "core/arith.h"
#include "core/crc32.h"
#include "core/means.h"

#include <stdbool.h>
#include <string.h>

#define HEAD_BYTES sizeof(tumble_gain_record_t)
#define TAIL_BYTES 8U /* a zero and the CRC, four bytes each */
#define WEIGHTS_BYTES (TUMBLE_CHANNELS * sizeof(double))
#define BYTES_BEFORE_NUMBERS offsetof(tumble_gain_record_t, k_v_per_g)

static const void *at(const tumble_gain_record_t *record, size_t offset)
{
    return (const uint8_t *)record + offset;
}

static uint32_t word_at(const tumble_gain_record_t *record, size_t offset)
{
    const uint32_t *word = at(record, offset);
    return *word;
}

static size_t row_bytes(const tumble_gain_record_t *record)
{
    return (size_t)record->fit_positions * TUMBLE_CHANNELS * sizeof(double);
}

const double *tumble_gain_record_gains(const tumble_gain_record_t *record)
{
    return at(record, HEAD_BYTES);
}

const double *tumble_gain_record_stand_gains(const tumble_gain_record_t *record)
{
    return at(record, HEAD_BYTES + (TUMBLE_COEFFICIENTS * row_bytes(record)));
}

static size_t rows_of(const tumble_gain_record_t *record)
{
    return (size_t)TUMBLE_COEFFICIENTS + 2U + record->yaws + (2U * (size_t)record->seats) + (size_t)record->waves +
           (size_t)record->drifts + (2U * (size_t)record->inclinations);
}

static size_t bytes_before_weights(const tumble_gain_record_t *record)
{
    const size_t sigma_bytes = (record->inclinations > 0U) ? sizeof(double) : 0U;
    return HEAD_BYTES + (rows_of(record) * row_bytes(record)) + sigma_bytes;
}

double tumble_gain_record_inclination(const tumble_gain_record_t *record)
{
    const double *sigma_rad = at(record, bytes_before_weights(record) - sizeof(double));
    return (record->inclinations > 0U) ? *sigma_rad : 0.0;
}

const double *tumble_gain_record_weights(const tumble_gain_record_t *record)
{
    const size_t before = bytes_before_weights(record);
    return (record->size_bytes == (before + TAIL_BYTES)) ? NULL : at(record, before);
}

static uint32_t crc32_of_double(uint32_t crc, double x)
{
    const double positive_zero = x + 0.0;
    return tumble_crc32(crc, &positive_zero, sizeof positive_zero);
}

uint32_t tumble_gain_record_schedule_crc(const tumble_schedule_t *schedule)
{
    uint32_t crc = 0;
    const tumble_mounting_t *mounting = schedule->mountings;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        crc = tumble_crc32(crc, &mounting->number, 1);
        for (int i = 0; i < (3 * 3); i++) {
            crc = crc32_of_double(crc, mounting->matrix[i / 3][i % 3]);
        }
        crc = crc32_of_double(crc, mounting->tilt.deg);
        crc = tumble_crc32(crc, &mounting->bolting, (mounting->bolting > 0U) ? 1U : 0U);
        mounting++;
    }
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        if (position->use == TUMBLE_USE_FIT) {
            crc = tumble_crc32(crc, &position->mounting, 1);
            crc = tumble_crc32(crc, &position->number, 1);
            crc = crc32_of_double(crc, position->angle.deg);
        }
    }
    return crc;
}

/* The part that must hold before the CRC can be looked for. */
static bool is_record(const tumble_gain_record_t *record, size_t memory_bytes)
{
    static const uint8_t magic[4] = {0x54, 0x47, 0x52, 0x31}; /* TGR1 */
    return (memory_bytes >= (HEAD_BYTES + TAIL_BYTES)) && (memcmp(record->magic, magic, sizeof magic) == 0) &&
           (record->schema == TUMBLE_GAIN_RECORD_SCHEMA) && (record->size_bytes >= (HEAD_BYTES + TAIL_BYTES)) &&
           (record->size_bytes <= memory_bytes) && ((record->size_bytes % sizeof(double)) == 0U);
}

static bool is_well_formed(const tumble_gain_record_t *record)
{
    const size_t alike = bytes_before_weights(record) + TAIL_BYTES;
    return ((record->size_bytes == alike) || (record->size_bytes == (alike + WEIGHTS_BYTES))) &&
           (record->mountings <= TUMBLE_MAX_YAWS) && ((record->yaws == 1U) || (record->yaws == record->mountings)) &&
           ((record->seats == 0U) || (record->seats == record->mountings)) &&
           ((record->inclinations == 0U) || (record->inclinations == record->mountings)) &&
           ((record->waves == 0U) || (record->waves == (uint8_t)TUMBLE_WAVES)) &&
           ((record->drifts == 0U) || (record->drifts == (uint8_t)TUMBLE_CHANNELS)) &&
           (word_at(record, record->size_bytes - TAIL_BYTES) == 0U);
}

static bool is_for(const tumble_gain_record_t *record, const tumble_schedule_t *schedule)
{
    return (record->fit_positions == tumble_means_fit_positions(schedule)) &&
           (record->mountings == schedule->mounting_count) &&
           (record->schedule_crc == tumble_gain_record_schedule_crc(schedule));
}

static bool all_within(const double *numbers, size_t count, double bound)
{
    bool within = true;
    for (size_t i = 0; i < count; i++) {
        within = within && tumble_within(numbers[i], bound);
    }
    return within;
}

static bool none_is_negative(const double *numbers, size_t count)
{
    bool negative = false;
    for (size_t i = 0; i < count; i++) {
        negative = negative || tumble_is_positive(-numbers[i]);
    }
    return !negative;
}

static bool weights_are_positive(const tumble_gain_record_t *record)
{
    const double *weights = tumble_gain_record_weights(record);
    bool positive = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        positive = positive && ((weights == NULL) || tumble_is_positive(weights[i]));
    }
    return positive;
}

static bool numbers_are_in_range(const tumble_gain_record_t *record)
{
    const size_t count = (record->size_bytes - BYTES_BEFORE_NUMBERS - TAIL_BYTES) / sizeof(double);
    const double inclination_rad = tumble_gain_record_inclination(record);
    return all_within(at(record, BYTES_BEFORE_NUMBERS), count, TUMBLE_MAX_GAIN) &&
           !all_within(record->k_v_per_g[0], (size_t)TUMBLE_CHANNELS * TUMBLE_CHANNELS, 0.0) &&
           all_within(record->sigma_rad, 4, TUMBLE_MAX_SIGMA_RAD) && none_is_negative(record->sigma_rad, 4) &&
           tumble_within(inclination_rad, TUMBLE_MAX_SIGMA_RAD) && !tumble_is_positive(-inclination_rad) &&
           tumble_is_positive(record->sigma_mean_v) && weights_are_positive(record) &&
           none_is_negative(record->u_k_v_per_g[0], (size_t)TUMBLE_CHANNELS * TUMBLE_CHANNELS) &&
           none_is_negative(record->u_u0_v, TUMBLE_CHANNELS);
}

tumble_status_t tumble_gain_record_open(const void *memory, size_t size, const tumble_schedule_t *schedule,
                                        const tumble_gain_record_t **record)
{
    if ((memory == NULL) || (schedule == NULL) || (record == NULL) || (((uintptr_t)memory % sizeof(double)) != 0U)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_gain_record_t *candidate = memory;
    if (!is_record(candidate, size)) {
        return TUMBLE_E_GAIN_RECORD;
    }
    const size_t covered = candidate->size_bytes - sizeof(uint32_t);
    if (tumble_crc32(0, candidate, covered) != word_at(candidate, covered)) {
        return TUMBLE_E_CRC;
    }
    if (!is_well_formed(candidate)) {
        return TUMBLE_E_GAIN_RECORD;
    }
    if (!is_for(candidate, schedule)) {
        return TUMBLE_E_GAIN_TABLE;
    }
    if (!numbers_are_in_range(candidate)) {
        return TUMBLE_E_NOT_FINITE;
    }
    *record = candidate;
    return TUMBLE_OK;
}
