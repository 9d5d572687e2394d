/* A controller with registers that misbehaves: what is noticed, what stops the table, and what is never sent. */
#include "played_positioner.h"
#include "support.h"

#define HOME_MS 500U

static played_positioner_t controller;
static tumble_positioner_profile_t profile;
static tumble_positioner_t axis;
static const tumble_stand_t stand = {&tumble_positioner_kind, &axis};

static tumble_status_t init(const tumble_positioner_profile_t *with)
{
    const tumble_stand_setup_t setup = {.profile = with, .cable_min_deg = -30.0, .cable_max_deg = 400.0};
    return stand.kind->init(&axis, &setup);
}

static void set_up(void)
{
    played_positioner_init(&controller);
    profile = played_positioner_profile(&controller);
    axis = (tumble_positioner_t){.known = false};
    ASSERT_STATUS(TUMBLE_OK, init(&profile));
}

static void tear_down(void)
{
    TEST_ASSERT_NULL_MESSAGE(controller.wrong, controller.wrong);
}

/* As navcomp: a step when its time has come. */
static void run_ms(unsigned ms)
{
    for (unsigned i = 0; i < ms; i++) {
        played_positioner_step(&controller);
        for (int steps = 0; stand.kind->next_us(&axis) <= controller.now_ms * 1000U; steps++) {
            stand.kind->step(&axis, controller.now_ms * 1000U);
            TEST_ASSERT_TRUE_MESSAGE(steps < 3, "it asks for steps without end");
        }
    }
}

static void run_to(tumble_stand_state_t state, unsigned most_ms)
{
    for (unsigned ms = 0; (ms < most_ms) && (stand.kind->state(&axis) != state); ms++) {
        run_ms(1);
    }
    TEST_ASSERT_EQUAL_INT(state, stand.kind->state(&axis));
}

static void assert_fault(tumble_stand_fault_t fault)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT, stand.kind->state(&axis));
    TEST_ASSERT_EQUAL_INT(fault, stand.kind->fault(&axis));
}

static void go_home(void)
{
    run_to(TUMBLE_STAND_READY, 100);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&axis));
    run_to(TUMBLE_STAND_IN_POSITION, HOME_MS);
}

static void start_move(double angle_deg)
{
    go_home();
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, angle_deg));
    run_ms(100);
    TEST_ASSERT_TRUE(controller.moving);
}

static void clear(tumble_stand_state_t state)
{
    ASSERT_STATUS(TUMBLE_OK, stand.kind->clear_fault(&axis));
    run_to(state, 200);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, stand.kind->fault(&axis));
}

static void assert_rungs(uint32_t silence, uint32_t unconfirmed)
{
    const tumble_stop_counters_t *stop = &axis.report.stop;
    TEST_ASSERT_EQUAL_UINT32(silence, stop->rungs[TUMBLE_RUNG_SILENCE - TUMBLE_RUNG_AGAIN]);
    TEST_ASSERT_EQUAL_UINT32(unconfirmed, stop->rungs[TUMBLE_RUNG_UNCONFIRMED - TUMBLE_RUNG_AGAIN]);
}

/* What is sent. */

static void test_an_order_and_its_target_travel_together(void)
{
    go_home();
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, -0.001));
    run_ms(30);
    const uint16_t expected[] = {250, controller.number, 2, 0xFFFF, 0xFFFF};
    TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, controller.exchange.values, COUNT_OF(expected));
    run_to(TUMBLE_STAND_IN_POSITION, 100);
    ASSERT_SAME_DOUBLE(-0.001, stand.kind->angle_deg(&axis));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 90.0));
    run_ms(30);
    TEST_ASSERT_EQUAL_HEX16(90000U >> 16, controller.exchange.values[3]);
    TEST_ASSERT_EQUAL_HEX16(90000U & 0xFFFFU, controller.exchange.values[4]);
}

static void test_the_table_may_count_the_other_way(void)
{
    profile.counts_per_deg = -PLAYED_COUNTS_PER_DEG;
    ASSERT_STATUS(TUMBLE_OK, init(&profile));
    start_move(90.0);
    run_to(TUMBLE_STAND_IN_POSITION, 1000);
    TEST_ASSERT_EQUAL_INT32(-90000, controller.table);
    ASSERT_SAME_DOUBLE(90.0, stand.kind->angle_deg(&axis));
}

/* The watchdog is fed in every cycle, and an order is sent at once. */
static void test_the_pace(void)
{
    go_home();
    const unsigned before = controller.writes;
    run_ms(1000);
    TEST_ASSERT_UINT_WITHIN(1, 50, controller.writes - before);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 10.0));
    run_ms(profile.cycle_ms + PLAYED_LATENCY_MS + 1U);
    TEST_ASSERT_TRUE(controller.moving);
}

static void test_beyond_32_bits(void)
{
    go_home();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, stand.kind->move(&axis, 2147483.7));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 370.0));
}

/* Contact. */

static void test_nobody_there(void)
{
    controller.dead = true;
    run_ms(10000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, stand.kind->state(&axis));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->home(&axis));
    stand.kind->stop(&axis);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, stand.kind->state(&axis));
    controller.dead = false;
    run_to(TUMBLE_STAND_READY, 100);
    assert_rungs(0, 0);
}

/* Whoever has that address may be anything: nothing is written to it. */
static void test_something_else_at_that_address(void)
{
    controller.spoilt = 0;
    controller.spoils = 1;
    run_ms(1000);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT(0, controller.writes);
    controller.spoils = 0;
    run_ms(200);
    clear(TUMBLE_STAND_READY);
}

static void test_a_controller_without_these_registers(void)
{
    controller.refuses = true;
    run_to(TUMBLE_STAND_FAULT, 100);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT(0, controller.writes);
}

static void test_a_controller_without_a_watchdog_is_not_moved(void)
{
    controller.never_watches = true;
    run_to(TUMBLE_STAND_FAULT, 100);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->home(&axis));
    TEST_ASSERT_EQUAL_INT32(12345, controller.table);
}

/* Left so by the program before: its watchdog has stopped it, and it is still homed. */
static void test_a_computer_that_starts_again_finds_it_homed(void)
{
    start_move(90.0);
    controller.now_ms += 1000U;
    played_positioner_step(&controller);
    TEST_ASSERT_FALSE(controller.moving);
    axis = (tumble_positioner_t){.known = false};
    ASSERT_STATUS(TUMBLE_OK, init(&profile));
    run_to(TUMBLE_STAND_STOPPED, 100);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 10.0));
    run_to(TUMBLE_STAND_IN_POSITION, 1000);
}

static void test_a_table_that_is_found_turning_is_stopped(void)
{
    start_move(390.0);
    ASSERT_STATUS(TUMBLE_OK, init(&profile)); /* an NMT reset of our node */
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, stand.kind->state(&axis));
    run_to(TUMBLE_STAND_STOPPED, 100);
    TEST_ASSERT_FALSE(controller.moving);
}

/* The link dies. */

static void test_a_link_that_dies_in_a_move(void)
{
    start_move(390.0);
    controller.dead = true;
    run_ms(profile.watch_ms + profile.cycle_ms);
    TEST_ASSERT_FALSE_MESSAGE(controller.moving, "the watchdog stops it");
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->clear_fault(&axis)); /* it has not been seen at rest */
    const int32_t stood = controller.table;
    controller.dead = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(stood, controller.table, "it does not go on by itself");
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    clear(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_INT32(stood, controller.table);
}

/* Then the fault can be cleared in the end, but there is no stand. */
static void test_a_link_that_stays_dead(void)
{
    start_move(390.0);
    controller.dead = true;
    run_ms(3000);
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    assert_rungs(1, 1);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->clear_fault(&axis));
    run_ms(3000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, stand.kind->state(&axis));
}

static void test_a_single_answer_may_be_missing(void)
{
    start_move(390.0);
    controller.dead = true;
    run_ms(3U * profile.cycle_ms);
    controller.dead = false;
    run_to(TUMBLE_STAND_IN_POSITION, 4000);
}

static void test_a_controller_that_was_off_for_a_moment(void)
{
    start_move(390.0);
    played_positioner_boot(&controller);
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_POWER);
    run_ms(100);
    clear(TUMBLE_STAND_READY);
}

/* The stop. */

static void test_a_stop_is_repeated_until_the_axis_rests_and_then_the_watchdog_must_do_it(void)
{
    start_move(390.0);
    controller.never_stops = true;
    stand.kind->stop(&axis);
    run_ms(200);
    stand.kind->stop(&axis); /* does not begin anew */
    run_ms(130);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_rungs(1, 0);
    const unsigned before = controller.exchanges;
    TEST_ASSERT_TRUE(controller.moving);
    run_ms(profile.watch_ms + 1U);
    TEST_ASSERT_FALSE(controller.moving);
    TEST_ASSERT_EQUAL_UINT_MESSAGE(before, controller.exchanges, "it is silent");
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->clear_fault(&axis));
    run_ms(400);
    assert_rungs(1, 0);
    controller.never_stops = false;
    clear(TUMBLE_STAND_STOPPED);
}

static void test_a_table_that_nothing_stops(void)
{
    start_move(390.0);
    controller.has_no_brake = true;
    const uint16_t before = controller.number;
    stand.kind->stop(&axis);
    run_ms(2000);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_rungs(1, 1);
    TEST_ASSERT_TRUE(controller.moving);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(before + 3U, controller.number, "told, told after the silence, told again");
    ASSERT_STATUS(TUMBLE_OK, stand.kind->clear_fault(&axis));
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
}

static void test_a_controller_that_takes_no_order(void)
{
    go_home();
    controller.deaf = true;
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 45.0));
    run_to(TUMBLE_STAND_FAULT, profile.move_timeout_ms + 50U);
    assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

/* What it reports. */

static void test_a_fault_of_the_controller_and_its_code(void)
{
    start_move(390.0);
    controller.fault = 0x2310;
    controller.moving = false;
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x2310, axis.report.fault_code);
    run_ms(50);
    clear(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_UINT16(0, controller.fault);
    TEST_ASSERT_EQUAL_UINT16(0, axis.report.fault_code);
}

static void test_a_fault_that_a_reset_does_not_clear(void)
{
    go_home();
    controller.fault = 7;
    run_to(TUMBLE_STAND_FAULT, 50);
    run_ms(50);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->clear_fault(&axis));
    for (unsigned ms = 0; ms < 200U; ms++) {
        run_ms(1);
        controller.fault = 7;
    }
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_UINT16(7, axis.report.fault_code);
}

static void spoil(uint8_t place, uint16_t bits)
{
    controller.spoilt = place;
    controller.spoils = bits;
    run_to(TUMBLE_STAND_FAULT, 50);
    run_ms(100);
}

static void test_a_status_that_there_is_not(void)
{
    start_move(390.0);
    spoil(1, 0x0100);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_FALSE_MESSAGE(controller.moving, "it is told to stop, whatever it says");
    TEST_ASSERT_TRUE(axis.report.stop.implausible > 0U);
}

static void test_moving_and_in_position_contradict_each_other(void)
{
    start_move(390.0);
    spoil(1, PLAYED_IN_POSITION);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
}

static void test_an_order_that_is_not_ours(void)
{
    start_move(390.0);
    controller.number = 999;
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_FOREIGN);
    run_ms(50);
    TEST_ASSERT_FALSE(controller.moving);
}

static void test_an_angle_that_changes_at_rest(void)
{
    go_home();
    controller.table += 51;
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_POSITION);
}

static void test_an_angle_within_the_window_is_no_fault(void)
{
    go_home();
    controller.table += 50;
    run_ms(100);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_IN_POSITION, stand.kind->state(&axis));
    ASSERT_SAME_DOUBLE(0.05, stand.kind->angle_deg(&axis));
}

static void test_an_angle_beyond_the_cable_in_a_move(void)
{
    start_move(390.0);
    spoil(4, 0x0010); /* of the high register: 1048 degrees off */
    assert_fault(TUMBLE_STAND_FAULT_POSITION);
    TEST_ASSERT_FALSE(controller.moving);
}

static void test_a_move_that_begins_in_position_is_not_believed(void)
{
    go_home();
    controller.arrives_early = true;
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 90.0));
    run_ms(400);
    TEST_ASSERT_TRUE(controller.moving);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_MOVING, stand.kind->state(&axis));
    run_to(TUMBLE_STAND_IN_POSITION, 150);
    TEST_ASSERT_INT32_WITHIN(50, 90000, controller.table);
}

static void test_a_move_that_does_not_arrive(void)
{
    go_home();
    controller.never_arrives = true;
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&axis, 90.0));
    run_ms(profile.move_timeout_ms - 50U);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_MOVING, stand.kind->state(&axis));
    run_to(TUMBLE_STAND_FAULT, 150);
    assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

/* The cable's span and one turn, 790 degrees here; 200 degrees a second. */
static void test_homing_that_does_not_end_is_ended(void)
{
    run_to(TUMBLE_STAND_READY, 100);
    controller.never_homes = true;
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&axis));
    run_to(TUMBLE_STAND_FAULT, 4100);
    assert_fault(TUMBLE_STAND_FAULT_HOMING);
    run_ms(100);
    TEST_ASSERT_FALSE(controller.moving);
    TEST_ASSERT_INT32_WITHIN(5000 + 50 * 200, 12345 + 790000, controller.table);
    clear(TUMBLE_STAND_READY);
}

static void test_profiles_that_cannot_be_worked_with(void)
{
    const tumble_positioner_profile_t good = profile;
    const tumble_exchange_link_t nowhere = {.context = &controller};
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
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, init(NULL));
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, init(&bad[i]));
    }
    ASSERT_STATUS(TUMBLE_OK, init(&good));
}

static const around_t around_each = {set_up, tear_down};
