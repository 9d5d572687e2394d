/* The node as a whole: starting, whose frames are whose, order on the bus, the link's counters, random frames. */
#include "canopen_fixture.h"

static const tumble_pdo_setup_t receive_setup[] = {
    {.cob_id = 0x200, .type = 255, .count = 1, .map = {0x20050010U}},
    {.cob_id = 0x333, .type = 254, .count = 1, .map = {0x20040008U}},
};
static const tumble_pdo_setup_t transmit_setup[] = {
    {.cob_id = 0x40000180U, .type = 255, .count = 1, .event_ms = 10, .map = {0x20050010U}},
};
static const tumble_node_defaults_t full = {.receive = receive_setup,
                                            .transmit = transmit_setup,
                                            .receive_count = 2,
                                            .transmit_count = 1,
                                            .heartbeat_ms = 100,
                                            .consumers = {0x000201F4U},
                                            .on_error = TUMBLE_ON_ERROR_STAY};

static void set_up(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&full));
}

static void test_init_refuses_what_cannot_work(void)
{
    static const tumble_pdo_setup_t bad_setup[] = {{.cob_id = 0x200, .type = 0}};
    static const tumble_node_defaults_t bad_pdo = {.receive = bad_setup, .receive_count = 1};
    static const tumble_node_defaults_t bad_transmit = {.transmit = bad_setup, .transmit_count = 1};
    static const tumble_node_defaults_t too_many = {.receive = receive_setup, .receive_count = 3};
    static const tumble_node_defaults_t no_setup = {.transmit_count = 1};
    static const tumble_node_defaults_t twice = {.consumers = {0x000201F4U, 0x000201F4U}};
    static const tumble_node_config_t good = {.table = &fixture_table, .defaults = &full, .node = NODE};
    tumble_node_config_t bad[10];
    tumble_node_binding_t binding = {.port = &at.fake.port, .variables = &at.variables, .other = &at.other};
    tumble_node_binding_t no_port = binding;

    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        bad[i] = good;
    }
    bad[0].node = 0;
    bad[1].node = 128;
    bad[2].table = NULL;
    bad[3].defaults = NULL;
    bad[4].defaults = &bad_pdo;
    bad[5].defaults = &bad_transmit;
    bad[6].defaults = &twice;
    bad[7].defaults = &too_many;
    bad[8].node = 255;
    bad[9].defaults = &no_setup;
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_node_init(&at.node, &bad[i], &binding));
    }
    no_port.port = NULL;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_node_init(&at.node, &good, &no_port));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_node_init(&at.node, &good, NULL));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_node_init(&at.node, NULL, &binding));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_node_init(NULL, &good, &binding));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_node_init(&at.node, &good, &binding));
}

static void test_init_clears_whatever_the_memory_held(void)
{
    tumble_node_config_t config = {.table = &fixture_table, .defaults = &full};
    tumble_node_binding_t binding = {.port = &at.fake.port, .variables = &at.variables, .other = &at.other};
    static const uint8_t nodes[] = {1, 127};

    for (size_t i = 0; i < COUNT_OF(nodes); i++) {
        memset(&at.node, 0xA5, sizeof at.node);
        config.node = nodes[i];
        TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_node_init(&at.node, &config, &binding));
        TEST_ASSERT_EQUAL_UINT32(0, at.node.link.counters.sent);
        TEST_ASSERT_EQUAL_UINT32(0, at.node.link.counters.invalid);
        TEST_ASSERT_EQUAL_INT(TUMBLE_OK, at.node.link.last);
        TEST_ASSERT_EQUAL_UINT16(0, at.node.pdos.refused);
        TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_result(&at.node.client));
        step();
        expect((uint16_t)(0x700 + nodes[i]), "00");
        tumble_node_set_state(&at.node, TUMBLE_NMT_OPERATIONAL);
        step();
        expect((uint16_t)(0x180 + nodes[i]), "00 00");
        expect_nothing(); /* the PDOs that are not set up send nothing */
    }
}

static void test_defaults_complete_predefined_identifiers(void)
{
    boot();
    ask("40 00 14 01 00 00 00 00", "43 00 14 01 05 02 00 00");
    ask("40 01 14 01 00 00 00 00", "43 01 14 01 33 03 00 00");
    ask("40 00 18 01 00 00 00 00", "43 00 18 01 85 01 00 40");
    ask("40 14 10 00 00 00 00 00", "43 14 10 00 85 00 00 00");
    ask("40 29 10 01 00 00 00 00", "4F 29 10 01 01 00 00 00");
    ask("40 00 12 01 00 00 00 00", "43 00 12 01 05 06 00 00");
    ask("40 00 12 02 00 00 00 00", "43 00 12 02 85 05 00 00");
    ask("40 80 12 01 00 00 00 00", "43 80 12 01 00 06 00 80"); /* no server yet */
    ask("40 80 12 03 00 00 00 00", "4F 80 12 03 00 00 00 00");
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_sdo_client_read(&at.node.client, 2, 0x1000, 0));
    expect_next(0x602, "40 00 10 00 00 00 00 00");
    ask("40 80 12 01 00 00 00 00", "43 80 12 01 02 06 00 00");
    ask("40 80 12 02 00 00 00 00", "43 80 12 02 82 05 00 00");
}

static void test_without_events_and_hooks_everything_still_works(void)
{
    static const tumble_node_config_t plain = {.table = &fixture_table, .defaults = &full, .node = NODE};
    tumble_node_binding_t binding = {.port = &at.fake.port, .variables = &at.variables, .other = &at.other};

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_node_init(&at.node, &plain, &binding));
    boot();
    give(0x000, "01 05");
    give(0x082, "11 86 21 01 02 03 04 05");
    give(0x702, "05");
    give(0x205, "34 12");
    TEST_ASSERT_EQUAL_HEX16(0x1234, at.variables.u16);
    pass(500 * MS);
    give(0x000, "81 05");
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_PRE_OPERATIONAL, tumble_node_state(&at.node));
}

static void test_frames_of_others_are_handed_back(void)
{
    static const uint16_t not_mine[] = {0x080, 0x100, 0x183,     0x206, 0x585, 0x586, 0x604, 0x683,
                                        0x693, 0x705, 0x77F + 1, 0x7E4, 0x7FF, 0x700, 0x580, 0x600};

    boot_to_operational();
    for (size_t i = 0; i < COUNT_OF(not_mine); i++) {
        TEST_ASSERT_FALSE(hand(not_mine[i], "00 00 00 00 00 00 00 00"));
    }
    TEST_ASSERT_TRUE(hand(0x333, "07"));
    TEST_ASSERT_EQUAL_UINT8(7, at.variables.u8);
}

static void test_order_of_what_is_due_together(void)
{
    boot_to_operational();
    at.fake.from_firmware.count = 0;
    at.fake.now_us += 100 * MS;
    tumble_emcy_raise(&at.node.emcy, 0x1000, 0, NULL);
    (void)tumble_nmt_command(&at.node.nmt, 2, TUMBLE_NMT_START);
    (void)tumble_sdo_client_read(&at.node.client, 2, 0x1000, 0);
    (void)hand(0x605, "40 00 10 00 00 00 00 00");
    expect_next(0x000, "01 02");
    expect(0x705, "05");
    expect(0x085, "00 10 01 00 00 00 00 00");
    expect(0x585, "43 00 10 00 92 01 02 00");
    expect(0x602, "40 00 10 00 00 00 00 00");
    expect(0x185, "00 00");
    expect_nothing();
}

/* A port with room for one frame a step: everything due arrives in the end, once each. */
static void test_a_narrow_port_loses_nothing(void)
{
    unsigned seen[5] = {0};
    tumble_can_frame_t frame;

    boot_to_operational();
    at.fake.from_firmware.count = 0;
    tumble_emcy_raise(&at.node.emcy, 0x1000, 0, NULL);
    tumble_emcy_raise(&at.node.emcy, 0x1001, 0, NULL);
    (void)tumble_nmt_command(&at.node.nmt, 2, TUMBLE_NMT_START);
    (void)tumble_sdo_client_read(&at.node.client, 2, 0x1000, 0);
    (void)hand(0x605, "40 00 10 00 00 00 00 00");
    tumble_pdo_trigger(&at.node.pdos, 0);
    for (int i = 0; i < 6; i++) {
        at.fake.send_room = 1;
        step();
        TEST_ASSERT_EQUAL_UINT(1, at.fake.from_firmware.count);
        TEST_ASSERT_TRUE(fake_port_take(&at.fake, &frame));
        seen[0] += (frame.id == 0x085);
        seen[1] += (frame.id == 0x000);
        seen[2] += (frame.id == 0x585);
        seen[3] += (frame.id == 0x602);
        seen[4] += (frame.id == 0x185);
    }
    TEST_ASSERT_EQUAL_UINT(2, seen[0]);
    for (int i = 1; i < 5; i++) {
        TEST_ASSERT_EQUAL_UINT(1, seen[i]);
    }
    expect_no_next();
}

static void test_the_link_checks_what_the_port_gives(void)
{
    tumble_link_t *link = &at.node.link;
    tumble_can_frame_t long_frame = {.id = 1, .length = 9};
    tumble_can_frame_t high_frame = {.id = 0x800, .length = 8};
    tumble_can_frame_t good = {.id = 0x7FF, .length = 8};
    tumble_can_frame_t frame;

    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_EMPTY, tumble_link_receive(link, &frame));
    fake_port_give(&at.fake, &long_frame);
    fake_port_give(&at.fake, &high_frame);
    fake_port_give(&at.fake, &good);
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_FRAME, tumble_link_receive(link, &frame));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_FRAME, tumble_link_receive(link, &frame));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_link_receive(link, &frame));
    TEST_ASSERT_EQUAL_HEX16(0x7FF, frame.id);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, link->last);
    at.fake.receive_status = TUMBLE_E_PORT_DOWN;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_DOWN, tumble_link_receive(link, &frame));
    at.fake.receive_status = TUMBLE_E_PORT_BUSY; /* not in its list */
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_DOWN, tumble_link_receive(link, &frame));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_DOWN, link->last);
    at.fake.send_status = TUMBLE_E_PORT_EMPTY; /* likewise */
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_DOWN, tumble_link_send(link, &good));
    at.fake.send_status = TUMBLE_OK;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_link_send(link, &good));
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, link->last);
    at.fake.send_status = TUMBLE_E_PORT_BUSY;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_BUSY, tumble_link_send(link, &good));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_PORT_BUSY, link->last);
    TEST_ASSERT_EQUAL_UINT32(3, link->counters.down);
    TEST_ASSERT_EQUAL_UINT32(2, link->counters.invalid);
    TEST_ASSERT_EQUAL_UINT32(3, link->counters.received);
}

static void test_an_object_that_only_the_table_claims(void)
{
    boot();
    ask("40 10 10 01 00 00 00 00", "80 10 10 01 24 00 00 08");
    ask("23 10 10 01 73 61 76 65", "80 10 10 01 30 00 09 06");
}

static void test_counters_stop_at_their_end(void)
{
    uint32_t counter = UINT32_MAX - 1U;

    tumble_count(&counter);
    tumble_count(&counter);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, counter);
    at.node.server.dropped = UINT16_MAX;
    at.node.nmt.ignored = UINT16_MAX;
    at.node.pdos.too_short = UINT16_MAX;
    boot_to_operational();
    (void)hand(0x605, "00");
    (void)hand(0x205, "00");
    (void)hand(0x000, "00");
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, at.node.server.dropped);
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, at.node.nmt.ignored);
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, at.node.pdos.too_short);
}

/* Any frames in any order: the node stays in a state that exists, and whoever steps until next_us comes to rest. */
static void test_random_frames(void)
{
    static const uint16_t ids[] = {0x000, 0x082, 0x205, 0x333, 0x582, 0x605, 0x605, 0x605, 0x702, 0x703, 0x185};
    uint32_t seed = 7;

    boot();
    for (int i = 0; i < 300000; i++) {
        tumble_can_frame_t frame;

        seed = (seed * 1664525U) + 1013904223U;
        frame.id = (seed >> 29) ? ids[(seed >> 8) % COUNT_OF(ids)] : (uint16_t)((seed >> 8) & 0x7FFU);
        frame.length = (uint8_t)((seed >> 20) & 15U);
        frame.length = (frame.length > 8U) ? 8U : frame.length;
        for (int j = 0; j < 8; j++) {
            seed = (seed * 1664525U) + 1013904223U;
            frame.data[j] = (uint8_t)(seed >> 24);
        }
        if ((frame.id == 0x605) && ((seed & 7U) != 0U)) {
            const tumble_entry_t *entry = &fixture_entries[(seed >> 3) % fixture_table.count];

            tumble_put_u16(&frame.data[1], entry->index);
            frame.data[3] = entry->subindex;
        }
        if ((seed & 0x1F00U) == 0U) {
            (void)tumble_sdo_client_read(&at.node.client, 2, 0x1000, 0);
        }
        at.fake.send_room = (seed >> 16) & 3U;
        (void)tumble_node_receive(&at.node, &frame, at.fake.now_us);
        pass((seed >> 18) & 0x3FFFU);
        switch (tumble_node_state(&at.node)) {
        case TUMBLE_NMT_INITIALISING:
        case TUMBLE_NMT_STOPPED:
        case TUMBLE_NMT_OPERATIONAL:
        case TUMBLE_NMT_PRE_OPERATIONAL:
            break;
        default:
            TEST_FAIL_MESSAGE("no such state");
        }
        at.fake.send_room = SIZE_MAX;
        step();
        step();
        TEST_ASSERT_TRUE(tumble_node_next_us(&at.node) > at.fake.now_us);
        at.fake.from_firmware.count = 0;
    }
}

static const around_t around_each = {set_up, fixture_end};
