/* answer.h - from a whole frame to its answer. */
#ifndef TUMBLE_GATEWAY_ANSWER_H
#define TUMBLE_GATEWAY_ANSWER_H

#include "reply.h"

/* On TCP the unit may be this as well: "the device at this address". */
#define GATEWAY_ANY_UNIT 0xFFU

/* Answer a whole frame (on the serial line with a right CRC) of a session into `answer` (GATEWAY_MAX_ADU). Returns its
 * bytes; 0: silence. */
size_t gateway_answer(gateway_t *gateway, const gateway_replies_t *replies, gateway_session_t *session, bool is_serial,
                      const uint8_t *frame, size_t size, uint64_t now_us, uint8_t *answer);

#endif
