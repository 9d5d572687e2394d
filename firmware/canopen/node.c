#include "canopen/node.h"

#include "core/arith.h"
#include "core/bytes.h"
#include "core/one_copy.h"

#include <stddef.h>
#include <string.h>

#define MAX_NODE 127U

/* The ranges of identifiers that CANopen gives to its services. */
#define LAST_EMCY 0x0FFU
#define LAST_HEARTBEAT 0x77FU

/* Its own objects, 1001h to 1BFFh, as hooks of the dictionary. Those whose value never changes (1000h, 1005h, 1018h) have their
 * home in the table and do not come here. */

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

/* Clear the error register's communication bit when no watched node is silent and no receive PDO falls short. */
static void mend_communication(tumble_node_t *node)
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
    if (subindex > emcy->recorded) {
        return TUMBLE_ABORT_NO_DATA;
    }
    *value = (subindex == 0U) ? emcy->recorded : emcy->history[subindex - 1U];
    return TUMBLE_ABORT_NONE;
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
    const bool is_own = ((value ^ node->config->node) & OWN_NUMBER) == 0U;
    const bool is_used = (value & TUMBLE_PDO_INVALID) == 0U;
    if ((subindex == SUB_COB_ID) && is_used && (!is_own || ((value & TUMBLE_CAN_MAX_ID) <= LAST_SERVICE_ID))) {
        return TUMBLE_ABORT_VALUE;
    }
    const bool too_low = ((subindex == SUB_INHIBIT) && (value < LEAST_INHIBIT_100US)) ||
                         ((subindex == SUB_EVENT) && ((value - 1U) < (LEAST_EVENT_MS - 1U))); /* 0: no timer */
    return too_low ? TUMBLE_ABORT_TOO_LOW : TUMBLE_ABORT_NONE;
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
    const tumble_abort_t refusal = read_number((tumble_node_t *)context, entry->index, entry->subindex, &value);
    (void)size; /* numbers: as the entry says */
    tumble_put_u32(bytes, value);
    return refusal;
}

static tumble_abort_t write_history(tumble_emcy_t *emcy, uint32_t value)
{
    if (value != 0U) {
        return TUMBLE_ABORT_VALUE;
    }
    emcy->recorded = 0;
    return TUMBLE_ABORT_NONE;
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
    uint8_t number[sizeof(uint32_t)] = {0};
    (void)memcpy(number, bytes, size);
    const tumble_abort_t refusal = write_number(node, entry->index, entry->subindex, tumble_get_u32(number));
    mend_communication(node);
    return refusal;
}

/* Init. */

/* An identifier of the predefined connection set is completed by the node's number. */
static tumble_abort_t set_pdo(tumble_node_t *node, tumble_pdo_direction_t direction, uint8_t number,
                              const tumble_pdo_setup_t *setup)
{
    tumble_pdo_setup_t own = *setup;
    if ((own.cob_id & (TUMBLE_PDO_INVALID | MAX_NODE)) == 0U) {
        own.cob_id |= node->config->node;
    }
    return tumble_pdo_configure(&node->pdos, &node->dictionary, direction, number, &own);
}

/* They are numbered from `first` on. */
static tumble_abort_t set_transmit(tumble_node_t *node, const tumble_pdo_setup_t *setups, uint8_t count, uint8_t first)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;
    for (uint8_t i = 0; (i < count) && (refusal == TUMBLE_ABORT_NONE); i++) {
        refusal = set_pdo(node, TUMBLE_PDO_TRANSMIT, (uint8_t)(first + i), &setups[i]);
    }
    return refusal;
}

static tumble_abort_t set_defaults(tumble_node_t *node, const tumble_node_defaults_t *defaults)
{
    const tumble_node_extension_t *extension = node->config->extension;
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;
    node->on_error = defaults->on_error;
    for (uint8_t i = 0; (i < TUMBLE_MAX_CONSUMERS) && (refusal == TUMBLE_ABORT_NONE); i++) {
        refusal = tumble_nmt_set_consumer(&node->nmt, (uint8_t)(i + 1U), defaults->consumers[i]);
    }
    for (uint8_t i = 0; (i < defaults->receive_count) && (refusal == TUMBLE_ABORT_NONE); i++) {
        refusal = set_pdo(node, TUMBLE_PDO_RECEIVE, (uint8_t)(defaults->first_receive + i), &defaults->receive[i]);
    }
    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = set_transmit(node, defaults->transmit, defaults->transmit_count, defaults->first_transmit);
    }
    if ((refusal == TUMBLE_ABORT_NONE) && (extension != NULL)) {
        refusal = set_transmit(node, extension->transmit, extension->transmit_count, extension->first_transmit);
    }
    return refusal;
}

/* Communication as after power-on; the link with its counters goes on. */
static tumble_abort_t start(tumble_node_t *node)
{
    const tumble_node_config_t *config = node->config;
    tumble_second_server_t *second = node->server.second;
    tumble_nmt_init(&node->nmt, config->node, config->defaults->heartbeat_ms);
    tumble_sdo_server_init(&node->server, (uint16_t)(TUMBLE_SDO_RESPONSE_ID + config->node));
    node->server.second = second;
    if (second != NULL) {
        tumble_sdo_server_init(&second->server, (uint16_t)(TUMBLE_SDO_SECOND_RESPONSE_ID + config->node));
    }
    tumble_sdo_client_drop(&node->client);
    tumble_pdo_init(&node->pdos);
    tumble_emcy_init(&node->emcy, config->node);
    return set_defaults(node, config->defaults);
}

static bool are_usable(const tumble_pdo_setup_t *setups, uint8_t count, uint8_t most)
{
    return (count <= most) && ((count == 0U) || (setups != NULL));
}

static bool is_usable(const tumble_node_config_t *config, const tumble_node_binding_t *binding)
{
    const tumble_node_defaults_t *defaults = (config != NULL) ? config->defaults : NULL;
    return (defaults != NULL) && (binding != NULL) && (config->table != NULL) && (binding->port != NULL) &&
           (config->node >= 1U) && (config->node <= MAX_NODE) &&
           are_usable(defaults->receive, defaults->receive_count, TUMBLE_MAX_RECEIVE_PDOS) &&
           are_usable(defaults->transmit, defaults->transmit_count, TUMBLE_MAX_TRANSMIT_PDOS);
}

/* A place in the tables is one byte. */
static bool fits(const tumble_node_extension_t *extension, const tumble_node_config_t *config)
{
    const tumble_object_table_t *further = (extension != NULL) ? extension->objects.table : NULL;
    return (extension == NULL) ||
           ((further != NULL) && (((uint32_t)config->table->count + further->count) <= UINT8_MAX) &&
            (extension->first_transmit <= TUMBLE_MAX_TRANSMIT_PDOS) &&
            are_usable(extension->transmit, extension->transmit_count,
                       (uint8_t)(TUMBLE_MAX_TRANSMIT_PDOS - extension->first_transmit)));
}

tumble_status_t tumble_node_init(tumble_node_t *node, const tumble_node_config_t *config,
                                 const tumble_node_binding_t *binding)
{
    static const tumble_object_hooks_t communication_hooks = {.read = read, .write = write};
    if ((node == NULL) || !is_usable(config, binding) || !fits(config->extension, config)) {
        return TUMBLE_E_ARGUMENT;
    }
    (void)memset(node, 0, sizeof *node);
    node->config = config;
    node->dictionary = (tumble_dictionary_t){
        .table = config->table,
        .extension = (config->extension != NULL) ? &config->extension->objects : NULL,
        .variables = binding->variables,
        .other = binding->other,
        .application = {.hooks = config->hooks, .context = binding->context},
        .communication = {.hooks = &communication_hooks, .context = node},
    };
    tumble_link_init(&node->link, binding->port);
    tumble_sdo_client_init(&node->client);
    node->server.second = binding->second;
    return (start(node) == TUMBLE_ABORT_NONE) ? TUMBLE_OK : TUMBLE_E_ARGUMENT;
}

static void *context_of(const tumble_node_t *node)
{
    return node->dictionary.application.context;
}

tumble_nmt_state_t tumble_node_state(const tumble_node_t *node)
{
    return (tumble_nmt_state_t)node->nmt.state;
}

/* SDO lives in these two states. */
static bool has_sdo(const tumble_node_t *node)
{
    return (node->nmt.state == (uint8_t)TUMBLE_NMT_PRE_OPERATIONAL) ||
           (node->nmt.state == (uint8_t)TUMBLE_NMT_OPERATIONAL);
}

static bool is_operational(const tumble_node_t *node)
{
    return node->nmt.state == (uint8_t)TUMBLE_NMT_OPERATIONAL;
}

/* What a change of state brings with it, if there was one. */
static void follow_state(tumble_node_t *node, tumble_nmt_state_t before)
{
    const tumble_node_events_t *events = node->config->events;
    tumble_nmt_state_t state = tumble_node_state(node);
    if (state != before) {
        if (state == TUMBLE_NMT_OPERATIONAL) {
            tumble_pdo_start(&node->pdos);
        }
        if ((events != NULL) && (events->state_changed != NULL)) {
            events->state_changed(context_of(node), state);
        }
    }
}

void tumble_node_set_state(tumble_node_t *node, tumble_nmt_state_t state)
{
    tumble_nmt_state_t before = tumble_node_state(node);
    tumble_nmt_set_state(&node->nmt, state);
    follow_state(node, before);
}

static void reset(tumble_node_t *node, bool application)
{
    const tumble_node_events_t *events = node->config->events;
    if ((events != NULL) && (events->reset != NULL)) {
        events->reset(context_of(node), application);
    }
    (void)start(node); /* the defaults passed at init */
}

static void receive_command(tumble_node_t *node, const tumble_can_frame_t *frame)
{
    tumble_nmt_state_t before = tumble_node_state(node);
    uint8_t command = tumble_nmt_receive(&node->nmt, frame);
    if ((command == (uint8_t)TUMBLE_NMT_RESET_NODE) || (command == (uint8_t)TUMBLE_NMT_RESET_COMMUNICATION)) {
        reset(node, command == (uint8_t)TUMBLE_NMT_RESET_NODE);
    } else {
        follow_state(node, before);
    }
}

static void receive_emergency(const tumble_node_t *node, const tumble_can_frame_t *frame)
{
    const tumble_node_events_t *events = node->config->events;
    tumble_emergency_t emergency;
    uint8_t from;
    if (tumble_emcy_parse(frame, &from, &emergency) && (events != NULL) && (events->emergency != NULL)) {
        events->emergency(context_of(node), from, &emergency);
    }
}

static void tell_heartbeat(const tumble_node_t *node, uint8_t from, tumble_heartbeat_event_t event)
{
    const tumble_node_events_t *events = node->config->events;
    if ((event != TUMBLE_HEARTBEAT_NOTHING) && (events != NULL) && (events->heartbeat != NULL)) {
        events->heartbeat(context_of(node), from, event, tumble_nmt_state_of(&node->nmt, from));
    }
}

static void receive_heartbeat(tumble_node_t *node, const tumble_can_frame_t *frame)
{
    uint8_t from;
    tumble_heartbeat_event_t event = tumble_nmt_heard(&node->nmt, frame, node->now_us, &from);
    mend_communication(node);
    tell_heartbeat(node, from, event);
}

static void raise_communication(tumble_node_t *node, uint16_t code, uint8_t detail)
{
    tumble_emcy_tell(&node->emcy, code, TUMBLE_ERROR_COMMUNICATION, detail);
}

/* A PDO that falls short is reported when it begins to do so, not every time. */
static bool receive_pdo(tumble_node_t *node, const tumble_can_frame_t *frame)
{
    const tumble_node_events_t *events = node->config->events;
    bool before = tumble_pdo_any_fault(&node->pdos);
    uint8_t number = 0;
    tumble_pdo_outcome_t outcome = tumble_pdo_receive(&node->pdos, &node->dictionary, frame, &number);
    if (outcome == TUMBLE_PDO_TAKEN) {
        mend_communication(node);
        if ((events != NULL) && (events->pdo_received != NULL)) {
            events->pdo_received(context_of(node), number);
        }
    } else if ((outcome == TUMBLE_PDO_TOO_SHORT) && !before) {
        raise_communication(node, TUMBLE_EMCY_PDO_LENGTH, number);
    } else {
        /* not a PDO, or known to be short */
    }
    return outcome != TUMBLE_PDO_NOT_MINE;
}

static bool is_other_node(const tumble_node_t *node, uint16_t id, uint16_t base, uint16_t last)
{
    return (id > base) && (id <= last) && (id != (base + node->config->node));
}

static bool is_answer(const tumble_node_t *node, uint16_t id)
{
    return (node->client.node != 0U) && (id == (TUMBLE_SDO_RESPONSE_ID + node->client.node));
}

/* What the client stages are variables of its own, for as long as its request is served. */
static void receive_second(tumble_node_t *node, const tumble_can_frame_t *frame)
{
    tumble_second_server_t *second = node->server.second;
    void *const variables = node->dictionary.variables;
    second->server.held = node->server.held;
    second->server.service = node->server.service;
    node->dictionary.variables = second->variables;
    tumble_sdo_server_receive(&second->server, &node->dictionary, frame, node->now_us);
    node->dictionary.variables = variables;
}

TUMBLE_ONE_COPY bool tumble_node_receive(tumble_node_t *node, const tumble_can_frame_t *frame, uint64_t now_us)
{
    bool mine = true;
    node->now_us = now_us;
    if (frame->id == TUMBLE_NMT_ID) {
        receive_command(node, frame);
    } else if (is_other_node(node, frame->id, TUMBLE_EMCY_ID, LAST_EMCY)) {
        receive_emergency(node, frame);
    } else if (is_other_node(node, frame->id, TUMBLE_HEARTBEAT_ID, LAST_HEARTBEAT)) {
        receive_heartbeat(node, frame);
    } else if ((frame->id == (TUMBLE_SDO_REQUEST_ID + node->config->node)) && has_sdo(node)) {
        tumble_sdo_server_receive(&node->server, &node->dictionary, frame, now_us);
    } else if ((frame->id == (TUMBLE_SDO_SECOND_REQUEST_ID + node->config->node)) && (node->server.second != NULL) &&
               has_sdo(node)) {
        receive_second(node, frame);
    } else if (is_answer(node, frame->id) && has_sdo(node)) {
        tumble_sdo_client_receive(&node->client, frame);
    } else {
        mine = is_operational(node) && receive_pdo(node, frame);
    }
    return mine;
}

/* 1029h:1, and the emergency message. */
static void act_on_loss(tumble_node_t *node, uint8_t silent)
{
    raise_communication(node, TUMBLE_EMCY_HEARTBEAT, silent);
    if (is_operational(node) && (node->on_error != TUMBLE_ON_ERROR_STAY)) {
        tumble_node_set_state(node, (node->on_error == TUMBLE_ON_ERROR_STOP) ? TUMBLE_NMT_STOPPED
                                                                             : TUMBLE_NMT_PRE_OPERATIONAL);
    }
}

static void watch(tumble_node_t *node)
{
    uint8_t silent = tumble_nmt_lost(&node->nmt, node->now_us);
    while (silent != 0U) {
        act_on_loss(node, silent);
        tell_heartbeat(node, silent, TUMBLE_HEARTBEAT_LOST);
        silent = tumble_nmt_lost(&node->nmt, node->now_us);
    }
}

void tumble_node_answer(tumble_node_t *node, tumble_abort_t refusal)
{
    tumble_sdo_server_answer(&node->server, refusal);
    if (node->server.second != NULL) {
        tumble_sdo_server_answer(&node->server.second->server, refusal);
    }
}

/* Emergencies live where SDO does. */
static void step_sdo(tumble_node_t *node)
{
    tumble_second_server_t *second = node->server.second;
    if (has_sdo(node)) {
        tumble_emcy_step(&node->emcy, &node->link);
        tumble_sdo_server_step(&node->server, &node->link, node->now_us);
        if (second != NULL) {
            tumble_sdo_server_step(&second->server, &node->link, node->now_us);
        }
        tumble_sdo_client_step(&node->client, &node->link, node->now_us);
    } else {
        tumble_sdo_server_drop(&node->server);
        if (second != NULL) {
            tumble_sdo_server_drop(&second->server);
        }
        tumble_sdo_client_drop(&node->client);
    }
}

void tumble_node_step(tumble_node_t *node, uint64_t now_us)
{
    tumble_nmt_state_t before;
    node->now_us = now_us;
    watch(node);
    before = tumble_node_state(node);
    if (tumble_nmt_step(&node->nmt, &node->link, now_us)) {
        follow_state(node, before);
    }
    step_sdo(node);
    if (is_operational(node)) {
        tumble_pdo_step(&node->pdos, &node->dictionary, &node->link, now_us);
    }
}

TUMBLE_ONE_COPY uint64_t tumble_node_next_us(const tumble_node_t *node)
{
    uint64_t next_us = tumble_nmt_next_us(&node->nmt);
    if (has_sdo(node)) {
        next_us = tumble_earlier(next_us, tumble_sdo_server_next_us(&node->server));
        if (node->server.second != NULL) {
            next_us = tumble_earlier(next_us, tumble_sdo_server_next_us(&node->server.second->server));
        }
        next_us = tumble_earlier(next_us, tumble_sdo_client_next_us(&node->client));
        next_us = (node->emcy.queued > 0U) ? 0U : next_us;
    }
    if (is_operational(node)) {
        next_us = tumble_earlier(next_us, tumble_pdo_next_us(&node->pdos));
    }
    return next_us;
}

tumble_abort_t tumble_node_read(tumble_node_t *node, uint16_t index, uint8_t subindex,
                                uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES], uint8_t *size)
{
    tumble_entry_t entry;
    const tumble_abort_t refusal = tumble_dictionary_find(&node->dictionary, index, subindex, &entry);
    return (refusal != TUMBLE_ABORT_NONE) ? refusal : tumble_dictionary_read(&node->dictionary, &entry, bytes, size);
}

tumble_abort_t tumble_node_write(tumble_node_t *node, uint16_t index, uint8_t subindex, const uint8_t *bytes,
                                 uint8_t size)
{
    tumble_entry_t entry;
    const tumble_abort_t refusal = tumble_dictionary_find(&node->dictionary, index, subindex, &entry);
    return (refusal != TUMBLE_ABORT_NONE) ? refusal : tumble_dictionary_write(&node->dictionary, &entry, bytes, size);
}
