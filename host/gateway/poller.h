/* poller.h - the side of the gateway that speaks CAN: reads the node's objects again and again by SDO, and writes
 * commands. One transfer at a time; never waits. A seam for tests: all it knows of the bus is a port (port/port.h).
 *
 * A snapshot is published whole or not at all. Objects named as marks are read before and after all others: when one
 * has changed meanwhile, the results may be a mixture, and all is read again; likewise when a transfer fails because
 * somebody else uses the node's SDO channel. As long as no mark changes, what the table says is kept is taken from the
 * snapshot before; not after silence, nor after the node has booted.
 */
#ifndef TUMBLE_GATEWAY_POLLER_H
#define TUMBLE_GATEWAY_POLLER_H

#include "canopen/sdo.h"
#include "counters.h"
#include "registers.h"

#include <stdbool.h>
#include <stdint.h>

#define GATEWAY_MAX_CLIENTS 32U
#define GATEWAY_MAX_SESSIONS (GATEWAY_MAX_CLIENTS + 1U) /* and that of the serial line */
#define GATEWAY_MAX_TORN 3U /* polls torn one after the other; then the rest of the period is waited for */
#define GATEWAY_KEPT_POLLS 60U /* after so many all is read anew, whatever the marks say */
#define GATEWAY_MARK_BYTES 8U

typedef enum { GATEWAY_LINK_UNKNOWN = 0, GATEWAY_LINK_UP, GATEWAY_LINK_SILENT, GATEWAY_LINK_DOWN } gateway_link_t;

typedef struct {
    uint32_t number; /* 0: none yet */
    uint64_t taken_us;
    uint16_t words[GATEWAY_INPUT_END]; /* 0 below GATEWAY_OWN_END */
} gateway_snapshot_t;

typedef enum {
    GATEWAY_RESULT_NONE = 0,
    GATEWAY_RESULT_PENDING,
    GATEWAY_RESULT_ACCEPTED,
    GATEWAY_RESULT_REFUSED,
    GATEWAY_RESULT_UNANSWERED
} gateway_result_t;

/* A command. */
typedef struct {
    uint16_t index;
    uint8_t argument;
    uint8_t command;
    bool has_angle;
    double angle_deg;
    uint8_t result; /* gateway_result_t */
    uint32_t abort; /* the node's code when it refused, else 0 */
} gateway_command_t;

typedef struct {
    gateway_command_t command;
    gateway_command_t *owner; /* who is told the result; null: has gone */
} gateway_queued_t;

/* A mark as it was read. */
typedef struct {
    uint32_t refusal;
    uint8_t size;
    uint8_t bytes[GATEWAY_MARK_BYTES];
} gateway_mark_t;

typedef struct {
    tumble_link_t link;
    tumble_sdo_client_t client;
    gateway_counters_t *counters;
    uint64_t period_us;
    uint64_t next_us; /* of the next poll */
    uint8_t node;
    uint8_t phase;    /* private; likewise `doing`, what the transfer under way is for */
    uint8_t doing;
    uint8_t link_state; /* gateway_link_t */
    uint8_t torn;       /* in a row */
    uint16_t place;     /* in the table that the phase walks */
    bool is_fresh;      /* this poll reads what is kept as well */
    bool is_partial;    /* the node could not give a value that it has: its memory was at work */
    bool must_be_fresh; /* the next one does: the node may be another since */
    bool has_booted;    /* since this poll began */
    uint16_t kept;      /* polls since one did */
    gateway_mark_t marks[GATEWAY_MARKS];
    gateway_mark_t published_marks[GATEWAY_MARKS];
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    gateway_snapshot_t building;
    gateway_snapshot_t published;
    gateway_queued_t queue[GATEWAY_MAX_SESSIONS]; /* the first one is being sent */
    uint16_t queued;
} gateway_poller_t;

/* `period_us` from the beginning of a poll to that of the next. All pointers must outlive the poller. */
void gateway_poller_init(gateway_poller_t *poller, const tumble_port_t *port, uint8_t node, uint64_t period_us,
                         gateway_counters_t *counters);

/* Take what has come, send what is due. */
void gateway_poller_step(gateway_poller_t *poller);

/* When step is due again if nothing comes before; one that is over: at once. Of the port's clock. */
uint64_t gateway_poller_next_us(const gateway_poller_t *poller);

/* Send a command, behind those that wait. Its result is PENDING from now on; the owner's memory must stay until that
 * has changed, or it is forgotten. False: too many wait. */
bool gateway_poller_command(gateway_poller_t *poller, gateway_command_t *command);

/* Its owner goes away: what was accepted is sent all the same. */
void gateway_poller_forget(gateway_poller_t *poller, const gateway_command_t *command);

#endif
