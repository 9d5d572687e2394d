#define _POSIX_C_SOURCE 200809L

#include "reply.h"

#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* What libmodbus asks for, without meaning here: nothing is ever connected to it. */
#define NOWHERE "127.0.0.1"
#define NO_PORT 502
#define NO_DEVICE "/dev/null"
#define SOME_BAUD 19200

bool gateway_replies_open(gateway_replies_t *replies)
{
    *replies = (gateway_replies_t){.ends = {-1, -1}};
    replies->tcp = modbus_new_tcp(NOWHERE, NO_PORT);
    replies->serial = modbus_new_rtu(NO_DEVICE, SOME_BAUD, 'N', 8, 1);
    if (replies->tcp == NULL || replies->serial == NULL ||
        socketpair(AF_UNIX, SOCK_DGRAM, 0, replies->ends) != 0) {
        gateway_replies_close(replies);
        return false;
    }
    (void)modbus_set_socket(replies->tcp, replies->ends[0]);
    (void)modbus_set_socket(replies->serial, replies->ends[0]);
    return true;
}

static modbus_t *maker(const gateway_replies_t *replies, bool is_serial)
{
    return is_serial ? replies->serial : replies->tcp;
}

static size_t take(const gateway_replies_t *replies, int sent, uint8_t *answer)
{
    const ssize_t size = (sent > 0) ? recv(replies->ends[1], answer, GATEWAY_MAX_ADU, MSG_DONTWAIT) : 0;
    return (size > 0) ? (size_t)size : 0U;
}

size_t gateway_reply(const gateway_replies_t *replies, bool is_serial, const uint8_t *frame, size_t size,
                     const uint16_t *input, const uint16_t *holding, uint8_t *answer)
{
    uint16_t inputs[GATEWAY_INPUT_END];
    uint16_t holdings[GATEWAY_HOLDING_END]; /* libmodbus stores what is written: into these, which nobody keeps */
    modbus_mapping_t mapping = {.nb_input_registers = (int)GATEWAY_INPUT_END, .tab_input_registers = inputs,
                                .nb_registers = (int)GATEWAY_HOLDING_END, .tab_registers = holdings};
    memcpy(inputs, input, sizeof inputs);
    memcpy(holdings, holding, sizeof holdings);
    return take(replies, modbus_reply(maker(replies, is_serial), frame, (int)size, &mapping), answer);
}

size_t gateway_reply_exception(const gateway_replies_t *replies, bool is_serial, const uint8_t *frame,
                               gateway_exception_t exception, uint8_t *answer)
{
    return take(replies, modbus_reply_exception(maker(replies, is_serial), frame, (unsigned)exception), answer);
}

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
