/* gateway.h - what all parts of the gateway share: how it was told to behave, what it counts, its node. */
#ifndef TUMBLE_GATEWAY_GATEWAY_H
#define TUMBLE_GATEWAY_GATEWAY_H

#include "counters.h"
#include "poller.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint8_t unit; /* Modbus, 1 to 247 */
    uint8_t node; /* CANopen, 1 to 127 */
    bool allow_commands;
    uint64_t unlock_us; /* an unlocked session locks itself so long after its last write */
    uint64_t idle_us;   /* a TCP client is closed so long after its last request */
    uint64_t poll_us;
} gateway_settings_t;

struct gateway_session;

typedef struct {
    gateway_settings_t settings;
    gateway_counters_t counters;
    gateway_poller_t poller;
    uint16_t clients;                      /* TCP connections now open */
    const struct gateway_session *service; /* who opened the service level last; null: nobody, or it is over */
    uint64_t service_until_us;
} gateway_t;

#endif
