/* Emergency messages: register, history, queue; those of other nodes. */
#include "canopen_fixture.h"

static void raise_code(uint16_t code, uint8_t bits)
{
    tumble_emcy_raise(&at.node.emcy, code, bits, NULL);
}

static void test_an_error_comes_and_goes(void)
{
    static const uint8_t info[TUMBLE_EMCY_INFO_BYTES] = {1, 2, 3, 4, 5};

    tumble_emcy_raise(&at.node.emcy, 0x8611, TUMBLE_ERROR_PROFILE, info);
    TEST_ASSERT_EQUAL_UINT64(0, tumble_node_next_us(&at.node));
    expect_next(0x085, "11 86 21 01 02 03 04 05");
    ask("40 01 10 00 00 00 00 00", "4F 01 10 00 21 00 00 00");
    ask("40 03 10 00 00 00 00 00", "4F 03 10 00 01 00 00 00");
    ask("40 03 10 01 00 00 00 00", "43 03 10 01 11 86 01 02");
    ask("40 03 10 02 00 00 00 00", "80 03 10 02 24 00 00 08"); /* no data */
    tumble_emcy_clear(&at.node.emcy, TUMBLE_ERROR_PROFILE);
    expect_next(0x085, "00 00 00 00 00 00 00 00");
    expect_nothing();
    ask("40 01 10 00 00 00 00 00", "4F 01 10 00 00 00 00 00");
    ask("40 03 10 01 00 00 00 00", "43 03 10 01 11 86 01 02"); /* the history stays */
}

static void test_no_error_is_said_when_the_last_one_goes(void)
{
    raise_code(0x8611, TUMBLE_ERROR_PROFILE);
    raise_code(0xFF01, TUMBLE_ERROR_MANUFACTURER);
    expect_next(0x085, "11 86 21 00 00 00 00 00");
    expect(0x085, "01 FF A1 00 00 00 00 00");
    tumble_emcy_clear(&at.node.emcy, TUMBLE_ERROR_PROFILE);
    expect_no_next();
    TEST_ASSERT_EQUAL_HEX8(0x81, at.node.emcy.error_register);
    tumble_emcy_clear(&at.node.emcy, TUMBLE_ERROR_MANUFACTURER);
    tumble_emcy_clear(&at.node.emcy, TUMBLE_ERROR_MANUFACTURER);
    expect_next(0x085, "00 00 00 00 00 00 00 00");
    expect_nothing();
    raise_code(0x1000, 0); /* a generic error has no other bit */
    expect_next(0x085, "00 10 01 00 00 00 00 00");
    tumble_emcy_clear(&at.node.emcy, TUMBLE_ERROR_GENERIC);
    expect_next(0x085, "00 00 00 00 00 00 00 00");
}

static void test_history_keeps_the_newest_and_can_be_forgotten(void)
{
    for (uint16_t i = 1; i <= 6; i++) {
        raise_code((uint16_t)(0x1000U + i), 0);
        step();
    }
    at.fake.from_firmware.count = 0;
    ask("40 03 10 00 00 00 00 00", "4F 03 10 00 04 00 00 00");
    ask("40 03 10 01 00 00 00 00", "43 03 10 01 06 10 00 00");
    ask("40 03 10 04 00 00 00 00", "43 03 10 04 03 10 00 00");
    ask("2F 03 10 00 01 00 00 00", "80 03 10 00 30 00 09 06");
    ask("23 03 10 01 00 00 00 00", "80 03 10 01 02 00 01 06");
    ask("2F 03 10 00 00 00 00 00", "60 03 10 00 00 00 00 00");
    ask("40 03 10 00 00 00 00 00", "4F 03 10 00 00 00 00 00");
    ask("40 03 10 01 00 00 00 00", "80 03 10 01 24 00 00 08");
}

static void test_messages_wait_for_the_port_and_the_rest_is_counted(void)
{
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    for (uint16_t i = 1; i <= 7; i++) {
        raise_code((uint16_t)(0x1000U + i), 0);
        step();
    }
    TEST_ASSERT_EQUAL_UINT16(3, at.node.emcy.overflow);
    TEST_ASSERT_EQUAL_HEX32(0x1007, at.node.emcy.history[0]); /* what was not sent can still be read */
    at.fake.send_status = TUMBLE_OK;
    at.fake.send_room = 1;
    expect_next(0x085, "01 10 01 00 00 00 00 00");
    expect_nothing();
    at.fake.send_room = SIZE_MAX;
    expect_next(0x085, "02 10 01 00 00 00 00 00");
    expect(0x085, "03 10 01 00 00 00 00 00");
    expect(0x085, "04 10 01 00 00 00 00 00");
    expect_nothing();
}

static void test_nothing_is_sent_while_stopped(void)
{
    give(0x000, "02 05");
    raise_code(0x1000, 0);
    expect_nothing_for(1000 * MS);
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
    trade(0x000, "80 05", 0x085, "00 10 01 00 00 00 00 00");
}

static void test_emergencies_of_others(void)
{
    TEST_ASSERT_TRUE(hand(0x082, "11 86 21 01 02 03 04 05"));
    TEST_ASSERT_EQUAL_UINT(1, at.emergencies);
    TEST_ASSERT_EQUAL_UINT8(2, at.emergency_node);
    TEST_ASSERT_EQUAL_HEX16(0x8611, at.emergency.code);
    TEST_ASSERT_EQUAL_HEX8(0x21, at.emergency.error_register);
    TEST_ASSERT_EQUAL_UINT8(5, at.emergency.info[4]);
    TEST_ASSERT_TRUE(hand(0x0FF, "00 00 00 00 00 00 00 00"));
    TEST_ASSERT_EQUAL_UINT8(127, at.emergency_node);
    TEST_ASSERT_TRUE(hand(0x082, "11 86 21 01 02 03 04"));
    TEST_ASSERT_EQUAL_UINT(2, at.emergencies);                 /* seven bytes are none */
    TEST_ASSERT_FALSE(hand(0x080, ""));                        /* SYNC */
    TEST_ASSERT_FALSE(hand(0x085, "11 86 21 01 02 03 04 05")); /* its own */
    TEST_ASSERT_FALSE(hand(0x100, "00 00 00 00 00 00"));       /* TIME */
    TEST_ASSERT_EQUAL_UINT(2, at.emergencies);
}

static const around_t around_each = {fixture_booted, fixture_end};
