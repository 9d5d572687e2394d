/* Process data: receiving, sending, timers, a busy port. */
#include "canopen_mapping.h"

static void test_a_received_pdo_is_written_in_order(void)
{
    map_receive();
    TEST_ASSERT_TRUE(hand(0x205, "34 12 FE FF FF FF"));
    TEST_ASSERT_EQUAL_HEX16(0x1234, at.variables.u16);
    TEST_ASSERT_EQUAL_INT32(-2, at.variables.i32);
    TEST_ASSERT_EQUAL_UINT(2, at.writes);
    TEST_ASSERT_TRUE(hand(0x205, "35 12 FD FF FF FF 99 99")); /* longer than mapped */
    TEST_ASSERT_EQUAL_INT32(-3, at.variables.i32);
    TEST_ASSERT_EQUAL_UINT(2, at.pdos[0]);
    TEST_ASSERT_FALSE(hand(0x206, "34 12 FE FF FF FF"));
}

static void test_dummies_skip_bytes(void)
{
    accepted(0x1401, 1, 0x80000305U);
    accepted(0x1601, 1, 0x00050008U);
    accepted(0x1601, 2, 0x20050010U);
    accepted(0x1601, 3, 0x00070020U);
    accepted(0x1601, 4, 0x20040008U);
    accepted(0x1601, 0, 4);
    accepted(0x1401, 1, 0x305);
    TEST_ASSERT_TRUE(hand(0x305, "FF 34 12 FF FF FF FF 77"));
    TEST_ASSERT_EQUAL_HEX16(0x1234, at.variables.u16);
    TEST_ASSERT_EQUAL_HEX8(0x77, at.variables.u8);
    TEST_ASSERT_EQUAL_UINT(1, at.pdos[1]);
}

static void test_a_refused_value_is_counted_and_does_not_stop_the_others(void)
{
    accepted(0x1400, 1, 0x80000205U);
    accepted(0x1600, 1, 0x20060020U); /* 10 to 4000000000 */
    accepted(0x1600, 2, 0x20140020U); /* its hook refuses 13 */
    accepted(0x1600, 0, 2);
    accepted(0x1400, 1, 0x205);
    at.variables.u32 = 50;
    TEST_ASSERT_TRUE(hand(0x205, "01 00 00 00 07 00 00 00"));
    TEST_ASSERT_EQUAL_UINT32(50, at.variables.u32);
    TEST_ASSERT_EQUAL_UINT32(7, at.variables.guarded);
    TEST_ASSERT_TRUE(hand(0x205, "20 00 00 00 0D 00 00 00"));
    TEST_ASSERT_EQUAL_UINT32(32, at.variables.u32);
    TEST_ASSERT_EQUAL_UINT32(7, at.variables.guarded);
    TEST_ASSERT_EQUAL_UINT16(2, at.node.pdos.refused);
    TEST_ASSERT_TRUE(hand(0x205, "20 00 00 00 07 00 00 00"));
    TEST_ASSERT_EQUAL_UINT16(2, at.node.pdos.refused);
}

static void test_a_short_pdo_writes_nothing_and_raises_one_emergency(void)
{
    map_receive();
    for (int i = 0; i < 3; i++) {
        give(0x205, "34 12 FE FF FF");
    }
    expect(0x085, "10 82 11 00 00 00 00 00");
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT16(0, at.variables.u16);
    TEST_ASSERT_EQUAL_UINT(0, at.pdos[0]);
    TEST_ASSERT_EQUAL_UINT16(3, at.node.pdos.too_short);
    trade(0x205, "34 12 FE FF FF FF", 0x085, "00 00 00 00 00 00 00 00"); /* over */
    trade(0x205, "", 0x085, "10 82 11 00 00 00 00 00");
    give(0x605, "23 00 14 01 05 02 00 80"); /* disabling it ends the fault as well */
    expect(0x085, "00 00 00 00 00 00 00 00");
}

static void test_nothing_is_received_unless_operational(void)
{
    map_receive();
    give(0x000, "80 05");
    TEST_ASSERT_FALSE(hand(0x205, "34 12 FE FF FF FF"));
    give(0x000, "02 05");
    TEST_ASSERT_FALSE(hand(0x205, "34 12 FE FF FF FF"));
    TEST_ASSERT_EQUAL_UINT16(0, at.variables.u16);
}

static void test_a_trigger_sends_the_values_of_the_moment(void)
{
    map_transmit(0, 0);
    expect_next(0x185, "00 00 00 00 00 00"); /* due when it was enabled */
    at.variables.u16 = 1;
    tumble_pdo_trigger(&at.node.pdos, 0);
    tumble_pdo_trigger(&at.node.pdos, 0);
    tumble_pdo_trigger(&at.node.pdos, 3); /* there is none */
    TEST_ASSERT_TRUE(tumble_node_next_us(&at.node) <= at.fake.now_us);
    at.variables.u16 = 0x1234;
    at.variables.i32 = -2;
    expect_next(0x185, "34 12 FE FF FF FF");
    expect_nothing_for(5000 * MS);
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
}

static void test_entering_operational_sends_once(void)
{
    map_transmit(0, 0);
    step();
    at.fake.from_firmware.count = 0;
    give(0x000, "80 05");
    tumble_pdo_trigger(&at.node.pdos, 0);
    expect_nothing_for(1000 * MS);
    trade(0x000, "01 05", 0x185, "00 00 00 00 00 00");
    give(0x000, "01 05"); /* is Operational already */
    expect_nothing();
}

static void test_the_event_timer_counts_from_the_last_sending(void)
{
    map_transmit(0, 100);
    expect_next(0x185, "00 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (100 * MS), tumble_node_next_us(&at.node));
    expect_nothing_for((100 * MS) - 1);
    expect_after(1, 0x185, "00 00 00 00 00 00");
    pass(60 * MS);
    tumble_pdo_trigger(&at.node.pdos, 0);
    expect_next(0x185, "00 00 00 00 00 00");
    expect_nothing_for(60 * MS);
    expect_after(40 * MS, 0x185, "00 00 00 00 00 00");
    accepted(0x1800, 5, 0);
    expect_nothing_for(500 * MS);
}

static void test_the_inhibit_time_holds_back_but_loses_nothing(void)
{
    map_transmit(500, 0); /* 50 ms */
    expect_next(0x185, "00 00 00 00 00 00");
    at.variables.u16 = 1;
    tumble_pdo_trigger(&at.node.pdos, 0);
    expect_no_next();
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (50 * MS), tumble_node_next_us(&at.node));
    at.variables.u16 = 2;
    tumble_pdo_trigger(&at.node.pdos, 0);
    expect_nothing_for((50 * MS) - 1);
    expect_after(1, 0x185, "02 00 00 00 00 00"); /* two events, one frame, the latest values */
    expect_nothing_for(50 * MS);
}

static void test_the_inhibit_time_bounds_the_event_timer(void)
{
    map_transmit(2000, 50); /* 200 ms, 50 ms */
    expect_next(0x185, "00 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (200 * MS), tumble_node_next_us(&at.node));
    expect_nothing_for(199 * MS);
    expect_after(1 * MS, 0x185, "00 00 00 00 00 00");
}

static void test_a_busy_port_delays_and_loses_nothing(void)
{
    map_transmit(0, 0);
    expect_next(0x185, "00 00 00 00 00 00");
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    at.variables.u16 = 1;
    tumble_pdo_trigger(&at.node.pdos, 0);
    for (int i = 0; i < 10; i++) {
        pass(10 * MS);
    }
    TEST_ASSERT_EQUAL_UINT32(10, at.node.link.counters.busy);
    TEST_ASSERT_TRUE(tumble_node_next_us(&at.node) <= at.fake.now_us);
    at.fake.send_status = TUMBLE_OK;
    at.variables.u16 = 7;
    expect_next(0x185, "07 00 00 00 00 00");
    expect_no_next();
}

static void test_a_value_that_nobody_has_goes_as_zeros(void)
{
    accepted(0x1801, 1, 0xC0000285U);
    accepted(0x1A01, 1, 0x20120040U); /* no data */
    accepted(0x1A01, 0, 1);
    accepted(0x1801, 1, 0x40000285U);
    expect_next(0x285, "00 00 00 00 00 00 00 00");
    expect_nothing_for(1000 * MS); /* no event timer was asked for */
}

/* What holds for the first PDO holds for the others. */
static void test_the_last_pdos_of_each_direction(void)
{
    give(0x000, "80 05");
    accepted(0x1802, 1, 0xC0000285U);
    accepted(0x1A02, 1, 0x20040008U);
    accepted(0x1A02, 0, 1);
    accepted(0x1802, 1, 0x40000285U);
    trade(0x000, "01 05", 0x285, "00");
    give(0x000, "80 05");
    trade(0x000, "01 05", 0x285, "00"); /* due on entering, though not enabled anew */
    accepted(0x1802, 5, 20);
    expect_next(0x285, "00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (20 * MS), tumble_node_next_us(&at.node));
    accepted(0x1401, 1, 0x80000305U);
    accepted(0x1601, 1, 0x20050010U);
    accepted(0x1601, 0, 1);
    accepted(0x1401, 1, 0x305);
    trade(0x305, "11", 0x085, "10 82 11 01 00 00 00 00");
    map_receive();
    give(0x205, "34 12 FE FF FF FF"); /* the first is well, the second still short */
    expect_nothing();
    TEST_ASSERT_TRUE(tumble_pdo_any_fault(&at.node.pdos));
}

static void test_a_pdo_without_mapping_does_nothing(void)
{
    accepted(0x1800, 1, 0x40000185U);
    accepted(0x1400, 1, 0x205);
    expect_no_next();
    TEST_ASSERT_FALSE(hand(0x205, "00"));
}

static const around_t around_each = {fixture_operational, fixture_end};
