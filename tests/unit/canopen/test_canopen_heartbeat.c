/* Heartbeats both ways: the node's own, and those of the nodes that it watches. */
#include "canopen_fixture.h"

static void expect_event(unsigned number, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t heard)
{
    TEST_ASSERT_EQUAL_UINT(number, at.heartbeats);
    TEST_ASSERT_EQUAL_UINT8(node, at.heartbeat_node);
    TEST_ASSERT_EQUAL_INT(event, at.heartbeat_event);
    TEST_ASSERT_EQUAL_INT(heard, at.heartbeat_state);
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
        expect_nothing_for((100 * MS) - 1);
        expect_after(1, 0x705, "7F");
    }
    give(0x000, "01 05");
    expect_after(100 * MS, 0x705, "05");
    give(0x000, "02 00");
    expect_after(100 * MS, 0x705, "04");
}

static void test_a_late_step_sends_one_heartbeat_and_keeps_the_period(void)
{
    boot();
    expect_after(130 * MS, 0x705, "7F");
    expect_after(70 * MS, 0x705, "7F");   /* at 200, not at 230 */
    expect_after(1000 * MS, 0x705, "7F"); /* ten are missed: one is sent, and the period starts anew */
    expect_nothing();
    expect_nothing_for(99 * MS);
    expect_after(1 * MS, 0x705, "7F");
    pass(200 * MS); /* one is missed */
    expect(0x705, "7F");
    expect_no_next();
}

static void test_a_heartbeat_waits_for_the_port(void)
{
    boot();
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    pass(100 * MS);
    pass(5 * MS);
    at.fake.send_status = TUMBLE_OK;
    expect_next(0x705, "7F");
    expect_nothing();
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
    expect_after(100 * MS, 0x705, "7F");
    expect(0x085, "30 81 11 02 00 00 00 00");
    expect_nothing();
    give(0x703, "05");
    expect_nothing();
    trade(0x702, "7F", 0x085, "00 00 00 00 00 00 00 00");
    expect_nothing();
}

static void test_the_error_stays_while_another_node_is_silent(void)
{
    boot();
    give(0x702, "05");
    give(0x703, "05");
    pass(500 * MS);
    drain();
    give(0x702, "05"); /* node 3 is still silent */
    expect_nothing();
    trade(0x703, "05", 0x085, "00 00 00 00 00 00 00 00");
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
    ask("23 16 10 04 F4 01 7F 00", "60 16 10 04 00 00 00 00"); /* the last entry, the last node */
    ask("40 16 10 04 00 00 00 00", "43 16 10 04 F4 01 7F 00");
    ask("40 16 10 06 00 00 00 00", "80 16 10 06 11 00 09 06");
    ask("40 16 10 05 00 00 00 00", "80 16 10 05 24 00 00 08"); /* more in the table than canopen has */
    ask("23 16 10 05 F4 01 04 00", "80 16 10 05 30 00 09 06");
    ask("23 16 10 01 00 00 00 00", "60 16 10 01 00 00 00 00"); /* no longer watched */
    give(0x702, "05");
    TEST_ASSERT_EQUAL_UINT(0, at.heartbeats);
    give(0x703, "05");
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_OPERATIONAL, tumble_nmt_state_of(&at.node.nmt, 3));
    ask("23 16 10 02 F4 01 03 00", "60 16 10 02 00 00 00 00"); /* writing starts afresh */
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_UNKNOWN, tumble_nmt_state_of(&at.node.nmt, 3));
    at.heartbeats = 0;
    pass(5000 * MS);
    TEST_ASSERT_EQUAL_UINT(0, at.heartbeats); /* not heard since, so not missed */
}

static void test_no_longer_watching_a_silent_node_ends_its_error(void)
{
    boot();
    give(0x702, "05");
    pass(500 * MS);
    drain();
    trade(0x605, "23 16 10 01 00 00 00 00", 0x085, "00 00 00 00 00 00 00 00");
    expect(0x585, "60 16 10 01 00 00 00 00");
}

static void test_producer_time_by_sdo(void)
{
    boot();
    at.fake.now_us += 30 * MS; /* time counts from the request, not from the last step */
    (void)hand(0x605, "2B 17 10 00 28 00 00 00");
    expect_next(0x585, "60 17 10 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (40 * MS), tumble_node_next_us(&at.node));
    ask("2B 17 10 00 64 00 00 00", "60 17 10 00 00 00 00 00");
    ask("40 17 10 00 00 00 00 00", "4B 17 10 00 64 00 00 00");
    ask("2B 17 10 00 14 00 00 00", "60 17 10 00 00 00 00 00");
    expect_after(20 * MS, 0x705, "7F");
    expect_after(20 * MS, 0x705, "7F");
    ask("2B 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00");
    expect_nothing_for(5000 * MS);
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
}

static const around_t around_each = {fixture_beating, fixture_end};
