/* The table always stops: the firmware with the simulated drive on the simulated bus, and somebody who interferes. */
#include "sim_guest.h"

#include <math.h>

/* At rest within so many seconds of now, by the table itself, and for long after. */
static void assert_stops_within(double seconds)
{
    pass((uint64_t)(seconds * 1e6));
    TEST_ASSERT_TRUE(bench_world_is_at_rest(&world));
    const double rest_deg = table_deg();
    pass(10U * SECOND);
    TEST_ASSERT_TRUE(fabs(least_deg - rest_deg) < 0.5 && fabs(most_deg - rest_deg) < 0.5);
}

static void start_homing(const char *lines)
{
    begin_homing(lines, &LISTENER, 3U * SECOND);
    TEST_ASSERT_FALSE(bench_world_is_at_rest(&world));
}

/* Homing. */

static void test_homing_is_bounded(void)
{
    static const char *const LINES[] = {
        WAITS "fault = homing_endless time=0\n",
        WAITS "fault = homing_endless time=0\ndrive.wrap_counts = 360000\n",
        WAITS "fault = homing_endless time=0\ndrive.sign = -1\n",
    };
    const double to_stop_deg = 45.0 * 0.2 + 45.0 * 45.0 / (2.0 * 180.0); /* a report late, and the brake */
    for (size_t i = 0; i < COUNT_OF(LINES); i++) {
        begin_homing(LINES[i], &NOBODY, 60U * SECOND);
        TEST_ASSERT_TRUE(bench_world_is_at_rest(&world));
        TEST_ASSERT_TRUE(most_deg - least_deg > 700.0);
        TEST_ASSERT_TRUE(most_deg - least_deg < 790.0 + to_stop_deg);
        TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT, progress().stand);
        TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_HOMING, progress().stand_fault);
    }
}

/* A drive that gives up by itself had the cable's span and a turn for it, and no more. */
static void test_a_homing_error_is_within_the_bound(void)
{
    begin_homing(WAITS "fault = homing_fails time=0\n", &NOBODY, 60U * SECOND);
    TEST_ASSERT_TRUE(most_deg - least_deg <= 790.0);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_HOMING, progress().stand_fault);
}

/* What a stop depends on. */

static void test_what_a_stop_depends_on_is_held_between_runs(void)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t value;
    } WRITES[] = {{0x1800, 1, 0x80000202}, {0x1400, 1, 0x80000182}, {0x1016, 1, 0}, {0x1016, 2, 0}};
    start_homing(WAITS "fault = homing_endless time=0\n");
    ASSERT_STATUS(TUMBLE_OK, tumble_service_unlock(&world.navcomp, TUMBLE_SERVICE_KEY)); /* nor does this help */
    for (size_t i = 0; i < COUNT_OF(WRITES); i++) {
        write_u32(1, WRITES[i].index, WRITES[i].subindex, WRITES[i].value);
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, answer);
    }
    (void)command(TUMBLE_COMMAND_ABORT, 0);
    assert_stops_within(3.0);
    TEST_ASSERT_EQUAL_UINT32(0, counters().stop.rungs[1]);
}

/* Somebody has taken the drive's own receive PDO away: it is told by SDO. */
static void test_a_drive_that_hears_no_process_data(void)
{
    start_turning(WAITS);
    write_u32(2, 0x1400, 1, 0x80000202);
    (void)command(TUMBLE_COMMAND_ABORT, 0);
    assert_stops_within(3.0);
    TEST_ASSERT_EQUAL_UINT32(1, counters().stop.rungs[1]);
    TEST_ASSERT_EQUAL_UINT32(0, counters().stop.rungs[2]);
}

/* Neither process data nor SDO reach it: it is taken out of operation; and the reason says what that was. */
static void test_a_drive_that_hears_nmt_alone(void)
{
    begin("", &NOBODY);
    run_to_a_move();
    sim_bus_fault_t lost = {.kind = 0, .match = 0x202, .mask = 0x3FF, .count = UINT32_MAX, .probability = 1.0};
    sim_random_open(&lost.random, 1, SIM_CAUSE_BUS_FAULT, 0);
    sim_bus_begin_fault(&world.bus, 5, &lost); /* 202h and 602h */
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_ABORT, 0));
    const uint64_t told_us = world.clock.now_us;
    while (!bench_world_is_at_rest(&world)) {
        TEST_ASSERT_TRUE(bench_world_advance(&world));
    }
    TEST_ASSERT_TRUE(world.clock.now_us - told_us < 3U * SECOND);
    pass(5U * SECOND);
    TEST_ASSERT_EQUAL_UINT32(1, counters().stop.rungs[2]);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STATE_ABORT, progress().run.state);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_STOP_NOT_CONFIRMED, progress().run.reason);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_STOP, progress().stand_fault);
}

/* NMT does not reach it either: our silence stops it. */
static void test_a_drive_that_hears_nothing_but_our_heartbeat(void)
{
    start_turning(WAITS);
    sim_bus_fault_t lost = {.kind = 0, .match = 0, .mask = 0x7FF, .count = UINT32_MAX, .probability = 1.0};
    sim_random_open(&lost.random, 1, SIM_CAUSE_BUS_FAULT, 0);
    sim_bus_begin_fault(&world.bus, 4, &lost); /* 000h */
    lost.match = 0x202;
    lost.mask = 0x3FF; /* and 602h */
    sim_bus_begin_fault(&world.bus, 5, &lost);
    (void)command(TUMBLE_COMMAND_ABORT, 0);
    assert_stops_within(3.0);
    TEST_ASSERT_EQUAL_UINT32(1, counters().stop.rungs[3]);
}

/* Supervision. */

/* A drive whose heartbeat nobody watches would be there unheard. */
static void test_a_start_without_supervision_is_refused_with_its_reason(void)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint8_t size;
        uint32_t value;
    } WRITES[] = {{0x1016, 1, 4, 0}, {0x1016, 2, 4, 0}, {0x1016, 1, 4, 0x0002FFFF}, {0x1017, 0, 2, 500}};
    for (size_t i = 0; i < COUNT_OF(WRITES); i++) {
        begin(WAITS "fault = drive_silent time=0\n", &LISTENER);
        pass(SECOND);
        ASSERT_STATUS(TUMBLE_OK, tumble_service_unlock(&world.navcomp, TUMBLE_SERVICE_KEY));
        write_bytes(1, WRITES[i].index, WRITES[i].subindex, WRITES[i].value, WRITES[i].size);
        TEST_ASSERT_EQUAL_HEX32(0, answer); /* there is no drive yet */
        ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_START, 0));
        pass(100000);
        TEST_ASSERT_EQUAL_INT(TUMBLE_STATE_FAULT, progress().run.state);
        TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_SUPERVISION, progress().run.reason);
        ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_ABORT, 0));
        ASSERT_STATUS(TUMBLE_E_STATE, command(TUMBLE_COMMAND_HOME_AXIS, 0));
    }
}

/* Position. */

static void report(int32_t counts)
{
    uint8_t data[6];
    tumble_put_u16(data, 0x1637);
    tumble_put_i32(&data[2], counts);
    guest_send(0x182, 6, data);
    pass(1000);
}

/* 120 degrees apart, they would shift the count by a turn: it goes on with a new homing, and never beyond the cable. */
static void test_two_forged_positions_lose_no_turn(void)
{
    static const tumble_state_t STATES[] = {TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_STATE_AVERAGE, TUMBLE_STATE_MOVE};
    for (size_t i = 0; i < COUNT_OF(STATES); i++) {
        begin("drive.wrap_counts = 360000\noperator.mount_s = 20\noperator.mends = 3\noperator.mend_s = 2\n", &NOBODY);
        while (world.progress.index != 9U || world.progress.state != STATES[i]) {
            TEST_ASSERT_TRUE(bench_world_advance(&world));
        }
        pass(300000);
        report(120000);
        report(240000);
        double low_deg = 0.0;
        double high_deg = 0.0;
        while (bench_world_advance(&world)) {
            const double deg = table_deg();
            low_deg = (deg < low_deg) ? deg : low_deg;
            high_deg = (deg > high_deg) ? deg : high_deg;
        }
        TEST_ASSERT_TRUE(has_passed()); /* mended by the operator, homed again */
        TEST_ASSERT_TRUE(low_deg >= -30.0 && high_deg <= 400.0);
        TEST_ASSERT_TRUE(counters().procedure.homings >= 2U);
    }
}

static void test_unmended_the_reason_is_a_slip(void)
{
    begin("drive.wrap_counts = 360000\noperator.mount_s = 20\n", &NOBODY);
    while (world.progress.index != 9U || world.progress.state != TUMBLE_STATE_WAIT_MOUNTING) {
        TEST_ASSERT_TRUE(bench_world_advance(&world));
    }
    report(120000);
    report(240000);
    bench_world_run(&world);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STATE_FAULT, world.progress.state);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_SLIP, world.progress.reason);
}

/* A foreign command, a second computer. */

static void test_a_foreign_set_point_is_noticed_and_stopped(void)
{
    static const uint8_t ENABLE[] = {0x0F, 0x00, 0x00, 0xF9, 0x15, 0x00}; /* 1440 degrees */
    static const uint8_t GO[] = {0x1F, 0x00, 0x00, 0xF9, 0x15, 0x00};
    begin_homing(WAITS "drive.software_limits = no\n", &NOBODY, 20U * SECOND);
    TEST_ASSERT_EQUAL_UINT8(0, progress().limited);
    guest_send(0x202, 6, ENABLE);
    guest_send(0x202, 6, GO);
    pass(10U * SECOND);
    TEST_ASSERT_TRUE(bench_world_is_at_rest(&world));
    TEST_ASSERT_TRUE(most_deg < 30.0);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT, progress().stand);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_FOREIGN, progress().stand_fault);
    TEST_ASSERT_EQUAL_UINT32(2, counters().events.foreign);
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_CLEAR_FAULT, 0));
    pass(2U * SECOND);
    ASSERT_STATUS(TUMBLE_E_STATE, command(TUMBLE_COMMAND_TURN_AXIS, 10.0)); /* its position is unknown */
}

static void test_a_second_computer_is_noticed(void)
{
    static const uint8_t OPERATIONAL[] = {5};
    begin("", &NOBODY);
    while (world.progress.state != TUMBLE_STATE_AVERAGE) {
        TEST_ASSERT_TRUE(bench_world_advance(&world));
    }
    guest_send(0x701, 1, OPERATIONAL);
    bench_world_run(&world);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STATE_FAULT, world.progress.state);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_FOREIGN_COMMAND, world.progress.reason);
    TEST_ASSERT_EQUAL_UINT32(1, counters().events.foreign);
    TEST_ASSERT_EQUAL_HEX32(0x07010000U | TUMBLE_EMCY_FOREIGN, world.navcomp.node.emcy.history[0]);
}

/* The drive's own limits hold where a foreign set-point would go beyond the cable. */
static void test_the_drive_keeps_to_the_cables_limits(void)
{
    static const uint8_t ENABLE[] = {0x0F, 0x00, 0x00, 0xF9, 0x15, 0x00};
    static const uint8_t GO[] = {0x1F, 0x00, 0x00, 0xF9, 0x15, 0x00};
    begin_homing(WAITS, &NOBODY, 20U * SECOND);
    TEST_ASSERT_EQUAL_UINT8(1, progress().limited);
    TEST_ASSERT_EQUAL_INT32(-30000, world.drive.objects.software_position_limit_min_position_limit);
    TEST_ASSERT_EQUAL_INT32(400000, world.drive.objects.software_position_limit_max_position_limit);
    sim_bus_set_down(&world.bus, BENCH_BUS_NAVCOMP, true); /* nobody notices */
    write_u32(2, 0x1016, 1, 0);
    pass(SECOND);
    guest_send(0x202, 6, ENABLE);
    guest_send(0x202, 6, GO);
    pass(20U * SECOND);
    TEST_ASSERT_TRUE(most_deg <= 400.5);
}

static void test_a_reset_of_the_node_in_a_run_leaves_its_reason(void)
{
    static const uint8_t RESET[] = {TUMBLE_NMT_RESET_NODE, 1};
    begin(WAITS, &NOBODY);
    pass(SECOND);
    guest_send(0x000, 2, RESET);
    pass(100000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_NONE, progress().run.reason); /* there was no run */
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_START, 0));
    pass(4U * SECOND);
    guest_send(0x000, 2, RESET);
    pass(100000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STATE_IDLE, progress().run.state);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_COMMAND, progress().run.reason);
}
