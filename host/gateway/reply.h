/* reply.h - answers made by libmodbus, without its waiting: it writes them into one end of a pair of sockets, and they
 * are taken from the other at once; who gets them, and when, is the caller's.
 *
 * Only requests that gateway_request_check let pass may come here: libmodbus itself sleeps and throws away input on
 * counts that are out of range. */
#ifndef TUMBLE_GATEWAY_REPLY_H
#define TUMBLE_GATEWAY_REPLY_H

#include "request.h"

#include <modbus/modbus.h>

#include <stdbool.h>

typedef struct {
    modbus_t *tcp;    /* of each framing one that is connected to nobody */
    modbus_t *serial;
    int ends[2];
} gateway_replies_t;

/* False: errno says why; nothing stays open. */
bool gateway_replies_open(gateway_replies_t *replies);

/* The answer to a whole frame of `size` bytes, out of input and holding registers, into `answer` (GATEWAY_MAX_ADU).
 * Returns its bytes; 0: libmodbus gave none. */
size_t gateway_reply(const gateway_replies_t *replies, bool is_serial, const uint8_t *frame, size_t size,
                     const uint16_t *input, const uint16_t *holding, uint8_t *answer);

/* An exception for a function below 128. */
size_t gateway_reply_exception(const gateway_replies_t *replies, bool is_serial, const uint8_t *frame,
                               gateway_exception_t exception, uint8_t *answer);

void gateway_replies_close(gateway_replies_t *replies);

#endif
