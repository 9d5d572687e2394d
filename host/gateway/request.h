/* request.h - Modbus requests as bytes: where one ends, whether it is one that is served, and its answer. (libmodbus could
 * make the answer, but waits, and throws away input, where a count is out of range.) */
#ifndef TUMBLE_GATEWAY_REQUEST_H
#define TUMBLE_GATEWAY_REQUEST_H

#include "session.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GATEWAY_MBAP 7U      /* bytes of the header, the unit included */
#define GATEWAY_MAX_ADU 260U /* TCP: header and 253 bytes; serial frames are shorter */
#define GATEWAY_MAX_SERIAL 256U

#define GATEWAY_READ_HOLDING 0x03U
#define GATEWAY_READ_INPUT 0x04U
#define GATEWAY_WRITE_ONE 0x06U
#define GATEWAY_WRITE_SEVERAL 0x10U
#define GATEWAY_EXCEPTION_BIT 0x80U

/* On TCP the unit may be this as well: "the device at this address". */
#define GATEWAY_ANY_UNIT 0xFFU

/* A request without its framing. */
typedef struct {
    uint8_t unit;
    uint8_t function;
    const uint8_t *data; /* behind the function */
    size_t size;
    uint16_t at; /* set by gateway_request_check; likewise `count` */
    uint16_t count;
} gateway_request_t;

/* What stands at the beginning of bytes received on TCP. */
typedef enum {
    GATEWAY_FRAME_PART,     /* not whole yet */
    GATEWAY_FRAME_WHOLE,    /* `size` bytes of it */
    GATEWAY_FRAME_PROTOCOL, /* whole, to be dropped: another protocol */
    GATEWAY_FRAME_SHORT,    /* whole, to be dropped: there is no function in it */
    GATEWAY_FRAME_LOST      /* longer than any frame can be: where the next one begins cannot be known */
} gateway_frame_t;

gateway_frame_t gateway_tcp_frame(const uint8_t *bytes, size_t count, size_t *size);

/* Bytes of a frame that stands whole, with a right CRC, at the beginning of what a serial line brought: a request, or
 * what another unit than `own` may answer. 0: none, or not whole yet. */
size_t gateway_serial_frame(const uint8_t *bytes, size_t count, uint8_t own);

/* Has it a right CRC as it stands? At least 4 bytes. */
bool gateway_serial_is_whole(const uint8_t *bytes, size_t count);

/* Is it served: function, length, count and registers, in this order? Sets `at` and `count` of the request. On an
 * exception `counter` is the counter that it belongs to. */
gateway_exception_t gateway_request_check(gateway_request_t *request, int *counter);

/* Answer a whole frame (on the serial line with a right CRC) of a session into `answer` (GATEWAY_MAX_ADU). Returns its
 * bytes; 0: silence. */
size_t gateway_answer(gateway_t *gateway, gateway_session_t *session, bool is_serial, const uint8_t *frame, size_t size,
                      uint64_t now_us, uint8_t *answer);

#endif
