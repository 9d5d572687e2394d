/* What a positioner sends, a link that dies, and the ladder of a stop: what stops the table whatever happens. */
#include "played_positioner.h"
#include "support.h"

typedef struct {
    played_positioner_t controller;
    tumble_positioner_profile_t profile;
    tumble_positioner_t axis;
    tumble_stand_t stand;
} positioner_bench_t;

#define HOME_MS 500U

/* what the cases work on */
static positioner_bench_t at;

/* With a cable from -30 to 400 degrees. */
static tumble_status_t init_axis(const tumble_positioner_profile_t *profile)
{
    const tumble_stand_setup_t setup = {.profile = profile, .cable_min_deg = -30.0, .cable_max_deg = 400.0};
    return tumble_positioner_kind.init(&at.axis, &setup);
}

/* Before and after each case: power on; the controller has seen nothing that it must not see. */
static void set_up(void)
{
    memset(&at, 0, sizeof at);
    at.stand = (tumble_stand_t){&tumble_positioner_kind, &at.axis};
    played_positioner_init(&at.controller);
    at.profile = played_positioner_profile(&at.controller);
    ASSERT_STATUS(TUMBLE_OK, init_axis(&at.profile));
}

static void tear_down(void)
{
    TEST_ASSERT_NULL_MESSAGE(at.controller.wrong, at.controller.wrong);
}

/* Milliseconds as a navcomp lets them pass: a step when its time has come. */
static void run_ms(unsigned ms)
{
    for (unsigned i = 0; i < ms; i++) {
        played_positioner_step(&at.controller);
        const uint64_t now_us = at.controller.now_ms * 1000U;
        for (int steps = 0; tumble_positioner_kind.next_us(&at.axis) <= now_us; steps++) {
            tumble_positioner_kind.step(&at.axis, now_us);
            TEST_ASSERT_TRUE_MESSAGE(steps < 3, "it asks for steps without end");
        }
    }
}

static void assert_state(tumble_stand_state_t state)
{
    TEST_ASSERT_EQUAL_INT(state, tumble_positioner_kind.state(&at.axis));
}

static void move(double angle_deg)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.move(&at.axis, angle_deg));
}

/* Until the stand is in this state; fails after so many milliseconds. */
static void run_to(tumble_stand_state_t state, unsigned most_ms)
{
    for (unsigned ms = 0; (ms < most_ms) && (tumble_positioner_kind.state(&at.axis) != state); ms++) {
        run_ms(1);
    }
    TEST_ASSERT_EQUAL_INT(state, tumble_positioner_kind.state(&at.axis));
}

static void assert_fault(tumble_stand_fault_t fault)
{
    assert_state(TUMBLE_STAND_FAULT);
    TEST_ASSERT_EQUAL_INT(fault, tumble_positioner_kind.fault(&at.axis));
}

static void go_home(void)
{
    run_to(TUMBLE_STAND_READY, 100);
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.home(&at.axis));
    run_to(TUMBLE_STAND_IN_POSITION, HOME_MS);
}

/* Homed, and on its way there since a tenth of a second. */
static void start_move(double angle_deg)
{
    go_home();
    move(angle_deg);
    run_ms(100);
    TEST_ASSERT_TRUE(at.controller.moving);
}

/* Clear the fault, which leads to this state. */
static void clear_fault(tumble_stand_state_t state)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.clear_fault(&at.axis));
    run_to(state, 200);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, tumble_positioner_kind.fault(&at.axis));
}

static void assert_rungs(uint32_t silence, uint32_t unconfirmed)
{
    const tumble_stop_counters_t *stop = &at.axis.report.stop;
    TEST_ASSERT_EQUAL_UINT32(silence, stop->rungs[TUMBLE_RUNG_SILENCE - TUMBLE_RUNG_AGAIN]);
    TEST_ASSERT_EQUAL_UINT32(unconfirmed, stop->rungs[TUMBLE_RUNG_UNCONFIRMED - TUMBLE_RUNG_AGAIN]);
}

/* What is sent. */

static void test_an_order_and_its_target_travel_together(void)
{
    go_home();
    move(-0.001);
    run_ms(30);
    const uint16_t expected[] = {250, at.controller.number, 2, 0xFFFF, 0xFFFF};
    TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, at.controller.exchange.values, COUNT_OF(expected));
    run_to(TUMBLE_STAND_IN_POSITION, 100);
    ASSERT_SAME_DOUBLE(-0.001, at.stand.kind->angle_deg(&at.axis));
    move(90.0);
    run_ms(30);
    TEST_ASSERT_EQUAL_HEX16(90000U >> 16, at.controller.exchange.values[3]);
    TEST_ASSERT_EQUAL_HEX16(90000U & 0xFFFFU, at.controller.exchange.values[4]);
}

static void test_the_table_may_count_the_other_way(void)
{
    at.profile.counts_per_deg = -PLAYED_COUNTS_PER_DEG;
    ASSERT_STATUS(TUMBLE_OK, init_axis(&at.profile));
    start_move(90.0);
    run_to(TUMBLE_STAND_IN_POSITION, 1000);
    TEST_ASSERT_EQUAL_INT32(-90000, at.controller.table);
    ASSERT_SAME_DOUBLE(90.0, at.stand.kind->angle_deg(&at.axis));
}

/* The watchdog is fed in every cycle, and an order is sent at once. */
static void test_the_pace(void)
{
    go_home();
    const unsigned before = at.controller.writes;
    run_ms(1000);
    TEST_ASSERT_UINT_WITHIN(1, 50, at.controller.writes - before);
    move(10.0);
    run_ms(at.profile.cycle_ms + PLAYED_LATENCY_MS + 1U);
    TEST_ASSERT_TRUE(at.controller.moving);
}

static void test_beyond_32_bits(void)
{
    go_home();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, at.stand.kind->move(&at.axis, 2147483.7));
    move(370.0);
}

/* Contact. */

static void test_nobody_there(void)
{
    at.controller.dead = true;
    run_ms(10000);
    assert_state(TUMBLE_STAND_OFFLINE);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->home(&at.axis));
    at.stand.kind->stop(&at.axis);
    assert_state(TUMBLE_STAND_OFFLINE);
    at.controller.dead = false;
    run_to(TUMBLE_STAND_READY, 100);
    assert_rungs(0, 0);
}

/* Whoever has that address may be anything: nothing is written to it. */
static void test_something_else_at_that_address(void)
{
    at.controller.spoilt = 0;
    at.controller.spoils = 1;
    run_ms(1000);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT(0, at.controller.writes);
    assert_rungs(0, 0);
    at.controller.spoils = 0;
    run_ms(200);
    clear_fault(TUMBLE_STAND_READY);
}

static void test_a_controller_without_these_registers(void)
{
    at.controller.refuses = true;
    run_to(TUMBLE_STAND_FAULT, 100);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT(0, at.controller.writes);
}

static void test_a_controller_without_a_watchdog_is_not_moved(void)
{
    at.controller.never_watches = true;
    run_to(TUMBLE_STAND_FAULT, 100);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->home(&at.axis));
    TEST_ASSERT_EQUAL_INT32(12345, at.controller.table);
}

/* Left so by the program before: its watchdog has stopped it, and it is still homed. */
static void test_a_computer_that_starts_again_finds_it_homed(void)
{
    start_move(90.0);
    at.controller.now_ms += 1000U;
    played_positioner_step(&at.controller);
    TEST_ASSERT_FALSE(at.controller.moving);
    at.controller.number = 1; /* what a computer that does not look would begin with */
    at.axis = (tumble_positioner_t){.known = false};
    ASSERT_STATUS(TUMBLE_OK, init_axis(&at.profile));
    run_to(TUMBLE_STAND_STOPPED, 100);
    move(10.0);
    run_to(TUMBLE_STAND_IN_POSITION, 1000);
}

/* 0 is the number of a controller that has no order. */
static void test_the_numbers_of_orders_go_round_without_0(void)
{
    at.controller.number = UINT16_MAX;
    run_to(TUMBLE_STAND_READY, 100);
    TEST_ASSERT_EQUAL_UINT16(1, at.controller.number);
}

static void test_a_table_that_is_found_turning_is_stopped(void)
{
    start_move(390.0);
    at.axis.report.stop.implausible = 7;
    ASSERT_STATUS(TUMBLE_OK, init_axis(&at.profile)); /* an NMT reset of our node */
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(7, at.axis.report.stop.implausible, "counters go on");
    assert_state(TUMBLE_STAND_OFFLINE);
    run_to(TUMBLE_STAND_STOPPED, 100);
    TEST_ASSERT_FALSE(at.controller.moving);
}

/* The link dies. */

static void test_a_link_that_dies_in_a_move(void)
{
    start_move(390.0);
    at.controller.dead = true;
    run_ms(at.profile.watch_ms + at.profile.cycle_ms);
    TEST_ASSERT_FALSE_MESSAGE(at.controller.moving, "the watchdog stops it");
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->clear_fault(&at.axis)); /* it has not been seen at rest */
    const int32_t stood = at.controller.table;
    at.controller.dead = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(stood, at.controller.table, "it does not go on by itself");
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    clear_fault(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_INT32(stood, at.controller.table);
}

/* Then the fault can be cleared in the end, but there is no stand. */
static void test_a_link_that_stays_dead(void)
{
    start_move(390.0);
    at.controller.dead = true;
    run_ms(3000);
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
    assert_rungs(1, 1);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->clear_fault(&at.axis));
    run_ms(3000);
    assert_state(TUMBLE_STAND_OFFLINE);
}

static void test_a_single_answer_may_be_missing(void)
{
    start_move(390.0);
    at.controller.dead = true;
    run_ms(3U * at.profile.cycle_ms);
    at.controller.dead = false;
    run_to(TUMBLE_STAND_IN_POSITION, 4000);
}

static void test_a_controller_that_was_off_for_a_moment(void)
{
    start_move(390.0);
    played_positioner_boot(&at.controller);
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_POWER);
    run_ms(100);
    clear_fault(TUMBLE_STAND_READY);
}

/* The stop. */

static void test_a_stop_is_repeated_until_the_axis_rests_and_then_the_watchdog_must_do_it(void)
{
    start_move(390.0);
    at.controller.never_stops = true;
    at.stand.kind->stop(&at.axis);
    run_ms(200);
    at.stand.kind->stop(&at.axis); /* does not begin anew */
    run_ms(130);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_rungs(1, 0);
    const unsigned before = at.controller.exchanges;
    TEST_ASSERT_TRUE(at.controller.moving);
    run_ms(at.profile.watch_ms + 1U);
    TEST_ASSERT_FALSE(at.controller.moving);
    TEST_ASSERT_EQUAL_UINT_MESSAGE(before, at.controller.exchanges, "it is silent");
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, at.stand.kind->clear_fault(&at.axis));
    run_ms(400);
    assert_rungs(1, 0);
    at.controller.never_stops = false;
    clear_fault(TUMBLE_STAND_STOPPED);
}

static void test_a_table_that_nothing_stops(void)
{
    start_move(390.0);
    at.controller.has_no_brake = true;
    const uint16_t before = at.controller.number;
    at.stand.kind->stop(&at.axis);
    run_ms(2000);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_rungs(1, 1);
    TEST_ASSERT_TRUE(at.controller.moving);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(before + 3U, at.controller.number, "told, told after the silence, told again");
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->clear_fault(&at.axis));
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
}

/* An order that was given up may arrive late: the first fault stays, and the table is stopped again. */
static void test_a_table_that_is_set_going_in_a_fault_is_stopped_again(void)
{
    start_move(390.0);
    at.controller.fault = 0x2310;
    run_to(TUMBLE_STAND_FAULT, 50);
    run_ms(100);
    TEST_ASSERT_FALSE(at.controller.moving);
    at.controller.moving = true;
    at.controller.number--;
    run_ms(50);
    TEST_ASSERT_FALSE(at.controller.moving);
    at.controller.moving = true;
    run_ms(50);
    TEST_ASSERT_FALSE(at.controller.moving);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x2310, at.axis.report.fault_code);
    assert_rungs(0, 0);
}

static void test_a_controller_that_takes_no_order(void)
{
    go_home();
    at.controller.deaf = true;
    move(45.0);
    run_to(TUMBLE_STAND_FAULT, at.profile.move_timeout_ms + 50U);
    assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

/* What a controller with registers reports, and which of it is not believed. */

static void test_a_fault_of_the_controller_and_its_code(void)
{
    start_move(390.0);
    at.controller.fault = 0x2310;
    at.controller.moving = false;
    run_to(TUMBLE_STAND_FAULT, 50);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x2310, at.axis.report.fault_code);
    run_ms(50);
    clear_fault(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_UINT16(0, at.controller.fault);
    TEST_ASSERT_EQUAL_UINT16(0, at.axis.report.fault_code);
}

static void test_a_fault_that_a_reset_does_not_clear(void)
{
    go_home();
    at.controller.fault = 7;
    run_to(TUMBLE_STAND_FAULT, 50);
    run_ms(50);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->clear_fault(&at.axis));
    for (unsigned ms = 0; ms < 200U; ms++) {
        run_ms(1);
        at.controller.fault = 7;
    }
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_UINT16(7, at.axis.report.fault_code);
}

static void spoil(uint8_t place, uint16_t bits)
{
    at.controller.spoilt = place;
    at.controller.spoils = bits;
}

/* From a beginning something happens that is this fault, and the table is told to stop, whatever the controller says. */
#define EXPECT_FAULT(what, begin, happens, expected)                                                                   \
    do {                                                                                                               \
        set_up();                                                                                                      \
        begin;                                                                                                         \
        happens;                                                                                                       \
        run_to(TUMBLE_STAND_FAULT, 50);                                                                                \
        run_ms(100);                                                                                                   \
        TEST_ASSERT_EQUAL_INT_MESSAGE(expected, tumble_positioner_kind.fault(&at.axis), what);                         \
        TEST_ASSERT_FALSE_MESSAGE(at.controller.moving, what);                                                         \
        tear_down();                                                                                                   \
    } while (0)

static void test_what_cannot_be_believed_is_a_fault(void)
{
    EXPECT_FAULT("a status that there is not", start_move(390.0), spoil(1, 0x0100), TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_TRUE(at.axis.report.stop.implausible > 0U);
    EXPECT_FAULT("moving and in position contradict each other", start_move(390.0), spoil(1, PLAYED_IN_POSITION),
                 TUMBLE_STAND_FAULT_PROTOCOL);
    EXPECT_FAULT("an order that is not ours", start_move(390.0), at.controller.number = 999,
                 TUMBLE_STAND_FAULT_FOREIGN);
    EXPECT_FAULT("an angle beyond the cable, 1048 degrees off", start_move(390.0), spoil(4, 0x0010),
                 TUMBLE_STAND_FAULT_POSITION);
    EXPECT_FAULT("an angle that changes at rest", go_home(), at.controller.table += 51, TUMBLE_STAND_FAULT_POSITION);
    EXPECT_FAULT("an axis that sets out by itself", run_to(TUMBLE_STAND_READY, 100),
                 (at.controller.moving = true, at.controller.goal = 400000), TUMBLE_STAND_FAULT_POSITION);
    EXPECT_FAULT("an axis that loses its home", go_home(), at.controller.homed = false, TUMBLE_STAND_FAULT_POSITION);
    clear_fault(TUMBLE_STAND_READY);
}

/* The zero that homing sets is no movement. */
static void test_homing_from_far_off(void)
{
    at.controller.zero = -10000000;
    go_home();
    ASSERT_SAME_DOUBLE(0.0, at.stand.kind->angle_deg(&at.axis));
}

static void test_homing_that_sets_no_zero_does_not_end(void)
{
    run_to(TUMBLE_STAND_READY, 100);
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->home(&at.axis));
    for (unsigned ms = 0; ms < 1000U; ms++) {
        run_ms(1);
        at.controller.homed = false;
    }
    TEST_ASSERT_TRUE(at.controller.table == at.controller.goal);
    assert_state(TUMBLE_STAND_HOMING);
}

static void test_an_angle_within_the_window_is_no_fault(void)
{
    go_home();
    at.controller.table += 50;
    run_ms(100);
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(0.05, at.stand.kind->angle_deg(&at.axis));
}

static void test_a_move_that_begins_in_position_is_not_believed(void)
{
    go_home();
    at.controller.arrives_early = true;
    move(90.0);
    run_ms(400);
    TEST_ASSERT_TRUE(at.controller.moving);
    assert_state(TUMBLE_STAND_MOVING);
    run_to(TUMBLE_STAND_IN_POSITION, 150);
    TEST_ASSERT_INT32_WITHIN(50, 90000, at.controller.table);
}

/* Where it should be, and at rest; but its loop has not settled. */
static void test_an_axis_that_does_not_say_that_it_is_in_position(void)
{
    go_home();
    at.controller.never_tells = true;
    move(10.0);
    run_ms(1000);
    TEST_ASSERT_EQUAL_INT32(10000, at.controller.table);
    assert_state(TUMBLE_STAND_MOVING);
    at.controller.never_tells = false;
    run_to(TUMBLE_STAND_IN_POSITION, 50);
}

static void test_a_move_that_does_not_arrive(void)
{
    go_home();
    at.controller.never_arrives = true;
    move(90.0);
    run_ms(at.profile.move_timeout_ms - 50U);
    assert_state(TUMBLE_STAND_MOVING);
    run_to(TUMBLE_STAND_FAULT, 150);
    assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

/* The cable's span and one turn, 790 degrees here; 200 degrees a second. */
static void test_homing_that_does_not_end_is_ended(void)
{
    run_to(TUMBLE_STAND_READY, 100);
    at.controller.never_homes = true;
    ASSERT_STATUS(TUMBLE_OK, at.stand.kind->home(&at.axis));
    run_to(TUMBLE_STAND_FAULT, 4100);
    assert_fault(TUMBLE_STAND_FAULT_HOMING);
    run_ms(100);
    TEST_ASSERT_FALSE(at.controller.moving);
    TEST_ASSERT_INT32_WITHIN(5000 + 50 * 200, 12345 + 790000, at.controller.table);
    clear_fault(TUMBLE_STAND_READY);
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
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, init_axis(NULL));
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, init_axis(&bad[i]));
    }
    ASSERT_STATUS(TUMBLE_OK, init_axis(&good));
}
