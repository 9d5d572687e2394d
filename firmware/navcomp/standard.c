#include "navcomp/standard.h"

#include "navcomp/fields.h"

#include <stddef.h>

#define STANDARD(type, member, standard, signs, result, part, key, low, high, about) .member = (standard),

const tumble_averaging_config_t tumble_standard_averaging = {TUMBLE_AVERAGING_FIELDS(STANDARD)};

const tumble_procedure_config_t tumble_standard_procedure = {
    TUMBLE_PROCEDURE_FIELDS(STANDARD).schedule = &tumble_schedule_paper,
    .averaging = &tumble_standard_averaging,
};

static const tumble_drive_pdo_t RECEIVE[] = {
    {.number = 0,
     .setup = {.cob_id = 0x202,
               .type = TUMBLE_PDO_EVENT_PROFILE,
               .count = 2,
               .map = {TUMBLE_MAP(0x6040, 0, 16), TUMBLE_MAP(0x607A, 0, 32), 0, 0, 0, 0, 0, 0}}},
};

static const tumble_drive_pdo_t TRANSMIT[] = {
    {.number = 0,
     .setup = {.cob_id = 0x182,
               .type = TUMBLE_PDO_EVENT_PROFILE,
               .count = 2,
               .inhibit_100us = 50,
               .event_ms = 100,
               .map = {TUMBLE_MAP(0x6041, 0, 16), TUMBLE_MAP(0x6064, 0, 32), 0, 0, 0, 0, 0, 0}}},
};

const tumble_drive_profile_t tumble_standard_drive = {
    TUMBLE_DRIVE_FIELDS(STANDARD).receive = RECEIVE,
    .transmit = TRANSMIT,
    .receive_count = 1,
    .transmit_count = 1,
};

const tumble_navcomp_config_t tumble_standard_navcomp = {
    .procedure = &tumble_standard_procedure,
    .stand = &tumble_drive402_kind,
    .stand_profile = &tumble_standard_drive,
    .block_period_us = 10000,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .node = 1,
    .stand_node = 2,
    .block_node = 3,
};
