#include "commissioning.h"

#include "navcomp/fields.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define MAGIC "TUMBLECF"
#define MAGIC_BYTES 8U
#define HEADER_BYTES 16U
#define LAST_PART_BEFORE_LISTS 4U

/* One walk over the fields serves both directions, so that they cannot differ. */
typedef struct {
    uint8_t *out; /* writing; null: reading */
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

static void walk_bool(walk_t *walk, bool *value)
{
    *value = walk_bytes(walk, *value ? 1U : 0U, 1) != 0U;
}

static void walk_u16(walk_t *walk, uint16_t *value)
{
    *value = (uint16_t)walk_bytes(walk, *value, 2);
}

static void walk_u32(walk_t *walk, uint32_t *value)
{
    *value = (uint32_t)walk_bytes(walk, *value, 4);
}

/* A number of four bytes, whatever it is. */
static void walk_u32_bits(walk_t *walk, void *value)
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

/* The numbers of a configuration, each with its place in its struct: column `part` of the tables of fields is the order. */

enum { F64, F32, U32, U16, U8, I32, I8, BOOL, ENUM8, ENUM };

typedef struct {
    uint8_t type;
    uint8_t part;
    uint16_t offset;
} field_t;

#define AVERAGING_FIELD(type, member, standard, signs, result, part, key, low, high, about)                            \
    {type, part, offsetof(tumble_averaging_config_t, member)},
#define PROCEDURE_FIELD(type, member, standard, signs, result, part, key, low, high, about)                            \
    {type, part, offsetof(tumble_procedure_config_t, member)},
#define DRIVE_FIELD(type, member, standard, signs, result, part, key, low, high, about)                                \
    {type, part, offsetof(tumble_drive_profile_t, member)},

static const field_t AVERAGING[] = {TUMBLE_AVERAGING_FIELDS(AVERAGING_FIELD)};
static const field_t PROCEDURE[] = {TUMBLE_PROCEDURE_FIELDS(PROCEDURE_FIELD)};
static const field_t DRIVE[] = {TUMBLE_DRIVE_FIELDS(DRIVE_FIELD)};

#define COUNT_OF(fields) (sizeof(fields) / sizeof((fields)[0]))

static void walk_field(walk_t *walk, uint8_t type, void *at)
{
    tumble_estimate_t choice;
    switch (type) {
    case F64:
        walk_f64(walk, at);
        break;
    case F32:
    case U32:
    case I32:
        walk_u32_bits(walk, at);
        break;
    case U16:
        walk_u16(walk, at);
        break;
    case BOOL:
        walk_bool(walk, at);
        break;
    case ENUM: /* a byte in the record, whatever the compiler takes for it */
        (void)memcpy(&choice, at, sizeof choice);
        choice = (tumble_estimate_t)walk_bytes(walk, (uint64_t)choice, 1);
        (void)memcpy(at, &choice, sizeof choice);
        break;
    default:
        walk_u8(walk, at);
        break;
    }
}

static void walk_fields(walk_t *walk, uint32_t part, const field_t *fields, size_t count, void *structure)
{
    for (size_t i = 0; i < count; i++) {
        if (fields[i].part == part) {
            walk_field(walk, fields[i].type, (uint8_t *)structure + fields[i].offset);
        }
    }
}

/* One part of the tables of fields. */
static void walk_part(walk_t *walk, uint32_t part, zcu102_commissioned_t *all)
{
    walk_fields(walk, part, AVERAGING, COUNT_OF(AVERAGING), &all->averaging);
    walk_fields(walk, part, PROCEDURE, COUNT_OF(PROCEDURE), &all->procedure);
    walk_fields(walk, part, DRIVE, COUNT_OF(DRIVE), &all->drive);
}

static void walk_angle(walk_t *walk, tumble_angle_t *angle)
{
    walk_f64(walk, &angle->deg);
    walk_f64(walk, &angle->sine);
    walk_f64(walk, &angle->cosine);
}

static void walk_schedule(walk_t *walk, zcu102_commissioned_t *all)
{
    walk_count(walk, &all->schedule.mounting_count, ZCU102_MAX_MOUNTINGS);
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

/* What came later stands at the end: a record that was made before ends here, and reads as zeros. */
static void walk_all(walk_t *walk, zcu102_commissioned_t *all)
{
    walk_u32(walk, &all->block_period_us);
    walk_u16(walk, &all->heartbeat_ms);
    walk_u16(walk, &all->heartbeat_timeout_ms);
    for (uint32_t part = 1; part <= LAST_PART_BEFORE_LISTS; part++) {
        walk_part(walk, part, all);
    }
    walk_lists(walk, all);
    walk_schedule(walk, all);
    for (uint32_t part = LAST_PART_BEFORE_LISTS + 1U; part <= UINT8_MAX; part++) {
        walk_part(walk, part, all);
    }
    for (uint8_t m = 0; m < all->schedule.mounting_count; m++) {
        walk_u8(walk, &all->mountings[m].bolting);
    }
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
        (schedule->mounting_count > ZCU102_MAX_MOUNTINGS) || (schedule->position_count > TUMBLE_MAX_POSITIONS)) {
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

tumble_status_t zcu102_commissioning_read(zcu102_commissioned_t *to, const uint8_t record[ZCU102_COMMISSIONING_BYTES])
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
