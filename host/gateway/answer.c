#include "answer.h"

/* Of a request that writes: what it writes. */
static void written_words(const gateway_request_t *request, uint16_t *words)
{
    const uint8_t *const from = &request->data[(request->function == GATEWAY_WRITE_ONE) ? 2 : 5];
    for (uint16_t i = 0; i < request->count; i++) {
        words[i] = gateway_word(&from[2U * i]);
    }
}

static bool writes(const gateway_request_t *request)
{
    return request->function == GATEWAY_WRITE_ONE || request->function == GATEWAY_WRITE_SEVERAL;
}

static gateway_exception_t write(gateway_t *gateway, gateway_session_t *session, const gateway_request_t *request,
                                 uint64_t now_us)
{
    uint16_t words[GATEWAY_HOLDING_END];
    written_words(request, words);
    const gateway_exception_t wrong =
        gateway_session_write(session, gateway, request->at, request->count, words, now_us);
    if (wrong == GATEWAY_ILLEGAL_ADDRESS) {
        gateway_count(&gateway->counters, GATEWAY_COUNT_WRONG_ADDRESS);
    } else if (wrong == GATEWAY_ILLEGAL_VALUE) {
        gateway_count(&gateway->counters, GATEWAY_COUNT_WRONG_VALUE);
    }
    return wrong;
}

static gateway_exception_t carry_out(gateway_t *gateway, gateway_session_t *session, gateway_request_t *request,
                                     uint64_t now_us)
{
    int counter = 0;
    const gateway_exception_t wrong = gateway_request_check(request, &counter);
    if (wrong != GATEWAY_OK) {
        gateway_count(&gateway->counters, counter);
        return wrong;
    }
    return writes(request) ? write(gateway, session, request, now_us) : GATEWAY_OK;
}

static size_t refuse(gateway_t *gateway, const gateway_replies_t *replies, bool is_serial, const uint8_t *frame,
                     gateway_exception_t exception, uint8_t *answer)
{
    gateway_count(&gateway->counters, GATEWAY_COUNT_EXCEPTIONS);
    return gateway_reply_exception(replies, is_serial, frame, exception, answer);
}

size_t gateway_answer(gateway_t *gateway, const gateway_replies_t *replies, gateway_session_t *session, bool is_serial,
                      const uint8_t *frame, size_t size, uint64_t now_us, uint8_t *answer)
{
    gateway_request_t request = is_serial ? gateway_serial_request(frame, size) : gateway_tcp_request(frame, size);
    const bool is_ours = request.unit == gateway->settings.unit || (!is_serial && request.unit == GATEWAY_ANY_UNIT);
    gateway_count(&gateway->counters, is_ours ? GATEWAY_COUNT_REQUESTS : GATEWAY_COUNT_WRONG_UNIT);
    if (!is_ours && is_serial) {
        return 0;
    }
    if ((request.function & GATEWAY_EXCEPTION_BIT) != 0U) { /* what only an answer may have */
        gateway_count(&gateway->counters, GATEWAY_COUNT_WRONG_FUNCTION);
        return 0;
    }
    const gateway_exception_t wrong =
        is_ours ? carry_out(gateway, session, &request, now_us) : GATEWAY_NO_PATH;
    if (wrong != GATEWAY_OK) {
        return refuse(gateway, replies, is_serial, frame, wrong, answer);
    }
    uint16_t holding[GATEWAY_HOLDING_END];
    gateway_session_holding(session, holding, now_us);
    gateway_count(&gateway->counters, GATEWAY_COUNT_ANSWERS);
    const uint16_t *const input = (request.function == GATEWAY_READ_INPUT)
                                      ? gateway_session_input(session, gateway, request.at, request.count, now_us)
                                      : session->snapshot.words; /* not looked at */
    return gateway_reply(replies, is_serial, frame, size, input, holding, answer);
}
