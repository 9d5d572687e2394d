/* modbus_link.h - exchanges of registers (stand/positioner/positioner.h) over Modbus TCP, in a thread of their own.
 *
 * libmodbus waits: for a connection, and for every answer. So a thread does that, one exchange at a time, and begin and
 * end never wait for it. After anything but an answer or a refusal the connection is closed and made anew for the next
 * exchange, so that no late answer is taken for that of another question.
 *
 * An exchange takes `timeout_ms` for a connection that must be made, and for each of its two questions, at most: then it
 * has failed. The thread does nothing by itself: a program that hangs feeds no watchdog.
 */
#ifndef TUMBLE_NODE_MODBUS_LINK_H
#define TUMBLE_NODE_MODBUS_LINK_H

#include "stand/positioner/positioner.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct {
    tumble_exchange_link_t link; /* for the profile */
    void *modbus;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    tumble_exchange_t exchange;
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    tumble_status_t answer;
    bool under_way;
    bool closing;
    bool connected;
} modbus_link_t;

/* Get ready to talk to a controller; it need not be there yet. `host` and `port` as getaddrinfo takes them. False: errno
 * says why. */
bool modbus_link_open(modbus_link_t *self, const char *host, const char *port, uint8_t unit, uint16_t timeout_ms);

/* Waits for the exchange under way. */
void modbus_link_close(modbus_link_t *self);

#endif
