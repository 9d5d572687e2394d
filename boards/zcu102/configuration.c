#include "configuration.h"

#include "navcomp/standard.h"

#include <stdbool.h>
#include <stddef.h>

/* The chip as it stands on the ZCU102 board, or in the emulator. */
#ifdef ZCU102_EMULATED
#define CAN_CLOCK_HZ 24000000U
#define CAN_LAYOUT ZCU102_CAN_EMULATED
#else
#define CAN_CLOCK_HZ 100000000U /* as the board's first stage loader leaves it */
#define CAN_LAYOUT ZCU102_CAN_SILICON
#endif

#define BITS_PER_SECOND 500000U

/* Four filters, 22 identifiers of 2048: a bus full of others' frames does not reach the queue. */
static const zcu102_can_filter_t FILTERS[ZCU102_CAN_FILTERS] = {
    {0x000, 0x1FE}, /* NMT command; SDO to us (601h, 401h); and five more */
    {0x082, 0x6FE}, /* emergencies of drive and block; the drive's process data (182h); 183h */
    {0x683, 0x7EF}, /* the two halves of a sample (683h, 693h) */
    {0x702, 0x57E}, /* heartbeats of drive and block; SDO of the drive (582h); and five more */
};

const zcu102_can_config_t zcu102_can = {
    .base = ZCU102_CAN0,
    .clock_hz = CAN_CLOCK_HZ,
    .bits_per_second = BITS_PER_SECOND,
    .filters = FILTERS,
    .filter_count = ZCU102_CAN_FILTERS,
    .layout = CAN_LAYOUT,
};

tumble_status_t zcu102_configure(tumble_navcomp_config_t *config, zcu102_commissioned_t *room)
{
    tumble_status_t status = TUMBLE_E_PORT_EMPTY;
    *config = tumble_standard_navcomp;
#ifdef ZCU102_COMMISSIONING_ADDRESS
    status = zcu102_commissioning_read(room, (const uint8_t *)(uintptr_t)ZCU102_COMMISSIONING_ADDRESS);
#endif
    if (status == TUMBLE_OK) {
        config->procedure = &room->procedure;
        config->stand_profile = &room->drive;
        config->block_period_us = room->block_period_us;
        config->heartbeat_ms = room->heartbeat_ms;
        config->heartbeat_timeout_ms = room->heartbeat_timeout_ms;
    }
    return (status == TUMBLE_E_PORT_EMPTY) ? TUMBLE_OK : status;
}

static bool is_heard(uint32_t id)
{
    bool heard = false;
    for (uint32_t n = 0; n < ZCU102_CAN_FILTERS; n++) {
        heard = heard || (((id ^ FILTERS[n].id) & FILTERS[n].mask) == 0U);
    }
    return heard;
}

zcu102_can_config_t zcu102_can_for(const tumble_navcomp_config_t *config)
{
    zcu102_can_config_t can = zcu102_can;
    const tumble_drive_profile_t *drive = config->stand_profile;
    for (uint8_t i = 0; i < drive->transmit_count; i++) {
        if (!is_heard(drive->transmit[i].setup.cob_id & TUMBLE_CAN_MAX_ID)) {
            can.filters = NULL;
            can.filter_count = 0;
        }
    }
    return can;
}
