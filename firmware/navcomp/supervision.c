/* supervision.c - who watches whom by heartbeats. To stop the axis when something falls silent, this computer must hear
 * the others, and they must hear it.
 */
#include "navcomp/navcomp_internal.h"

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

void tumble_tell_block_alive(tumble_navcomp_t *navcomp)
{
    const uint8_t block_node = navcomp->config->block_node;
    const bool alive =
        !tumble_has_block(navcomp) || (tumble_nmt_state_of(&navcomp->node.nmt, block_node) == TUMBLE_NMT_OPERATIONAL);
    tumble_procedure_set_block_alive(&navcomp->procedure, alive);
}
