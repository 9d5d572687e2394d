#include "canopen/communication.h"

#include "core/bytes.h"

#define ERROR_REGISTER 0x1001U
#define ERROR_HISTORY 0x1003U
#define CONSUMER_TIME 0x1016U
#define EMCY_ID 0x1014U
#define PRODUCER_TIME 0x1017U
#define ERROR_BEHAVIOUR 0x1029U
#define SDO_SERVER 0x1200U
#define SECOND_SDO_SERVER 0x1201U
#define SDO_CLIENT 0x1280U
#define FIRST_PDO 0x1400U
#define LAST_PDO 0x1BFFU
#define PDO_MAPPING 0x0200U /* set in 1600h and 1A00h, not in 1400h and 1800h */

/* The third transmit PDO and those after it are for outsiders to set up as they like. At the normal level they get no
 * identifier that another node or service could have: above those of NMT, SYNC, EMCY and TIME, and with the node's own
 * number in its low six bits, as 180h + node, ..., 680h + node and 6C0h + node have it. And none of them goes more often
 * than every 10 ms: all three together then take 8 % of a bus of 500 kbit/s, and no heartbeat is lost at 125 kbit/s. */
#define FREE_PDO 0x1802U
#define LAST_SERVICE_ID 0x180U
#define OWN_NUMBER 0x3FU
#define SUB_COB_ID 1U
#define SUB_INHIBIT 3U
#define SUB_EVENT 5U
#define LEAST_INHIBIT_100US 100U
#define LEAST_EVENT_MS 10U

void tumble_communication_mend(tumble_node_t *node)
{
    if (!tumble_nmt_any_lost(&node->nmt) && !tumble_pdo_any_fault(&node->pdos) &&
        ((node->emcy.error_register & TUMBLE_ERROR_COMMUNICATION) != 0U)) {
        tumble_emcy_clear(&node->emcy, TUMBLE_ERROR_COMMUNICATION);
    }
}

static bool is_pdo(uint16_t index)
{
    return (index >= FIRST_PDO) && (index <= LAST_PDO);
}

static tumble_abort_t read_history(const tumble_emcy_t *emcy, uint8_t subindex, uint32_t *value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (subindex == 0U) {
        *value = emcy->recorded;
    } else if (subindex <= emcy->recorded) {
        *value = emcy->history[subindex - 1U];
    } else {
        refusal = TUMBLE_ABORT_NO_DATA;
    }
    return refusal;
}

/* Subindex 1: identifier from client to server, 2: back, 3: the node at the other end. Without such a node, or without
 * the server, the identifiers are marked invalid. */
static uint32_t sdo_parameter(uint8_t server, uint8_t subindex, bool is_there)
{
    uint32_t value = server;

    if (subindex != 3U) {
        value += (subindex == 1U) ? TUMBLE_SDO_REQUEST_ID : TUMBLE_SDO_RESPONSE_ID;
        value |= is_there ? 0U : TUMBLE_PDO_INVALID;
    }
    return value;
}

/* Would a PDO with this identifier be taken for a frame of the second server, or this for one of it? */
static bool is_of_second(const tumble_node_t *node, uint32_t cob_id)
{
    const uint32_t kind = (cob_id & (TUMBLE_PDO_INVALID | TUMBLE_CAN_MAX_ID)) - node->config->node;

    return (node->server.second != NULL) &&
           ((kind == TUMBLE_SDO_SECOND_REQUEST_ID) || (kind == TUMBLE_SDO_SECOND_RESPONSE_ID));
}

/* See FREE_PDO. */
static tumble_abort_t check_free_pdo(const tumble_node_t *node, uint8_t subindex, uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (subindex == SUB_COB_ID) {
        const bool is_own = ((value ^ node->config->node) & OWN_NUMBER) == 0U;
        const bool is_used = (value & TUMBLE_PDO_INVALID) == 0U;

        if (is_used && (!is_own || ((value & TUMBLE_CAN_MAX_ID) <= LAST_SERVICE_ID))) {
            refusal = TUMBLE_ABORT_VALUE;
        }
    } else if (((subindex == SUB_INHIBIT) && (value < LEAST_INHIBIT_100US)) ||
               ((subindex == SUB_EVENT) && ((value - 1U) < (LEAST_EVENT_MS - 1U)))) { /* 0: no timer */
        refusal = TUMBLE_ABORT_TOO_LOW;
    } else {
        /* any value */
    }
    return refusal;
}

static tumble_abort_t write_pdo(tumble_node_t *node, uint16_t index, uint8_t subindex, uint32_t value)
{
    const bool maps = ((index & PDO_MAPPING) != 0U); /* an object, or their number */
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (!maps && (subindex == SUB_COB_ID) && is_of_second(node, value)) {
        refusal = TUMBLE_ABORT_VALUE;
    } else if (!maps && (index >= FREE_PDO) && !node->server.service) {
        refusal = check_free_pdo(node, subindex, value);
    } else {
        /* a mapping, of the node's own parts, or at service level */
    }
    return (refusal == TUMBLE_ABORT_NONE)
               ? tumble_pdo_write_parameter(&node->pdos, &node->dictionary, index, subindex, value)
               : refusal;
}

static bool is_consumer(uint8_t subindex)
{
    return (subindex >= 1U) && (subindex <= TUMBLE_MAX_CONSUMERS);
}

static tumble_abort_t read_number(tumble_node_t *node, uint16_t index, uint8_t subindex, uint32_t *value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (is_pdo(index)) {
        refusal = tumble_pdo_read_parameter(&node->pdos, &node->dictionary, index, subindex, value);
    } else if (index == ERROR_REGISTER) {
        *value = node->emcy.error_register;
    } else if (index == ERROR_HISTORY) {
        refusal = read_history(&node->emcy, subindex, value);
    } else if ((index == CONSUMER_TIME) && is_consumer(subindex)) {
        *value = tumble_nmt_consumer(&node->nmt, subindex);
    } else if (index == PRODUCER_TIME) {
        *value = node->nmt.producer_ms;
    } else if (index == ERROR_BEHAVIOUR) {
        *value = node->on_error;
    } else if (index == SDO_CLIENT) {
        *value = sdo_parameter(node->client.node, subindex, node->client.node != 0U);
    } else if (index == SDO_SERVER) {
        *value = sdo_parameter(node->config->node, subindex, true);
    } else if (index == SECOND_SDO_SERVER) {
        *value = sdo_parameter(node->config->node, subindex, node->server.second != NULL) - TUMBLE_SDO_TO_SECOND;
    } else if (index == EMCY_ID) {
        *value = TUMBLE_EMCY_ID + (uint32_t)node->config->node;
    } else {
        refusal = TUMBLE_ABORT_NO_DATA;
    }
    return refusal;
}

static tumble_abort_t read(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    uint32_t value = 0;
    tumble_abort_t refusal = read_number((tumble_node_t *)context, entry->index, entry->subindex, &value);

    (void)size; /* numbers: as the entry says */
    tumble_put_u32(bytes, value);
    return refusal;
}

static tumble_abort_t write_history(tumble_emcy_t *emcy, uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_VALUE;

    if (value == 0U) {
        tumble_emcy_forget(emcy);
        refusal = TUMBLE_ABORT_NONE;
    }
    return refusal;
}

static tumble_abort_t write_number(tumble_node_t *node, uint16_t index, uint8_t subindex, uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (is_pdo(index)) {
        refusal = write_pdo(node, index, subindex, value);
    } else if (index == ERROR_HISTORY) {
        refusal = write_history(&node->emcy, value);
    } else if ((index == CONSUMER_TIME) && is_consumer(subindex)) {
        refusal = tumble_nmt_set_consumer(&node->nmt, subindex, value);
    } else if (index == PRODUCER_TIME) {
        tumble_nmt_set_producer(&node->nmt, (uint16_t)value, node->now_us);
    } else if ((index == ERROR_BEHAVIOUR) && (value <= TUMBLE_ON_ERROR_STOP)) {
        node->on_error = (uint8_t)value;
    } else {
        refusal = TUMBLE_ABORT_VALUE;
    }
    return refusal;
}

static tumble_abort_t write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    tumble_node_t *node = (tumble_node_t *)context;
    tumble_abort_t refusal;
    uint32_t value = bytes[0];

    if (size == 2U) {
        value = tumble_get_u16(bytes);
    } else if (size == 4U) {
        value = tumble_get_u32(bytes);
    } else {
        /* one byte */
    }
    refusal = write_number(node, entry->index, entry->subindex, value);
    tumble_communication_mend(node);
    return refusal;
}

const tumble_object_hooks_t tumble_communication_hooks = {.read = read, .write = write};
