#include "commissioning.h"

#include <stdbool.h>
#include <string.h>

#define MAGIC "TUMBLECF"
#define MAGIC_BYTES 8U
#define HEADER_BYTES 16U

/* One walk over the fields serves both directions, so that they cannot differ. */
typedef struct {
    uint8_t *out;      /* writing; null: reading */
    const uint8_t *in;
    size_t at;
    size_t end;
} walk_t;

static uint64_t walk_bytes(walk_t *walk, uint64_t value, uint32_t count)
{
    uint64_t read = 0;
    for (uint32_t i = 0; (i < count) && (walk->at < walk->end); i++) {
        if (walk->out != NULL) {
            walk->out[walk->at] = (uint8_t)(value >> (8U * i));
        } else {
            read |= (uint64_t)walk->in[walk->at] << (8U * i);
        }
        walk->at++;
    }
    return (walk->out != NULL) ? value : read;
}

static void walk_u8(walk_t *walk, uint8_t *value)
{
    *value = (uint8_t)walk_bytes(walk, *value, 1);
}

static void walk_i8(walk_t *walk, int8_t *value)
{
    *value = (int8_t)(uint8_t)walk_bytes(walk, (uint8_t)*value, 1);
}

static void walk_u16(walk_t *walk, uint16_t *value)
{
    *value = (uint16_t)walk_bytes(walk, *value, 2);
}

static void walk_u32(walk_t *walk, uint32_t *value)
{
    *value = (uint32_t)walk_bytes(walk, *value, 4);
}

static void walk_f32(walk_t *walk, float *value)
{
    uint32_t bits;
    (void)memcpy(&bits, value, sizeof bits);
    walk_u32(walk, &bits);
    (void)memcpy(value, &bits, sizeof bits);
}

static void walk_f64(walk_t *walk, double *value)
{
    uint64_t bits;
    (void)memcpy(&bits, value, sizeof bits);
    bits = walk_bytes(walk, bits, 8);
    (void)memcpy(value, &bits, sizeof bits);
}

/* How many of something: what does not fit is cut off, and a checksum that was right makes that impossible. */
static void walk_count(walk_t *walk, uint8_t *count, uint8_t most)
{
    walk_u8(walk, count);
    *count = (*count < most) ? *count : most;
}

static void walk_averaging(walk_t *walk, tumble_averaging_config_t *averaging)
{
    averaging->saturation_counts =
        (int32_t)(uint32_t)walk_bytes(walk, (uint32_t)averaging->saturation_counts, 4);
    walk_u32(walk, &averaging->min_samples);
    walk_u16(walk, &averaging->max_lost);
    walk_u16(walk, &averaging->stuck_run);
    walk_f32(walk, &averaging->noise_counts);
    walk_f32(walk, &averaging->stillness_ratio);
}

static void walk_procedure(walk_t *walk, tumble_procedure_config_t *procedure)
{
    double *const numbers[] = {&procedure->error_budget_v,
                               &procedure->v_per_count,     &procedure->nominal_scale_v_per_g,
                               &procedure->gravity_limit_g, &procedure->closure_limit_g,
                               &procedure->position_tolerance_deg, &procedure->approach_deg,
                               &procedure->cable_min_deg,   &procedure->cable_max_deg};
    uint32_t *const times[] = {&procedure->preflight_timeout_ms, &procedure->warm_up_timeout_ms,
                               &procedure->mounting_timeout_ms,  &procedure->home_timeout_ms,
                               &procedure->move_timeout_ms,      &procedure->settle_timeout_ms,
                               &procedure->average_timeout_ms,   &procedure->sample_timeout_ms};
    procedure->estimate = (tumble_estimate_t)walk_bytes(walk, (uint64_t)procedure->estimate, 1);
    walk_u32(walk, &procedure->samples);
    for (size_t i = 0; i < (sizeof numbers / sizeof numbers[0]); i++) {
        walk_f64(walk, numbers[i]);
    }
    walk_u16(walk, &procedure->settle_ms);
    walk_u16(walk, &procedure->max_corrupted);
    walk_u8(walk, &procedure->retries);
    walk_i8(walk, &procedure->warm_up_band_half_c);
    walk_u16(walk, &procedure->warm_up_samples);
    for (size_t i = 0; i < (sizeof times / sizeof times[0]); i++) {
        walk_u32(walk, times[i]);
    }
}

static void walk_angle(walk_t *walk, tumble_angle_t *angle)
{
    walk_f64(walk, &angle->deg);
    walk_f64(walk, &angle->sine);
    walk_f64(walk, &angle->cosine);
}

static void walk_schedule(walk_t *walk, zcu102_commissioned_t *all)
{
    walk_count(walk, &all->schedule.mounting_count, TUMBLE_MAX_MOUNTINGS);
    for (uint8_t m = 0; m < all->schedule.mounting_count; m++) {
        tumble_mounting_t *mounting = &all->mountings[m];
        walk_u8(walk, &mounting->number);
        walk_angle(walk, &mounting->tilt);
        for (uint32_t i = 0; i < 9U; i++) {
            walk_f64(walk, &mounting->matrix[i / 3U][i % 3U]);
        }
    }
    walk_count(walk, &all->schedule.position_count, TUMBLE_MAX_POSITIONS);
    for (uint8_t p = 0; p < all->schedule.position_count; p++) {
        tumble_position_t *position = &all->positions[p];
        walk_u8(walk, &position->mounting);
        walk_u8(walk, &position->number);
        position->use = (tumble_use_t)walk_bytes(walk, (uint64_t)position->use, 1);
        walk_angle(walk, &position->angle);
    }
}

static void walk_pdo(walk_t *walk, tumble_drive_pdo_t *pdo)
{
    const size_t most = sizeof pdo->setup.map / sizeof pdo->setup.map[0];
    walk_u8(walk, &pdo->number);
    walk_u32(walk, &pdo->setup.cob_id);
    walk_u8(walk, &pdo->setup.type);
    walk_u16(walk, &pdo->setup.inhibit_100us);
    walk_u16(walk, &pdo->setup.event_ms);
    walk_count(walk, &pdo->setup.count, (uint8_t)most);
    for (size_t i = 0; i < most; i++) {
        walk_u32(walk, &pdo->setup.map[i]);
    }
}

static void walk_lists(walk_t *walk, zcu102_commissioned_t *all)
{
    walk_count(walk, &all->drive.receive_count, TUMBLE_DRIVE402_PDOS);
    for (uint8_t i = 0; i < all->drive.receive_count; i++) {
        walk_pdo(walk, &all->receive[i]);
    }
    walk_count(walk, &all->drive.transmit_count, TUMBLE_DRIVE402_PDOS);
    for (uint8_t i = 0; i < all->drive.transmit_count; i++) {
        walk_pdo(walk, &all->transmit[i]);
    }
    walk_count(walk, &all->drive.write_count, ZCU102_MAX_WRITES);
    for (uint8_t i = 0; i < all->drive.write_count; i++) {
        walk_u16(walk, &all->writes[i].index);
        walk_u8(walk, &all->writes[i].subindex);
        walk_u8(walk, &all->writes[i].size);
        walk_u32(walk, &all->writes[i].value);
    }
}

static void walk_drive(walk_t *walk, tumble_drive_profile_t *drive)
{
    double *const numbers[] = {&drive->counts_per_revolution, &drive->velocity_units_per_deg_s,
                               &drive->acceleration_units_per_deg_s2, &drive->velocity_deg_s,
                               &drive->acceleration_deg_s2, &drive->deceleration_deg_s2,
                               &drive->quick_stop_deg_s2, &drive->homing_fast_deg_s,
                               &drive->homing_slow_deg_s, &drive->homing_acceleration_deg_s2};
    uint32_t *const words[] = {&drive->wrap_counts, &drive->window_counts, &drive->start_timeout_ms,
                               &drive->power_timeout_ms, &drive->handshake_timeout_ms, &drive->home_timeout_ms,
                               &drive->move_timeout_ms, &drive->stop_timeout_ms};
    for (size_t i = 0; i < (sizeof numbers / sizeof numbers[0]); i++) {
        walk_f64(walk, numbers[i]);
    }
    for (size_t i = 0; i < (sizeof words / sizeof words[0]); i++) {
        walk_u32(walk, words[i]);
    }
    walk_i8(walk, &drive->sign);
    walk_i8(walk, &drive->homing_method);
    walk_u8(walk, &drive->stop);
    walk_u16(walk, &drive->heartbeat_ms);
    walk_u16(walk, &drive->heartbeat_timeout_ms);
}

/* What came later stands at the end: a record that was made before ends here, and reads as zeros. */
static void walk_limits(walk_t *walk, tumble_drive_profile_t *drive)
{
    uint8_t limited = drive->software_limits ? 1U : 0U;
    walk_f64(walk, &drive->homing_travel_deg);
    walk_u8(walk, &limited);
    drive->software_limits = (limited != 0U);
}

static void walk_all(walk_t *walk, zcu102_commissioned_t *all)
{
    walk_u32(walk, &all->block_period_us);
    walk_u16(walk, &all->heartbeat_ms);
    walk_u16(walk, &all->heartbeat_timeout_ms);
    walk_averaging(walk, &all->averaging);
    walk_procedure(walk, &all->procedure);
    walk_drive(walk, &all->drive);
    walk_lists(walk, all);
    walk_schedule(walk, all);
    walk_limits(walk, &all->drive);
}

static void point_within(zcu102_commissioned_t *all)
{
    all->schedule.mountings = all->mountings;
    all->schedule.positions = all->positions;
    all->procedure.schedule = &all->schedule;
    all->procedure.averaging = &all->averaging;
    all->drive.receive = all->receive;
    all->drive.transmit = all->transmit;
    all->drive.writes = all->writes;
}

tumble_status_t zcu102_commission(zcu102_commissioned_t *to, const tumble_navcomp_config_t *config)
{
    const tumble_drive_profile_t *drive = config->stand_profile;
    const tumble_schedule_t *schedule = config->procedure->schedule;
    if ((config->stand != &tumble_drive402_kind) || (drive->receive_count > TUMBLE_DRIVE402_PDOS) ||
        (drive->transmit_count > TUMBLE_DRIVE402_PDOS) || (drive->write_count > ZCU102_MAX_WRITES) ||
        (schedule->mounting_count > TUMBLE_MAX_MOUNTINGS) || (schedule->position_count > TUMBLE_MAX_POSITIONS)) {
        return TUMBLE_E_ARGUMENT;
    }
    (void)memset(to, 0, sizeof *to);
    to->averaging = *config->procedure->averaging;
    to->procedure = *config->procedure;
    to->drive = *drive;
    to->schedule = *schedule;
    to->block_period_us = config->block_period_us;
    to->heartbeat_ms = config->heartbeat_ms;
    to->heartbeat_timeout_ms = config->heartbeat_timeout_ms;
    (void)memcpy(to->mountings, schedule->mountings, schedule->mounting_count * sizeof to->mountings[0]);
    (void)memcpy(to->positions, schedule->positions, schedule->position_count * sizeof to->positions[0]);
    (void)memcpy(to->receive, drive->receive, drive->receive_count * sizeof to->receive[0]);
    (void)memcpy(to->transmit, drive->transmit, drive->transmit_count * sizeof to->transmit[0]);
    if (drive->write_count > 0U) {
        (void)memcpy(to->writes, drive->writes, drive->write_count * sizeof to->writes[0]);
    }
    point_within(to);
    return TUMBLE_OK;
}

static uint32_t checksum(const uint8_t *bytes, size_t count)
{
    uint32_t sum = 2166136261U;
    for (size_t i = 0; i < count; i++) {
        sum = (sum ^ bytes[i]) * 16777619U;
    }
    return sum;
}

size_t zcu102_commissioning_write(zcu102_commissioned_t *from, uint8_t record[ZCU102_COMMISSIONING_BYTES])
{
    walk_t walk = {.out = record, .at = HEADER_BYTES, .end = ZCU102_COMMISSIONING_BYTES};
    walk_all(&walk, from);
    const size_t size = walk.at;
    (void)memcpy(record, MAGIC, MAGIC_BYTES);
    walk = (walk_t){.out = record, .at = MAGIC_BYTES, .end = HEADER_BYTES};
    (void)walk_bytes(&walk, size - HEADER_BYTES, 4);
    (void)walk_bytes(&walk, checksum(&record[HEADER_BYTES], size - HEADER_BYTES), 4);
    return size;
}

/* Erased memory: anything else that is no record is a spoilt one. */
static bool is_blank(const uint8_t record[ZCU102_COMMISSIONING_BYTES])
{
    bool blank = (record[0] == 0U) || (record[0] == 0xFFU);
    for (uint32_t i = 0; i < HEADER_BYTES; i++) {
        blank = blank && (record[i] == record[0]);
    }
    return blank;
}

tumble_status_t zcu102_commissioning_read(zcu102_commissioned_t *to,
                                          const uint8_t record[ZCU102_COMMISSIONING_BYTES])
{
    if (is_blank(record)) {
        return TUMBLE_E_PORT_EMPTY;
    }
    for (uint32_t i = 0; i < MAGIC_BYTES; i++) {
        if (record[i] != (uint8_t)MAGIC[i]) {
            return TUMBLE_E_CRC;
        }
    }
    walk_t walk = {.in = record, .at = MAGIC_BYTES, .end = HEADER_BYTES};
    const size_t length = (size_t)walk_bytes(&walk, 0, 4);
    const uint32_t sum = (uint32_t)walk_bytes(&walk, 0, 4);
    if ((length > (ZCU102_COMMISSIONING_BYTES - HEADER_BYTES)) || (checksum(&record[HEADER_BYTES], length) != sum)) {
        return TUMBLE_E_CRC;
    }
    (void)memset(to, 0, sizeof *to);
    walk = (walk_t){.in = record, .at = HEADER_BYTES, .end = HEADER_BYTES + length};
    walk_all(&walk, to);
    point_within(to);
    return (walk.at == (HEADER_BYTES + length)) ? TUMBLE_OK : TUMBLE_E_CRC;
}
