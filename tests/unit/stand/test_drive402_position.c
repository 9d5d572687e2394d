/* Where the axis is: reports that are not believed, an axis that strays, homing that has no end, who else commands it. */
#include "drive_bench.h"
#include "stand/drive402/internal.h"

#include <stdlib.h>

#define PER_DEG 100 /* counts */

/* One report with another position than the drive's. */
static void forge(int32_t counts)
{
    const int32_t actual = played.actual;
    played.actual = counts;
    scripted_drive_report(&played);
    played.actual = actual;
    run_ms(1);
}

/* Its reports may say less in the same time. */
static tumble_drive_profile_t slow(void)
{
    tumble_drive_profile_t profile = common;
    profile.velocity_deg_s = 90.0;
    return profile;
}

static void assert_lost(void)
{
    assert_fault(TUMBLE_STAND_FAULT_POSITION);
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_EMCY_POSITION, bench.node.emcy.history[0] & 0xFFFFU);
    recover(TUMBLE_STAND_READY);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 10.0));
    go_home();
}

static void test_one_garbled_report_changes_nothing(void)
{
    bring_home(MADE(slow()));
    run_ms(SCRIPTED_REPORT_MS); /* the first report after the new zero is what the next is compared with */
    for (int i = 0; i < 20; i++) {
        forge((i & 1) ? 12000 : -30000);
        run_ms(10U + (unsigned)i);
    }
    assert_angle(0.0);
    TEST_ASSERT_EQUAL_UINT32(20, bench.drive.report.stop.implausible);
    assert_state_after(0, TUMBLE_STAND_IN_POSITION);
    move_to(30.0);
}

static void test_nor_does_one_in_a_move(void)
{
    start_move(&common);
    forge(-12000);
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    assert_angle(90.0);
}

static void test_two_in_a_row_lose_the_position(void)
{
    const tumble_drive_profile_t profile = slow();
    static const double angles_deg[] = {0.0, 60.0};
    for (size_t i = 0; i < COUNT_OF(angles_deg); i++) {
        bring_home(&profile);
        played.move_ms = 800;
        move_to(angles_deg[i]);
        played.move_ms = 0;
        forge(12000);
        forge(24000);
        assert_lost();
    }
}

/* 120 degrees apart they would be a turn on a drive that wraps: the table would go on a turn away. */
static void test_a_wrapping_drive_does_not_lose_a_turn(void)
{
    tumble_drive_profile_t profile = slow();
    profile.wrap_counts = 36000;
    for (unsigned pause_ms = 0; pause_ms <= 150U; pause_ms += 50U) {
        scripted_drive_t *d = &played;
        bring_home(&profile);
        d->wrap = 36000;
        run_ms(SCRIPTED_REPORT_MS + pause_ms);
        d->event_only = true; /* no true report comes between them */
        forge(12000);
        forge(24000);
        d->event_only = false;
        TEST_ASSERT_EQUAL_INT(0, tumble_drive402_kind.angle_deg(&bench.drive) > 1.0);
        assert_lost();
        assert_angle(0.0);
    }
}

/* Each step could have been made in the time of a report, but not all of them: the way grows with time. */
static void test_forged_reports_between_two_true_ones_turn_no_count(void)
{
    tumble_drive_profile_t profile = slow();
    profile.wrap_counts = 36000;
    for (int step_deg = 5; step_deg <= 45; step_deg += 5) {
        bring_home(&profile);
        played.wrap = 36000;
        run_ms(50);
        played.event_only = true;
        for (int i = 1; i <= (360 / step_deg); i++) {
            played.actual = (i * step_deg * PER_DEG) % 36000;
            scripted_drive_report(&played);
        }
        run_ms(1);
        assert_lost();
    }
}

/* Whoever was away for longer than half a turn takes does not know which one it is in. */
static void test_a_turn_is_not_guessed_after_silence(void)
{
    start_move(MADE(wrapping()));
    played.wrap = 36000;
    played.dead = true;
    assert_fault_after(3000, TUMBLE_STAND_FAULT_HEARTBEAT);
    played.dead = false;
    run_ms(300);
    clear_fault();
    run_to(TUMBLE_STAND_READY, 1000); /* not STOPPED: that would be homed */
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 10.0));
}

/* Slower than any limit of speed, but it was told to rest. */
static void test_an_axis_that_creeps_at_rest(void)
{
    bring_home(&common);
    run_ms(100);
    for (int i = 0; i < 90; i++) { /* 0.9 degrees are forgiven */
        played.actual++;
        run_ms(10);
    }
    assert_state_after(0, TUMBLE_STAND_IN_POSITION);
    for (int i = 0; i < 20; i++) {
        played.actual++;
        run_ms(10);
    }
    assert_lost();
}

static void test_a_stopped_axis_that_is_turned_by_hand(void)
{
    start_move(&common);
    stop_at_rest();
    run_ms(100);
    played.actual += 20 * PER_DEG;
    run_ms(30);
    assert_lost();
}

/* Not homed and without power, nothing is known that could be lost. */
static void test_before_homing_the_axis_may_be_turned(void)
{
    bring_up(&common);
    played.homing_never_ends = true;
    home_for(50);
    stop_for(0);
    run_to(TUMBLE_STAND_READY, 100);
    run_ms(100);
    played.actual += 5000;
    assert_state_after(100, TUMBLE_STAND_READY);
    TEST_ASSERT_EQUAL_UINT32(0, bench.drive.report.stop.implausible);
}

/* Somebody else turns it, by a way that we do not see: it was told to rest. */
static void test_an_axis_that_is_not_homed_and_held_must_rest(void)
{
    bring_up(MADE(halting()));
    played.homing_never_ends = true;
    home_for(50);
    stop_for(0);
    run_to(TUMBLE_STAND_READY, 100);
    played.homing = false;
    run_ms(100);
    played.control = 0x0F;
    played.goal = 100000;
    played.mode = 1;
    played.moving = true;
    assert_fault_after(60, TUMBLE_STAND_FAULT_POSITION);
    run_ms(30);
    TEST_ASSERT_FALSE(played.moving);
}

/* Homing. */

/* The start got lost, and the drive still tells of the homing before: that is none. */
static void test_a_homing_that_never_began(void)
{
    bring_up(CHANGED(common, made.home_timeout_ms = 500));
    played.attained_from_before = true;
    played.old_reports = UINT32_MAX;
    played.homing_never_ends = true;
    home_for(450);
    assert_state_after(0, TUMBLE_STAND_HOMING);
    assert_fault_after(100, TUMBLE_STAND_FAULT_HOMING);
}

/* A method that homes where the axis stands shows nothing else. */
static void test_a_homing_on_the_spot(void)
{
    bring_up(CHANGED(common, made.homing_method = 37));
    played.attained_from_before = true;
    played.old_reports = UINT32_MAX;
    go_home();
}

static void home_without_end(const tumble_drive_profile_t *profile, int32_t counts_per_ms)
{
    bring_up(profile);
    played.homing_never_ends = true;
    played.homing_turns = counts_per_ms;
    played.wrap = (int32_t)profile->wrap_counts;
    home_for(0);
}

static void assert_bounded(const tumble_drive_profile_t *profile, double most_deg)
{
    static const int32_t ways[] = {-20, 20};
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        home_without_end(profile, ways[i]);
        const int32_t from = played.actual;
        run_to_fault(TUMBLE_STAND_FAULT_HOMING, 10000);
        run_ms(50);
        const double turned_deg = (double)abs(played.actual - from) / PER_DEG;
        TEST_ASSERT_TRUE(turned_deg > most_deg - 1.0);
        TEST_ASSERT_TRUE(turned_deg < most_deg + 5.0); /* a report late, and on to the stop */
    }
}

static void test_homing_turns_no_further_than_the_cable_and_a_turn(void)
{
    assert_bounded(CHANGED(common, made.home_timeout_ms = 60000), 790.0);
    made.homing_travel_deg = 100.0;
    assert_bounded(&made, 100.0);
}

static void test_nor_on_a_drive_that_wraps(void)
{
    assert_bounded(CHANGED(wrapping(), made.home_timeout_ms = 60000), 790.0); /* the played drive's own count goes on */
}

/* There and back is added up; the zero that homing sets is no way. */
static void test_a_new_zero_is_no_travel(void)
{
    bring_up(&common);
    played.actual = 90000;
    played.home = -90000;
    go_home();
    assert_angle(-900.0);
}

/* The home offset, which drives count the one way or the other. */
static void test_homing_ends_at_the_home_offset(void)
{
    tumble_drive_profile_t wraps = wrapping();
    const tumble_drive_profile_t *const profiles[] = {&common, &wraps};
    static const int32_t offsets[] = {-1000, -510, 510, 9000};
    for (size_t i = 0; i < COUNT_OF(profiles) * COUNT_OF(offsets) * 2U; i++) {
        bring_up(profiles[i / (COUNT_OF(offsets) * 2U)]);
        played.home = offsets[(i / 2U) % COUNT_OF(offsets)];
        played.negates_offset = (i % 2U) != 0U;
        go_home();
        assert_angle((double)played.home / PER_DEG);
    }
}

/* 35990 counts of 36000 are 10 below zero, also as an offset. */
static void test_nor_is_there_a_circle_between_them(void)
{
    bring_up(MADE(wrapping()));
    played.home = 35000;
    go_home();
    assert_angle(-10.0);
}

/* The table may brake past its mark: up to 5 degrees from 0 a drive needs no home offset. */
static void test_near_zero_nobody_asks_for_the_home_offset(void)
{
    static const int32_t places[] = {-500, 0, 500};
    for (size_t i = 0; i < COUNT_OF(places); i++) {
        bring_up(&common);
        played.refuse_index = 0x607C;
        played.home = places[i];
        go_home();
        TEST_ASSERT_EQUAL_UINT(0, played.refusals);
    }
    bring_up(&common);
    played.refuse_index = 0x607C;
    played.home = 510;
    home_for(0);
    run_to(TUMBLE_STAND_FAULT, 1000);
    assert_refused(0x607C, 0, TUMBLE_STAND_STEP_POSITION_MODE, 0x06020000);
}

/* Reports that are frozen from before: home is where the table is, and nobody knows it. */
static void test_a_homing_that_leaves_the_position_elsewhere(void)
{
    static const int32_t shown[] = {-14629, -510, 510, 14629, INT32_MIN};
    for (size_t i = 0; i < COUNT_OF(shown); i++) {
        bring_up(&common);
        played.frozen = true;
        played.shown = shown[i];
        home_for(0);
        run_to_fault(TUMBLE_STAND_FAULT_HOMING, 1000);
        recover(TUMBLE_STAND_READY);
        ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 0.0));
        played.frozen = false;
        go_home();
    }
}

/* Nobody has seen it: the statusword came, and the position only when it was asked for after homing. */
static void test_homing_that_turned_too_far_unseen(void)
{
    static const tumble_drive_pdo_t apart[] = {
        {0, {.cob_id = 0x182, .type = 255, .count = 1, .event_ms = 10, .map = {0x60410010}}},
        {1, {.cob_id = 0x282, .type = 255, .count = 1, .event_ms = 1000, .map = {0x60640020}}},
    };
    bring_up(
        CHANGED(common, made.transmit = apart, made.transmit_count = COUNT_OF(apart), made.homing_travel_deg = 80.0));
    played.second_ms = 1000;
    played.home = 9000;
    home_for(0);
    run_to_fault(TUMBLE_STAND_FAULT_HOMING, 500);
}

/* An axis that turns and is not seen is stopped. */
static void test_homing_that_nobody_sees(void)
{
    home_without_end(CHANGED(common, made.home_timeout_ms = 60000), -1);
    run_ms(100);
    TEST_ASSERT_EQUAL_UINT64(bench.drive.reported_us + 1200000U, tumble_drive_blind_us(&bench.drive));
    played.transmit[0].cob_id |= 0x80000000U; /* somebody has switched its process data off */
    assert_state_after(1100, TUMBLE_STAND_HOMING);
    assert_fault_after(130, TUMBLE_STAND_FAULT_PROTOCOL);
}

/* Limits of the drive's own. */

static void test_the_cables_limits_are_written_and_read_back(void)
{
    bench_setup(CHANGED(common, made.software_limits = true, made.sign = -1));
    TEST_ASSERT_FALSE(bench.drive.report.limited); /* nobody has asked the drive yet */
    boot_drive();
    TEST_ASSERT_TRUE(bench.drive.report.limited);
    TEST_ASSERT_EQUAL_INT32(-40000, played.limits[0]);
    TEST_ASSERT_EQUAL_INT32(3000, played.limits[1]);
    TEST_ASSERT_EQUAL_UINT(26, played.write_count);
}

static void test_a_drive_that_does_not_keep_them_does_not_run(void)
{
    bench_setup(CHANGED(common, made.software_limits = true));
    played.keeps_no_limits = true;
    drive_boots(0);
    run_to(TUMBLE_STAND_FAULT, 500);
    assert_refused(0x607D, 1, TUMBLE_STAND_STEP_CONFIGURATION, TUMBLE_ABORT_VALUE);
    TEST_ASSERT_FALSE(bench.drive.report.limited);
}

static void test_a_drive_without_them_is_said_to_be_so(void)
{
    const tumble_drive_profile_t *const profiles[] = {
        &common, CHANGED(wrapping(), made.software_limits = true)}; /* in a circle there is no end */
    for (size_t i = 0; i < COUNT_OF(profiles); i++) {
        bench_setup(profiles[i]);
        TEST_ASSERT_FALSE(bench.drive.report.limited);
        boot_drive();
        TEST_ASSERT_EQUAL_UINT(24, played.write_count);
    }
}

/* Somebody else. */

static void test_a_foreign_command_stops_the_axis(void)
{
    static const bool moves[] = {false, true};
    for (size_t i = 0; i < COUNT_OF(moves); i++) {
        bring_home(&common);
        if (moves[i]) {
            move_for(20, 90.0);
        }
        TEST_ASSERT_FALSE(tumble_drive402_kind.foreign(&bench.drive, 0x302, false));
        TEST_ASSERT_TRUE(tumble_drive402_kind.foreign(&bench.drive, 0x202, false));
        assert_fault(TUMBLE_STAND_FAULT_FOREIGN);
        TEST_ASSERT_EQUAL_HEX32(((uint32_t)0x202 << 16) | TUMBLE_EMCY_FOREIGN, bench.node.emcy.history[0]);
        (void)tumble_drive402_kind.foreign(&bench.drive, 0x202, false); /* told once */
        TEST_ASSERT_EQUAL_UINT8(1, bench.node.emcy.recorded);
        run_ms(50);
        TEST_ASSERT_FALSE(played.moving);
        recover(TUMBLE_STAND_READY);
    }
}

/* Our own process data are set right again when a drive comes: nobody could be told by what is left of them. */
static void test_our_process_data_are_mended(void)
{
    bench_setup(&common);
    const tumble_pdo_setup_t other = {.cob_id = 0x80000202U, .type = 255};
    TEST_ASSERT_EQUAL_HEX32(
        0, tumble_pdo_configure(&bench.node.pdos, &bench.node.dictionary, TUMBLE_PDO_TRANSMIT, 0, &other));
    boot_drive();
    TEST_ASSERT_EQUAL_HEX32(0x202, bench.node.pdos.transmit[0].pdo.cob_id);
    TEST_ASSERT_EQUAL_UINT8(2, bench.node.pdos.transmit[0].pdo.count);
}
