#include "request.h"

#define LENGTH_AT 4U /* in the MBAP header, of all that is behind it */
#define BEFORE_UNIT 6U
#define LEAST_LENGTH 2U
#define MOST_LENGTH 254U

#define MOST_READ 125U
#define MOST_WRITTEN 123U
#define FIXED 4U /* bytes behind the function: register, and count or value */

gateway_frame_t gateway_tcp_frame(const uint8_t *bytes, size_t count, size_t *size)
{
    if (count < BEFORE_UNIT) {
        return GATEWAY_FRAME_PART;
    }
    const uint16_t length = gateway_word(&bytes[LENGTH_AT]);
    *size = BEFORE_UNIT + (size_t)length;
    if (length > MOST_LENGTH) {
        return GATEWAY_FRAME_LOST;
    }
    if (count < *size) {
        return GATEWAY_FRAME_PART;
    }
    if (gateway_word(&bytes[2]) != 0U) {
        return GATEWAY_FRAME_PROTOCOL;
    }
    return (length < LEAST_LENGTH) ? GATEWAY_FRAME_SHORT : GATEWAY_FRAME_WHOLE;
}

gateway_request_t gateway_tcp_request(const uint8_t *frame, size_t size)
{
    return (gateway_request_t){.unit = frame[BEFORE_UNIT],
                               .function = frame[GATEWAY_MBAP],
                               .data = &frame[GATEWAY_MBAP + 1U],
                               .size = size - GATEWAY_MBAP - 1U};
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

gateway_request_t gateway_serial_request(const uint8_t *frame, size_t size)
{
    return (gateway_request_t){.unit = frame[0], .function = frame[1], .data = &frame[2], .size = size - 4U};
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
    request->at = gateway_word(request->data);
    request->count = (request->function == GATEWAY_WRITE_ONE) ? 1U : gateway_word(&request->data[2]);
    if (!has_right_count(request)) {
        return refuse(counter, GATEWAY_COUNT_WRONG_VALUE, GATEWAY_ILLEGAL_VALUE);
    }
    if (request->at + (unsigned)request->count > end) {
        return refuse(counter, GATEWAY_COUNT_WRONG_ADDRESS, GATEWAY_ILLEGAL_ADDRESS);
    }
    return GATEWAY_OK;
}
