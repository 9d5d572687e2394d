/* Network management: states and the commands that change them, boot-up, resets, master commands. */
#include "canopen_fixture.h"

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

/* It tells the node that the state has changed; no other step does. */
static void test_one_step_leaves_initialising(void)
{
    TEST_ASSERT_TRUE(tumble_nmt_step(&at.node.nmt, &at.node.link, at.fake.now_us));
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_FALSE(tumble_nmt_step(&at.node.nmt, &at.node.link, at.fake.now_us));
    }
}

static void test_commands_change_the_state(void)
{
    static const struct {
        const char *frame;
        tumble_nmt_state_t wanted;
    } cases[] = {
        {"01 05", TUMBLE_NMT_OPERATIONAL},
        {"80 05", TUMBLE_NMT_PRE_OPERATIONAL},
        {"02 05", TUMBLE_NMT_STOPPED},
        {"01 00", TUMBLE_NMT_OPERATIONAL},
        {"02 04", TUMBLE_NMT_OPERATIONAL},
        {"80 00", TUMBLE_NMT_PRE_OPERATIONAL},
        {"03 05", TUMBLE_NMT_PRE_OPERATIONAL},    /* unknown */
        {"01", TUMBLE_NMT_PRE_OPERATIONAL},       /* too short */
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
    expect_next(0x000, "82 00");
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
    expect_after(100 * MS, 0x000, "01 02");
    expect_nothing();
    at.fake.send_room = 2;
    expect_next(0x000, "01 03");
    expect(0x705, "7F");
    expect_nothing();
}

static void test_when_the_next_step_is_due(void)
{
    boot();
    ask("2B 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
    give(0x703, "05");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + (500 * MS), tumble_node_next_us(&at.node));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_nmt_command(&at.node.nmt, 3, TUMBLE_NMT_START));
    TEST_ASSERT_TRUE(tumble_node_next_us(&at.node) <= at.fake.now_us);
}

/* The service by itself, as it is after init, whatever the memory held before. */
static void test_nmt_alone(void)
{
    tumble_nmt_t nmt;
    tumble_can_frame_t frame = frame_of(0x000, "07 05");

    memset(&nmt, 0xA5, sizeof nmt);
    tumble_nmt_init(&nmt, NODE, 0);
    TEST_ASSERT_EQUAL_UINT8(0, tumble_nmt_lost(&nmt, TUMBLE_NEVER - 1U));
    TEST_ASSERT_FALSE(tumble_nmt_any_lost(&nmt));
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_UNKNOWN, tumble_nmt_state_of(&nmt, 0));
    TEST_ASSERT_EQUAL_UINT8(0, tumble_nmt_receive(&nmt, &frame));
    frame = frame_of(0x000, "82 00");
    TEST_ASSERT_EQUAL_UINT8(130, tumble_nmt_receive(&nmt, &frame));
    frame = frame_of(0x000, "82 04");
    TEST_ASSERT_EQUAL_UINT8(0, tumble_nmt_receive(&nmt, &frame));
}

static const around_t around_each = {fixture_beating, fixture_end};
