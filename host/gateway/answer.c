#define _POSIX_C_SOURCE 200809L

#include "answer.h"

#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* What libmodbus asks for, without meaning here: nothing is ever connected to it. */
#define NOWHERE "127.0.0.1"
#define NO_PORT 502
#define NO_DEVICE "/dev/null"
#define SOME_BAUD 19200

void gateway_replies_close(gateway_replies_t *replies)
{
    for (int i = 0; i < 2; i++) {
        if (replies->ends[i] >= 0) {
            (void)close(replies->ends[i]);
        }
    }
    modbus_free(replies->tcp);
    modbus_free(replies->serial);
    *replies = (gateway_replies_t){.ends = {-1, -1}};
}

bool gateway_replies_open(gateway_replies_t *replies)
{
    *replies = (gateway_replies_t){.ends = {-1, -1}};
    replies->tcp = modbus_new_tcp(NOWHERE, NO_PORT);
    replies->serial = modbus_new_rtu(NO_DEVICE, SOME_BAUD, 'N', 8, 1);
    if (replies->tcp == NULL || replies->serial == NULL || socketpair(AF_UNIX, SOCK_DGRAM, 0, replies->ends) != 0) {
        gateway_replies_close(replies);
        return false;
    }
    (void)modbus_set_socket(replies->tcp, replies->ends[0]);
    (void)modbus_set_socket(replies->serial, replies->ends[0]);
    return true;
}

static size_t take(const gateway_replies_t *replies, int sent, uint8_t *answer)
{
    const ssize_t size = (sent > 0) ? recv(replies->ends[1], answer, GATEWAY_MAX_ADU, MSG_DONTWAIT) : 0;
    return (size > 0) ? (size_t)size : 0U;
}

static size_t reply(const gateway_replies_t *replies, modbus_t *maker, const uint8_t *frame, size_t size,
                    const uint16_t *input, const uint16_t *holding, uint8_t *answer)
{
    uint16_t inputs[GATEWAY_INPUT_END];
    uint16_t holdings[GATEWAY_HOLDING_END]; /* libmodbus stores what is written: into these, which nobody keeps */
    modbus_mapping_t mapping = {.nb_input_registers = (int)GATEWAY_INPUT_END,
                                .tab_input_registers = inputs,
                                .nb_registers = (int)GATEWAY_HOLDING_END,
                                .tab_registers = holdings};
    memcpy(inputs, input, sizeof inputs);
    memcpy(holdings, holding, sizeof holdings);
    return take(replies, modbus_reply(maker, frame, (int)size, &mapping), answer);
}

/* Of a request that writes: what it writes. */
static void written_words(const gateway_request_t *request, uint16_t *words)
{
    const uint8_t *const from = &request->data[(request->function == GATEWAY_WRITE_ONE) ? 2 : 5];
    for (uint16_t i = 0; i < request->count; i++) {
        words[i] = gateway_word(&from[2U * i]);
    }
}

static gateway_exception_t obey(gateway_t *gateway, gateway_session_t *session, const gateway_request_t *request,
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
    const bool writes = request->function == GATEWAY_WRITE_ONE || request->function == GATEWAY_WRITE_SEVERAL;
    return writes ? obey(gateway, session, request, now_us) : GATEWAY_OK;
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
    const gateway_exception_t wrong = is_ours ? carry_out(gateway, session, &request, now_us) : GATEWAY_NO_PATH;
    modbus_t *const maker = is_serial ? replies->serial : replies->tcp;
    if (wrong != GATEWAY_OK) {
        gateway_count(&gateway->counters, GATEWAY_COUNT_EXCEPTIONS);
        return take(replies, modbus_reply_exception(maker, frame, (unsigned)wrong), answer);
    }
    uint16_t holding[GATEWAY_HOLDING_END];
    gateway_session_holding(session, holding, now_us);
    gateway_count(&gateway->counters, GATEWAY_COUNT_ANSWERS);
    const uint16_t *const input = (request.function == GATEWAY_READ_INPUT)
                                      ? gateway_session_input(session, gateway, request.at, request.count, now_us)
                                      : session->snapshot.words; /* not looked at */
    return reply(replies, maker, frame, size, input, holding, answer);
}
