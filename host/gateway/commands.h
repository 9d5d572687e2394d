/* commands.h - what the gateway writes to the node: a command with what belongs to it, or a setting. Pure functions
 * and a queue; it is sent by the poller. */
#ifndef TUMBLE_GATEWAY_COMMANDS_H
#define TUMBLE_GATEWAY_COMMANDS_H

#include "registers.h"

#include <stdbool.h>
#include <stdint.h>

#define GATEWAY_MAX_CLIENTS 32U
#define GATEWAY_MAX_SESSIONS (GATEWAY_MAX_CLIENTS + 1U) /* and that of the serial line */
#define GATEWAY_MAX_WRITES 4U
#define GATEWAY_NUMBER_BYTES 8U

typedef enum {
    GATEWAY_RESULT_NONE = 0,
    GATEWAY_RESULT_PENDING,
    GATEWAY_RESULT_ACCEPTED,
    GATEWAY_RESULT_REFUSED,
    GATEWAY_RESULT_UNANSWERED,
    GATEWAY_RESULT_UNFIT,
    GATEWAY_RESULT_NO_SERVICE
} gateway_result_t;

/* One object that is to be written: `size` little-endian bytes. */
typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint8_t bytes[GATEWAY_NUMBER_BYTES];
} gateway_write_t;

/* What is sent for one Execute, in this order, until one is refused. */
typedef struct {
    gateway_write_t writes[GATEWAY_MAX_WRITES];
    uint8_t count;
    uint8_t group;  /* of values that a setting changes */
    uint8_t result; /* gateway_result_t */
    uint32_t abort; /* the node's code when it refused, else 0 */
    uint32_t ended; /* how many commands had their result when it had its own, itself included; 0: none was sent */
} gateway_command_t;

/* A number as an object of a type (TUMBLE_TYPE_...) has it, into GATEWAY_NUMBER_BYTES. Returns how many bytes; 0: it
 * cannot hold the number, or is no number. Integers are exact, from the least to the greatest of the type; a REAL32 is
 * rounded to nearest, and what it has only as a denormal number does not fit. */
uint8_t gateway_number_bytes(uint8_t type, double number, uint8_t *bytes);

/* A command of the object at `index`: its argument, the angle and the proposal if there are any (else null), the
 * command. */
gateway_command_t gateway_command(uint16_t index, uint8_t argument, const double *angle_deg, const uint32_t *proposal,
                                  uint8_t command);

/* The object that has the number of a setting; number 0: there is none. */
gateway_target_t gateway_target(uint16_t number);

/* A setting, and before it the key to the service level; 0: none. With result GATEWAY_RESULT_UNFIT the object cannot hold
 * the value, and nothing is to be sent. */
gateway_command_t gateway_setting(gateway_target_t target, uint32_t key, double value);

/* What waits to be sent; the first one is being sent. */
typedef struct {
    struct {
        gateway_command_t command;
        gateway_command_t *owner; /* who is told the result; null: has gone */
    } items[GATEWAY_MAX_SESSIONS];
    uint16_t count;
    uint32_t ended;           /* how many have been told their result */
    bool ends_service;        /* the service level is to be ended, for its owner has gone, as soon as there is room, */
    gateway_command_t ending; /* by this */
} gateway_queue_t;

/* Behind the others. Its result is PENDING from now on; the owner's memory must stay until that has changed, or it is
 * forgotten. False: too many wait, and nothing has changed. */
bool gateway_queue_add(gateway_queue_t *queue, gateway_command_t *command);

/* If the service level is to be ended, and there is room: that waits now behind the others. */
void gateway_queue_end_service(gateway_queue_t *queue);

/* The first one has ended: tell its owner, and forget it. */
void gateway_queue_end(gateway_queue_t *queue, gateway_result_t result, uint32_t abort);

/* An owner goes away; what was accepted is sent all the same. */
void gateway_queue_forget(gateway_queue_t *queue, const gateway_command_t *command);

#endif
