#include "navcomp/navcomp_internal.h"

#include "core/bytes.h"
#include "core/one_copy.h"

#include <stddef.h>

/* Who watches whom by heartbeats. To stop the axis when something falls silent, this computer must hear the others, and they
 * must hear it. */

#define WATCHES_STAND 1U /* subindices of 1016h */
#define WATCHES_BLOCK 2U

/* 1016h:1 and :2 as configured. */
static uint32_t watched_stand(const tumble_navcomp_t *navcomp)
{
    const tumble_navcomp_config_t *config = navcomp->config;
    return tumble_is_on_bus(navcomp) ? (((uint32_t)config->stand_node << 16) | config->heartbeat_timeout_ms) : 0U;
}

static uint32_t watched_block(const tumble_navcomp_t *navcomp)
{
    const tumble_navcomp_config_t *config = navcomp->config;
    return tumble_has_block(navcomp) ? (((uint32_t)config->block_node << 16) | config->heartbeat_timeout_ms) : 0U;
}

/* Put the configuration's heartbeats in place of the dictionary's power-on values. Clear all consumers first: a node
 * that is watched twice is refused, also if its old place is about to change. */
void tumble_set_heartbeats(tumble_navcomp_t *navcomp, uint64_t now_us)
{
    const tumble_navcomp_config_t *config = navcomp->config;
    tumble_nmt_t *nmt = &navcomp->node.nmt;
    tumble_nmt_set_producer(nmt, config->heartbeat_ms, now_us);
    for (uint8_t subindex = 1; subindex <= TUMBLE_MAX_CONSUMERS; subindex++) {
        (void)tumble_nmt_set_consumer(nmt, subindex, 0);
    }
    (void)tumble_nmt_set_consumer(nmt, WATCHES_STAND, watched_stand(navcomp));
    (void)tumble_nmt_set_consumer(nmt, WATCHES_BLOCK, watched_block(navcomp));
}

/* Process data need no check: while there is a drive nobody can write them, and its bring-up sets them. */
bool tumble_is_supervised(const tumble_navcomp_t *navcomp)
{
    const tumble_nmt_t *nmt = &navcomp->node.nmt;
    return (tumble_nmt_consumer(nmt, WATCHES_STAND) == watched_stand(navcomp)) &&
           (tumble_nmt_consumer(nmt, WATCHES_BLOCK) == watched_block(navcomp)) &&
           (nmt->producer_ms == navcomp->config->heartbeat_ms);
}

TUMBLE_ONE_COPY void tumble_tell_block_alive(tumble_navcomp_t *navcomp)
{
    const uint8_t block_node = navcomp->config->block_node;
    const bool alive =
        !tumble_has_block(navcomp) || (tumble_nmt_state_of(&navcomp->node.nmt, block_node) == TUMBLE_NMT_OPERATIONAL);
    tumble_procedure_set_block_alive(&navcomp->procedure, alive);
}

/* What the node tells. */

static bool is_stand(const tumble_navcomp_t *navcomp, uint8_t node)
{
    return node == navcomp->config->stand_node; /* nobody is node 0 */
}

static bool is_block(const tumble_navcomp_t *navcomp, uint8_t node)
{
    return tumble_has_block(navcomp) && (node == navcomp->config->block_node);
}

/* A block that has restarted counts from the beginning: forget its last counter, or its samples would count as
 * reordered. Start it (again) as soon as it is seen. */
static void block_heartbeat(tumble_navcomp_t *navcomp, tumble_heartbeat_event_t event)
{
    if (event == TUMBLE_HEARTBEAT_BOOTED) {
        tumble_block_receiver_restart(&navcomp->block);
    }
    navcomp->block_start_us = 0;
    tumble_tell_block_alive(navcomp);
}

static void heartbeat(void *context, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t state)
{
    tumble_navcomp_t *navcomp = context;
    if (is_stand(navcomp, node)) {
        navcomp->stand.kind->heartbeat(navcomp->stand.self, event, state);
    } else if (is_block(navcomp, node)) {
        block_heartbeat(navcomp, event);
    } else {
        return; /* somebody whom an outsider made us watch (1016h) */
    }
    if (event == TUMBLE_HEARTBEAT_LOST) {
        tumble_count(&navcomp->events.heartbeats_lost);
        navcomp->more = true; /* the procedure has not seen it yet */
    } else if (event == TUMBLE_HEARTBEAT_BOOTED) {
        tumble_count(&navcomp->events.boot_ups);
    } else {
        /* it lives */
    }
}

static void emergency(void *context, uint8_t node, const tumble_emergency_t *message)
{
    tumble_navcomp_t *navcomp = context;
    if (is_stand(navcomp, node)) {
        navcomp->stand.kind->emergency(navcomp->stand.self, message);
    }
    if (is_stand(navcomp, node) || is_block(navcomp, node)) {
        tumble_count(&navcomp->events.emergencies);
    }
}

static void pdo_received(void *context, uint8_t number)
{
    tumble_navcomp_t *navcomp = context;
    if (tumble_is_on_bus(navcomp)) {
        navcomp->stand.kind->pdo_received(navcomp->stand.self, number);
    }
}

static void reset(void *context, bool application)
{
    tumble_navcomp_t *navcomp = context;
    tumble_node_t *node = &navcomp->node;
    (void)tumble_procedure_abort(&navcomp->procedure); /* stops the table even when there is no run to abort */
    if (tumble_node_state(node) == TUMBLE_NMT_OPERATIONAL) {
        tumble_pdo_step(&node->pdos, &node->dictionary, &node->link, navcomp->stepped_us); /* before they are gone */
    }
    navcomp->service_until_us = 0; /* the node's emergencies begin anew as well */
    navcomp->restart = (uint8_t)(application ? RESTART_APPLICATION : RESTART_COMMUNICATION);
}

/* A request to the drive's SDO server that begins to write what commands its axis. */
static bool commands_by_sdo(const tumble_navcomp_t *navcomp, const tumble_can_frame_t *frame)
{
    const uint16_t index = tumble_get_u16(&frame->data[1]);
    const unsigned begins = frame->data[0] & 0xE1U; /* 20h, 21h: a download; C0h: one in blocks */
    return (frame->id == (TUMBLE_SDO_REQUEST_ID + navcomp->config->stand_node)) && (frame->length >= 4U) &&
           (((begins & 0xE0U) == 0x20U) || (begins == 0xC0U)) &&
           ((index == TUMBLE_402_CONTROLWORD) || (index == TUMBLE_402_TARGET_POSITION) || (index == TUMBLE_402_MODE));
}

bool tumble_notice_foreign(tumble_navcomp_t *navcomp, const tumble_can_frame_t *frame)
{
    bool ours = (frame->id == (TUMBLE_HEARTBEAT_ID + navcomp->config->node)) || commands_by_sdo(navcomp, frame);
    if (tumble_is_on_bus(navcomp)) {
        ours = navcomp->stand.kind->foreign(navcomp->stand.self, frame->id, ours);
    }
    if (ours) {
        tumble_count(&navcomp->events.foreign);
    }
    return ours;
}

const tumble_node_events_t tumble_navcomp_node_events = {
    .state_changed = NULL,
    .reset = reset,
    .heartbeat = heartbeat,
    .emergency = emergency,
    .pdo_received = pdo_received,
};
