/* What a controller with registers reports, and which of it is not believed. */
#include "positioner_bench.h"

static void test_a_fault_of_the_controller_and_its_code(void)
{
    positioner_start_move(390.0);
    at.controller.fault = 0x2310;
    at.controller.moving = false;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x2310, at.axis.report.fault_code);
    positioner_run_ms(50);
    positioner_clear(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_UINT16(0, at.controller.fault);
    TEST_ASSERT_EQUAL_UINT16(0, at.axis.report.fault_code);
}

static void test_a_fault_that_a_reset_does_not_clear(void)
{
    positioner_go_home();
    at.controller.fault = 7;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_run_ms(50);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->clear_fault(&at.axis));
    for (unsigned ms = 0; ms < 200U; ms++) {
        positioner_run_ms(1);
        at.controller.fault = 7;
    }
    positioner_assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_UINT16(7, at.axis.report.fault_code);
}

static void spoil(uint8_t place, uint16_t bits)
{
    at.controller.spoilt = place;
    at.controller.spoils = bits;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_run_ms(100);
}

static void test_a_status_that_there_is_not(void)
{
    positioner_start_move(390.0);
    spoil(1, 0x0100);
    positioner_assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_FALSE_MESSAGE(at.controller.moving, "it is told to stop, whatever it says");
    TEST_ASSERT_TRUE(at.axis.report.stop.implausible > 0U);
}

static void test_moving_and_in_position_contradict_each_other(void)
{
    positioner_start_move(390.0);
    spoil(1, PLAYED_IN_POSITION);
    positioner_assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
}

static void test_an_order_that_is_not_ours(void)
{
    positioner_start_move(390.0);
    at.controller.number = 999;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_FOREIGN);
    positioner_run_ms(50);
    TEST_ASSERT_FALSE(at.controller.moving);
}

static void test_an_angle_that_changes_at_rest(void)
{
    positioner_go_home();
    at.controller.table += 51;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_POSITION);
}

static void test_an_axis_that_loses_its_home(void)
{
    positioner_go_home();
    at.controller.homed = false;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_POSITION);
    positioner_run_ms(50);
    positioner_clear(TUMBLE_STAND_READY);
}

static void test_an_axis_that_sets_out_by_itself(void)
{
    positioner_run_to(TUMBLE_STAND_READY, 100);
    at.controller.moving = true;
    at.controller.goal = 400000;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_POSITION);
    positioner_run_ms(50);
    TEST_ASSERT_FALSE(at.controller.moving);
}

/* The zero that homing sets is no movement. */
static void test_homing_from_far_off(void)
{
    at.controller.zero = -10000000;
    positioner_go_home();
    ASSERT_SAME_DOUBLE(0.0, at.stand.kind->angle_deg(&at.axis));
}

static void test_homing_that_sets_no_zero_does_not_end(void)
{
    positioner_run_to(TUMBLE_STAND_READY, 100);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->home(&at.axis));
    for (unsigned ms = 0; ms < 1000U; ms++) {
        positioner_run_ms(1);
        at.controller.homed = false;
    }
    TEST_ASSERT_TRUE(at.controller.table == at.controller.goal);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_HOMING, at.stand.kind->state(&at.axis));
}

static void test_an_angle_within_the_window_is_no_fault(void)
{
    positioner_go_home();
    at.controller.table += 50;
    positioner_run_ms(100);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_IN_POSITION, at.stand.kind->state(&at.axis));
    ASSERT_SAME_DOUBLE(0.05, at.stand.kind->angle_deg(&at.axis));
}

static void test_an_angle_beyond_the_cable_in_a_move(void)
{
    positioner_start_move(390.0);
    spoil(4, 0x0010); /* of the high register: 1048 degrees off */
    positioner_assert_fault(TUMBLE_STAND_FAULT_POSITION);
    TEST_ASSERT_FALSE(at.controller.moving);
}

static void test_a_move_that_begins_in_position_is_not_believed(void)
{
    positioner_go_home();
    at.controller.arrives_early = true;
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 90.0));
    positioner_run_ms(400);
    TEST_ASSERT_TRUE(at.controller.moving);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_MOVING, at.stand.kind->state(&at.axis));
    positioner_run_to(TUMBLE_STAND_IN_POSITION, 150);
    TEST_ASSERT_INT32_WITHIN(50, 90000, at.controller.table);
}

/* Where it should be, and at rest; but its loop has not settled. */
static void test_an_axis_that_does_not_say_that_it_is_in_position(void)
{
    positioner_go_home();
    at.controller.never_tells = true;
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 10.0));
    positioner_run_ms(1000);
    TEST_ASSERT_EQUAL_INT32(10000, at.controller.table);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_MOVING, at.stand.kind->state(&at.axis));
    at.controller.never_tells = false;
    positioner_run_to(TUMBLE_STAND_IN_POSITION, 50);
}

static void test_a_move_that_does_not_arrive(void)
{
    positioner_go_home();
    at.controller.never_arrives = true;
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 90.0));
    positioner_run_ms(at.profile.move_timeout_ms - 50U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_MOVING, at.stand.kind->state(&at.axis));
    positioner_run_to(TUMBLE_STAND_FAULT, 150);
    positioner_assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

/* The cable's span and one turn, 790 degrees here; 200 degrees a second. */
static void test_homing_that_does_not_end_is_ended(void)
{
    positioner_run_to(TUMBLE_STAND_READY, 100);
    at.controller.never_homes = true;
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->home(&at.axis));
    positioner_run_to(TUMBLE_STAND_FAULT, 4100);
    positioner_assert_fault(TUMBLE_STAND_FAULT_HOMING);
    positioner_run_ms(100);
    TEST_ASSERT_FALSE(at.controller.moving);
    TEST_ASSERT_INT32_WITHIN(5000 + 50 * 200, 12345 + 790000, at.controller.table);
    positioner_clear(TUMBLE_STAND_READY);
}

static void test_profiles_that_cannot_be_worked_with(void)
{
    const tumble_positioner_profile_t good = at.profile;
    const tumble_exchange_link_t nowhere = {.context = &at.controller};
    tumble_positioner_profile_t bad[12];
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        bad[i] = good;
    }
    bad[0].link = NULL;
    bad[1].link = &nowhere;
    bad[2].counts_per_deg = 0.0;
    bad[3].counts_per_deg = NOT_A_NUMBER;
    bad[4].counts_per_deg = 1e9;
    bad[5].window_deg = 0.0;
    bad[6].home_timeout_ms = 0;
    bad[7].move_timeout_ms = 0;
    bad[8].stop_timeout_ms = 0;
    bad[9].cycle_ms = 0;
    bad[10].silence_ms = (uint16_t)(2U * good.cycle_ms - 1U);
    bad[11].watch_ms = (uint16_t)(2U * good.cycle_ms - 1U);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, positioner_init(NULL));
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, positioner_init(&bad[i]));
    }
    ASSERT_STATUS(TUMBLE_OK, positioner_init(&good));
}

static const around_t around_each = {positioner_begin, positioner_end};
