#include "request.h"

#include <string.h>

#define LENGTH_AT 4U /* in the MBAP header, of all that is behind it */
#define BEFORE_UNIT 6U
#define LEAST_LENGTH 2U
#define MOST_LENGTH 254U

#define MOST_READ 125U
#define MOST_WRITTEN 123U
#define FIXED 4U /* bytes behind the function: register, and count or value */
#define CRC_BYTES 2U

/* 16-bit numbers as Modbus has them. */
static uint16_t get_word(const uint8_t *bytes)
{
    return (uint16_t)((unsigned)bytes[0] << 8 | bytes[1]);
}

static void put_word(uint8_t *bytes, size_t word)
{
    bytes[0] = (uint8_t)(word >> 8);
    bytes[1] = (uint8_t)(word & 0xFFU);
}

gateway_frame_t gateway_tcp_frame(const uint8_t *bytes, size_t count, size_t *size)
{
    if (count < BEFORE_UNIT) {
        return GATEWAY_FRAME_PART;
    }
    const uint16_t length = get_word(&bytes[LENGTH_AT]);
    *size = BEFORE_UNIT + (size_t)length;
    if (length > MOST_LENGTH) {
        return GATEWAY_FRAME_LOST;
    }
    if (count < *size) {
        return GATEWAY_FRAME_PART;
    }
    if (get_word(&bytes[2]) != 0U) {
        return GATEWAY_FRAME_PROTOCOL;
    }
    return (length < LEAST_LENGTH) ? GATEWAY_FRAME_SHORT : GATEWAY_FRAME_WHOLE;
}

/* The serial line. */

/* CRC-16 of Modbus: polynomial 8005h, reflected, beginning with all ones. */
static uint16_t crc_of(const uint8_t *bytes, size_t count)
{
    uint16_t crc = 0xFFFFU;
    for (size_t i = 0; i < count; i++) {
        crc = (uint16_t)(crc ^ bytes[i]);
        for (int bit = 0; bit < 8; bit++) {
            crc = (uint16_t)((crc >> 1) ^ ((crc & 1U) != 0U ? 0xA001U : 0U));
        }
    }
    return crc;
}

bool gateway_serial_is_whole(const uint8_t *bytes, size_t count)
{
    return crc_of(bytes, count - 2U) == (bytes[count - 2U] | (unsigned)bytes[count - 1U] << 8);
}

/* Bytes of a request by its function, unit and CRC included; 0: not known, or not yet. */
static size_t request_size(const uint8_t *bytes, size_t count)
{
    const uint8_t function = bytes[1];
    if (function >= 1U && function <= GATEWAY_WRITE_ONE) {
        return 8;
    }
    if (function == 0x0FU || function == GATEWAY_WRITE_SEVERAL) {
        return (count > 6U) ? 9U + (size_t)bytes[6] : 0U;
    }
    return 0;
}

static size_t answer_size(const uint8_t *bytes)
{
    const uint8_t function = bytes[1];
    if ((function & GATEWAY_EXCEPTION_BIT) != 0U) {
        return 5;
    }
    if (function >= 1U && function <= GATEWAY_READ_INPUT) {
        return 5U + (size_t)bytes[2];
    }
    const bool writes =
        function == 0x05U || function == GATEWAY_WRITE_ONE || function == 0x0FU || function == GATEWAY_WRITE_SEVERAL;
    return writes ? 8U : 0U;
}

size_t gateway_serial_frame(const uint8_t *bytes, size_t count, uint8_t own)
{
    if (count < 4U) {
        return 0;
    }
    const size_t sizes[] = {request_size(bytes, count), (bytes[0] == own) ? 0U : answer_size(bytes)};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        if (sizes[i] != 0U && sizes[i] <= count && gateway_serial_is_whole(bytes, sizes[i])) {
            return sizes[i];
        }
    }
    return 0;
}

/* What is asked for. */

static gateway_exception_t refuse(int *counter, int which, gateway_exception_t exception)
{
    *counter = which;
    return exception;
}

static bool is_served(uint8_t function)
{
    return function == GATEWAY_READ_HOLDING || function == GATEWAY_READ_INPUT || function == GATEWAY_WRITE_ONE ||
           function == GATEWAY_WRITE_SEVERAL;
}

/* Behind the function: register and count, or register and value, or register, count, bytes and that many. */
static bool has_right_size(const gateway_request_t *request)
{
    if (request->function != GATEWAY_WRITE_SEVERAL) {
        return request->size == FIXED;
    }
    return request->size > FIXED && request->size == FIXED + 1U + (size_t)request->data[FIXED];
}

static bool has_right_count(const gateway_request_t *request)
{
    if (request->function == GATEWAY_WRITE_SEVERAL) {
        return request->count >= 1U && request->count <= MOST_WRITTEN && request->data[FIXED] == 2U * request->count;
    }
    return request->count >= 1U && request->count <= MOST_READ;
}

gateway_exception_t gateway_request_check(gateway_request_t *request, int *counter)
{
    if (!is_served(request->function)) {
        return refuse(counter, GATEWAY_COUNT_WRONG_FUNCTION, GATEWAY_ILLEGAL_FUNCTION);
    }
    if (!has_right_size(request)) {
        return refuse(counter, GATEWAY_COUNT_WRONG_LENGTH, GATEWAY_ILLEGAL_VALUE);
    }
    const unsigned end = (request->function == GATEWAY_READ_INPUT) ? GATEWAY_INPUT_END : GATEWAY_HOLDING_END;
    request->at = get_word(request->data);
    request->count = (request->function == GATEWAY_WRITE_ONE) ? 1U : get_word(&request->data[2]);
    if (!has_right_count(request)) {
        return refuse(counter, GATEWAY_COUNT_WRONG_VALUE, GATEWAY_ILLEGAL_VALUE);
    }
    if (request->at + (unsigned)request->count > end) {
        return refuse(counter, GATEWAY_COUNT_WRONG_ADDRESS, GATEWAY_ILLEGAL_ADDRESS);
    }
    return GATEWAY_OK;
}

/* The answer. */

static gateway_exception_t obey(gateway_t *gateway, gateway_session_t *session, const gateway_request_t *request,
                                uint64_t now_us)
{
    const uint8_t *const from = &request->data[(request->function == GATEWAY_WRITE_ONE) ? 2 : 5];
    uint16_t words[GATEWAY_HOLDING_END];
    for (uint16_t i = 0; i < request->count; i++) {
        words[i] = get_word(&from[2U * i]);
    }
    const gateway_exception_t wrong =
        gateway_session_write(session, gateway, request->at, request->count, words, now_us);
    if (wrong == GATEWAY_ILLEGAL_ADDRESS) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_ADDRESS]);
    } else if (wrong == GATEWAY_ILLEGAL_VALUE) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_VALUE]);
    }
    return wrong;
}

static bool writes(const gateway_request_t *request)
{
    return request->function == GATEWAY_WRITE_ONE || request->function == GATEWAY_WRITE_SEVERAL;
}

static gateway_exception_t carry_out(gateway_t *gateway, gateway_session_t *session, gateway_request_t *request,
                                     uint64_t now_us)
{
    int counter = 0;
    const gateway_exception_t wrong = gateway_request_check(request, &counter);
    if (wrong != GATEWAY_OK) {
        tumble_count(&gateway->counters[counter]);
        return wrong;
    }
    return writes(request) ? obey(gateway, session, request, now_us) : GATEWAY_OK;
}

/* Behind the function: the registers that were asked for, or where how many were written. Returns how many bytes. */
static size_t put_answer(const gateway_t *gateway, gateway_session_t *session, const gateway_request_t *request,
                         uint64_t now_us, uint8_t *answer)
{
    uint16_t holding[GATEWAY_HOLDING_END];
    const uint16_t *words = holding;
    if (writes(request)) {
        memcpy(answer, request->data, FIXED);
        return FIXED;
    }
    if (request->function == GATEWAY_READ_INPUT) {
        words = gateway_session_input(session, gateway, request->at, request->count, now_us);
    } else {
        gateway_session_holding(session, holding, now_us);
    }
    answer[0] = (uint8_t)(2U * request->count);
    for (uint16_t i = 0; i < request->count; i++) {
        put_word(&answer[1U + 2U * i], words[request->at + i]);
    }
    return 1U + answer[0];
}

size_t gateway_answer(gateway_t *gateway, gateway_session_t *session, bool is_serial, const uint8_t *frame, size_t size,
                      uint64_t now_us, uint8_t *answer)
{
    const size_t head = is_serial ? 1U : GATEWAY_MBAP; /* ends with the unit */
    const size_t tail = is_serial ? CRC_BYTES : 0U;
    gateway_request_t request = {
        .unit = frame[head - 1U], .function = frame[head], .data = &frame[head + 1U], .size = size - head - 1U - tail};
    const bool is_ours = request.unit == gateway->settings.unit || (!is_serial && request.unit == GATEWAY_ANY_UNIT);
    tumble_count(&gateway->counters[is_ours ? GATEWAY_COUNT_REQUESTS : GATEWAY_COUNT_WRONG_UNIT]);
    if (!is_ours && is_serial) {
        return 0;
    }
    if ((request.function & GATEWAY_EXCEPTION_BIT) != 0U) { /* what only an answer may have */
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_FUNCTION]);
        return 0;
    }
    const gateway_exception_t wrong = is_ours ? carry_out(gateway, session, &request, now_us) : GATEWAY_NO_PATH;
    size_t end = head + 1U;
    memcpy(answer, frame, end);
    if (wrong != GATEWAY_OK) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_EXCEPTIONS]);
        answer[head] |= GATEWAY_EXCEPTION_BIT;
        answer[end++] = (uint8_t)wrong;
    } else {
        tumble_count(&gateway->counters[GATEWAY_COUNT_ANSWERS]);
        end += put_answer(gateway, session, &request, now_us, &answer[end]);
    }
    if (is_serial) {
        const uint16_t crc = crc_of(answer, end);
        answer[end++] = (uint8_t)(crc & 0xFFU); /* the low byte first */
        answer[end++] = (uint8_t)(crc >> 8);
    } else {
        put_word(&answer[LENGTH_AT], end - BEFORE_UNIT);
    }
    return end;
}
