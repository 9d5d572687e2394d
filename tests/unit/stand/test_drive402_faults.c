/* The CiA 402 master with a drive that fails: every fault, and the way back. */
#include "drive_bench.h"

static void test_a_fault_of_the_drive(void)
{
    start_move(&common);
    drive_fails(0x3210, 2);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x3210, bench.drive.report.fault_code);
    TEST_ASSERT_EQUAL_HEX16(0x0002, played.control);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 1.0));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->home(bench.stand.self));
    const unsigned before = played.control_count;
    recover(TUMBLE_STAND_STOPPED);                                    /* homed all the while */
    TEST_ASSERT_EQUAL_HEX16(0x0000, played.controls[before].control); /* the edge of bit 7 */
    TEST_ASSERT_EQUAL_HEX16(0x0080, played.controls[before + 1U].control);
    TEST_ASSERT_EQUAL_HEX16(0x0006, played.controls[before + 2U].control);
    move_to(30.0);
}

/* From a beginning something happens, and so many milliseconds later it is this fault. */
#define EXPECT_FAULT(what, begin, happens, ms, expected)                                                               \
    do {                                                                                                               \
        begin;                                                                                                         \
        happens;                                                                                                       \
        run_ms(ms);                                                                                                    \
        TEST_ASSERT_EQUAL_INT_MESSAGE(TUMBLE_STAND_FAULT, stand_state(), what);                                        \
        TEST_ASSERT_EQUAL_INT_MESSAGE(expected, bench.stand.kind->fault(bench.stand.self), what);                      \
    } while (0)

static void test_what_is_which_fault(void)
{
    EXPECT_FAULT("a fault reaction is a fault already", start_move(&common),
                 (played.state = IS_FAULT_REACTION, report_now()), 0, TUMBLE_STAND_FAULT_DRIVE);
    EXPECT_FAULT("a stall by its emergency message", start_move(&common), drive_fails(0x8611, 0), 2,
                 TUMBLE_STAND_FAULT_STALL);
    EXPECT_FAULT("a stall by bit 13 in fault", start_move(&common), (played.bits |= 0x2000U, drive_fails(0, 0)), 2,
                 TUMBLE_STAND_FAULT_STALL);
    EXPECT_FAULT("a stall is no arrival, whatever else the same report says",
                 start_move(CHANGED(common, made.window_counts = 0)), (played.bits |= 0x2400U, report_now()), 0,
                 TUMBLE_STAND_FAULT_STALL);
    EXPECT_FAULT("power lost at rest", bring_home(&common), played.state = IS_DISABLED, 15, TUMBLE_STAND_FAULT_POWER);
    EXPECT_FAULT("a fault while homing is no stall, bit 13 or not", (bring_up(&common), home_for(20)),
                 (played.bits |= 0x2000U, drive_fails(0x7300, 0)), 2, TUMBLE_STAND_FAULT_DRIVE);
    EXPECT_FAULT("a fault while stopping", (start_move(&common), played.ignores_stop = true, stop_for(5)),
                 drive_fails(0x2220, 0), 2, TUMBLE_STAND_FAULT_DRIVE);
}

static void test_stall_by_a_late_emergency_message(void)
{
    start_move(&common);
    drive_fails(0, 2);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    scripted_drive_emergency(&played, 0x8611);
    assert_fault_after(2, TUMBLE_STAND_FAULT_STALL);
    scripted_drive_emergency(&played, 0x0000); /* "no error" does not hide it */
    run_ms(2);
    TEST_ASSERT_EQUAL_HEX16(0x8611, bench.drive.report.fault_code);
}

static void test_stall_by_bit_13_without_fault(void)
{
    start_move(&common);
    played.bits |= 0x2000U;
    scripted_drive_report(&played);
    assert_fault_after(3, TUMBLE_STAND_FAULT_STALL);
    TEST_ASSERT_FALSE(played.moving); /* it has been stopped */
    played.bits = 0;
    recover(TUMBLE_STAND_STOPPED);
    move_to(30.0);
}

static void test_silence(void)
{
    start_move(&common);
    played.dead = true;
    assert_state_after(390, TUMBLE_STAND_MOVING);
    assert_fault_after(200, TUMBLE_STAND_FAULT_HEARTBEAT);
    clear_fault();
    assert_state_after(0, TUMBLE_STAND_OFFLINE);
    run_ms(100);
    played.dead = false; /* the cable is back; it has never lost its power */
    run_to(TUMBLE_STAND_STOPPED, 500);
    move_to(30.0);
}

static void test_silence_that_ends_before_it_is_cleared(void)
{
    start_move(&common);
    played.dead = true;
    run_ms(600);
    played.dead = false;
    assert_fault_after(200, TUMBLE_STAND_FAULT_HEARTBEAT);
    recover(TUMBLE_STAND_STOPPED);
    move_to(30.0);
}

static void test_power_lost(void)
{
    static const uint16_t states[] = {IS_DISABLED, IS_READY, IS_ON, IS_QUICK_STOP, 0x00};
    for (size_t i = 0; i < COUNT_OF(states); i++) {
        start_move(&common);
        played.state = states[i];
        played.moving = false;
        report_now();
        assert_fault(TUMBLE_STAND_FAULT_POWER);
        played.state = IS_DISABLED;
        recover(TUMBLE_STAND_READY); /* where it stands is not known any more */
        ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 1.0));
        go_home();
    }
}

static void test_a_restart_of_the_drive(void)
{
    start_move(&common);
    played.write_count = 0;
    drive_boots(2);
    assert_fault(TUMBLE_STAND_FAULT_POWER);
    assert_fault_after(500, TUMBLE_STAND_FAULT_POWER);
    TEST_ASSERT_EQUAL_UINT(0, played.write_count); /* nothing by itself */
    recover(TUMBLE_STAND_READY);
    TEST_ASSERT_EQUAL_UINT(24, played.write_count);
}

static void test_a_restart_while_it_is_configured_starts_again(void)
{
    bench_setup(&common);
    drive_boots(6);
    TEST_ASSERT_TRUE((played.write_count > 0U) && (played.write_count < 24U));
    played.write_count = 0;
    boot_drive();
    TEST_ASSERT_EQUAL_UINT(24, played.write_count);
}

static void test_a_restart_after_a_fault(void)
{
    start_move(&common);
    drive_fails(0x1000, 5);
    drive_boots(5);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    recover(TUMBLE_STAND_READY);
}

/* Its boot-up message was not heard, within the time of its heartbeat or long after. */
static void test_a_restart_that_nobody_heard(void)
{
    static const unsigned silent_ms[] = {0, 600};
    for (size_t i = 0; i < COUNT_OF(silent_ms); i++) {
        start_move(&common);
        played.dead = true;
        run_ms(silent_ms[i]);
        drive_boots(0);
        played.actual = 0; /* where it stands is its zero */
        port.to_firmware.count = 0;
        assert_state_after(200, TUMBLE_STAND_FAULT);
        recover(TUMBLE_STAND_READY);
        ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 30.0));
        go_home();
        move_to(30.0);
    }
}

static void test_somebody_stops_the_node(void)
{
    start_move(&common);
    played.operational = false;
    scripted_drive_beat(&played, 127);
    assert_fault_after(2, TUMBLE_STAND_FAULT_PROTOCOL);
    played.moving = false;
    recover(TUMBLE_STAND_READY); /* for all we know it has booted, so it must be homed again */
}

static void test_a_refused_configuration(void)
{
    bench_setup(&common);
    played.refuse_index = 0x6083;
    drive_boots(50);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    const tumble_stand_refusal_t refusal = bench.drive.report.refusal;
    TEST_ASSERT_EQUAL_HEX16(0x6083, refusal.index);
    TEST_ASSERT_EQUAL_HEX8(0, refusal.subindex);
    TEST_ASSERT_EQUAL_HEX32(0x06020000, refusal.abort);
    played.refuse_index = 0;
    clear_fault();
    TEST_ASSERT_EQUAL_HEX16(0, bench.drive.report.refusal.index);
    run_to(TUMBLE_STAND_READY, 500);
}

static void test_a_drive_found_in_fault_is_not_reset_unasked(void)
{
    bench_setup(&common);
    drive_boots(0);
    played.state = IS_FAULT;
    assert_fault_after(100, TUMBLE_STAND_FAULT_DRIVE);
    recover(TUMBLE_STAND_READY);
}

/* The reset is asked for once: a fault that comes back while powering up is a fault again. */
static void test_a_fault_that_comes_back_at_once(void)
{
    start_move(&common);
    drive_fails(0x4210, 5);
    clear_fault();
    while (played.state != IS_READY) {
        run_ms(1);
    }
    drive_fails(0x4211, 5);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(0x4211, bench.drive.report.fault_code);
}

static void test_homing_that_fails(void)
{
    bring_up(&common);
    played.homing_fails = true;
    home_for(60);
    assert_fault(TUMBLE_STAND_FAULT_HOMING);
    played.homing_fails = false;
    recover(TUMBLE_STAND_READY);
    go_home();
}

static void test_a_mode_that_is_refused(void)
{
    bring_up(&common);
    played.refuse_index = 0x6060;
    home_for(15);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_HEX16(0x6060, bench.drive.report.refusal.index);
}

static void test_stop_in_fault_is_sent_all_the_same(void)
{
    start_move(&common);
    drive_fails(0x2220, 5);
    const unsigned before = played.control_count;
    stop_for(2);
    TEST_ASSERT_EQUAL_UINT(before + 1U, played.control_count);
    TEST_ASSERT_EQUAL_HEX16(0x0002, played.control);
    assert_fault(TUMBLE_STAND_FAULT_DRIVE);
}

/* The frame that stops it is lost, and so are the next ones. */
static void test_a_stop_is_repeated_in_fault(void)
{
    for (unsigned lost = 0; lost < 5U; lost++) {
        start_move(&common);
        played.never_reaches = true;
        played.misses = lost;
        played.bits |= 0x2000U;
        assert_fault_after(70, TUMBLE_STAND_FAULT_STALL);
        TEST_ASSERT_FALSE(played.moving);
        const unsigned told = played.control_count;
        run_ms(100);
        TEST_ASSERT_EQUAL_UINT(told, played.control_count); /* that was enough */
    }
}

/* It was away when it was told, and tells nothing of its state now: its heartbeat is enough. */
static void test_a_drive_that_comes_back_is_told_to_stop(void)
{
    start_move(&common);
    played.never_reaches = true;
    played.dead = true;
    assert_fault_after(600, TUMBLE_STAND_FAULT_HEARTBEAT);
    TEST_ASSERT_TRUE(played.moving);
    played.event_only = true;
    played.dead = false;
    run_ms(105);
    TEST_ASSERT_FALSE(played.moving);
    TEST_ASSERT_EQUAL_HEX16(0x0002, played.control);
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT);
}
