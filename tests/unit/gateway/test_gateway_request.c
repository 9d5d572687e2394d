/* Where a Modbus request ends and whether it is served: TCP and serial framing, function, length, count, registers. */
#include "request.h"
#include "support.h"

#include <string.h>

#define OWN 1U

/* Polynomial division of the message's bits, least significant first, with the initial value added to the first 16. */
static uint16_t crc_by_division(const uint8_t *bytes, size_t count)
{
    uint32_t rest = 0;
    for (size_t bit = 0; bit < 8U * count + 16U; bit++) {
        uint32_t in = (bit < 8U * count) ? (uint32_t)(bytes[bit / 8U] >> (bit % 8U)) & 1U : 0U;
        in ^= (bit < 16U) ? 1U : 0U;
        const uint32_t out = rest >> 15;
        rest = ((rest << 1) | in) & 0xFFFFU;
        rest ^= (out != 0U) ? 0x8005U : 0U;
    }
    uint16_t reflected = 0;
    for (int bit = 0; bit < 16; bit++) {
        reflected = (uint16_t)(reflected | ((rest >> bit) & 1U) << (15 - bit));
    }
    return reflected;
}

static size_t with_crc(uint8_t *bytes, size_t count)
{
    const uint16_t crc = crc_by_division(bytes, count);
    bytes[count] = (uint8_t)(crc & 0xFFU);
    bytes[count + 1U] = (uint8_t)(crc >> 8);
    return count + 2U;
}

static void test_a_published_crc(void)
{
    const uint8_t frame[] = {0x02, 0x07, 0x41, 0x12}; /* Modbus over serial line, V1.02, 6.2.2 */
    TEST_ASSERT_TRUE(gateway_serial_is_whole(frame, sizeof frame));
    TEST_ASSERT_EQUAL_HEX16(0x1241U, crc_by_division(frame, 2));
}

static void test_every_length_of_the_header(void)
{
    uint8_t frame[300] = {0};
    for (uint32_t length = 0; length <= 65535U; length++) {
        size_t size = 0;
        frame[4] = (uint8_t)(length >> 8);
        frame[5] = (uint8_t)(length & 0xFFU);
        const gateway_frame_t found = gateway_tcp_frame(frame, sizeof frame, &size);
        TEST_ASSERT_EQUAL_INT((length > 254U) ? GATEWAY_FRAME_LOST
                              : (length < 2U) ? GATEWAY_FRAME_SHORT
                                              : GATEWAY_FRAME_WHOLE,
                              found);
        TEST_ASSERT_EQUAL_size_t(6U + length, size);
    }
}

static void test_a_frame_is_whole_with_its_last_byte(void)
{
    uint8_t frame[260] = {0};
    for (size_t length = 2; length <= 254U; length++) {
        frame[5] = (uint8_t)length;
        for (size_t count = 0; count <= 6U + length; count++) {
            size_t size = 0;
            const gateway_frame_t found = gateway_tcp_frame(frame, count, &size);
            TEST_ASSERT_EQUAL_INT((count < 6U + length) ? GATEWAY_FRAME_PART : GATEWAY_FRAME_WHOLE, found);
        }
    }
}

static void test_another_protocol(void)
{
    uint8_t frame[260] = {0, 0, 0, 1, 0, 6};
    size_t size = 0;
    TEST_ASSERT_EQUAL_INT(GATEWAY_FRAME_PROTOCOL, gateway_tcp_frame(frame, 12, &size));
    TEST_ASSERT_EQUAL_size_t(12, size);
    TEST_ASSERT_EQUAL_INT(GATEWAY_FRAME_PART, gateway_tcp_frame(frame, 11, &size));
    frame[5] = 1;
    TEST_ASSERT_EQUAL_INT(GATEWAY_FRAME_PROTOCOL, gateway_tcp_frame(frame, 12, &size));
}

/* Serial. */

static void test_requests_of_every_length_and_their_beginnings(void)
{
    uint8_t frame[300];
    for (unsigned function = 1; function <= 16U; function++) {
        const bool has_bytes = function >= 15U;
        if (function > 6U && !has_bytes) {
            continue;
        }
        for (unsigned bytes = 0; bytes <= (has_bytes ? 246U : 0U); bytes++) {
            memset(frame, 0x5A, sizeof frame);
            frame[0] = OWN;
            frame[1] = (uint8_t)function;
            frame[6] = (uint8_t)bytes;
            const size_t size = with_crc(frame, has_bytes ? 7U + bytes : 6U);
            for (size_t count = 0; count < size; count++) {
                TEST_ASSERT_EQUAL_size_t(0, gateway_serial_frame(frame, count, OWN));
            }
            TEST_ASSERT_EQUAL_size_t(size, gateway_serial_frame(frame, size, OWN));
            TEST_ASSERT_EQUAL_size_t(size, gateway_serial_frame(frame, size + 1U, OWN));
            frame[size - 1U] ^= 1U;
            TEST_ASSERT_EQUAL_size_t(0, gateway_serial_frame(frame, size, OWN));
        }
    }
}

static void test_answers_of_others_only(void)
{
    uint8_t frame[300];
    for (uint8_t unit = 1; unit <= 2U; unit++) {
        for (unsigned bytes = 0; bytes <= 250U; bytes++) {
            memset(frame, 0xA5, sizeof frame);
            frame[0] = unit;
            frame[1] = GATEWAY_READ_HOLDING;
            frame[2] = (uint8_t)bytes;
            const size_t size = with_crc(frame, 3U + bytes);
            const bool like_a_request = size == 8U;
            const size_t wanted = (unit != OWN || like_a_request) ? size : 0U;
            TEST_ASSERT_EQUAL_size_t(wanted, gateway_serial_frame(frame, size, OWN));
        }
    }
    uint8_t exception[5] = {2, 0x83, 2};
    (void)with_crc(exception, 3);
    TEST_ASSERT_EQUAL_size_t(5, gateway_serial_frame(exception, 5, OWN));
    exception[0] = OWN;
    (void)with_crc(exception, 3);
    TEST_ASSERT_EQUAL_size_t(0, gateway_serial_frame(exception, 5, OWN));
}

/* What is served. */

static gateway_exception_t judge(uint8_t function, const uint8_t *data, size_t size, int *counter)
{
    gateway_request_t request = {.unit = OWN, .function = function, .data = data, .size = size};
    *counter = -1;
    return gateway_request_check(&request, counter);
}

static void test_functions(void)
{
    const uint8_t data[4] = {0, 0, 0, 1};
    int counter;
    for (unsigned function = 0; function <= 255U; function++) {
        const bool served = function == 3U || function == 4U || function == 6U;
        const gateway_exception_t wrong = judge((uint8_t)function, data, sizeof data, &counter);
        if (function == 16U) {
            TEST_ASSERT_EQUAL_INT(GATEWAY_ILLEGAL_VALUE, wrong);
            TEST_ASSERT_EQUAL_INT(GATEWAY_COUNT_WRONG_LENGTH, counter);
        } else {
            TEST_ASSERT_EQUAL_INT(served ? GATEWAY_OK : GATEWAY_ILLEGAL_FUNCTION, wrong);
            TEST_ASSERT_EQUAL_INT(served ? -1 : GATEWAY_COUNT_WRONG_FUNCTION, counter);
        }
    }
}

static void test_every_count_and_the_edges_of_the_map(void)
{
    int counter;
    for (uint32_t count = 0; count <= 65535U; count++) {
        const uint32_t edges[] = {0, GATEWAY_INPUT_END - 125U, GATEWAY_INPUT_END - 1U, GATEWAY_INPUT_END, 65535U};
        for (size_t i = 0; i < COUNT_OF(edges); i++) {
            const uint8_t data[4] = {(uint8_t)(edges[i] >> 8), (uint8_t)(edges[i] & 0xFFU), (uint8_t)(count >> 8),
                                     (uint8_t)(count & 0xFFU)};
            const gateway_exception_t wrong = judge(GATEWAY_READ_INPUT, data, sizeof data, &counter);
            const gateway_exception_t wanted = (count == 0U || count > 125U)            ? GATEWAY_ILLEGAL_VALUE
                                               : (edges[i] + count > GATEWAY_INPUT_END) ? GATEWAY_ILLEGAL_ADDRESS
                                                                                        : GATEWAY_OK;
            TEST_ASSERT_EQUAL_INT(wanted, wrong);
        }
    }
}

static void test_write_several_in_all_sizes(void)
{
    int counter;
    uint8_t data[260] = {0};
    for (unsigned count = 0; count <= 130U; count++) {
        for (unsigned announced = 0; announced <= 255U; announced++) {
            data[3] = (uint8_t)count;
            data[4] = (uint8_t)announced;
            const unsigned least = (announced > 0U) ? announced - 1U : 0U;
            for (unsigned given = least; given <= announced + 1U && given <= 247U; given++) {
                const gateway_exception_t wrong = judge(GATEWAY_WRITE_SEVERAL, data, 5U + given, &counter);
                const bool good = given == announced && announced == 2U * count && count >= 1U && count <= 123U;
                TEST_ASSERT_EQUAL_INT(!good                           ? GATEWAY_ILLEGAL_VALUE
                                      : (count > GATEWAY_HOLDING_END) ? GATEWAY_ILLEGAL_ADDRESS
                                                                      : GATEWAY_OK,
                                      wrong);
            }
        }
    }
}
