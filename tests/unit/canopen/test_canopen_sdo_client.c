/* The SDO client against hand-written answers of a server, and against its own server. */
#include "canopen_client.h"

static void test_expedited_write(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write(client, 2, 0x6060, 0, 1, 1));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    serve("2F 60 60 00 01 00 00 00", "60 60 60 00 00 00 00 00");
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write(client, 2, 0x6040, 0, 0x0106, 2));
    serve("2B 40 60 00 06 01 00 00", "60 40 60 00 00 00 00 00");
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write(client, 2, 0x607A, 3, (uint32_t)-2, 4));
    serve("23 7A 60 03 FE FF FF FF", "60 7A 60 03 00 00 00 00");
    expect_end(TUMBLE_OK, 0);
}

static void test_expedited_read(void)
{
    static const char *const answers[] = {"4F 41 60 00 27 06 04 03", "4B 41 60 00 27 06 04 03",
                                          "47 41 60 00 27 06 04 03", "43 41 60 00 27 06 04 03",
                                          "42 41 60 00 27 06 04 03", "4E 41 60 00 27 06 04 03"};
    static const uint32_t values[] = {0x27, 0x0627, 0x040627, 0x03040627, 0x03040627, 0x03040627};
    static const uint8_t sizes[] = {1, 2, 3, 4, 4, 4}; /* without a size, the unused bytes do not count */

    for (size_t i = 0; i < COUNT_OF(answers); i++) {
        uint8_t size;

        TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
        TEST_ASSERT_EQUAL_UINT32(0, tumble_sdo_client_u32(client)); /* not yet */
        serve("40 41 60 00 00 00 00 00", answers[i]);
        expect_end(TUMBLE_OK, 0);
        TEST_ASSERT_EQUAL_HEX32(values[i], tumble_sdo_client_u32(client));
        (void)tumble_sdo_client_data(client, &size);
        TEST_ASSERT_EQUAL_UINT8(sizes[i], size);
    }
}

static void test_segmented_read(void)
{
    uint8_t text[20] = {0};
    uint8_t size;

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x1008, 0, text, 16));
    serve("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    serve("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20");
    serve("70 00 00 00 00 00 00 00", "10 74 65 73 74 20 6E 6F");
    serve("60 00 00 00 00 00 00 00", "0B 64 65 00 00 00 00 00");
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_PTR(text, tumble_sdo_client_data(client, &size));
    TEST_ASSERT_EQUAL_UINT8(16, size);
    TEST_ASSERT_EQUAL_STRING("Tumble test node", text);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_sdo_client_u32(client));
}

static void test_segmented_read_of_an_unannounced_and_of_no_size(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x2008, 0));
    serve("40 08 20 00 00 00 00 00", "40 08 20 00 FF FF FF FF"); /* the bytes of the size mean nothing */
    serve("60 00 00 00 00 00 00 00", "09 01 02 03 00 00 00 00"); /* three bytes, last */
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_HEX32(0x030201, tumble_sdo_client_u32(client));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x2008, 0));
    serve("40 08 20 00 00 00 00 00", "41 08 20 00 00 00 00 00");
    serve("60 00 00 00 00 00 00 00", "0F 00 00 00 00 00 00 00"); /* empty */
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_sdo_client_u32(client));
}

static void test_segmented_write(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK,
                          tumble_sdo_client_write_from(client, 2, 0x200B, 0, (const uint8_t *)"ABCDEFGHIJKLMNOP", 16));
    serve("21 0B 20 00 10 00 00 00", "60 0B 20 00 00 00 00 00");
    serve("00 41 42 43 44 45 46 47", "20 00 00 00 00 00 00 00");
    serve("10 48 49 4A 4B 4C 4D 4E", "30 00 00 00 00 00 00 00");
    expect(0x602, "0B 4F 50 00 00 00 00 00");
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, result());
    give(0x582, "20 00 00 00 00 00 00 00");
    expect_end(TUMBLE_OK, 0);
}

static void test_a_write_of_seven_bytes_is_one_segment(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write_from(client, 2, 0x200B, 0, (const uint8_t *)"ABCDEFG", 7));
    serve("21 0B 20 00 07 00 00 00", "60 0B 20 00 00 00 00 00");
    serve("01 41 42 43 44 45 46 47", "20 00 00 00 00 00 00 00");
    expect_end(TUMBLE_OK, 0);
}

static void test_one_transfer_at_a_time(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, tumble_sdo_client_read(client, 3, 0x1000, 0));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_SDO_BUSY, tumble_sdo_client_write(client, 3, 0x1017, 0, 5, 2));
    expect_request("40 41 60 00 00 00 00 00");
}

/* What one transfer lent, the next one does not touch. */
static void test_the_callers_memory_is_let_go(void)
{
    uint8_t room[8] = {0};

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 127, 0x6041, 0, room, 8));
    expect_next(0x67F, "40 41 60 00 00 00 00 00");
    give(0x5FF, "4B 41 60 00 27 06 00 00");
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_HEX8(0x27, room[0]);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    serve("40 41 60 00 00 00 00 00", "4B 41 60 00 99 99 00 00");
    TEST_ASSERT_EQUAL_HEX8(0x27, room[0]);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write_from(client, 2, 0x6060, 0, room, 1));
    serve("2F 60 60 00 27 00 00 00", "80 60 60 00 30 00 09 06");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x06090030U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write(client, 2, 0x6060, 0, 6, 1));
    TEST_ASSERT_EQUAL_HEX32(0, client->abort);
    expect_request("2F 60 60 00 06 00 00 00");
}

static void test_arguments(void)
{
    uint8_t byte = 0;

    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_read(client, 0, 0x6041, 0));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_read(client, 128, 0x6041, 0));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_write(client, 2, 0x6041, 0, 0, 3));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_write(client, 2, 0x6041, 0, 0, 0));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_read_into(client, 2, 0x6041, 0, NULL, 4));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_read_into(client, 2, 0x6041, 0, &byte, 0));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_write_from(client, 2, 0x6041, 0, NULL, 4));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_sdo_client_write_from(client, 2, 0x6041, 0, &byte, 0));
    expect_end(TUMBLE_OK, 0);
}

static void test_the_servers_abort_is_the_result(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_write(client, 2, 0x6060, 0, 3, 1));
    serve("2F 60 60 00 03 00 00 00", "80 60 60 00 30 00 09 06");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x06090030U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x1008, 0));
    expect_request("40 08 10 00 00 00 00 00");
    TEST_ASSERT_EQUAL_HEX32(0, client->abort);
    give(0x582, "41 08 10 00 08 00 00 00");
    serve("60 00 00 00 00 00 00 00", "80 00 00 00 00 00 00 08"); /* within segments an abort need not name the object */
    expect_end(TUMBLE_E_SDO_ABORTED, 0x08000000U);
}

static void test_cancel_tells_the_server(void)
{
    tumble_sdo_client_cancel(client); /* nothing to cancel */
    expect_end(TUMBLE_OK, 0);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(client, 2, 0x6041, 0));
    expect_request("40 41 60 00 00 00 00 00");
    tumble_sdo_client_cancel(client);
    expect_request("80 41 60 00 00 00 00 08");
    expect_end(TUMBLE_E_SDO_ABORTED, 0x08000000U);
}

/* The client of one end and the server of the other, through frames: every length that either can hold, both ways. */
static void test_client_and_server_agree_on_every_length(void)
{
    tumble_sdo_server_t server;
    char pattern[32];

    tumble_sdo_server_init(&server, TUMBLE_SDO_RESPONSE_ID + 2);
    for (uint8_t length = 1; length <= sizeof pattern; length++) {
        for (int direction = 0; direction < 2; direction++) {
            uint8_t room[sizeof pattern] = {0};
            uint8_t size = 0;
            int exchanges = 0;
            tumble_can_frame_t frame;

            for (uint8_t i = 0; i < length; i++) {
                pattern[i] = (char)('A' + ((i + length) % 26));
            }
            if (direction == 0) {
                memset(at.variables.text, 0, sizeof at.variables.text);
                TEST_ASSERT_EQUAL_INT(
                    TUMBLE_OK, tumble_sdo_client_write_from(client, 2, 0x200B, 0, (const uint8_t *)pattern, length));
            } else {
                TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read_into(client, 2, 0x200B, 0, room, length));
            }
            while ((result() == TUMBLE_E_SDO_BUSY) && (exchanges < 20)) {
                tumble_sdo_client_step(client, &at.node.link, at.fake.now_us);
                TEST_ASSERT_TRUE(fake_port_take(&at.fake, &frame));
                tumble_sdo_server_receive(&server, &at.node.dictionary, &frame, at.fake.now_us);
                tumble_sdo_server_step(&server, &at.node.link, at.fake.now_us);
                TEST_ASSERT_TRUE(fake_port_take(&at.fake, &frame));
                tumble_sdo_client_receive(client, &frame);
                exchanges++;
            }
            TEST_ASSERT_EQUAL_INT(TUMBLE_OK, result());
            TEST_ASSERT_EQUAL_INT((length <= 4) ? 1 : 1 + ((length + 6) / 7), exchanges);
            (void)tumble_sdo_client_data(client, &size);
            TEST_ASSERT_EQUAL_UINT8(length, size);
            TEST_ASSERT_EQUAL_MEMORY(pattern, (direction == 0) ? (const void *)at.variables.text : room, length);
        }
    }
}

static const around_t around_each = {fixture_booted, fixture_end};
