/* A calibration whose table a motor controller with registers turns: played in virtual time, from power-on to the
 * coefficients. */
#include "navcomp_bench.h"
#include "played_positioner.h"

static played_positioner_t controller;
static tumble_positioner_profile_t registers;
static tumble_positioner_t axis;

static void set_up(void)
{
    bench_init(&bench);
    played_positioner_init(&controller);
    registers = played_positioner_profile(&controller);
    bench.config.stand = &tumble_positioner_kind;
    bench.config.stand_profile = &registers;
    bench.config.stand_memory = &axis;
    bench.config.stand_bytes = sizeof axis;
    bench.config.stand_node = 0;
    bench.drive.dead = true;
    fake_port_init(&bench.fake);
    scripted_block_init(&bench.block, &bench.fake, &tumble_schedule_paper.mountings[0]);
    bench_power_on(&bench);
}

static void tear_down(void)
{
    TEST_ASSERT_NULL_MESSAGE(controller.wrong, controller.wrong);
}

static void one_millisecond(void)
{
    tumble_can_frame_t frame;
    tumble_navcomp_step(&bench.navcomp);
    while (fake_port_take(&bench.fake, &frame)) {
        bench_hear(&bench, &frame);
    }
    scripted_block_step(&bench.block, &bench.fake, played_positioner_angle_deg(&controller));
    bench_operate(&bench);
    bench.fake.now_us += 1000U;
    played_positioner_step(&controller);
}

static tumble_state_t run_to(tumble_state_t state, int most_ms)
{
    for (int ms = 0; (ms < most_ms) && (bench_progress(&bench).run.state != state); ms++) {
        one_millisecond();
    }
    return bench_progress(&bench).run.state;
}

static void run_to_a_move(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_START, 0));
    for (int ms = 0; (ms < 600000) && (bench_progress(&bench).run.index != 2U); ms++) {
        one_millisecond();
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_MOVE, run_to(TUMBLE_STATE_MOVE, 60000));
    for (int ms = 0; (ms < 1000) && !controller.moving; ms++) {
        one_millisecond();
    }
    TEST_ASSERT_TRUE(controller.moving);
}

static void assert_fault(const char *reason)
{
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, run_to(TUMBLE_STATE_FAULT, 1000));
    TEST_ASSERT_EQUAL_STRING(reason, tumble_reason_name(bench_progress(&bench).run.reason));
    for (int ms = 0; ms < 500; ms++) {
        one_millisecond();
    }
    TEST_ASSERT_FALSE(controller.moving);
}

static void test_it_calibrates(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_START, 0));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, run_to(TUMBLE_STATE_DONE, 600000));
    assert_right_coefficients();
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).stop.implausible);
}

/* The stand cannot know, but the full circle does not close: the check above can fail. */
static void test_a_wrong_scale_of_the_angle_is_noticed(void)
{
    registers.counts_per_deg = 1.01 * PLAYED_COUNTS_PER_DEG;
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_START, 0));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, run_to(TUMBLE_STATE_FAULT, 600000));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_SLIP", tumble_reason_name(bench_progress(&bench).run.reason));
    TEST_ASSERT_EQUAL(TUMBLE_STAND_FAULT_NONE, tumble_positioner_kind.fault(&axis));
}

static void test_a_link_that_dies_in_a_move_ends_the_run_which_goes_on_by_command(void)
{
    run_to_a_move();
    controller.dead = true;
    assert_fault("TUMBLE_REASON_STAND_HEARTBEAT");
    controller.dead = false;
    for (int ms = 0; ms < 1000; ms++) {
        one_millisecond();
    }
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_RESUME, 0));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, run_to(TUMBLE_STATE_DONE, 600000));
    assert_right_coefficients();
}

static void test_abort_stops_the_table(void)
{
    run_to_a_move();
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_ABORT, 0));
    for (int ms = 0; ms < 100; ms++) {
        one_millisecond();
    }
    TEST_ASSERT_FALSE(controller.moving);
    TEST_ASSERT_EQUAL(TUMBLE_STAND_STOPPED, tumble_positioner_kind.state(&axis));
}

static void test_a_fault_of_the_controller_tells_its_code(void)
{
    run_to_a_move();
    controller.fault = 0x77;
    controller.moving = false;
    assert_fault("TUMBLE_REASON_DRIVE_FAULT");
    TEST_ASSERT_EQUAL_UINT16(0x77, bench_progress(&bench).run.drive_code);
}

static void test_a_table_that_nothing_stops_is_told(void)
{
    run_to_a_move();
    controller.has_no_brake = true;
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_ABORT, 0));
    for (int ms = 0; ms < 3000; ms++) {
        one_millisecond();
    }
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_STOP_NOT_CONFIRMED", tumble_reason_name(bench_progress(&bench).run.reason));
}
