/* nmt.h - network management (CiA 301, 7.2.8): state machine, boot-up, heartbeat both ways, master commands.
 *
 * Events are returned as bits and values, not called back: node.h turns them into callbacks.
 */
#ifndef TUMBLE_CANOPEN_NMT_H
#define TUMBLE_CANOPEN_NMT_H

#include "canopen/abort.h"
#include "canopen/link.h"
#include "tumble/status.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_NMT_ID 0x000U
#define TUMBLE_HEARTBEAT_ID 0x700U /* + node */
#define TUMBLE_MAX_CONSUMERS 4     /* other nodes watched, subindices of 1016h */
#define TUMBLE_NMT_QUEUE 4         /* master commands that may wait for the port */

/* States, with the numbers that a heartbeat carries. */
typedef enum {
    TUMBLE_NMT_INITIALISING = 0, /* in a heartbeat: boot-up */
    TUMBLE_NMT_STOPPED = 4,
    TUMBLE_NMT_OPERATIONAL = 5,
    TUMBLE_NMT_PRE_OPERATIONAL = 127,
    TUMBLE_NMT_UNKNOWN = 255 /* a watched node that has not been heard, or is silent */
} tumble_nmt_state_t;

typedef enum {
    TUMBLE_NMT_START = 1,
    TUMBLE_NMT_STOP = 2,
    TUMBLE_NMT_ENTER_PRE_OPERATIONAL = 128,
    TUMBLE_NMT_RESET_NODE = 129,
    TUMBLE_NMT_RESET_COMMUNICATION = 130
} tumble_nmt_command_t;

/* What happened to a watched node. */
typedef enum {
    TUMBLE_HEARTBEAT_NOTHING = 0,
    TUMBLE_HEARTBEAT_BEGAN,   /* heard for the first time, or again after a loss */
    TUMBLE_HEARTBEAT_BOOTED,  /* its boot-up message: it was reset or powered */
    TUMBLE_HEARTBEAT_CHANGED, /* its state changed */
    TUMBLE_HEARTBEAT_LOST     /* silent for longer than its consumer time */
} tumble_heartbeat_event_t;

typedef struct {
    uint8_t node;
    uint8_t state;        /* tumble_nmt_state_t as last heard */
    bool lost;            /* was heard and fell silent */
    uint16_t time_ms;     /* 0: not watched */
    uint64_t deadline_us; /* TUMBLE_NEVER: not heard yet, or lost, or not watched */
} tumble_consumer_t;

typedef struct {
    uint8_t node;
    uint8_t state;      /* tumble_nmt_state_t */
    uint8_t next_state; /* entered when the boot-up message is out */
    uint8_t queued;
    uint16_t producer_ms;  /* 1017h */
    uint16_t ignored;      /* NMT commands malformed or unknown, master commands that found the queue full */
    uint64_t heartbeat_us; /* next heartbeat; TUMBLE_NEVER: none */
    tumble_consumer_t consumers[TUMBLE_MAX_CONSUMERS];
    uint8_t queue[TUMBLE_NMT_QUEUE][2];
} tumble_nmt_t;

/* Node (1 to 127) in state Initialising: the first step that can send the boot-up message enters Pre-operational. */
void tumble_nmt_init(tumble_nmt_t *nmt, uint8_t node, uint16_t producer_ms);

/* A command from the master, in a frame of identifier 0: the command if it is for this node and known, else 0. States
 * are changed here but for the resets, which are the node's to do. */
uint8_t tumble_nmt_receive(tumble_nmt_t *nmt, const tumble_can_frame_t *frame);

/* Change this node's own state, as a master does by itself: any of the three but Initialising. Before boot-up went out
 * it takes effect right after it. */
void tumble_nmt_set_state(tumble_nmt_t *nmt, tumble_nmt_state_t state);

/* Queue a command to `node` (0: all others). Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (queue full, counted),
 * TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_nmt_command(tumble_nmt_t *nmt, uint8_t node, tumble_nmt_command_t command);

/* A heartbeat (identifier 0x701 to 0x77F) of a watched node. `node` receives the node. */
tumble_heartbeat_event_t tumble_nmt_heard(tumble_nmt_t *nmt, const tumble_can_frame_t *frame, uint64_t now_us,
                                          uint8_t *node);

/* One watched node whose time is over, or 0: call until it returns 0. */
uint8_t tumble_nmt_lost(tumble_nmt_t *nmt, uint64_t now_us);

/* Send what is due: boot-up, master commands, heartbeat. True when this step left Initialising. */
bool tumble_nmt_step(tumble_nmt_t *nmt, tumble_link_t *link, uint64_t now_us);

/* State of a watched node as last heard; TUMBLE_NMT_UNKNOWN when it is not watched, not heard, or silent. */
tumble_nmt_state_t tumble_nmt_state_of(const tumble_nmt_t *nmt, uint8_t node);

/* Is any watched node silent? */
bool tumble_nmt_any_lost(const tumble_nmt_t *nmt);

/* 1016h and 1017h. Subindex 1 to TUMBLE_MAX_CONSUMERS. Refusals of a consumer: TUMBLE_ABORT_VALUE (node over 127),
 * TUMBLE_ABORT_INCOMPATIBLE (a node watched twice). Writing starts afresh: the node counts as not heard. */
uint32_t tumble_nmt_consumer(const tumble_nmt_t *nmt, uint8_t subindex);
tumble_abort_t tumble_nmt_set_consumer(tumble_nmt_t *nmt, uint8_t subindex, uint32_t value);
void tumble_nmt_set_producer(tumble_nmt_t *nmt, uint16_t producer_ms, uint64_t now_us);

/* Send no heartbeat before this moment (us), so that those who watch this node notice. */
void tumble_nmt_withhold(tumble_nmt_t *nmt, uint64_t until_us);

/* The next moment at which step or lost has something to do; one that is over: at once. */
uint64_t tumble_nmt_next_us(const tumble_nmt_t *nmt);

#endif
