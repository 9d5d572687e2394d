/* answer.h - from a whole frame to its answer, which libmodbus makes without its waiting: it writes into one end of a pair
 * of sockets, and the answer is taken from the other at once; who gets it, and when, is the caller's.
 *
 * Only requests that gateway_request_check lets pass come to libmodbus: it sleeps and throws away input on counts that
 * are out of range. */
#ifndef TUMBLE_GATEWAY_ANSWER_H
#define TUMBLE_GATEWAY_ANSWER_H

#include "request.h"

#include <modbus/modbus.h>

#include <stdbool.h>

/* On TCP the unit may be this as well: "the device at this address". */
#define GATEWAY_ANY_UNIT 0xFFU

typedef struct {
    modbus_t *tcp; /* of each framing one that is connected to nobody */
    modbus_t *serial;
    int ends[2];
} gateway_replies_t;

/* False: errno says why; nothing stays open. */
bool gateway_replies_open(gateway_replies_t *replies);

void gateway_replies_close(gateway_replies_t *replies);

/* Answer a whole frame (on the serial line with a right CRC) of a session into `answer` (GATEWAY_MAX_ADU). Returns its
 * bytes; 0: silence. */
size_t gateway_answer(gateway_t *gateway, const gateway_replies_t *replies, gateway_session_t *session, bool is_serial,
                      const uint8_t *frame, size_t size, uint64_t now_us, uint8_t *answer);

#endif
