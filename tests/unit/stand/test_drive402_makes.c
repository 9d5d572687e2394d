/* Drives of other makes: process data in two PDOs, objects that are not there, PDOs that cannot be written, homing that
 * takes no time, bit 12 from Operation enabled on; and what is told of a drive that refuses. */
#include "drive_bench.h"
#include "stand/drive402/internal.h"

/* Statusword and position in PDOs of their own. */
static const tumble_drive_pdo_t apart[] = {
    {0, {.cob_id = 0x182, .type = 255, .count = 1, .event_ms = 10, .map = {0x60410010}}},
    {1, {.cob_id = 0x282, .type = 255, .count = 1, .event_ms = 50, .map = {0x60640020}}}};

static tumble_drive_profile_t two_pdos(uint32_t window_counts)
{
    tumble_drive_profile_t profile = common;
    profile.transmit = apart;
    profile.transmit_count = 2;
    profile.window_counts = window_counts;
    return profile;
}

/* The statusword comes first. In position is the table where it stands, not where it was reported last. */
static void test_a_position_that_comes_later_is_waited_for(void)
{
    static const uint32_t windows[] = {0, 10};
    static const double angles_deg[] = {170.0, 10.0, 40.0};
    for (size_t i = 0; i < COUNT_OF(windows); i++) {
        const tumble_drive_profile_t profile = two_pdos(windows[i]);
        bench_setup(&profile);
        played.second_ms = 50;
        boot_drive();
        go_home();
        for (size_t a = 0; a < COUNT_OF(angles_deg); a++) {
            move_to(angles_deg[a]);
            assert_angle(angles_deg[a]);
        }
    }
}

/* And if no report comes any more, because nothing changes, it is asked for. */
static void test_a_position_that_never_comes_is_asked_for(void)
{
    bench_setup(MADE(two_pdos(0)));
    played.second_ms = 100000;
    boot_drive();
    go_home();
    move_to(170.0);
    assert_angle(170.0);
    played.refuse_index = 0x6064;
    move_for(0, 0.0);
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x6064, 0, TUMBLE_STAND_STEP_MOTION, 0x06020000);
}

/* Between question and answer the drive says that it is not there after all. The answer waits, and keeps nobody busy. */
static void test_an_answer_about_an_arrival_that_is_over_waits(void)
{
    bench_setup(MADE(two_pdos(0)));
    played.second_ms = 100000;
    boot_drive();
    go_home();
    played.never_reaches = true;
    move_for(60, 170.0);
    const uint8_t reached[] = {0x37, 0x06};
    const uint8_t not_reached[] = {0x37, 0x02};
    tumble_can_frame_t frame;
    scripted_drive_send(&played, 0x182, 2, reached);
    while (tumble_link_receive(&bench.node.link, &frame) == TUMBLE_OK) {
        (void)tumble_node_receive(&bench.node, &frame, port.now_us);
    }
    scripted_drive_send(&played, 0x182, 2, not_reached);
    run_ms(3);
    TEST_ASSERT_EQUAL_HEX16(0x6064, bench.node.client.index);
    ASSERT_STATUS(TUMBLE_OK, tumble_sdo_client_result(&bench.node.client));
    TEST_ASSERT_TRUE(tumble_drive402_kind.next_us(&bench.drive) > port.now_us);
    scripted_drive_send(&played, 0x182, 2, reached);
    run_to(TUMBLE_STAND_IN_POSITION, 500);
}

static void test_what_is_refused_is_named(void)
{
    static const uint16_t objects[] = {0x1016, 0x6084, 0x609A, 0x1A00};
    for (size_t i = 0; i < COUNT_OF(objects); i++) {
        tumble_drive_profile_t profile = common;
        profile.deceleration_deg_s2 = 100.0;
        profile.homing_acceleration_deg_s2 = 100.0;
        bench_setup(&profile);
        drive_boots(0);
        played.refuse_index = objects[i];
        run_to(TUMBLE_STAND_FAULT, 500);
        assert_refused(objects[i], (objects[i] == 0x1016) ? 1U : 0U, TUMBLE_STAND_STEP_CONFIGURATION, 0x06020000);
        played.refuse_index = 0;
        recover(TUMBLE_STAND_READY);
        TEST_ASSERT_EQUAL_HEX16(0, bench.drive.report.refusal.index);
    }
}

static void test_which_handshake_broke_is_named(void)
{
    bring_up(&common);
    played.mode_sticks = true;
    home_for(0);
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x6061, 0, TUMBLE_STAND_STEP_HOMING_MODE, TUMBLE_ABORT_TIMEOUT);
    bring_home(&common);
    played.never_acknowledges = true;
    move_for(0, 10.0);
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x6041, 0, TUMBLE_STAND_STEP_SET_POINT, TUMBLE_ABORT_TIMEOUT);
    bring_home(&common);
    played.keeps_acknowledging = true;
    move_for(0, 10.0);
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x6041, 0, TUMBLE_STAND_STEP_RELEASE, TUMBLE_ABORT_TIMEOUT);
}

static void assert_not_written(uint16_t first, uint16_t last)
{
    for (unsigned i = 0; i < played.write_count; i++) {
        TEST_ASSERT_FALSE((played.writes[i].index >= first) && (played.writes[i].index <= last));
    }
}

/* 0 in the profile: it is not there, or right as it is. */
static void test_what_the_drive_does_not_have_is_left_out(void)
{
    bring_home(CHANGED(common, made.heartbeat_ms = 0, made.homing_method = 0, made.quick_stop_deg_s2 = 0.0));
    assert_not_written(0x1017, 0x1017);
    assert_not_written(0x6084, 0x6085);
    assert_not_written(0x6098, 0x6098);
    assert_not_written(0x609A, 0x609A);
}

/* PDOs that cannot be written are read. */

static void begin_fixed(const tumble_drive_profile_t *profile, uint32_t mapped)
{
    bench_setup(profile);
    played.fixed_pdos = true;
    played.receive[0] = (scripted_pdo_t){0x202, 2, {0x60400010, 0x607A0020}};
    played.transmit[0] = (scripted_pdo_t){0x182, 2, {0x60410010, mapped}};
    drive_boots(0);
}

static void test_pdos_that_are_kept_must_be_as_the_profile_has_them(void)
{
    begin_fixed(CHANGED(common, made.keeps_pdos = true), 0x60640020);
    run_to(TUMBLE_STAND_READY, 500);
    TEST_ASSERT_EQUAL_UINT(0, played.refusals);
    go_home();
    move_to(45.0);
    assert_angle(45.0);
    begin_fixed(&made, 0x606C0020); /* the velocity, and it would be taken for the position */
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x1A00, 2, TUMBLE_STAND_STEP_CONFIGURATION, TUMBLE_ABORT_VALUE);
    begin_fixed(&common, 0x60640020);
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x1400, 1, TUMBLE_STAND_STEP_CONFIGURATION, 0x06020000);
}

/* A drive that was Operational before us takes nothing by PDO until it has our mapping: another controlword would be
 * one that it cannot take, or takes for something else. It is told to stop by SDO. */
static void test_no_word_goes_out_before_the_mapping(void)
{
    bring_home(&common);
    played.moving = true;
    played.goal = 100000;
    played.brakes_for_ms = 45;
    played.quick_stop_stays = true;
    played.receive[0] = (scripted_pdo_t){0x202, 1, {0x60400010}};
    played.control_count = 0;
    played.write_count = 0;
    restart_computer();
    for (unsigned ms = 0; (ms < 500U) && (played.receive[0].count != 2U); ms++) {
        TEST_ASSERT_EQUAL_UINT(0, played.control_count);
        run_ms(1);
    }
    const scripted_write_t *first = &played.writes[(played.writes[0].index == 0x1017U) ? 1 : 0];
    TEST_ASSERT_EQUAL_HEX16(0x6040, first->index);
    TEST_ASSERT_EQUAL_HEX32(0x0002, first->value);
    run_to(TUMBLE_STAND_READY, 500);
    TEST_ASSERT_FALSE(played.coasted);
}

/* What it said while it was brought up is not what a later fault comes from. */
static void test_an_old_emergency_is_not_the_code_of_a_later_fault(void)
{
    bench_setup(&common);
    drive_boots(0);
    scripted_drive_emergency(&played, 0x8220);
    run_to(TUMBLE_STAND_READY, 500);
    TEST_ASSERT_EQUAL_HEX16(0, bench.drive.report.fault_code);
    scripted_drive_emergency(&played, 0x8220);
    scripted_drive_emergency(&played, 0);
    run_ms(5);
    go_home();
    TEST_ASSERT_EQUAL_HEX16(0, bench.drive.report.fault_code);
    scripted_drive_fail(&played, &port, 0x3210);
    scripted_drive_emergency(&played, 0);
    run_to(TUMBLE_STAND_FAULT, 20);
    TEST_ASSERT_EQUAL_HEX16(0x3210, bench.drive.report.fault_code);
}

static void test_how_far_a_stop_has_gone_is_told(void)
{
    start_move(&common);
    played.ignores_stop = true;
    stop_for(500);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_SDO, bench.drive.report.rung);
    run_ms(600);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_NMT, bench.drive.report.rung);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->clear_fault(bench.stand.self));
}

/* At its mark already: bit 12 is set when the first statusword after the start comes, and was clear before it. */
static void test_a_homing_that_takes_no_time(void)
{
    bench_setup(&common);
    played.homes_at_once = true;
    boot_drive();
    go_home();
    home_for(0); /* again: it may have slipped meanwhile */
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    move_to(45.0);
}

/* Nor does a start that got lost pass for one: it is given again. */
static void test_a_start_of_homing_that_got_lost_is_given_again(void)
{
    bring_up(&common);
    played.homes_at_once = true;
    played.actual = 777;
    home_for(0);
    while (bench.drive.phase != (uint8_t)PHASE_HOMING) {
        run_ms(1);
    }
    played.misses = 1;
    played.bits |= 0x1400; /* of the homing before, shown late */
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    assert_angle(0.0);
}

static void test_bit_12_may_be_set_from_operation_enabled_on(void)
{
    tumble_drive_profile_t profile = common;
    profile.acknowledges_enabling = true;
    for (unsigned known = 0; known < 2U; known++) {
        bench_setup((known != 0U) ? &profile : &common);
        played.acknowledges_enabling = true;
        boot_drive();
        go_home();
        move_for(0, 30.0);
        run_to((known != 0U) ? TUMBLE_STAND_IN_POSITION : TUMBLE_STAND_FAULT, 1000);
    }
    assert_angle(30.0);
    move_to(10.0);
    stop_at_rest();
    move_to(60.0);
    assert_angle(60.0);
}
