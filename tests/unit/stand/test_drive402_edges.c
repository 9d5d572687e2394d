/* The CiA 402 master at its limits: standstill, faults at every moment, two PDOs each way, exact times. */
#include "drive_bench.h"

/* Status and position apart, and as many receive PDOs. */
static const tumble_drive_pdo_t apart_receive[] = {
    {0, {.cob_id = 0x202, .type = 255, .count = 1, .map = {0x60400010}}},
    {1, {.cob_id = 0x302, .type = 255, .count = 1, .map = {0x607A0020}}},
};
static const tumble_drive_pdo_t apart_transmit[] = {
    {0, {.cob_id = 0x182, .type = 255, .count = 1, .event_ms = 10, .map = {0x60410010}}},
    {1, {.cob_id = 0x282, .type = 255, .count = 1, .event_ms = 10, .map = {0x60640020}}},
};

static tumble_drive_profile_t apart(void)
{
    tumble_drive_profile_t profile = common;
    profile.receive = apart_receive;
    profile.transmit = apart_transmit;
    profile.receive_count = 2;
    profile.transmit_count = 2;
    return profile;
}

/* It brakes for 45 ms, and does or does not say when it stands. */
static void expect_stop(const tumble_drive_profile_t *profile, bool hides_standstill, unsigned most_ms)
{
    start_move(profile);
    played.quick_stop_stays = true;
    played.brakes_for_ms = 45;
    played.hides_standstill = hides_standstill;
    stop_for(0);
    for (unsigned ms = 0; ms < most_ms; ms++) {
        run_ms(1);
        TEST_ASSERT_TRUE((stand_state() == TUMBLE_STAND_MOVING) || !played.moving);
    }
    assert_state_after(0, TUMBLE_STAND_STOPPED);
    move_to(45.0);
}

static void test_stopped_means_at_rest(void)
{
    const tumble_drive_profile_t halt = halting();
    const tumble_drive_profile_t two = apart();
    expect_stop(&common, false, 60);
    expect_stop(&common, true, 100);
    expect_stop(&halt, false, 60);
    expect_stop(&halt, true, 100);
    expect_stop(&two, false, 60);
    expect_stop(&two, true, 100);
}

/* The frame with the stop is lost, and the next ones too. */
static void test_a_stop_is_repeated_until_it_acts(void)
{
    const tumble_drive_profile_t halt = halting();
    const tumble_drive_profile_t *const profiles[] = {&common, &halt};
    for (size_t i = 0; i < COUNT_OF(profiles); i++) {
        for (unsigned lost = 0; lost < 5U; lost++) {
            start_move(profiles[i]);
            played.never_reaches = true;
            played.misses = lost;
            stop_at_rest();
            TEST_ASSERT_FALSE(played.moving);
        }
    }
}

static void test_two_process_data_each_way(void)
{
    bring_home(MADE(apart()));
    static const double angles_deg[] = {45.0, 0.0, 400.0};
    for (size_t i = 0; i < COUNT_OF(angles_deg); i++) {
        move_to(angles_deg[i]);
        assert_angle(angles_deg[i]);
    }
}

/* The position alone says nothing about homing. */
static void test_old_attained_bits_with_the_position_apart(void)
{
    bring_up(MADE(apart()));
    played.attained_from_before = true;
    played.old_reports = 2;
    played.actual = 12345;
    go_home();
    assert_angle(0.0);
}

static void test_one_start_command_is_enough(void)
{
    bring_up(&common);
    run_ms(500);
    TEST_ASSERT_EQUAL_UINT(1, played.nmt_starts);
}

/* Whatever phase a home or a move is in, a loss of power is seen, and as what it is. */
static void test_power_lost_at_every_moment(void)
{
    for (unsigned ms = 0; ms < 70U; ms++) {
        bring_up(&common);
        home_for(ms);
        played.state = IS_DISABLED;
        report_now();
        assert_fault(TUMBLE_STAND_FAULT_POWER);
        bring_home(&common);
        move_for(ms, 50.0);
        played.state = IS_READY;
        report_now();
        assert_fault(TUMBLE_STAND_FAULT_POWER);
    }
}

static void test_following_error_at_every_moment_of_a_move(void)
{
    for (unsigned ms = 0; ms < 50U; ms++) {
        bring_home(&common);
        move_for(ms, 50.0);
        played.bits |= 0x2000U;
        report_now();
        run_ms(20); /* what the motion depends on is being read back */
        assert_fault(TUMBLE_STAND_FAULT_STALL);
    }
}

/* The last report of a move says everything at once: there, and failed. The failure counts. */
static void test_a_failure_on_arrival(void)
{
    static const uint16_t bits[] = {0x2400, 0x0400};
    static const uint16_t states[] = {IS_ENABLED, IS_DISABLED};
    static const tumble_stand_fault_t faults[] = {TUMBLE_STAND_FAULT_STALL, TUMBLE_STAND_FAULT_POWER};
    for (size_t i = 0; i < COUNT_OF(bits); i++) {
        start_move(&common);
        played.event_only = true;
        played.moving = false;
        played.actual = 9000;
        played.bits = bits[i];
        played.state = states[i];
        scripted_drive_report(&played);
        assert_fault_after(20, faults[i]);
    }
}

static void test_homing_again_after_a_move(void)
{
    bring_home(&common);
    move_to(20.0);
    go_home();
    played.bits = 0; /* target reached has no meaning now */
    assert_state_after(20, TUMBLE_STAND_IN_POSITION);
    home_for(10);
    stop_for(0);
    run_to(TUMBLE_STAND_READY, 200); /* the old home is gone with the new one half done */
}

static void test_stop_on_the_way_back_to_power(void)
{
    start_move(&common);
    stop_at_rest();
    move_for(0, 10.0);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    run_ms(2);
    stop_for(0); /* nothing moves yet, and nothing will */
    const int32_t here = played.actual;
    run_ms(300);
    TEST_ASSERT_EQUAL_INT32(here, played.actual);
    assert_state_after(0, TUMBLE_STAND_STOPPED);
}

static void test_stopping_again_and_again_gains_no_time(void)
{
    start_move(&common);
    played.ignores_stop = true;
    played.never_reaches = true;
    for (unsigned ms = 0; ms < 1010U; ms++) {
        stop_for(1);
    }
    assert_fault(TUMBLE_STAND_FAULT_STOP);
}

static void test_times_are_over_to_the_microsecond(void)
{
    start_move(CHANGED(common, made.move_timeout_ms = 700)); /* before the axis would be unseen for too long */
    played.never_reaches = true;
    const uint64_t deadline_us = tumble_drive402_kind.next_us(&bench.drive);
    TEST_ASSERT_TRUE(deadline_us > port.now_us);
    tumble_drive402_kind.step(&bench.drive, deadline_us - 1U);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    tumble_drive402_kind.step(&bench.drive, deadline_us);
    assert_fault(TUMBLE_STAND_FAULT_TIMEOUT);
}

static void test_an_answer_is_followed_up_at_once(void)
{
    bench_setup(&common);
    drive_boots(0);
    tumble_can_frame_t frame;
    bool answered = false;
    for (unsigned ms = 0; (ms < 20U) && !answered; ms++) {
        port.now_us += 1000U;
        while (!answered && (tumble_link_receive(&bench.node.link, &frame) == TUMBLE_OK)) {
            (void)tumble_node_receive(&bench.node, &frame, port.now_us);
            answered = (frame.id == (0x580U + SCRIPTED_DRIVE_NODE));
        }
        TEST_ASSERT_EQUAL_UINT64(answered ? 0U : TUMBLE_NEVER,
                                 bench.drive.restart_timer ? TUMBLE_NEVER : tumble_drive402_kind.next_us(&bench.drive));
        tumble_drive402_kind.step(&bench.drive, port.now_us);
        tumble_node_step(&bench.node, port.now_us);
        while (fake_port_take(&port, &frame)) {
            scripted_drive_hear(&played, &port, &frame);
        }
    }
    TEST_ASSERT_TRUE(answered);
}

static void test_nothing_is_written_after_a_refusal(void)
{
    bench_setup(&common);
    played.refuse_index = 0x6083;
    drive_boots(100);
    TEST_ASSERT_EQUAL_UINT(5, played.write_count); /* what comes before it */
    TEST_ASSERT_EQUAL_UINT(1, played.refusals);
}

/* The drive restarts with our question unanswered: the next one does not wait for that answer. */
static void test_a_restart_with_a_question_open(void)
{
    bench_setup(&common);
    drive_boots(3);
    played.sdo_is_deaf = true;
    run_ms(3);
    played.sdo_is_deaf = false;
    drive_boots(0);
    run_to(TUMBLE_STAND_READY, 100);
}

/* A permission to reset is used up when the drive is up, fault or no fault. */
static void test_a_later_fault_is_not_reset_unasked(void)
{
    start_move(&common);
    played.dead = true;
    run_ms(600);
    played.dead = false;
    run_ms(200);
    recover(TUMBLE_STAND_STOPPED);
    stop_for(20);
    assert_state_after(0, TUMBLE_STAND_STOPPED);
    played.state = IS_FAULT;
    move_for(20, 10.0);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(IS_FAULT, played.state);
}

static void test_without_a_window_target_reached_is_enough(void)
{
    start_move(CHANGED(common, made.window_counts = 0));
    played.moving = false; /* a thousand counts short of it */
    played.bits |= 0x0400U;
    report_now();
    assert_state_after(0, TUMBLE_STAND_IN_POSITION);
}

static void test_profiles_at_the_end_of_their_range(void)
{
    static tumble_object_write_t writes[255];
    tumble_drive_profile_t profile = common;
    for (size_t i = 0; i < COUNT_OF(writes); i++) {
        writes[i] = (tumble_object_write_t){0x2000, 0, 1, 0};
    }
    profile.writes = writes;
    profile.write_count = 211; /* with 13 objects and 30 steps of the PDOs: 254 */
    ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
    profile.write_count = 212;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
    profile = common;
    profile.heartbeat_ms = 1;
    profile.velocity_units_per_deg_s = 1.0;
    profile.velocity_deg_s = 4294967295.0;
    profile.homing_fast_deg_s = 0.5;
    profile.wrap_counts = INT32_MAX;
    profile.start_timeout_ms = 1;
    profile.stop_timeout_ms = 1;
    ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
    bench_setup(&common);
    ASSERT_STATUS(TUMBLE_OK, drive_init(&common, 127));
}

static void test_our_heartbeat_need_not_be_watched(void)
{
    bring_up(CHANGED(common, made.heartbeat_timeout_ms = 0));
    TEST_ASSERT_EQUAL_HEX16(0x1017, played.writes[0].index);
    TEST_ASSERT_EQUAL_UINT(23, played.write_count);
}
