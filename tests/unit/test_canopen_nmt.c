/* Network management: states and what lives in them, boot-up, heartbeats both ways, master commands. */
#include "canopen_fixture.h"

static const tumble_node_defaults_t beating = {.heartbeat_ms = 100, .consumers = {0x000201F4U, 0x000301F4U}};

void setUp(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&beating));
}

void tearDown(void)
{
    TEST_ASSERT_FALSE(at.fake.overflowed);
}

static void drain(void)
{
    at.fake.from_firmware.count = 0;
}

static tumble_nmt_state_t state(void)
{
    return tumble_node_state(&at.node);
}

static void test_boot_up_and_then_heartbeats(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_INITIALISING, state());
    TEST_ASSERT_EQUAL_UINT64(0, tumble_node_next_us(&at.node));
    boot();
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_PRE_OPERATIONAL, state());
    TEST_ASSERT_EQUAL_UINT(1, at.state_changes);
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (100 * MS), tumble_node_next_us(&at.node));
    for (int i = 0; i < 5; i++) {
        pass((100 * MS) - 1);
        expect_nothing();
        pass(1);
        expect(0x705, "7F");
    }
    give(0x000, "01 05");
    pass(100 * MS);
    expect(0x705, "05");
    give(0x000, "02 00");
    pass(100 * MS);
    expect(0x705, "04");
}

static void test_a_late_step_sends_one_heartbeat_and_keeps_the_period(void)
{
    boot();
    pass(130 * MS);
    expect(0x705, "7F");
    pass(70 * MS);
    expect(0x705, "7F"); /* at 200, not at 230 */
    pass(1000 * MS);
    expect(0x705, "7F"); /* ten are missed: one is sent, and the period starts anew */
    expect_nothing();
    pass(99 * MS);
    expect_nothing();
    pass(1 * MS);
    expect(0x705, "7F");
}

static void test_boot_up_waits_for_the_port(void)
{
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    for (int i = 0; i < 3; i++) {
        pass(10 * MS);
        TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_INITIALISING, state());
    }
    at.fake.send_status = TUMBLE_OK;
    boot();
    TEST_ASSERT_EQUAL_UINT32(3, at.node.link.counters.busy);
    TEST_ASSERT_EQUAL_UINT32(1, at.node.link.counters.sent);
}

static void test_a_heartbeat_waits_for_the_port(void)
{
    boot();
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    pass(100 * MS);
    pass(5 * MS);
    at.fake.send_status = TUMBLE_OK;
    step();
    expect(0x705, "7F");
    expect_nothing();
}

static void test_commands_change_the_state(void)
{
    static const struct {
        const char *frame;
        tumble_nmt_state_t wanted;
    } cases[] = {
        {"01 05", TUMBLE_NMT_OPERATIONAL}, {"80 05", TUMBLE_NMT_PRE_OPERATIONAL}, {"02 05", TUMBLE_NMT_STOPPED},
        {"01 00", TUMBLE_NMT_OPERATIONAL}, {"02 04", TUMBLE_NMT_OPERATIONAL},     {"80 00", TUMBLE_NMT_PRE_OPERATIONAL},
        {"03 05", TUMBLE_NMT_PRE_OPERATIONAL}, /* unknown */
        {"01", TUMBLE_NMT_PRE_OPERATIONAL},    /* too short */
        {"01 05 00", TUMBLE_NMT_PRE_OPERATIONAL}, /* too long */
        {"01 85", TUMBLE_NMT_PRE_OPERATIONAL},
    };

    boot();
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        TEST_ASSERT_TRUE(hand(0x000, cases[i].frame));
        TEST_ASSERT_EQUAL_INT(cases[i].wanted, state());
    }
    TEST_ASSERT_EQUAL_UINT16(3, at.node.nmt.ignored);
    TEST_ASSERT_EQUAL_UINT(1 + 5, at.state_changes);
}

static void test_every_command_byte(void)
{
    boot();
    for (unsigned command = 0; command < 256U; command++) {
        tumble_can_frame_t frame = {.id = 0, .length = 2, .data = {(uint8_t)command, NODE}};

        (void)tumble_node_receive(&at.node, &frame, at.fake.now_us);
        switch (command) {
        case 1:
            TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_OPERATIONAL, state());
            break;
        case 2:
            TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_STOPPED, state());
            break;
        case 129:
        case 130:
            TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_INITIALISING, state());
            step();
            break;
        default:
            TEST_ASSERT_EQUAL_INT((command == 0U)    ? TUMBLE_NMT_PRE_OPERATIONAL
                                  : (command < 128U) ? TUMBLE_NMT_STOPPED
                                                     : TUMBLE_NMT_PRE_OPERATIONAL,
                                  state());
            break;
        }
    }
}

static void test_resets_start_the_communication_anew(void)
{
    static const uint8_t time[2] = {50, 0};

    boot_to_operational();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_write(&at.node, 0x1017, 0, time, 2));
    tumble_emcy_raise(&at.node.emcy, 0x1000, 0, NULL);
    drain();
    give(0x000, "82 05");
    TEST_ASSERT_EQUAL_UINT(1, at.resets[false]);
    TEST_ASSERT_EQUAL_UINT(0, at.resets[true]);
    expect(0x705, "00");
    expect_nothing(); /* nor the emergency: it is gone with the reset */
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_PRE_OPERATIONAL, state());
    TEST_ASSERT_EQUAL_UINT16(100, at.node.nmt.producer_ms);
    TEST_ASSERT_EQUAL_UINT8(0, at.node.emcy.recorded);
    give(0x000, "81 00");
    TEST_ASSERT_EQUAL_UINT(1, at.resets[true]);
    expect(0x705, "00");
}

static void test_a_master_sets_its_own_state(void)
{
    tumble_node_set_state(&at.node, TUMBLE_NMT_OPERATIONAL); /* before boot-up: after it */
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_INITIALISING, state());
    boot();
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_OPERATIONAL, state());
    tumble_node_set_state(&at.node, TUMBLE_NMT_PRE_OPERATIONAL);
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_PRE_OPERATIONAL, state());
    TEST_ASSERT_EQUAL_UINT(2, at.state_changes);
}

static void test_master_commands_go_out_in_order(void)
{
    boot();
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_nmt_command(&at.node.nmt, 0, TUMBLE_NMT_RESET_COMMUNICATION));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_nmt_command(&at.node.nmt, 2, TUMBLE_NMT_START));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_nmt_command(&at.node.nmt, 128, TUMBLE_NMT_START));
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    step();
    at.fake.send_status = TUMBLE_OK;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_nmt_command(&at.node.nmt, 3, TUMBLE_NMT_STOP));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_nmt_command(&at.node.nmt, 127, TUMBLE_NMT_RESET_NODE));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_BUSY, tumble_nmt_command(&at.node.nmt, 4, TUMBLE_NMT_START));
    TEST_ASSERT_EQUAL_UINT16(1, at.node.nmt.ignored);
    step();
    expect(0x000, "82 00");
    expect(0x000, "01 02");
    expect(0x000, "02 03");
    expect(0x000, "81 7F");
    expect_nothing();
}

static void test_a_port_with_room_for_one_takes_one_a_step(void)
{
    boot();
    (void)tumble_nmt_command(&at.node.nmt, 2, TUMBLE_NMT_START);
    (void)tumble_nmt_command(&at.node.nmt, 3, TUMBLE_NMT_START);
    at.fake.send_room = 1;
    pass(100 * MS);
    expect(0x000, "01 02");
    expect_nothing();
    at.fake.send_room = 2;
    step();
    expect(0x000, "01 03");
    expect(0x705, "7F");
    expect_nothing();
}

static void expect_event(unsigned number, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t heard)
{
    TEST_ASSERT_EQUAL_UINT(number, at.heartbeats);
    TEST_ASSERT_EQUAL_UINT8(node, at.heartbeat_node);
    TEST_ASSERT_EQUAL_INT(event, at.heartbeat_event);
    TEST_ASSERT_EQUAL_INT(heard, at.heartbeat_state);
}

static void test_life_of_a_watched_node(void)
{
    boot();
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_UNKNOWN, tumble_nmt_state_of(&at.node.nmt, 2));
    pass(10000 * MS); /* who was never heard is not missed */
    TEST_ASSERT_EQUAL_UINT(0, at.heartbeats);
    give(0x702, "00");
    expect_event(1, 2, TUMBLE_HEARTBEAT_BOOTED, TUMBLE_NMT_INITIALISING);
    give(0x702, "7F");
    expect_event(2, 2, TUMBLE_HEARTBEAT_CHANGED, TUMBLE_NMT_PRE_OPERATIONAL);
    pass(499 * MS);
    give(0x702, "7F");
    give(0x702, "05");
    expect_event(3, 2, TUMBLE_HEARTBEAT_CHANGED, TUMBLE_NMT_OPERATIONAL);
    give(0x703, "05");
    expect_event(4, 3, TUMBLE_HEARTBEAT_BEGAN, TUMBLE_NMT_OPERATIONAL);
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_OPERATIONAL, tumble_nmt_state_of(&at.node.nmt, 2));
    pass(300 * MS);
    give(0x703, "05");
    pass(200 * MS);
    expect_event(5, 2, TUMBLE_HEARTBEAT_LOST, TUMBLE_NMT_UNKNOWN);
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_UNKNOWN, tumble_nmt_state_of(&at.node.nmt, 2));
    pass(100 * MS);
    TEST_ASSERT_EQUAL_UINT(5, at.heartbeats); /* told once */
    give(0x702, "05");
    expect_event(6, 2, TUMBLE_HEARTBEAT_BEGAN, TUMBLE_NMT_OPERATIONAL);
}

static void test_exactly_the_consumer_time_is_a_loss(void)
{
    boot();
    give(0x702, "05");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (100 * MS), tumble_node_next_us(&at.node));
    for (int i = 0; i < 4; i++) {
        pass(100 * MS);
    }
    pass((100 * MS) - 1);
    TEST_ASSERT_EQUAL_UINT(1, at.heartbeats);
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + 1, tumble_node_next_us(&at.node));
    pass(1);
    expect_event(2, 2, TUMBLE_HEARTBEAT_LOST, TUMBLE_NMT_UNKNOWN);
}

static void test_both_lost_at_once_are_both_told(void)
{
    boot();
    give(0x702, "05");
    give(0x703, "05");
    pass(500 * MS);
    TEST_ASSERT_EQUAL_UINT(4, at.heartbeats);
    drain();
    TEST_ASSERT_TRUE(tumble_nmt_any_lost(&at.node.nmt));
}

static void test_a_loss_raises_an_emergency_and_its_end_clears_it(void)
{
    boot();
    drain();
    give(0x702, "05");
    give(0x703, "05");
    pass(400 * MS);
    give(0x703, "05");
    drain();
    pass(100 * MS);
    expect(0x705, "7F");
    expect(0x085, "30 81 11 02 00 00 00 00");
    expect_nothing();
    give(0x703, "05");
    expect_nothing();
    give(0x702, "7F");
    expect(0x085, "00 00 00 00 00 00 00 00");
    expect_nothing();
}

static void test_what_a_loss_does_to_an_operational_node(void)
{
    static const tumble_nmt_state_t wanted[] = {TUMBLE_NMT_PRE_OPERATIONAL, TUMBLE_NMT_OPERATIONAL, TUMBLE_NMT_STOPPED};
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t size;

    boot();
    for (uint8_t behaviour = 0; behaviour < 3; behaviour++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_write(&at.node, 0x1029, 1, &behaviour, 1));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_read(&at.node, 0x1029, 1, bytes, &size));
        TEST_ASSERT_EQUAL_UINT8(behaviour, bytes[0]);
        TEST_ASSERT_EQUAL_UINT8(1, size);
        give(0x702, "05");
        give(0x000, "01 05");
        pass(500 * MS);
        TEST_ASSERT_EQUAL_INT(wanted[behaviour], state());
        give(0x000, "80 05");
        give(0x702, "05");
        pass(500 * MS);
        TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_PRE_OPERATIONAL, state()); /* only an Operational node reacts */
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, tumble_node_write(&at.node, 0x1029, 1, (const uint8_t *)"\x03", 1));
}

static void test_heartbeats_of_others_and_broken_ones_change_nothing(void)
{
    boot();
    give(0x704, "05");
    give(0x702, "");
    give(0x702, "05 05");
    TEST_ASSERT_EQUAL_UINT(0, at.heartbeats);
    give(0x702, "85"); /* the toggle bit of node guarding is not a state */
    expect_event(1, 2, TUMBLE_HEARTBEAT_BEGAN, TUMBLE_NMT_OPERATIONAL);
    give(0x702, "05");
    TEST_ASSERT_EQUAL_UINT(1, at.heartbeats);
}

static void test_consumer_times_by_sdo(void)
{
    boot();
    ask("40 16 10 01 00 00 00 00", "43 16 10 01 F4 01 02 00");
    ask("23 16 10 03 F4 01 03 00", "80 16 10 03 43 00 04 06"); /* node 3 is watched already */
    ask("23 16 10 02 E8 03 03 00", "60 16 10 02 00 00 00 00"); /* its own entry may change */
    ask("23 16 10 03 00 00 03 00", "60 16 10 03 00 00 00 00"); /* time 0 is nobody */
    ask("23 16 10 03 F4 01 80 00", "80 16 10 03 30 00 09 06"); /* node 128 */
    ask("23 16 10 03 F4 01 00 00", "80 16 10 03 30 00 09 06"); /* node 0 */
    ask("23 16 10 03 F4 01 04 01", "80 16 10 03 30 00 09 06"); /* reserved bits */
    ask("40 16 10 06 00 00 00 00", "80 16 10 06 11 00 09 06");
    ask("40 16 10 05 00 00 00 00", "80 16 10 05 24 00 00 08"); /* more in the table than canopen has */
    ask("23 16 10 05 F4 01 04 00", "80 16 10 05 30 00 09 06");
    ask("23 16 10 01 00 00 00 00", "60 16 10 01 00 00 00 00"); /* no longer watched */
    give(0x702, "05");
    TEST_ASSERT_EQUAL_UINT(0, at.heartbeats);
}

static void test_no_longer_watching_a_silent_node_ends_its_error(void)
{
    boot();
    give(0x702, "05");
    pass(500 * MS);
    drain();
    give(0x605, "23 16 10 01 00 00 00 00");
    expect(0x085, "00 00 00 00 00 00 00 00");
    expect(0x585, "60 16 10 01 00 00 00 00");
}

static void test_producer_time_by_sdo(void)
{
    boot();
    ask("40 17 10 00 00 00 00 00", "4B 17 10 00 64 00 00 00");
    ask("2B 17 10 00 14 00 00 00", "60 17 10 00 00 00 00 00");
    pass(20 * MS);
    expect(0x705, "7F");
    pass(20 * MS);
    expect(0x705, "7F");
    ask("2B 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00");
    pass(5000 * MS);
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_boot_up_and_then_heartbeats);
    RUN_TEST(test_a_late_step_sends_one_heartbeat_and_keeps_the_period);
    RUN_TEST(test_boot_up_waits_for_the_port);
    RUN_TEST(test_a_heartbeat_waits_for_the_port);
    RUN_TEST(test_commands_change_the_state);
    RUN_TEST(test_every_command_byte);
    RUN_TEST(test_resets_start_the_communication_anew);
    RUN_TEST(test_a_master_sets_its_own_state);
    RUN_TEST(test_master_commands_go_out_in_order);
    RUN_TEST(test_a_port_with_room_for_one_takes_one_a_step);
    RUN_TEST(test_life_of_a_watched_node);
    RUN_TEST(test_exactly_the_consumer_time_is_a_loss);
    RUN_TEST(test_both_lost_at_once_are_both_told);
    RUN_TEST(test_a_loss_raises_an_emergency_and_its_end_clears_it);
    RUN_TEST(test_what_a_loss_does_to_an_operational_node);
    RUN_TEST(test_heartbeats_of_others_and_broken_ones_change_nothing);
    RUN_TEST(test_consumer_times_by_sdo);
    RUN_TEST(test_no_longer_watching_a_silent_node_ends_its_error);
    RUN_TEST(test_producer_time_by_sdo);
    return UNITY_END();
}
