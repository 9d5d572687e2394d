/* Fingerprints, and how a run that lost power goes on. */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include "core/bytes.h"
#include "core/crc32.h"
#include "navcomp/fields.h"
#include "navcomp/uncertainty.h"
#include "tumble/core.h"

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

/* The one that gain records carry, too. */
uint32_t tumble_keeper_schedule_crc(const tumble_keeper_t *keeper)
{
    return tumble_gain_record_schedule_crc(keeper->navcomp->procedure_config.schedule);
}

/* What is declared of it, and how it is turned. */
uint32_t tumble_keeper_stand_crc(const tumble_keeper_t *keeper)
{
    const tumble_navcomp_config_t *config = keeper->navcomp->config;
    uint32_t crc = 0;
    if (config->declared != NULL) {
        const tumble_stand_record_t *stand = config->declared->stand;
        const double numbers[] = {stand->axis_tilt_rad, stand->level_rad,     stand->remount_rad, stand->angle_rad,
                                  stand->noise_v,       stand->least_noise_v, stand->common_yaw ? 1.0 : 0.0};
        crc = ADD(crc, numbers);
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

/* All that must not have changed. The active set's sequence as well: a result that was committed is no run to go on with.
 */
uint32_t tumble_keeper_fingerprint(const tumble_keeper_t *keeper)
{
    const tumble_procedure_config_t *config = &keeper->navcomp->procedure_config;
    const double numbers[] = {(double)tumble_keeper_schedule_crc(keeper), (double)tumble_keeper_stand_crc(keeper),
                              (double)tumble_store_sequence(&keeper->store)};
    uint32_t crc = ADD(0U, numbers);
    crc = tumble_crc32(crc, keeper->config->serial, tumble_serial_length(keeper->config));
    return add_positions(add_configuration(crc, config), config->schedule);
}

/* Going on. */

uint8_t tumble_keeper_positions(const tumble_keeper_t *keeper)
{
    return keeper->navcomp->procedure_config.schedule->position_count;
}

static bool is_fit(const tumble_keeper_t *keeper, uint8_t index)
{
    return tumble_checkpoint_has(&keeper->checkpoint, index) && ((keeper->unfit & (UINT64_C(1) << index)) == 0U);
}

/* One that is about to be cleared holds none. */
void tumble_keeper_count_resumable(tumble_keeper_t *keeper)
{
    const bool idle = (tumble_run_state(keeper->navcomp) == TUMBLE_STATE_IDLE) &&
                      ((keeper->wants & WANT_CLEAR) == 0U);
    keeper->resumable = 0;
    if (idle && tumble_checkpoint_matches(&keeper->checkpoint, tumble_keeper_fingerprint(keeper))) {
        for (uint8_t p = 0; p < tumble_keeper_positions(keeper); p++) {
            keeper->resumable = (uint8_t)(keeper->resumable + (is_fit(keeper, p) ? 1U : 0U));
        }
    }
}

static tumble_status_t refuse(tumble_keeper_t *keeper)
{
    tumble_count(&keeper->counters.not_resumed);
    return TUMBLE_E_STATE;
}

tumble_status_t tumble_keeper_resume(tumble_keeper_t *keeper)
{
    if ((keeper->task != (uint8_t)TASK_NONE) || keeper->stale || tumble_keeper_is_busy(keeper)) {
        return refuse(keeper);
    }
    keeper->unfit = 0; /* who asks is heard: all of them are tried anew */
    tumble_keeper_count_resumable(keeper);
    if (keeper->resumable == 0U) {
        return refuse(keeper);
    }
    keeper->fingerprint = tumble_keeper_fingerprint(keeper);
    keeper->saved = 0;
    keeper->lost = 0;
    keeper->task = TASK_RESTORE;
    keeper->at = 0;
    return TUMBLE_OK;
}

/* All that is kept has been put back. Nothing but the configuration can have changed since the command. */
static void go_on(tumble_keeper_t *keeper)
{
    keeper->task = TASK_NONE;
    const bool same = (keeper->fingerprint == tumble_keeper_fingerprint(keeper)) && !tumble_keeper_is_inhibited(keeper);
    if (!same || (tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_RESUME, 0) != TUMBLE_OK)) {
        (void)refuse(keeper);
        tumble_keeper_count_resumable(keeper); /* for what cannot be put back nothing waits */
        return;
    }
    tumble_count(&keeper->counters.resumed);
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
    keeper->has_checkpoint = true;
    keeper->run_was_on = true;
    keeper->run_resumed = true;
    keeper->warmth_half_c = 0;
    keeper->warm_samples = 0;
    keeper->resumable = 0;
}

void tumble_keeper_restore(tumble_keeper_t *keeper)
{
    tumble_average_t average;
    while ((keeper->at < tumble_keeper_positions(keeper)) && !tumble_checkpoint_has(&keeper->checkpoint, keeper->at)) {
        keeper->at++;
    }
    if (keeper->at == tumble_keeper_positions(keeper)) {
        go_on(keeper);
        return;
    }
    const tumble_status_t status = tumble_checkpoint_read(&keeper->checkpoint, keeper->at, &average);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if ((status == TUMBLE_OK) &&
        (tumble_procedure_restore(&keeper->navcomp->procedure, keeper->at, &average) == TUMBLE_OK)) {
        keeper->saved |= UINT64_C(1) << keeper->at;
    } else {
        keeper->unfit |= UINT64_C(1) << keeper->at;
    }
    keeper->at++;
}
