/* The SDO client and servers that are silent, late, wrong or mad, and a port without room. */
#include "canopen_client.h"

/* What is left over from an earlier transfer must not end the present one. */
static void test_late_answers_are_ignored_and_counted(void)
{
    static const char *const late[] = {
        "60 41 60 00 00 00 00 00", /* acknowledges a write */
        "4B 40 60 00 27 06 00 00", /* another object */
        "4B 41 60 01 27 06 00 00", /* another subindex */
        "80 40 60 00 00 00 04 05", /* abort of another object */
        "00 41 60 00 00 00 00 00", /* segments */
        "30 41 60 00 00 00 00 00", "C0 41 60 00 00 00 00 00",
    };

    give(0x582, "4B 41 60 00 27 06 00 00"); /* nothing was asked, nobody known: not even for us */
    TEST_ASSERT_EQUAL_UINT16(0, client->ignored);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    give(0x582, "4B 41 60 00 27 06 00 00"); /* before the request was sent */
    TEST_ASSERT_EQUAL_UINT16(1, client->ignored);
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    expect(0x602, "40 41 60 00 00 00 00 00");
    for (size_t i = 0; i < COUNT_OF(late); i++) {
        give(0x582, late[i]);
        TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    }
    TEST_ASSERT_EQUAL_UINT16(1U + COUNT_OF(late), client->ignored);
    TEST_ASSERT_FALSE(hand(0x583, "4B 41 60 00 27 06 00 00")); /* another node's */
    give(0x582, "4B 41 60 00 27 06 00 00");
    expect_end(TUMBLE_OK, 0);
    give(0x582, "4B 41 60 00 99 99 00 00"); /* twice */
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_HEX32(0x0627, tumble_sdo_client_u32(client));
}

static void test_a_server_that_breaks_the_protocol_is_told(void)
{
    static const struct {
        const char *answer;
        const char *abort;
        uint32_t code;
    } cases[] = {
        {"10 61 62 63 64 65 66 67", "80 08 10 00 00 00 03 05", 0x05030000U}, /* toggle */
        {"20 61 62 63 64 65 66 67", "80 08 10 00 01 00 04 05", 0x05040001U}, /* command */
        {"03 61 62 63 64 65 66 67", "80 08 10 00 10 00 07 06", 0x06070010U}, /* ends after 6 of 8 */
        {"0E 00 00 00 00 00 00 00", "80 08 10 00 10 00 07 06", 0x06070010U}, /* no byte, and not the last */
    };

    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        uint8_t room[20];

        TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x1008, 0, room, 20));
        serve("40 08 10 00 00 00 00 00", "41 08 10 00 08 00 00 00");
        serve("60 00 00 00 00 00 00 00", cases[i].answer);
        expect(0x602, cases[i].abort);
        expect_end(TUMBLE_E_SDO_ABORTED, cases[i].code);
    }
}

static void test_more_than_announced_is_refused(void)
{
    uint8_t room[20];

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x1008, 0, room, 20));
    serve("40 08 10 00 00 00 00 00", "41 08 10 00 08 00 00 00");
    serve("60 00 00 00 00 00 00 00", "00 61 62 63 64 65 66 67");
    serve("70 00 00 00 00 00 00 00", "1B 61 62 00 00 00 00 00");
    expect(0x602, "80 08 10 00 10 00 07 06");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x06070010U);
}

static void test_a_value_that_does_not_fit_is_refused(void)
{
    uint8_t room[10] = {0, 0, 0, 0, 0, 0, 0, 0, 0xA5, 0xA5};

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x1008, 0, room, 8));
    serve("40 08 10 00 00 00 00 00", "41 08 10 00 09 00 00 00"); /* announced */
    expect(0x602, "80 08 10 00 05 00 04 05");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x05040005U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x1008, 0, room, 8));
    serve("40 08 10 00 00 00 00 00", "40 08 10 00 00 00 00 00"); /* not announced */
    serve("60 00 00 00 00 00 00 00", "00 61 62 63 64 65 66 67");
    serve("70 00 00 00 00 00 00 00", "1B 61 62 00 00 00 00 00");
    expect(0x602, "80 08 10 00 05 00 04 05");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x05040005U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x1008, 0, room, 2));
    serve("40 08 10 00 00 00 00 00", "43 08 10 00 61 62 63 64"); /* expedited */
    expect(0x602, "80 08 10 00 05 00 04 05");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x05040005U);
    TEST_ASSERT_EQUAL_HEX8(0xA5, room[8]);
}

static void test_a_wrong_toggle_of_a_write_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK,
                          tumble_sdo_client_write_from(client, 2, 0x200B, 0, (const uint8_t *)"ABCDEFGHI", 9));
    serve("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    serve("00 41 42 43 44 45 46 47", "30 00 00 00 00 00 00 00");
    expect(0x602, "80 0B 20 00 00 00 03 05");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x05030000U);
}

static void test_a_silent_server_is_a_timeout_and_is_told(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    TEST_ASSERT_EQUAL_UINT64(0, tumble_node_next_us(&at.node));
    expect_request("40 41 60 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (500 * MS), tumble_node_next_us(&at.node));
    pass((500 * MS) - 1);
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    expect_nothing();
    expect_after(1, 0x602, "80 41 60 00 00 00 04 05");
    expect_end(TUMBLE_E_SDO_TIMEOUT, 0x05040000U);
    expect_nothing_for(5000 * MS);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0)); /* and can be used again */
    expect_request("40 41 60 00 00 00 00 00");
}

static void test_a_port_without_room_delays_and_then_times_out(void)
{
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    step();
    pass(499 * MS);
    at.fake.send_status = TUMBLE_OK;
    expect_request("40 41 60 00 00 00 00 00");
    pass(499 * MS); /* time runs anew from here */
    give(0x582, "4B 41 60 00 27 06 00 00");
    expect_end(TUMBLE_OK, 0);
    at.fake.send_status = TUMBLE_E_PORT_DOWN;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    step();
    pass(300 * MS); /* offers in between do not prolong it */
    pass(199 * MS);
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    pass(1 * MS);
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_TIMEOUT, result());
}

static void test_a_transfer_ends_when_the_node_is_stopped_or_reset(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    expect_request("40 41 60 00 00 00 00 00");
    give(0x000, "02 05");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x08000022U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    expect_end(TUMBLE_E_SDO_ABORTED, 0x08000022U);
    give(0x000, "80 05");
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    expect_request("40 41 60 00 00 00 00 00");
    trade(0x000, "82 05", 0x705, "00");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x08000022U);
}

static void test_answers_that_are_not_eight_bytes_are_ignored(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    expect_request("40 41 60 00 00 00 00 00");
    for (uint8_t length = 0; length < 8; length++) {
        tumble_can_frame_t frame = frame_of(0x582, "4B 41 60 00 27 06 00 00");

        frame.length = length;
        (void)tumble_node_receive(&at.node, &frame, at.fake.now_us);
        TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    }
    TEST_ASSERT_EQUAL_UINT16(8, client->ignored);
}

/* A server gone mad: whatever it sends, the client comes to an end in bounded time and stays within its memory. */
static void test_random_answers_always_come_to_an_end(void)
{
    uint32_t seed = 99;

    for (int run = 0; run < 3000; run++) {
        uint8_t *room = malloc(12); /* on the heap, so that the sanitizer sees one byte too many */
        int rounds = 0;

        TEST_ASSERT_EQUAL_INT(TUMBLE_OK, (run % 2 == 0) ? tumble_sdo_client_read_into(client, 2, 0x1008, 0, room, 12)
                                                        : tumble_sdo_client_write_from(client, 2, 0x1008, 0, room, 12));
        memset(room, 0, 12);
        while ((result() == TUMBLE_E_SDO_BUSY) && (rounds < 2000)) {
            tumble_can_frame_t frame = {.id = 0x582, .length = 8, .data = {0, 0x08, 0x10, 0}};

            seed = (seed * 1664525U) + 1013904223U;
            frame.data[0] = (uint8_t)((seed >> 24) & (((seed >> 10) & 1U) ? 0x7FU : 0x5FU));
            frame.data[4] = (uint8_t)((seed >> 16) & 0x0FU);
            (void)tumble_node_receive(&at.node, &frame, at.fake.now_us);
            pass(20 * MS);
            rounds++;
        }
        TEST_ASSERT_LESS_THAN(2000, rounds);
        at.fake.from_firmware.count = 0;
        free(room);
    }
}

static const around_t around_each = {fixture_booted, fixture_end};
