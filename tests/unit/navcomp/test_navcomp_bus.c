/* The navigation computer as a node: configuration, NMT duties, a port with moods, frames that make no sense. */
#include "navcomp_bench.h"

static tumble_status_t init(void)
{
    return tumble_navcomp_init(&bench.navcomp, &bench.config);
}

static void give(uint16_t id, uint8_t length, const uint8_t *data)
{
    const tumble_can_frame_t frame = fake_frame(id, length, data);
    fake_port_give(&bench.fake, &frame);
}

/* All that was sent, oldest first, in `sent`; returns how many. */
static tumble_can_frame_t sent[FAKE_PORT_QUEUE];

static size_t take_sent(void)
{
    size_t count = 0;
    while (fake_port_take(&bench.fake, &sent[count])) {
        count++;
    }
    return count;
}

static size_t count_sent(size_t total, uint16_t id, int first_byte)
{
    size_t found = 0;
    for (size_t i = 0; i < total; i++) {
        const bool same = (sent[i].id == id) && ((first_byte < 0) || (sent[i].data[0] == first_byte));
        found += same ? 1U : 0U;
    }
    return found;
}

static void test_init_refuses_what_it_cannot_work_with(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, tumble_navcomp_init(NULL, &bench.config));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, NULL));
    const tumble_navcomp_config_t good = bench.config;
#define REFUSED(change)                                                                                                \
    do {                                                                                                               \
        bench.config = good;                                                                                           \
        bench.config.change;                                                                                           \
        TEST_ASSERT_EQUAL_MESSAGE(TUMBLE_E_ARGUMENT, init(), #change);                                                 \
    } while (false)
    REFUSED(port = NULL);
    REFUSED(procedure = NULL);
    REFUSED(stand = NULL);
    REFUSED(stand_memory = NULL);
    REFUSED(stand_bytes = 0);
    REFUSED(stand_bytes--);
    REFUSED(heartbeat_ms = 0);
    REFUSED(heartbeat_timeout_ms = 0);
    REFUSED(node = 0);
    REFUSED(node = 128);
    REFUSED(stand_node = 0);
    REFUSED(stand_node = 128);
    REFUSED(block_node = 0);
    REFUSED(block_node = 128);
    REFUSED(stand_node = 1);
    REFUSED(block_node = 1);
    REFUSED(block_node = 2);
    REFUSED(block_period_us = 0);
#undef REFUSED
    tumble_drive_profile_t profile = scripted_drive_profile;
    profile.counts_per_revolution = 0.0;
    bench.config = good;
    bench.config.stand_profile = &profile;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, init());
}

static void test_nodes_may_swap_their_numbers(void)
{
    bench.config.stand_node = 3;
    bench.config.block_node = 2;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench.config.node = 127;
    bench.config.block_node = 1;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench.config.node = 1;
    bench.config.block_node = 127;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
}

static void test_nothing_is_sent_before_the_first_step(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    TEST_ASSERT_EQUAL_size_t(0, take_sent());
    TEST_ASSERT_TRUE(tumble_navcomp_next_deadline_us(&bench.navcomp) <= bench.fake.now_us);
}

static void test_boot_up_then_heartbeats_as_operational(void)
{
    fake_port_init(&bench.fake); /* alone on the bus */
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench_settle(&bench);
    TEST_ASSERT_EQUAL_size_t(3, take_sent());
    TEST_ASSERT_EQUAL_HEX16(0x701, sent[0].id);
    TEST_ASSERT_EQUAL_UINT8(1, sent[0].length);
    TEST_ASSERT_EQUAL_HEX8(0, sent[0].data[0]);
    TEST_ASSERT_EQUAL_HEX16(0x181, sent[1].id); /* the states of calibration and level, on becoming Operational; */
    TEST_ASSERT_EQUAL_HEX16(0x6C1, sent[2].id); /* nothing to the drive, whose mapping nobody knows yet */
    for (uint64_t beat = 1; beat <= 20U; beat++) {
        TEST_ASSERT_EQUAL_UINT64(beat * 100000U, tumble_navcomp_next_deadline_us(&bench.navcomp));
        bench.fake.now_us = beat * 100000U;
        bench_settle(&bench);
        const size_t count = take_sent();
        TEST_ASSERT_EQUAL_size_t(1, count_sent(count, 0x701, TUMBLE_NMT_OPERATIONAL));
    }
}

static void test_the_heartbeat_time_comes_from_the_configuration(void)
{
    fake_port_init(&bench.fake);
    bench.config.heartbeat_ms = 40;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench_settle(&bench);
    TEST_ASSERT_EQUAL_UINT64(40000, tumble_navcomp_next_deadline_us(&bench.navcomp));
}

static void test_drive_and_block_are_started_wherever_they_are_found(void)
{
    const uint8_t states[] = {TUMBLE_NMT_INITIALISING, TUMBLE_NMT_PRE_OPERATIONAL, TUMBLE_NMT_STOPPED};
    for (size_t i = 0; i < sizeof states; i++) {
        bench_init(&bench);
        fake_port_init(&bench.fake);
        TEST_ASSERT_EQUAL(TUMBLE_OK, init());
        bench_settle(&bench);
        (void)take_sent();
        give(0x703, 1, &states[i]);
        bench_settle(&bench);
        const size_t count = take_sent();
        TEST_ASSERT_EQUAL_size_t(1, count_sent(count, TUMBLE_NMT_ID, TUMBLE_NMT_START));
        TEST_ASSERT_EQUAL_UINT8(3, sent[(sent[0].id == TUMBLE_NMT_ID) ? 0 : 1].data[1]);
    }
}

/* A block that does not obey is told again, but not at every step. */
static void test_a_block_that_does_not_start_is_told_again_now_and_then(void)
{
    const uint8_t state = TUMBLE_NMT_PRE_OPERATIONAL;
    fake_port_init(&bench.fake);
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    for (int ms = 0; ms <= 2050; ms += 50) {
        bench.fake.now_us = (uint64_t)ms * 1000U;
        if ((ms % 100) == 0) {
            give(0x703, 1, &state);
        }
        bench_settle(&bench);
    }
    TEST_ASSERT_EQUAL_size_t(5, count_sent(take_sent(), TUMBLE_NMT_ID, TUMBLE_NMT_START));
    TEST_ASSERT_EQUAL_UINT32(5, bench_counters(&bench).events.starts);
}

/* The node notices it at the end of a step, behind the procedure. */
static void test_a_lost_heartbeat_is_followed_up_at_once(void)
{
    power_on_for(1.0);
    bench.block.dead = true;
    while (bench_counters(&bench).events.heartbeats_lost == 0U) {
        TEST_ASSERT_TRUE(bench.fake.now_us < 3000000U);
        bench_play(&bench);
        bench.fake.now_us += 1000U;
        tumble_navcomp_step(&bench.navcomp);
    }
    TEST_ASSERT_EQUAL_UINT64(0, tumble_navcomp_next_deadline_us(&bench.navcomp));
}

/* Whoever tells the NMT master to leave Operational: it goes back, or the axis could no longer be stopped. */
static void test_it_stays_operational(void)
{
    const uint8_t commands[] = {TUMBLE_NMT_STOP, TUMBLE_NMT_ENTER_PRE_OPERATIONAL};
    power_on_for(0.5);
    for (size_t i = 0; i < sizeof commands; i++) {
        give(TUMBLE_NMT_ID, 2, (const uint8_t[]){commands[i], 1});
        bench_event(&bench);
        TEST_ASSERT_EQUAL(TUMBLE_NMT_OPERATIONAL, tumble_node_state(&bench.navcomp.node));
    }
}

static void test_a_reset_by_nmt_stops_the_table_and_brings_the_axis_up_again(void)
{
    const uint8_t commands[] = {TUMBLE_NMT_RESET_NODE, TUMBLE_NMT_RESET_COMMUNICATION};
    for (size_t i = 0; i < sizeof commands; i++) {
        bench_init(&bench);
        bench_start(&bench);
        TEST_ASSERT_EQUAL(TUMBLE_STATE_MOVE, bench_run(&bench, TUMBLE_STATE_MOVE, 60.0));
        bench_pass(&bench, 0.05);
        TEST_ASSERT_TRUE(scripted_drive_moves(&bench.drive));
        give(TUMBLE_NMT_ID, 2, (const uint8_t[]){commands[i], 1});
        bench_event(&bench);
        TEST_ASSERT_FALSE(scripted_drive_moves(&bench.drive));
        TEST_ASSERT_EQUAL_HEX16(TUMBLE_402_CONTROL_QUICK_STOP, bench.drive.control); /* and it may still brake */
        const bool node = commands[i] == TUMBLE_NMT_RESET_NODE;
        TEST_ASSERT_EQUAL(node ? TUMBLE_STATE_IDLE : TUMBLE_STATE_ABORT, bench_progress(&bench).run.state);
        bench_pass(&bench, 2.0);
        TEST_ASSERT_EQUAL(TUMBLE_STAND_READY, bench_progress(&bench).stand);
        TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
        TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    }
}

static void test_a_port_without_room_is_asked_again_later(void)
{
    bench.fake.send_room = 0;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL_size_t(0, take_sent());
    TEST_ASSERT_EQUAL_UINT64(1000, tumble_navcomp_next_deadline_us(&bench.navcomp)); /* not at once: it would spin */
    TEST_ASSERT_TRUE(bench_counters(&bench).link.busy > 0U);
    bench.fake.send_room = SIZE_MAX;
    bench.fake.now_us = 1000;
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_TRUE(take_sent() > 0U);
}

/* Room for one frame at every second event, all the way through a run: slower, but right. */
static void test_a_port_that_is_often_busy_loses_nothing(void)
{
    bench_start(&bench);
    uint32_t event = 0;
    while ((bench_progress(&bench).run.state != TUMBLE_STATE_DONE) && (event < 1000000U)) {
        bench.fake.send_room = ((event++ % 2U) == 0U) ? 1U : 0U;
        bench_event(&bench);
        TEST_ASSERT_TRUE(bench_progress(&bench).run.state != TUMBLE_STATE_FAULT);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_progress(&bench).run.state);
    TEST_ASSERT_TRUE(bench_counters(&bench).link.busy > 10U);
}

static void test_a_port_that_lies_counts_as_down(void)
{
    const tumble_status_t lies[] = {TUMBLE_E_RANK, TUMBLE_STATUS_COUNT, TUMBLE_E_PORT_EMPTY};
    for (size_t i = 0; i < (sizeof lies / sizeof lies[0]); i++) {
        bench_init(&bench);
        bench_start(&bench);
        bench.fake.send_status = lies[i];
        for (int step = 0; step < 5; step++) {
            tumble_navcomp_step(&bench.navcomp);
            bench.fake.now_us += 1000U;
        }
        TEST_ASSERT_TRUE(bench_counters(&bench).link.down > 0U);
        TEST_ASSERT_EQUAL(TUMBLE_REASON_BUS, bench_progress(&bench).run.reason);
    }
}

static void test_a_clock_that_goes_back_does_no_harm(void)
{
    power_on_for(1.0);
    const uint64_t now_us = bench.fake.now_us;
    bench.fake.now_us = 0;
    tumble_navcomp_step(&bench.navcomp);
    bench.fake.now_us = now_us;
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL(TUMBLE_STAND_READY, bench_progress(&bench).stand);
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).events.heartbeats_lost);
}

static void test_malformed_and_foreign_frames_are_counted(void)
{
    power_on_for(1.0);
    tumble_can_frame_t frame = {.id = 0x800, .length = 1};
    fake_port_give(&bench.fake, &frame);
    frame = (tumble_can_frame_t){.id = 0x123, .length = 9};
    fake_port_give(&bench.fake, &frame);
    give(0x123, 3, (const uint8_t[]){1, 2, 3});
    give(0x684, 8, (const uint8_t[8]){0});
    bench_event(&bench);
    const tumble_navcomp_counters_t counters = bench_counters(&bench);
    TEST_ASSERT_EQUAL_UINT32(2, counters.link.invalid);
    TEST_ASSERT_EQUAL_UINT32(2, counters.events.frames_ignored);
}

/* A set-point that we did not send, by SDO: the axis is told to stop. What only reads, or writes what moves nothing, is
 * nothing to us. */
static void test_a_set_point_of_a_stranger_by_sdo_is_foreign(void)
{
    static const struct {
        uint8_t data[8];
        bool foreign;
    } requests[] = {
        {{0x23, 0x7A, 0x60, 0x00, 1, 2, 3, 4}, true},  {{0x2B, 0x40, 0x60, 0x00, 0x1F, 0, 0, 0}, true},
        {{0x40, 0x7A, 0x60, 0x00, 0, 0, 0, 0}, false}, {{0x40, 0x40, 0x60, 0x00, 0, 0, 0, 0}, false},
        {{0x23, 0x65, 0x60, 0x00, 1, 2, 3, 4}, false}, {{0x80, 0x7A, 0x60, 0x00, 0, 0, 0, 0}, false},
        {{0x2F, 0x60, 0x60, 0x00, 6, 0, 0, 0}, true},  {{0x21, 0x7A, 0x60, 0x00, 4, 0, 0, 0}, true}, /* in segments */
        {{0xC6, 0x7A, 0x60, 0x00, 4, 0, 0, 0}, true},  {{0xC0, 0x40, 0x60, 0x00, 0, 0, 0, 0}, true}, /* in blocks */
        {{0xC1, 0x40, 0x60, 0x00, 0, 0, 0, 0}, false}, {{0xA4, 0x7A, 0x60, 0x00, 4, 0, 0, 0}, false},
    };
    for (size_t i = 0; i < (sizeof requests / sizeof requests[0]); i++) {
        power_on_for(1.0);
        give(0x602, 8, requests[i].data);
        bench_event(&bench);
        bench_pass(&bench, 0.1);
        TEST_ASSERT_EQUAL_UINT32(requests[i].foreign ? 1U : 0U, bench_counters(&bench).events.foreign);
        TEST_ASSERT_EQUAL(requests[i].foreign ? TUMBLE_STAND_FAULT : TUMBLE_STAND_READY, bench_progress(&bench).stand);
        TEST_ASSERT_EQUAL_UINT8(requests[i].foreign ? TUMBLE_STAND_FAULT_FOREIGN : TUMBLE_STAND_FAULT_NONE,
                                bench_progress(&bench).stand_fault);
    }
}

/* Noise on every identifier, valid frames in between: nothing crashes, everything received is counted, and afterwards a
 * calibration still works. */
static void test_garbage_does_no_lasting_harm(void)
{
    uint32_t seed = 12345;
    bench_power_on(&bench);
    for (int i = 0; i < 300000; i++) {
        tumble_can_frame_t frame;
        seed = (seed * 1664525U) + 1013904223U;
        frame.id = (uint16_t)((seed >> 16U) % 0x900U);
        seed = (seed * 1664525U) + 1013904223U;
        frame.length = (uint8_t)((seed >> 16U) % 11U);
        for (int byte = 0; byte < TUMBLE_CAN_MAX_BYTES; byte++) {
            seed = (seed * 1664525U) + 1013904223U;
            frame.data[byte] = (uint8_t)(seed >> 24U);
        }
        fake_port_give(&bench.fake, &frame);
        if ((i % 50) == 0) {
            bench_settle(&bench);
            (void)take_sent();
            bench.fake.now_us += 1000U;
        }
    }
    fake_port_init(&bench.fake);
    bench.fake.now_us = bench.navcomp.stepped_us;
    scripted_drive_init(&bench.drive, &bench.fake);
    scripted_block_init(&bench.block, &bench.fake, &tumble_schedule_paper.mountings[0]);
    TEST_ASSERT_TRUE(bench_counters(&bench).link.invalid > 1000U);
    TEST_ASSERT_TRUE(bench_counters(&bench).events.frames_ignored > 1000U);
    give(TUMBLE_NMT_ID, 2, (const uint8_t[]){TUMBLE_NMT_RESET_NODE, 1});
    bench_pass(&bench, 2.0);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
}

/* A flood does not keep a step busy: it takes its share and says that there is more. */
static void test_a_step_takes_a_bounded_number_of_frames(void)
{
    bench_power_on(&bench);
    for (int i = 0; i < 200; i++) {
        give(0x555, 0, NULL);
    }
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_NAVCOMP_MAX_FRAMES_PER_STEP, bench_counters(&bench).link.received);
    TEST_ASSERT_TRUE(tumble_navcomp_next_deadline_us(&bench.navcomp) <= bench.fake.now_us);
    bench_settle(&bench);
    TEST_ASSERT_EQUAL_UINT32(202, bench_counters(&bench).link.received); /* with two boot-up messages */
}

static void test_commands_out_of_place_are_refused_and_counted(void)
{
    bench_power_on(&bench);
    const struct {
        tumble_command_t command;
        tumble_status_t status;
    } expected[] = {
        {TUMBLE_COMMAND_NONE, TUMBLE_OK},
        {TUMBLE_COMMAND_ABORT, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_CONFIRM_MOUNTING, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_CONFIRM_ANGLE, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_REPEAT_POSITION, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_REPEAT_MOUNTING, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_RESUME, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_CLEAR_FAULT, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_ACCEPT, TUMBLE_E_STATE}, /* without a keeper never */
        {TUMBLE_COMMAND_DISCARD, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_ROLLBACK, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_HOME_AXIS, TUMBLE_E_STATE}, /* the stand is not there yet */
        {TUMBLE_COMMAND_TURN_AXIS, TUMBLE_E_STATE},
        {TUMBLE_COMMAND_COUNT, TUMBLE_E_ARGUMENT},
        {(tumble_command_t)200, TUMBLE_E_ARGUMENT},
    };
    const size_t count = sizeof expected / sizeof expected[0];
    for (size_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL(expected[i].status, tumble_navcomp_command(&bench.navcomp, expected[i].command, 0));
    }
    TEST_ASSERT_EQUAL_UINT32(count - 1U, bench_counters(&bench).events.commands_refused);
    TEST_ASSERT_EQUAL(TUMBLE_E_STATE, tumble_navcomp_confirm_angle(&bench.navcomp, 0.0));
    double angle_deg = 0.0;
    TEST_ASSERT_FALSE(tumble_navcomp_request(&bench.navcomp, &angle_deg));
}

static void test_a_command_is_due_at_once(void)
{
    power_on_for(1.0);
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_START, 0));
    TEST_ASSERT_TRUE(tumble_navcomp_next_deadline_us(&bench.navcomp) <= bench.fake.now_us);
}

static void test_names_of_commands(void)
{
    TEST_ASSERT_EQUAL_STRING("TUMBLE_COMMAND_START", tumble_command_name(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_COMMAND_UNKNOWN", tumble_command_name(TUMBLE_COMMAND_COUNT));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_COMMAND_UNKNOWN", tumble_command_name((tumble_command_t)99));
}

static const around_t around_each = {bench_begin, NULL};
