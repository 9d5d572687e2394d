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

    if (is_pdo(index) && (subindex == 1U) && ((index & PDO_MAPPING) == 0U) && is_of_second(node, value)) {
        refusal = TUMBLE_ABORT_VALUE;
    } else if (is_pdo(index)) {
        refusal = tumble_pdo_write_parameter(&node->pdos, &node->dictionary, index, subindex, value);
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
