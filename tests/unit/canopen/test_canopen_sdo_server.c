/* The SDO server, frame by frame as CiA 301 draws them (7.2.4.3), and under abuse. */
#include "canopen_fixture.h"

static void test_expedited_upload_of_one_to_four_bytes(void)
{
    at.variables.u8 = 0x11;
    at.variables.u16 = 0x2211;
    ask("40 04 20 00 00 00 00 00", "4F 04 20 00 11 00 00 00");
    ask("40 05 20 00 00 00 00 00", "4B 05 20 00 11 22 00 00");
    memcpy(at.variables.text, "abc", 3);
    ask("40 0B 20 00 00 00 00 00", "47 0B 20 00 61 62 63 00");
    ask("40 00 10 00 00 00 00 00", "43 00 10 00 92 01 02 00");
    ask("5F 00 10 00 FF FF FF FF", "43 00 10 00 92 01 02 00"); /* bits that CiA 301 leaves open */
}

static void test_segmented_upload(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20"); /* "Tumble " */
    ask("70 00 00 00 00 00 00 00", "10 74 65 73 74 20 6E 6F"); /* "test no" */
    ask("60 00 00 00 00 00 00 00", "0B 64 65 00 00 00 00 00"); /* "de", five bytes unused, last */
    ask("70 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"); /* nothing is under way any more */
}

static void test_an_empty_string_goes_in_an_empty_segment(void)
{
    ask("40 0B 20 00 00 00 00 00", "41 0B 20 00 00 00 00 00");
    ask("60 00 00 00 00 00 00 00", "0F 00 00 00 00 00 00 00");
}

static void test_an_upload_gives_the_value_of_its_beginning(void)
{
    at.variables.u64 = UINT64_C(0x0807060504030201);
    ask("40 0A 20 00 00 00 00 00", "41 0A 20 00 08 00 00 00");
    at.variables.u64 = 0;
    ask("60 00 00 00 00 00 00 00", "00 01 02 03 04 05 06 07");
    ask("70 00 00 00 00 00 00 00", "1D 08 00 00 00 00 00 00");
}

static void test_expedited_download(void)
{
    ask("2F 04 20 00 7F 00 00 00", "60 04 20 00 00 00 00 00");
    ask("2B 05 20 00 34 12 00 00", "60 05 20 00 00 00 00 00");
    ask("23 03 20 00 FE FF FF FF", "60 03 20 00 00 00 00 00");
    ask("27 0B 20 00 61 62 63 00", "60 0B 20 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT8(0x7F, at.variables.u8);
    TEST_ASSERT_EQUAL_UINT16(0x1234, at.variables.u16);
    TEST_ASSERT_EQUAL_INT32(-2, at.variables.i32);
    TEST_ASSERT_EQUAL_STRING("abc", at.variables.text);
}

static void test_expedited_download_without_a_size_takes_the_objects(void)
{
    ask("22 04 20 00 01 02 03 04", "60 04 20 00 00 00 00 00");
    ask("22 05 20 00 01 02 03 04", "60 05 20 00 00 00 00 00");
    ask("22 08 20 00 01 02 03 04", "80 08 20 00 13 00 07 06"); /* eight bytes do not come in four */
    TEST_ASSERT_EQUAL_UINT8(1, at.variables.u8);
    TEST_ASSERT_EQUAL_UINT16(0x0201, at.variables.u16);
}

static void test_segmented_download(void)
{
    ask("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    ask("00 41 42 43 44 45 46 47", "20 00 00 00 00 00 00 00");
    TEST_ASSERT_EQUAL_STRING("", at.variables.text); /* all or nothing */
    ask("1B 48 49 00 00 00 00 00", "30 00 00 00 00 00 00 00");
    TEST_ASSERT_EQUAL_STRING("ABCDEFGHI", at.variables.text);
    ask("00 41 42 43 44 45 46 47", "80 00 00 00 01 00 04 05");
}

static void test_segmented_download_without_a_size(void)
{
    ask("20 08 20 00 00 00 00 00", "60 08 20 00 00 00 00 00");
    ask("00 00 00 00 00 00 00 E0", "20 00 00 00 00 00 00 00");
    ask("1D BF 00 00 00 00 00 00", "30 00 00 00 00 00 00 00");
    TEST_ASSERT_TRUE(at.variables.f64 == -0.5);
}

static void test_a_string_of_full_length_and_not_one_byte_more(void)
{
    ask("21 0B 20 00 20 00 00 00", "60 0B 20 00 00 00 00 00");
    for (int i = 0; i < 4; i++) {
        trade(0x605, (i % 2 == 0) ? "00 61 61 61 61 61 61 61" : "10 61 61 61 61 61 61 61", 0x585,
              (i % 2 == 0) ? "20 00 00 00 00 00 00 00" : "30 00 00 00 00 00 00 00");
    }
    ask("05 62 62 62 62 62 00 00", "80 0B 20 00 12 00 07 06"); /* 28 + 5 */
    TEST_ASSERT_EQUAL_STRING("", at.variables.text);
    ask("21 0B 20 00 21 00 00 00", "80 0B 20 00 12 00 07 06"); /* refused at its start */
}

static void test_refusals_of_the_first_request(void)
{
    static const char *const cases[][2] = {
        {"40 00 30 00 00 00 00 00", "80 00 30 00 00 00 02 06"}, /* no object */
        {"40 00 20 01 00 00 00 00", "80 00 20 01 11 00 09 06"}, /* no subindex */
        {"40 0E 20 02 00 00 00 00", "80 0E 20 02 11 00 09 06"}, /* a hole between subindices */
        {"40 0C 20 00 00 00 00 00", "80 0C 20 00 01 00 01 06"}, /* write-only */
        {"40 12 20 00 00 00 00 00", "80 12 20 00 24 00 00 08"}, /* no data */
        {"2F 00 30 00 00 00 00 00", "80 00 30 00 00 00 02 06"},
        {"2F 0E 20 02 00 00 00 00", "80 0E 20 02 11 00 09 06"},
        {"2B 0D 20 00 00 00 00 00", "80 0D 20 00 02 00 01 06"}, /* read-only */
        {"21 0D 20 00 02 00 00 00", "80 0D 20 00 02 00 01 06"},
        {"20 0D 20 00 00 00 00 00", "80 0D 20 00 02 00 01 06"},
        {"23 05 20 00 00 00 00 00", "80 05 20 00 12 00 07 06"}, /* too long */
        {"2F 05 20 00 00 00 00 00", "80 05 20 00 13 00 07 06"}, /* too short */
        {"21 05 20 00 00 00 00 80", "80 05 20 00 12 00 07 06"}, /* 2^31 bytes announced */
        {"21 05 20 00 01 00 00 00", "80 05 20 00 13 00 07 06"},
        {"2F 00 20 00 02 00 00 00", "80 00 20 00 30 00 09 06"}, /* BOOLEAN 2 */
        {"2F 01 20 00 06 00 00 00", "80 01 20 00 31 00 09 06"}, /* too high */
        {"2F 01 20 00 FA 00 00 00", "80 01 20 00 32 00 09 06"}, /* too low */
        {"23 14 20 00 0D 00 00 00", "80 14 20 00 22 00 00 08"}, /* the hook says no */
    };

    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        ask(cases[i][0], cases[i][1]);
    }
    TEST_ASSERT_EQUAL_UINT16(COUNT_OF(cases), at.node.server.aborted);
}

static void test_refusals_at_the_end_of_a_download(void)
{
    ask("21 08 20 00 08 00 00 00", "60 08 20 00 00 00 00 00");
    ask("00 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00");
    ask("1D 40 00 00 00 00 00 00", "80 08 20 00 31 00 09 06"); /* 2.0 */
    ask("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    ask("03 61 62 63 64 65 66 00", "80 0B 20 00 10 00 07 06"); /* 6 of 9 bytes */
    ask("20 08 20 00 00 00 00 00", "60 08 20 00 00 00 00 00");
    ask("01 61 62 63 64 65 66 67", "80 08 20 00 13 00 07 06"); /* 7 of a REAL64, nothing announced */
    TEST_ASSERT_TRUE(at.variables.f64 == 0.0);
    TEST_ASSERT_EQUAL_STRING("", at.variables.text);
}

static void test_toggle_bit_of_both_directions(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask("70 00 00 00 00 00 00 00", "80 08 10 00 00 00 03 05");
    ask("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20");
    ask("60 00 00 00 00 00 00 00", "80 08 10 00 00 00 03 05"); /* asked again */
    ask("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    ask("10 41 42 43 44 45 46 47", "80 0B 20 00 00 00 03 05");
}

static void test_block_transfer_and_unknown_commands_are_refused(void)
{
    ask("A0 08 10 00 7F 00 00 00", "80 08 10 00 01 00 04 05"); /* block upload */
    ask("C2 0B 20 00 09 00 00 00", "80 0B 20 00 01 00 04 05"); /* block download */
    ask("E0 34 12 56 00 00 00 00", "80 34 12 56 01 00 04 05");
}

static void test_a_segment_of_the_wrong_direction_ends_the_transfer(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask("00 00 00 00 00 00 00 00", "80 08 10 00 01 00 04 05");
    ask("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    ask("60 00 00 00 00 00 00 00", "80 0B 20 00 01 00 04 05");
}

static void test_an_abort_of_the_client_ends_it_without_an_answer(void)
{
    ask("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    give(0x605, "80 0B 20 00 00 00 04 05");
    expect_nothing();
    ask("00 41 42 43 44 45 46 47", "80 00 00 00 01 00 04 05");
    TEST_ASSERT_EQUAL_UINT16(2, at.node.server.aborted);
    give(0x605, "80 00 00 00 00 00 00 00"); /* with nothing under way */
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT16(2, at.node.server.aborted);
    ask("40 0E 20 01 00 00 00 00", "4F 0E 20 01 00 00 00 00");
    ask("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"); /* of no object */
}

static void test_a_new_request_replaces_an_unfinished_transfer(void)
{
    ask("21 0B 20 00 09 00 00 00", "60 0B 20 00 00 00 00 00");
    ask("40 04 20 00 00 00 00 00", "4F 04 20 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT16(1, at.node.server.aborted);
    ask("00 41 42 43 44 45 46 47", "80 00 00 00 01 00 04 05");
}

static void test_a_silent_client_is_told_after_one_second(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (1000 * MS), tumble_node_next_us(&at.node));
    expect_nothing_for((1000 * MS) - 1);
    expect_after(1, 0x585, "80 08 10 00 00 00 04 05");
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
    ask("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
}

static void test_every_segment_prolongs_the_time(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    pass(900 * MS);
    ask("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20");
    pass(900 * MS);
    ask("70 00 00 00 00 00 00 00", "10 74 65 73 74 20 6E 6F");
    pass(900 * MS);
    ask("60 00 00 00 00 00 00 00", "0B 64 65 00 00 00 00 00");
}

static void test_an_answer_waits_for_the_port_and_is_sent_once(void)
{
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    give(0x605, "40 00 10 00 00 00 00 00");
    step();
    TEST_ASSERT_EQUAL_UINT64(0, tumble_node_next_us(&at.node));
    give(0x605, "40 04 20 00 00 00 00 00"); /* no correct client does this */
    TEST_ASSERT_EQUAL_UINT16(1, at.node.server.dropped);
    at.fake.send_status = TUMBLE_OK;
    expect_next(0x585, "43 00 10 00 92 01 02 00");
    expect_no_next();
    TEST_ASSERT_EQUAL_UINT32(3, at.node.link.counters.busy);
    at.fake.send_status = TUMBLE_E_PORT_DOWN;
    give(0x605, "40 00 10 00 00 00 00 00");
    at.fake.send_status = TUMBLE_STATUS_COUNT; /* a port that lies */
    step();
    TEST_ASSERT_EQUAL_UINT32(2, at.node.link.counters.down);
    at.fake.send_status = TUMBLE_OK;
    expect_next(0x585, "43 00 10 00 92 01 02 00");
}

static void test_an_abort_takes_back_an_answer_that_was_not_sent(void)
{
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    give(0x605, "40 00 10 00 00 00 00 00");
    give(0x605, "80 00 10 00 00 00 04 05");
    at.fake.send_status = TUMBLE_OK;
    expect_no_next();
    ask("40 04 20 00 00 00 00 00", "4F 04 20 00 00 00 00 00");
}

static void test_init_clears_whatever_the_memory_held(void)
{
    memset(&at.node.server, 0xA5, sizeof at.node.server);
    tumble_sdo_server_init(&at.node.server, TUMBLE_SDO_RESPONSE_ID + NODE);
    expect_nothing_for(5000 * MS);
    TEST_ASSERT_EQUAL_UINT16(0, at.node.server.aborted);
    ask("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
}

static void test_frames_that_are_not_eight_bytes_are_dropped_and_counted(void)
{
    for (uint8_t length = 0; length < 8; length++) {
        tumble_can_frame_t frame = frame_of(0x605, "40 00 10 00 00 00 00 00");

        frame.length = length;
        TEST_ASSERT_TRUE(tumble_node_receive(&at.node, &frame, at.fake.now_us));
        expect_no_next();
    }
    TEST_ASSERT_EQUAL_UINT16(8, at.node.server.dropped);
}

static void test_sdo_is_silent_when_stopped_and_before_boot_up(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    give(0x000, "02 05");
    TEST_ASSERT_FALSE(hand(0x605, "40 00 10 00 00 00 00 00"));
    expect_nothing_for(2000 * MS);
    give(0x000, "80 05");
    ask("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
    trade(0x000, "82 05", 0x705, "00");
    ask("40 04 20 00 00 00 00 00", "4F 04 20 00 00 00 00 00");
}

/* A client that knows nothing: every command byte in every phase of a transfer. What must hold: one answer and only one
 * for every request but an abort, always eight bytes on the right identifier, and a good transfer works right after. */
static void abuse(const char *beginning)
{
    for (unsigned command = 0; command < 256U; command++) {
        tumble_can_frame_t frame = frame_of(0x605, "00 0B 20 00 05 00 00 00");
        tumble_can_frame_t answer;

        if (beginning != NULL) {
            give(0x605, beginning);
            TEST_ASSERT_TRUE(fake_port_take(&at.fake, &answer));
        }
        frame.data[0] = (uint8_t)command;
        (void)tumble_node_receive(&at.node, &frame, at.fake.now_us);
        step();
        if ((command >> 5) == 4U) {
            expect_nothing();
        } else {
            TEST_ASSERT_TRUE(fake_port_take(&at.fake, &answer));
            TEST_ASSERT_EQUAL_HEX16(0x585, answer.id);
            TEST_ASSERT_EQUAL_UINT8(8, answer.length);
            expect_nothing();
        }
        give(0x605, "80 00 00 00 00 00 00 00");
        ask("40 00 10 00 00 00 00 00", "43 00 10 00 92 01 02 00");
    }
}

static void test_every_command_byte_in_every_phase(void)
{
    abuse(NULL);
    abuse("40 08 10 00 00 00 00 00");
    abuse("21 0B 20 00 09 00 00 00");
    abuse("20 0B 20 00 00 00 00 00");
}

/* Random requests biased towards valid commands and objects, against the same promise. */
static void test_random_requests_get_one_answer_each(void)
{
    uint32_t seed = 12345;

    for (int i = 0; i < 200000; i++) {
        tumble_can_frame_t frame = {.id = 0x605, .length = 8};
        tumble_can_frame_t answer;

        for (int j = 0; j < 8; j++) {
            seed = (seed * 1664525U) + 1013904223U;
            frame.data[j] = (uint8_t)(seed >> 24);
        }
        if ((seed & 3U) != 0U) {
            const tumble_entry_t *entry = &fixture_entries[(seed >> 8) % fixture_table.count];

            tumble_put_u16(&frame.data[1], entry->index);
            frame.data[3] = entry->subindex;
        }
        (void)tumble_node_receive(&at.node, &frame, at.fake.now_us);
        tumble_sdo_server_step(&at.node.server, &at.node.link, at.fake.now_us);
        TEST_ASSERT_EQUAL_UINT((frame.data[0] >> 5) != 4U, at.fake.from_firmware.count);
        while (fake_port_take(&at.fake, &answer)) {
            TEST_ASSERT_EQUAL_HEX16(0x585, answer.id);
        }
        at.fake.now_us += seed % (30 * MS);
    }
}

static const around_t around_each = {fixture_booted, fixture_end};
