#include "canopen/nmt.h"

#include <stddef.h>
#include <string.h>

#define US_PER_MS 1000U
#define MAX_NODE 127U

/* A watched node from power-on. Nothing is armed before it is first heard: a node that boots slowly is not lost.
 *
 *     node       off          boot-up   hb    hb    hb    (falls silent)                     hb
 *                              |        |     |     |                                        |
 *     event                    BOOTED   (CHANGED or nothing)    |<- time_ms ->| LOST         BEGAN
 *     deadline   TUMBLE_NEVER  | heard + time_ms, anew at each                | TUMBLE_NEVER | heard + time_ms
 *     state      UNKNOWN       | as heard                                     | UNKNOWN      | as heard
 *
 * A heartbeat after a loss is BEGAN again, so that its owner brings the node up anew: while it was silent it may have
 * restarted, and its boot-up message may be lost.
 */
void tumble_nmt_init(tumble_nmt_t *nmt, uint8_t node, uint16_t producer_ms)
{
    (void)memset(nmt, 0, sizeof *nmt);
    nmt->node = node;
    nmt->producer_ms = producer_ms;
    nmt->state = (uint8_t)TUMBLE_NMT_INITIALISING;
    nmt->next_state = (uint8_t)TUMBLE_NMT_PRE_OPERATIONAL;
    nmt->heartbeat_us = TUMBLE_NEVER;
    for (uint8_t i = 0; i < TUMBLE_MAX_CONSUMERS; i++) {
        nmt->consumers[i].deadline_us = TUMBLE_NEVER;
        nmt->consumers[i].state = (uint8_t)TUMBLE_NMT_UNKNOWN;
    }
}

void tumble_nmt_set_state(tumble_nmt_t *nmt, tumble_nmt_state_t state)
{
    if (nmt->state == (uint8_t)TUMBLE_NMT_INITIALISING) {
        nmt->next_state = (uint8_t)state;
    } else {
        nmt->state = (uint8_t)state;
    }
}

uint8_t tumble_nmt_receive(tumble_nmt_t *nmt, const tumble_can_frame_t *frame)
{
    uint8_t command = frame->data[0];
    if (frame->length != 2U) {
        tumble_count_u16(&nmt->ignored);
        return 0;
    }
    if ((frame->data[1] != 0U) && (frame->data[1] != nmt->node)) {
        return 0;
    }
    switch (command) {
    case TUMBLE_NMT_START:
        tumble_nmt_set_state(nmt, TUMBLE_NMT_OPERATIONAL);
        break;
    case TUMBLE_NMT_STOP:
        tumble_nmt_set_state(nmt, TUMBLE_NMT_STOPPED);
        break;
    case TUMBLE_NMT_ENTER_PRE_OPERATIONAL:
        tumble_nmt_set_state(nmt, TUMBLE_NMT_PRE_OPERATIONAL);
        break;
    case TUMBLE_NMT_RESET_NODE:
    case TUMBLE_NMT_RESET_COMMUNICATION:
        break;
    default:
        tumble_count_u16(&nmt->ignored);
        command = 0;
        break;
    }
    return command;
}

tumble_status_t tumble_nmt_command(tumble_nmt_t *nmt, uint8_t node, tumble_nmt_command_t command)
{
    if (node > MAX_NODE) {
        return TUMBLE_E_ARGUMENT;
    }
    if (nmt->queued >= TUMBLE_NMT_QUEUE) {
        tumble_count_u16(&nmt->ignored);
        return TUMBLE_E_PORT_BUSY;
    }
    nmt->queue[nmt->queued][0] = (uint8_t)command;
    nmt->queue[nmt->queued][1] = node;
    ++nmt->queued;
    return TUMBLE_OK;
}

/* Where a node is watched: a place in the consumers, or their number. None is watched twice. */
static uint8_t place_of(const tumble_nmt_t *nmt, uint8_t node)
{
    uint8_t place = 0;
    while ((place < TUMBLE_MAX_CONSUMERS) &&
           ((nmt->consumers[place].node != node) || (nmt->consumers[place].time_ms == 0U))) {
        ++place;
    }
    return place;
}

/* What a heartbeat says beside what was known. */
static tumble_heartbeat_event_t judge(const tumble_consumer_t *consumer, uint8_t state)
{
    if (state == (uint8_t)TUMBLE_NMT_INITIALISING) {
        return TUMBLE_HEARTBEAT_BOOTED;
    }
    if (consumer->deadline_us == TUMBLE_NEVER) {
        return TUMBLE_HEARTBEAT_BEGAN;
    }
    return (consumer->state != state) ? TUMBLE_HEARTBEAT_CHANGED : TUMBLE_HEARTBEAT_NOTHING;
}

tumble_heartbeat_event_t tumble_nmt_heard(tumble_nmt_t *nmt, const tumble_can_frame_t *frame, uint64_t now_us,
                                          uint8_t *node)
{
    const uint8_t state = frame->data[0] & 0x7FU; /* bit 7 is the toggle bit of node guarding */
    *node = (uint8_t)(frame->id - TUMBLE_HEARTBEAT_ID);
    const uint8_t place = place_of(nmt, *node);
    if ((place == TUMBLE_MAX_CONSUMERS) || (frame->length != 1U)) {
        return TUMBLE_HEARTBEAT_NOTHING;
    }
    tumble_consumer_t *consumer = &nmt->consumers[place];
    const tumble_heartbeat_event_t event = judge(consumer, state);
    consumer->state = state;
    consumer->lost = false;
    consumer->deadline_us = now_us + ((uint64_t)consumer->time_ms * US_PER_MS);
    return event;
}

uint8_t tumble_nmt_lost(tumble_nmt_t *nmt, uint64_t now_us)
{
    for (uint8_t i = 0; i < TUMBLE_MAX_CONSUMERS; i++) {
        tumble_consumer_t *consumer = &nmt->consumers[i];
        if (now_us >= consumer->deadline_us) {
            consumer->deadline_us = TUMBLE_NEVER;
            consumer->state = (uint8_t)TUMBLE_NMT_UNKNOWN;
            consumer->lost = true;
            return consumer->node;
        }
    }
    return 0;
}

static tumble_status_t send_state(const tumble_nmt_t *nmt, tumble_link_t *link)
{
    return tumble_link_send_bytes(link, TUMBLE_HEARTBEAT_ID + (uint32_t)nmt->node, &nmt->state, sizeof nmt->state);
}

/* The boot-up message is a heartbeat that carries 0. */
static bool boot(tumble_nmt_t *nmt, tumble_link_t *link, uint64_t now_us)
{
    const bool sent = send_state(nmt, link) == TUMBLE_OK;
    if (sent) {
        nmt->state = nmt->next_state;
        tumble_nmt_set_producer(nmt, nmt->producer_ms, now_us);
    }
    return sent;
}

static tumble_status_t send_commands(tumble_nmt_t *nmt, tumble_link_t *link)
{
    tumble_status_t status = TUMBLE_OK;
    while ((nmt->queued > 0U) && (status == TUMBLE_OK)) {
        status = tumble_link_send_bytes(link, TUMBLE_NMT_ID, nmt->queue[0], sizeof nmt->queue[0]);
        if (status == TUMBLE_OK) {
            --nmt->queued;
            (void)memmove(nmt->queue[0], nmt->queue[1], nmt->queued * sizeof nmt->queue[0]);
        }
    }
    return status;
}

/* Heartbeats keep their period whatever the delay of a step: the next is due a period after the last was due. Only if a
 * whole period was missed the period begins anew, or several heartbeats would go out at once. */
static void send_heartbeat(tumble_nmt_t *nmt, tumble_link_t *link, uint64_t now_us)
{
    uint64_t period_us = (uint64_t)nmt->producer_ms * US_PER_MS;
    if ((now_us >= nmt->heartbeat_us) && (send_state(nmt, link) == TUMBLE_OK)) {
        nmt->heartbeat_us += period_us;
        if (nmt->heartbeat_us <= now_us) {
            nmt->heartbeat_us = now_us + period_us;
        }
    }
}

bool tumble_nmt_step(tumble_nmt_t *nmt, tumble_link_t *link, uint64_t now_us)
{
    if (nmt->state == (uint8_t)TUMBLE_NMT_INITIALISING) {
        return boot(nmt, link, now_us);
    }
    if (send_commands(nmt, link) == TUMBLE_OK) { /* else the port has no room: next step */
        send_heartbeat(nmt, link, now_us);
    }
    return false;
}

tumble_nmt_state_t tumble_nmt_state_of(const tumble_nmt_t *nmt, uint8_t node)
{
    const uint8_t place = place_of(nmt, node);
    return (place < TUMBLE_MAX_CONSUMERS) ? (tumble_nmt_state_t)nmt->consumers[place].state : TUMBLE_NMT_UNKNOWN;
}

bool tumble_nmt_any_lost(const tumble_nmt_t *nmt)
{
    bool lost = false;
    for (uint8_t i = 0; i < TUMBLE_MAX_CONSUMERS; i++) {
        lost = lost || nmt->consumers[i].lost;
    }
    return lost;
}

uint32_t tumble_nmt_consumer(const tumble_nmt_t *nmt, uint8_t subindex)
{
    const tumble_consumer_t *consumer = &nmt->consumers[subindex - 1U];
    return ((uint32_t)consumer->node << 16) | consumer->time_ms;
}

tumble_abort_t tumble_nmt_set_consumer(tumble_nmt_t *nmt, uint8_t subindex, uint32_t value)
{
    tumble_consumer_t *consumer = &nmt->consumers[subindex - 1U];
    uint8_t node = (uint8_t)((value >> 16) & 0xFFU);
    uint16_t time_ms = (uint16_t)(value & 0xFFFFU);
    const uint8_t place = place_of(nmt, node);
    if (((value >> 24) != 0U) || (node > MAX_NODE) || ((node == 0U) && (time_ms != 0U))) {
        return TUMBLE_ABORT_VALUE;
    }
    if ((time_ms != 0U) && (place != TUMBLE_MAX_CONSUMERS) && (place != (subindex - 1U))) {
        return TUMBLE_ABORT_INCOMPATIBLE;
    }
    consumer->node = node;
    consumer->time_ms = time_ms;
    consumer->state = (uint8_t)TUMBLE_NMT_UNKNOWN;
    consumer->lost = false;
    consumer->deadline_us = TUMBLE_NEVER;
    return TUMBLE_ABORT_NONE;
}

void tumble_nmt_set_producer(tumble_nmt_t *nmt, uint16_t producer_ms, uint64_t now_us)
{
    nmt->producer_ms = producer_ms;
    nmt->heartbeat_us = (producer_ms == 0U) ? TUMBLE_NEVER : (now_us + ((uint64_t)producer_ms * US_PER_MS));
}

void tumble_nmt_withhold(tumble_nmt_t *nmt, uint64_t until_us)
{
    if (nmt->heartbeat_us < until_us) {
        nmt->heartbeat_us = until_us;
    }
}

uint64_t tumble_nmt_next_us(const tumble_nmt_t *nmt)
{
    uint64_t next_us = nmt->heartbeat_us;
    if ((nmt->state == (uint8_t)TUMBLE_NMT_INITIALISING) || (nmt->queued > 0U)) {
        return 0;
    }
    for (uint8_t i = 0; i < TUMBLE_MAX_CONSUMERS; i++) {
        if (nmt->consumers[i].deadline_us < next_us) {
            next_us = nmt->consumers[i].deadline_us;
        }
    }
    return next_us;
}
