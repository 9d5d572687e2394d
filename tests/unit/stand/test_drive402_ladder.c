/* No way leads past the ladder: bring-ups that fail, messages that are not the drive's, Halt, an axis in FAULT. */
#include "drive_bench.h"
#include "stand/drive402/internal.h"

#define PER_DEG 100 /* counts */
#define FAR 100000000

/* Reports without a timer: the drive tells of changes alone. */
static const tumble_drive_pdo_t untimed[] = {
    {0, {.cob_id = 0x40000182, .type = 255, .count = 2, .map = {0x60410010, 0x60640020}}}};

static uint32_t climbed(tumble_stop_rung_t rung)
{
    return bench.drive.report.stop.rungs[rung - TUMBLE_RUNG_AGAIN];
}

static void start_endless_homing(const tumble_drive_profile_t *profile, int32_t counts_per_ms)
{
    bring_up(profile);
    played.homing_never_ends = true;
    played.homing_turns = counts_per_ms;
    home_for(200);
    TEST_ASSERT_TRUE(played.homing);
    played.write_count = 0;
}

static void start_endless_move(const tumble_drive_profile_t *profile)
{
    start_move(profile);
    played.never_reaches = true;
    played.goal = FAR;
    played.write_count = 0;
}

/* A computer that is held up climbs every rung whose time has passed, not only those it looks at to the microsecond. */
static void test_a_step_that_comes_late_climbs_what_is_due(void)
{
    start_endless_move(&common);
    tumble_drive402_kind.stop(&bench.drive);
    run_ms(1);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_TOLD, bench.drive.rung);
    port.now_us += 60000001U;
    tumble_drive402_kind.step(&bench.drive, port.now_us);
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_AGAIN));
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_SDO));
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_NMT));
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_SILENCE));
}

/* Before POWER nothing has been set going by us, but the axis may turn since before a restart. */
static void test_a_bring_up_that_fails_stops_a_turning_axis(void)
{
    static const uint16_t refused[] = {0x1600, 0x6098, 0x1A00};
    for (size_t i = 0; i < COUNT_OF(refused); i++) {
        start_endless_homing(&common, 10);
        restart_computer();
        played.refuse_index = refused[i];
        played.misses = UINT32_MAX;
        run_to(TUMBLE_STAND_FAULT, 500);
        TEST_ASSERT_FALSE(played.homing); /* it was told by SDO before anything else */
        assert_fault_after(2400, TUMBLE_STAND_FAULT_PROTOCOL);
        TEST_ASSERT_EQUAL_UINT32(0, climbed(TUMBLE_RUNG_NMT));
    }
}

/* A bring-up that is not answered fails likewise, and the third way is left. */
static void test_nor_does_it_turn_on_where_no_sdo_is_answered(void)
{
    start_endless_homing(&common, 10);
    restart_computer();
    played.sdo_is_deaf = true;
    played.misses = UINT32_MAX;
    run_to(TUMBLE_STAND_FAULT, 10000);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_TOLD, bench.drive.rung);
    run_ms(2400);
    TEST_ASSERT_FALSE(played.homing);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_NMT));
}

/* A boot-up says that the drive has let go; its statusword afterwards says whether that is true. */
static void test_a_forged_boot_up_does_not_end_the_ladder(void)
{
    static const unsigned after_ms[] = {0, 300}; /* the stop: none has been told, or it is at work */
    const uint8_t boot_up = 0;
    for (size_t i = 0; i < COUNT_OF(after_ms); i++) {
        start_endless_homing(&common, 10);
        played.misses = UINT32_MAX;
        if (after_ms[i] != 0U) {
            stop_for(after_ms[i]);
        }
        scripted_drive_send(&played, 0x702, 1, &boot_up);
        run_ms(500);
        TEST_ASSERT_FALSE(played.homing);
        assert_fault(TUMBLE_STAND_FAULT_POWER);
        TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_SDO));
    }
}

/* Somebody else resets and enables the drive while we wait in FAULT. */
static void test_an_axis_that_is_set_going_in_fault_is_stopped(void)
{
    start_move(&common);
    drive_fails(0x1234, 3000);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_NONE, bench.drive.rung);
    played.state = IS_ENABLED;
    played.moving = true;
    played.never_reaches = true;
    played.goal = FAR;
    played.misses = UINT32_MAX;
    run_ms(450);
    TEST_ASSERT_FALSE(played.moving);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_SDO));
    TEST_ASSERT_EQUAL_UINT32(0, climbed(TUMBLE_RUNG_NMT));
}

/* The first stop reached the end of the ladder; whoever commands another one is not told that nothing is left. */
static void test_a_second_stop_climbs_again(void)
{
    start_endless_homing(&common, 10);
    played.misses = UINT32_MAX;
    played.sdo_is_deaf = true;
    played.ignores_nmt = true;
    stop_for(5000);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_UNCONFIRMED, bench.drive.rung);
    TEST_ASSERT_TRUE(played.homing);
    played.sdo_is_deaf = false;
    played.operational = true; /* somebody has started it again */
    played.stopped = false;
    stop_for(450);
    TEST_ASSERT_FALSE(played.homing);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    TEST_ASSERT_EQUAL_UINT32(2, climbed(TUMBLE_RUNG_SDO));
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_NMT));
}

/* A drive that was seen to brake keeps the time for it, whatever one old report says. */
static void test_a_stray_statusword_does_not_rush_the_ladder(void)
{
    tumble_drive_profile_t slow = common;
    slow.stop_timeout_ms = 5000;
    start_endless_move(&slow);
    played.quick_stop_stays = true;
    played.brakes_for_ms = 3500;
    stop_for(3000);
    const uint16_t braking = played.state;
    played.state = IS_ENABLED;
    scripted_drive_report(&played);
    played.state = braking;
    run_ms(5);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_TOLD, bench.drive.rung);
    run_to(TUMBLE_STAND_STOPPED, 600);
    TEST_ASSERT_EQUAL_UINT32(0, climbed(TUMBLE_RUNG_AGAIN));
    TEST_ASSERT_EQUAL_UINT32(0, climbed(TUMBLE_RUNG_NMT));
}

/* Halt. */

/* A drive that did not hear the Halt looks like one that obeys it: the second way is not waited for. */
static void test_halt_is_told_by_sdo_at_once(void)
{
    start_endless_move(MADE(halting()));
    played.misses = UINT32_MAX;
    stop_for(5);
    TEST_ASSERT_FALSE(played.moving);
    TEST_ASSERT_EQUAL_UINT(1, played.write_count);
    TEST_ASSERT_EQUAL_HEX16(0x6040, played.writes[0].index);
    TEST_ASSERT_EQUAL_HEX32(0x010F, played.writes[0].value);
    TEST_ASSERT_EQUAL_UINT8(2, played.writes[0].size);
    run_to(TUMBLE_STAND_STOPPED, 100);
    TEST_ASSERT_EQUAL_UINT32(0, climbed(TUMBLE_RUNG_AGAIN));
}

/* Bit 10 of the target before is no standstill: the position tells. */
static void test_a_halt_that_nobody_hears_is_no_rest(void)
{
    bring_home(MADE(halting()));
    played.reached_lingers = true;
    move_for(30, 300.0);
    TEST_ASSERT_TRUE(played.moving);
    played.goal = FAR;
    played.never_reaches = true;
    played.misses = UINT32_MAX;
    played.sdo_is_deaf = true;
    stop_for(590);
    TEST_ASSERT_TRUE(played.moving);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    run_ms(830); /* 0.4 s for the brake, 1 s for the ladder */
    TEST_ASSERT_FALSE(played.moving);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_NMT));
}

/* What is believed on the way. */

static void report_every(unsigned ms, unsigned most_ms)
{
    for (unsigned i = 1; (i <= most_ms) && (stand_state() == TUMBLE_STAND_HOMING); i++) {
        run_ms(1);
        if ((i % ms) == 0U) {
            scripted_drive_report(&played);
        }
    }
}

/* Homing may be faster than the profile's velocity, and reports rare: each way counts, plausible or not. */
static void test_a_fast_homing_is_bounded_by_rare_reports(void)
{
    static const struct {
        unsigned report_ms;
        int32_t counts_per_ms;
    } ways[] = {{400, 3}, {100, 5}};
    tumble_drive_profile_t profile = common;
    profile.velocity_deg_s = 5.0;
    profile.home_timeout_ms = 60000;
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        start_endless_homing(&profile, ways[i].counts_per_ms);
        const int32_t from = played.actual;
        played.event_only = true;
        report_every(ways[i].report_ms, 55000);
        assert_fault(TUMBLE_STAND_FAULT_HOMING);
        const double turned_deg = (double)(played.actual - from) / PER_DEG;
        TEST_ASSERT_TRUE(turned_deg > 770.0);
        TEST_ASSERT_TRUE(turned_deg < 810.0);
    }
}

/* At rest such a drive tells nothing for as long as it likes, and has not turned round meanwhile. */
static void test_a_wrapping_drive_without_timer_keeps_its_position_at_rest(void)
{
    bring_up(CHANGED(wrapping(), made.transmit = untimed));
    played.wrap = 36000;
    played.event_only = true;
    scripted_drive_report(&played);
    go_home();
    move_to(30.0);
    run_ms(60000);
    for (int32_t by = 1; by >= -1; by -= 2) {
        played.actual += by;
        scripted_drive_report(&played);
        run_ms(20);
    }
    assert_state_after(0, TUMBLE_STAND_IN_POSITION);
    TEST_ASSERT_EQUAL_UINT32(0, bench.drive.report.stop.implausible);
    assert_angle(30.0);
}

/* That the axis rests does not say where: the error of a lost position stays until it is cleared. */
static void test_the_end_of_the_ladder_leaves_the_error_of_a_lost_position(void)
{
    start_endless_move(&common);
    played.misses = UINT32_MAX;
    (void)tumble_drive402_kind.foreign(&bench.drive, 0x202, false);
    run_ms(1000);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_NONE, bench.drive.rung);
    TEST_ASSERT_EQUAL_UINT32(1, climbed(TUMBLE_RUNG_SDO));
    assert_fault(TUMBLE_STAND_FAULT_FOREIGN);
    TEST_ASSERT_TRUE((bench.node.emcy.error_register & TUMBLE_ERROR_PROFILE) != 0U);
    played.misses = 0;
    clear_fault();
    TEST_ASSERT_EQUAL_UINT8(0, bench.node.emcy.error_register);
}
