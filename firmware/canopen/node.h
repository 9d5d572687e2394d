/* node.h - one CANopen node: object dictionary, NMT, SDO both ends, PDOs and EMCY put together.
 *
 *     tumble_node_init(&node, &config, &binding);
 *     for (;;) {
 *         now = port->now_us(port->context);
 *         while (tumble_link_receive(&node.link, &frame) == TUMBLE_OK) { tumble_node_receive(&node, &frame, now); }
 *         tumble_node_step(&node, now);
 *     }
 *
 * `receive` takes a frame in and sends nothing; `step` sends what is due. A frame that is no business of the node is
 * handed back, so that other parts can look at it. The caller owns everything; nothing waits. Not re-entrant, and the
 * callbacks are called from within receive and step: they may trigger PDOs, start SDO transfers, queue commands and
 * raise emergencies, but not call receive or step.
 */
#ifndef TUMBLE_CANOPEN_NODE_H
#define TUMBLE_CANOPEN_NODE_H

#include "canopen/dictionary.h"
#include "canopen/emcy.h"
#include "canopen/link.h"
#include "canopen/nmt.h"
#include "canopen/pdo.h"
#include "canopen/sdo.h"

#include <stdbool.h>
#include <stdint.h>

/* What a node tells the application. Every member may be null. `context` is the binding's. */
typedef struct {
    /* This node entered another NMT state. */
    void (*state_changed)(void *context, tumble_nmt_state_t state);

    /* NMT reset: set the application's variables back to power-on values if `application`, else nothing but the
     * communication starts again. The node itself starts over after this call. */
    void (*reset)(void *context, bool application);

    /* Something happened to a watched node (1016h). */
    void (*heartbeat)(void *context, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t state);

    /* Another node's emergency message; code 0 means that its errors are gone. */
    void (*emergency)(void *context, uint8_t node, const tumble_emergency_t *emergency);

    /* Receive PDO `number` (0 is 1400h) was written into the dictionary. */
    void (*pdo_received)(void *context, uint8_t number);
} tumble_node_events_t;

/* What a node does when a watched heartbeat is lost while it is Operational (1029h:1). */
#define TUMBLE_ON_ERROR_PRE_OPERATIONAL 0U
#define TUMBLE_ON_ERROR_STAY 1U
#define TUMBLE_ON_ERROR_STOP 2U

/* Power-on values of the communication objects; written by the generator. */
typedef struct {
    const tumble_pdo_setup_t *receive;
    const tumble_pdo_setup_t *transmit;
    uint8_t first_receive;  /* number of the first (0 is 1400h); those before it are not in use */
    uint8_t first_transmit; /* likewise (1800h) */
    uint8_t receive_count;  /* from there up to TUMBLE_MAX_RECEIVE_PDOS */
    uint8_t transmit_count; /* and TUMBLE_MAX_TRANSMIT_PDOS */
    uint16_t heartbeat_ms;
    uint32_t consumers[TUMBLE_MAX_CONSUMERS]; /* as in 1016h: node << 16 | ms; 0: none */
    uint8_t on_error;                         /* TUMBLE_ON_ERROR_... */
} tumble_node_defaults_t;

/* What some computers have besides: objects, and transmit PDOs, in place of those that the defaults leave unused, or
 * behind them. */
typedef struct {
    tumble_object_extension_t objects;
    const tumble_pdo_setup_t *transmit;
    uint8_t first_transmit; /* number of the first (0 is 1800h) */
    uint8_t transmit_count; /* from there up to TUMBLE_MAX_TRANSMIT_PDOS */
} tumble_node_extension_t;

/* The constant part of a node. */
typedef struct {
    const tumble_object_table_t *table;
    const tumble_node_extension_t *extension; /* null: none */
    const tumble_node_defaults_t *defaults;
    const tumble_object_hooks_t *hooks; /* may be null */
    const tumble_node_events_t *events; /* may be null */
    uint8_t node;                       /* 1 to 127 */
} tumble_node_config_t;

/* A second SDO server (1201h), for a client of its own. Its memory is the owner's, who sets `variables` alone. */
typedef struct tumble_second_server {
    tumble_sdo_server_t server;
    void *variables; /* TUMBLE_HOME_VARIABLES as its client sees and writes them */
} tumble_second_server_t;

/* What a node is bound to; copied by init. */
typedef struct {
    const tumble_port_t *port;
    tumble_second_server_t *second; /* null: it has one SDO server */
    void *variables;                /* TUMBLE_HOME_VARIABLES; may be null if the table has none */
    void *other;                    /* TUMBLE_HOME_OTHER; likewise */
    void *context;                  /* of hooks, the extension's too, and events */
} tumble_node_binding_t;

typedef struct {
    uint8_t on_error; /* 1029h:1 */
    const tumble_node_config_t *config;
    uint64_t now_us; /* of the call under way, for the dictionary's own objects */
    tumble_nmt_t nmt;
    tumble_link_t link;
    tumble_dictionary_t dictionary;
    tumble_emcy_t emcy;
    tumble_sdo_server_t server; /* what the owner sets of it holds for the second as well */
    tumble_sdo_client_t client;
    tumble_pdos_t pdos;
} tumble_node_t;

static_assert(sizeof(tumble_node_t) <= ((sizeof(void *) == 4) ? 696 : 760), "a node must leave room for the rest");

/* Power on: variables are the caller's to set before. Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT: a null pointer that may
 * not be null, a node number out of range, tables of more than 255 entries together, or defaults that the node's own
 * rules refuse. */
tumble_status_t tumble_node_init(tumble_node_t *node, const tumble_node_config_t *config,
                                 const tumble_node_binding_t *binding);

/* Take a frame in. True when it was a service of this node (whatever became of it); false: not for this node. */
bool tumble_node_receive(tumble_node_t *node, const tumble_can_frame_t *frame, uint64_t now_us);

/* tumble_sdo_server_answer of whichever server waits for it. */
void tumble_node_answer(tumble_node_t *node, tumble_abort_t refusal);

/* Send what is due, watch all times. */
void tumble_node_step(tumble_node_t *node, uint64_t now_us);

/* The next moment at which step has something to do, for those who jump in time. One that is over means at once (also
 * while the port has no room for a frame: then step again when it has), TUMBLE_NEVER not by itself. */
uint64_t tumble_node_next_us(const tumble_node_t *node);

/* This node's NMT state, and a change of it by itself (Pre-operational, Operational or Stopped; not before boot-up went
 * out: then it takes effect right after). */
tumble_nmt_state_t tumble_node_state(const tumble_node_t *node);
void tumble_node_set_state(tumble_node_t *node, tumble_nmt_state_t state);

/* Read and write an object of this node from the inside, under the same rules as by SDO. */
tumble_abort_t tumble_node_read(tumble_node_t *node, uint16_t index, uint8_t subindex,
                                uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES], uint8_t *size);
tumble_abort_t tumble_node_write(tumble_node_t *node, uint16_t index, uint8_t subindex, const uint8_t *bytes,
                                 uint8_t size);

/* The parts, for their own functions: tumble_pdo_trigger(&node->pdos, 0), tumble_pdo_configure(&node->pdos,
 * &node->dictionary, ...), tumble_sdo_client_write(&node->client, ...), tumble_nmt_command(&node->nmt, ...),
 * tumble_emcy_raise(&node->emcy, ...). */

#endif
