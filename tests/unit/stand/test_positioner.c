/* What a positioner sends, a link that dies, and the ladder of a stop: what stops the table whatever happens. */
#include "positioner_bench.h"

static void assert_rungs(uint32_t silence, uint32_t unconfirmed)
{
    const tumble_stop_counters_t *stop = &at.axis.report.stop;
    TEST_ASSERT_EQUAL_UINT32(silence, stop->rungs[TUMBLE_RUNG_SILENCE - TUMBLE_RUNG_AGAIN]);
    TEST_ASSERT_EQUAL_UINT32(unconfirmed, stop->rungs[TUMBLE_RUNG_UNCONFIRMED - TUMBLE_RUNG_AGAIN]);
}

/* What is sent. */

static void test_an_order_and_its_target_travel_together(void)
{
    positioner_go_home();
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, -0.001));
    positioner_run_ms(30);
    const uint16_t expected[] = {250, at.controller.number, 2, 0xFFFF, 0xFFFF};
    TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, at.controller.exchange.values, COUNT_OF(expected));
    positioner_run_to(TUMBLE_STAND_IN_POSITION, 100);
    ASSERT_SAME_DOUBLE(-0.001, at.stand.kind->angle_deg(&at.axis));
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 90.0));
    positioner_run_ms(30);
    TEST_ASSERT_EQUAL_HEX16(90000U >> 16, at.controller.exchange.values[3]);
    TEST_ASSERT_EQUAL_HEX16(90000U & 0xFFFFU, at.controller.exchange.values[4]);
}

static void test_the_table_may_count_the_other_way(void)
{
    at.profile.counts_per_deg = -PLAYED_COUNTS_PER_DEG;
    ASSERT_STATUS(TUMBLE_OK, positioner_init(&at.profile));
    positioner_start_move(90.0);
    positioner_run_to(TUMBLE_STAND_IN_POSITION, 1000);
    TEST_ASSERT_EQUAL_INT32(-90000, at.controller.table);
    ASSERT_SAME_DOUBLE(90.0, at.stand.kind->angle_deg(&at.axis));
}

/* The watchdog is fed in every cycle, and an order is sent at once. */
static void test_the_pace(void)
{
    positioner_go_home();
    const unsigned before = at.controller.writes;
    positioner_run_ms(1000);
    TEST_ASSERT_UINT_WITHIN(1, 50, at.controller.writes - before);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 10.0));
    positioner_run_ms(at.profile.cycle_ms + PLAYED_LATENCY_MS + 1U);
    TEST_ASSERT_TRUE(at.controller.moving);
}

static void test_beyond_32_bits(void)
{
    positioner_go_home();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, at.stand.kind->move(&at.axis, 2147483.7));
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 370.0));
}

/* Contact. */

static void test_nobody_there(void)
{
    at.controller.dead = true;
    positioner_run_ms(10000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, at.stand.kind->state(&at.axis));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->home(&at.axis));
    at.stand.kind->stop(&at.axis);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, at.stand.kind->state(&at.axis));
    at.controller.dead = false;
    positioner_run_to(TUMBLE_STAND_READY, 100);
    assert_rungs(0, 0);
}

/* Whoever has that address may be anything: nothing is written to it. */
static void test_something_else_at_that_address(void)
{
    at.controller.spoilt = 0;
    at.controller.spoils = 1;
    positioner_run_ms(1000);
    positioner_assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT(0, at.controller.writes);
    assert_rungs(0, 0);
    at.controller.spoils = 0;
    positioner_run_ms(200);
    positioner_clear(TUMBLE_STAND_READY);
}

static void test_a_controller_without_these_registers(void)
{
    at.controller.refuses = true;
    positioner_run_to(TUMBLE_STAND_FAULT, 100);
    positioner_assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT(0, at.controller.writes);
}

static void test_a_controller_without_a_watchdog_is_not_moved(void)
{
    at.controller.never_watches = true;
    positioner_run_to(TUMBLE_STAND_FAULT, 100);
    positioner_assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->home(&at.axis));
    TEST_ASSERT_EQUAL_INT32(12345, at.controller.table);
}

/* Left so by the program before: its watchdog has stopped it, and it is still homed. */
static void test_a_computer_that_starts_again_finds_it_homed(void)
{
    positioner_start_move(90.0);
    at.controller.now_ms += 1000U;
    played_positioner_step(&at.controller);
    TEST_ASSERT_FALSE(at.controller.moving);
    at.controller.number = 1; /* what a computer that does not look would begin with */
    at.axis = (tumble_positioner_t){.known = false};
    ASSERT_STATUS(TUMBLE_OK, positioner_init(&at.profile));
    positioner_run_to(TUMBLE_STAND_STOPPED, 100);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 10.0));
    positioner_run_to(TUMBLE_STAND_IN_POSITION, 1000);
}

/* 0 is the number of a controller that has no order. */
static void test_the_numbers_of_orders_go_round_without_0(void)
{
    at.controller.number = UINT16_MAX;
    positioner_run_to(TUMBLE_STAND_READY, 100);
    TEST_ASSERT_EQUAL_UINT16(1, at.controller.number);
}

static void test_a_table_that_is_found_turning_is_stopped(void)
{
    positioner_start_move(390.0);
    at.axis.report.stop.implausible = 7;
    ASSERT_STATUS(TUMBLE_OK, positioner_init(&at.profile)); /* an NMT reset of our node */
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(7, at.axis.report.stop.implausible, "counters go on");
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, at.stand.kind->state(&at.axis));
    positioner_run_to(TUMBLE_STAND_STOPPED, 100);
    TEST_ASSERT_FALSE(at.controller.moving);
}

/* The link dies. */

static void test_a_link_that_dies_in_a_move(void)
{
    positioner_start_move(390.0);
    at.controller.dead = true;
    positioner_run_ms(at.profile.watch_ms + at.profile.cycle_ms);
    TEST_ASSERT_FALSE_MESSAGE(at.controller.moving, "the watchdog stops it");
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->clear_fault(&at.axis)); /* it has not been seen at rest */
    const int32_t stood = at.controller.table;
    at.controller.dead = false;
    positioner_run_ms(1000);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(stood, at.controller.table, "it does not go on by itself");
    positioner_assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    positioner_clear(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_INT32(stood, at.controller.table);
}

/* Then the fault can be cleared in the end, but there is no stand. */
static void test_a_link_that_stays_dead(void)
{
    positioner_start_move(390.0);
    at.controller.dead = true;
    positioner_run_ms(3000);
    positioner_assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    assert_rungs(1, 1);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->clear_fault(&at.axis));
    positioner_run_ms(3000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_OFFLINE, at.stand.kind->state(&at.axis));
}

static void test_a_single_answer_may_be_missing(void)
{
    positioner_start_move(390.0);
    at.controller.dead = true;
    positioner_run_ms(3U * at.profile.cycle_ms);
    at.controller.dead = false;
    positioner_run_to(TUMBLE_STAND_IN_POSITION, 4000);
}

static void test_a_controller_that_was_off_for_a_moment(void)
{
    positioner_start_move(390.0);
    played_positioner_boot(&at.controller);
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_assert_fault(TUMBLE_STAND_FAULT_POWER);
    positioner_run_ms(100);
    positioner_clear(TUMBLE_STAND_READY);
}

/* The stop. */

static void test_a_stop_is_repeated_until_the_axis_rests_and_then_the_watchdog_must_do_it(void)
{
    positioner_start_move(390.0);
    at.controller.never_stops = true;
    at.stand.kind->stop(&at.axis);
    positioner_run_ms(200);
    at.stand.kind->stop(&at.axis); /* does not begin anew */
    positioner_run_ms(130);
    positioner_assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_rungs(1, 0);
    const unsigned before = at.controller.exchanges;
    TEST_ASSERT_TRUE(at.controller.moving);
    positioner_run_ms(at.profile.watch_ms + 1U);
    TEST_ASSERT_FALSE(at.controller.moving);
    TEST_ASSERT_EQUAL_UINT_MESSAGE(before, at.controller.exchanges, "it is silent");
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->clear_fault(&at.axis));
    positioner_run_ms(400);
    assert_rungs(1, 0);
    at.controller.never_stops = false;
    positioner_clear(TUMBLE_STAND_STOPPED);
}

static void test_a_table_that_nothing_stops(void)
{
    positioner_start_move(390.0);
    at.controller.has_no_brake = true;
    const uint16_t before = at.controller.number;
    at.stand.kind->stop(&at.axis);
    positioner_run_ms(2000);
    positioner_assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_rungs(1, 1);
    TEST_ASSERT_TRUE(at.controller.moving);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(before + 3U, at.controller.number, "told, told after the silence, told again");
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->clear_fault(&at.axis));
    positioner_run_to(TUMBLE_STAND_FAULT, 500);
    positioner_assert_fault(TUMBLE_STAND_FAULT_STOP);
}

/* An order that was given up may arrive late: the first fault stays, and the table is stopped again. */
static void test_a_table_that_is_set_going_in_a_fault_is_stopped_again(void)
{
    positioner_start_move(390.0);
    at.controller.fault = 0x2310;
    positioner_run_to(TUMBLE_STAND_FAULT, 50);
    positioner_run_ms(100);
    TEST_ASSERT_FALSE(at.controller.moving);
    at.controller.moving = true;
    at.controller.number--;
    positioner_run_ms(50);
    TEST_ASSERT_FALSE(at.controller.moving);
    at.controller.moving = true;
    positioner_run_ms(50);
    TEST_ASSERT_FALSE(at.controller.moving);
    positioner_assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x2310, at.axis.report.fault_code);
    assert_rungs(0, 0);
}

static void test_a_controller_that_takes_no_order(void)
{
    positioner_go_home();
    at.controller.deaf = true;
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->move(&at.axis, 45.0));
    positioner_run_to(TUMBLE_STAND_FAULT, at.profile.move_timeout_ms + 50U);
    positioner_assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

static const around_t around_each = {positioner_begin, positioner_end};
