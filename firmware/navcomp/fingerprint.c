#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/bytes.h"
#include "core/crc32.h"
#include "navcomp/fields.h"
#include "navcomp/uncertainty.h"

#include <stddef.h>

#define NUMBER_BYTES 8

/* Fingerprints: CRC-32 over little-endian doubles, the same on every machine. */

static uint32_t add_numbers(uint32_t crc, const double *numbers, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        uint8_t bytes[NUMBER_BYTES];
        tumble_put_f64(bytes, numbers[n]);
        crc = tumble_crc32(crc, bytes, sizeof bytes);
    }
    return crc;
}

/* Of a table of fields those that decide what comes out of a run. */
#define RESULT_ONLY(number) (number),
#define NO_RESULT_ONLY(number)
#define PROCEDURE_RESULT(type, member, standard, signs, result, part, key, low, high, about)                           \
    result##_ONLY((double)config->member)
#define AVERAGING_RESULT(type, member, standard, signs, result, part, key, low, high, about)                           \
    result##_ONLY((double)averaging->member)

#define ADD(crc, numbers) add_numbers((crc), (numbers), sizeof(numbers) / sizeof((numbers)[0]))

static bool all_are_zero(const double *numbers, size_t count)
{
    bool zero = true;
    for (size_t n = 0; n < count; n++) {
        zero = zero && tumble_within(numbers[n], 0.0);
    }
    return zero;
}

/* What is declared of it, and how it is turned. Sets in memory bear this number: a stand that declares no seat, neither
 * encoder nor drift, and channels that are alike, keeps the one that it had before these could be declared. */
uint32_t tumble_stand_fingerprint(const tumble_navcomp_t *navcomp)
{
    const tumble_navcomp_config_t *config = navcomp->config;
    uint32_t crc = 0;
    if (config->declared != NULL) {
        const tumble_stand_record_t *stand = config->declared->stand;
        const double numbers[] = {
            stand->axis_tilt_rad, stand->level_rad,     stand->remount_rad,           stand->angle_rad,
            stand->noise_v,       stand->least_noise_v, stand->common_yaw ? 1.0 : 0.0};
        crc = ADD(crc, numbers);
        const double seats[] = {stand->seat_rad, stand->platform_rad};
        if (tumble_is_positive(stand->seat_rad + stand->platform_rad)) {
            crc = ADD(crc, seats);
        }
        const double course[] = {stand->encoder_rad, stand->drift_v};
        if (tumble_is_positive(stand->encoder_rad + stand->drift_v)) {
            crc = ADD(crc, course);
        }
        const double channels[] = {stand->channel_noise_v[0], stand->channel_noise_v[1], stand->channel_noise_v[2],
                                   stand->channel_drift_v[0], stand->channel_drift_v[1], stand->channel_drift_v[2]};
        if (!all_are_zero(channels, sizeof channels / sizeof channels[0])) {
            crc = ADD(crc, channels);
        }
    }
    double numbers[TUMBLE_STAND_NUMBERS] = {0};
    crc = add_numbers(crc, numbers, tumble_stand_numbers(config->stand, config->stand_profile, numbers));
    return crc;
}

/* How samples become means, and means a result. */
static uint32_t add_configuration(uint32_t crc, const tumble_procedure_config_t *config)
{
    const tumble_averaging_config_t *averaging = config->averaging;
    const double numbers[] = {TUMBLE_PROCEDURE_FIELDS(PROCEDURE_RESULT) TUMBLE_AVERAGING_FIELDS(AVERAGING_RESULT)};
    return ADD(crc, numbers);
}

/* Positions that only check are not in the schedule's own. */
static uint32_t add_positions(uint32_t crc, const tumble_schedule_t *schedule)
{
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        const double numbers[] = {(double)position->mounting, (double)position->number, (double)position->use,
                                  position->angle.deg};
        crc = ADD(crc, numbers);
    }
    return crc;
}

uint32_t tumble_serial_length(const char *serial)
{
    uint32_t length = 0;
    while ((length <= TUMBLE_SET_SERIAL_BYTES) && (serial[length] != '\0')) {
        length++;
    }
    return length;
}

uint32_t tumble_run_fingerprint(const tumble_navcomp_t *navcomp, const char *serial, uint32_t sequence)
{
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const double numbers[] = {(double)tumble_gain_record_schedule_crc(config->schedule),
                              (double)tumble_stand_fingerprint(navcomp), (double)sequence};
    uint32_t crc = ADD(0U, numbers);
    crc = tumble_crc32(crc, serial, tumble_serial_length(serial));
    return add_positions(add_configuration(crc, config), config->schedule);
}
