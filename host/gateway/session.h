/* session.h - one Modbus client as the gateway sees it: a TCP connection, or the serial line. Its own frozen snapshot,
 * its own lock, its own staged command. Never waits. Times are of one monotonic clock, in microseconds. */
#ifndef TUMBLE_GATEWAY_SESSION_H
#define TUMBLE_GATEWAY_SESSION_H

#include "poller.h"

#include <stdbool.h>
#include <stdint.h>

/* What all parts of the gateway share: how it was told to behave, what it counts, its node. */

typedef struct {
    uint8_t unit; /* Modbus, 1 to 247 */
    uint8_t node; /* CANopen, 1 to 127 */
    bool allow_commands;
    uint64_t unlock_us; /* an unlocked session locks itself so long after its last write */
    uint64_t idle_us;   /* a TCP client is closed so long after its last request */
    uint64_t poll_us;
} gateway_settings_t;

typedef struct {
    gateway_settings_t settings;
    uint32_t counters[GATEWAY_COUNTERS]; /* each stops at its largest value */
    gateway_poller_t poller;
    uint16_t clients;                      /* TCP connections now open */
    const struct gateway_session *service; /* who opened the service level last; null: nobody, or it is over */
    uint64_t service_until_us;
} gateway_t;

/* Who never reads the snapshot number sees no state of long ago all the same: a session whose snapshot is older takes
 * the newest one with a request that does not go on upwards from the one before, and much later with any. */
#define GATEWAY_HOLD_US 2000000U
#define GATEWAY_PASS_US 30000000U

/* The service level of the node, as its object 2006h has it. */
#define GATEWAY_SERVICE_NUMBER 0x76726573U
#define GATEWAY_SERVICE_US 60000000U

#define GATEWAY_KEY_1 0x4F50U
#define GATEWAY_KEY_2 0x454EU

/* Modbus exceptions; 0 is none. */
typedef enum {
    GATEWAY_OK = 0,
    GATEWAY_ILLEGAL_FUNCTION = 0x01,
    GATEWAY_ILLEGAL_ADDRESS = 0x02,
    GATEWAY_ILLEGAL_VALUE = 0x03,
    GATEWAY_BUSY = 0x06,
    GATEWAY_NO_PATH = 0x0A,
    GATEWAY_TARGET_FAILED = 0x0B
} gateway_exception_t;

/* The last request to write that was answered with an exception. */
typedef struct {
    uint32_t number; /* of them so far */
    uint16_t at;
    uint16_t count;
    uint8_t exception; /* gateway_exception_t */
    bool has_wrong_keys;
    uint16_t command; /* that it was to execute; 0: none, or a setting */
} gateway_refusal_t;

/* A new one is all zero. */
typedef struct gateway_session {
    gateway_snapshot_t snapshot;
    uint64_t renewed_us;
    uint16_t last_at;                     /* of input registers, the first one of the last request */
    uint64_t unlocked_until_us;           /* 0: locked */
    uint16_t staged[GATEWAY_HOLDING_END]; /* the holding registers as they were written; Execute: as it was last */
    bool has_angle;                       /* written since the last execution; likewise `has_proposal` */
    bool has_proposal;
    bool is_setting_done; /* a setting was executed, and nothing has been staged since */
    gateway_command_t sent;
    bool sent_key; /* it is the service level's */
    gateway_refusal_t refusal;
} gateway_session_t;

/* The input registers as a request for `count` of them from `at` on gets them: GATEWAY_INPUT_END words, until the next
 * call. May renew the snapshot. */
const uint16_t *gateway_session_input(gateway_session_t *session, const gateway_t *gateway, uint16_t at, uint16_t count,
                                      uint64_t now_us);

/* The holding registers, into GATEWAY_HOLDING_END words. */
void gateway_session_holding(const gateway_session_t *session, uint16_t *words, uint64_t now_us);

/* Write `count` registers from `at` on, all or none; both within GATEWAY_HOLDING_END. */
gateway_exception_t gateway_session_write(gateway_session_t *session, gateway_t *gateway, uint16_t at, uint16_t count,
                                          const uint16_t *words, uint64_t now_us);

/* Its client has gone. A service level that it opened is ended. */
void gateway_session_close(gateway_session_t *session, gateway_t *gateway);

#endif
