/* A stop is a state that is seen: every rung of the ladder, when it is climbed, what it tells, and when it is left. */
#include "drive_bench.h"
#include "stand/drive402/internal.h"

/* Moving, and stop has just been told. */
static void stop_a_move(const tumble_drive_profile_t *profile)
{
    start_move(profile);
    played.never_reaches = true;
    played.write_count = 0;
    played.nmt_stops = 0;
    played.silent_ms = 0;
    stop_for(0);
}

static void assert_counters(uint32_t again, uint32_t by_sdo, uint32_t by_nmt, uint32_t by_silence, uint32_t unconfirmed)
{
    const tumble_stop_counters_t *counters = &bench.drive.report.stop;
    TEST_ASSERT_EQUAL_UINT32(again, counters->rungs[0]);
    TEST_ASSERT_EQUAL_UINT32(by_sdo, counters->rungs[1]);
    TEST_ASSERT_EQUAL_UINT32(by_nmt, counters->rungs[2]);
    TEST_ASSERT_EQUAL_UINT32(by_silence, counters->rungs[3]);
    TEST_ASSERT_EQUAL_UINT32(unconfirmed, counters->rungs[4]);
}

static void assert_told(tumble_stop_rung_t rung)
{
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_EMCY_STOP, bench.node.emcy.history[0] & 0xFFFFU);
    TEST_ASSERT_EQUAL_HEX32(rung, bench.node.emcy.history[0] >> 16);
    TEST_ASSERT_TRUE((bench.node.emcy.error_register & TUMBLE_ERROR_PROFILE) != 0U);
}

static void test_a_stop_that_is_obeyed_tells_nothing(void)
{
    stop_a_move(&common);
    run_to(TUMBLE_STAND_STOPPED, 100);
    run_ms(3000);
    assert_counters(0, 0, 0, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(0, bench.node.emcy.recorded);
    TEST_ASSERT_EQUAL_UINT(0, played.nmt_stops);
}

/* Process data do not reach it: it is told by SDO. */
static void test_the_second_way_is_sdo(void)
{
    stop_a_move(&common);
    played.misses = UINT32_MAX;
    run_ms(395);
    TEST_ASSERT_TRUE(played.moving);
    assert_counters(1, 0, 0, 0, 0);
    assert_told(TUMBLE_RUNG_AGAIN);
    run_ms(10);
    TEST_ASSERT_FALSE(played.moving);
    TEST_ASSERT_EQUAL_HEX16(0x6040, played.writes[0].index);
    TEST_ASSERT_EQUAL_HEX32(0x0002, played.writes[0].value);
    TEST_ASSERT_EQUAL_UINT8(2, played.writes[0].size);
    assert_told(TUMBLE_RUNG_SDO);
    run_to(TUMBLE_STAND_STOPPED, 100);
    assert_counters(1, 1, 0, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(0, bench.node.emcy.error_register); /* it rests */
    played.misses = 0;
    played.never_reaches = false;
    move_to(30.0);
}

/* Nor does SDO: it is taken out of operation. From then on nothing tells of the axis. */
static void test_the_third_way_is_nmt(void)
{
    stop_a_move(&common);
    played.misses = UINT32_MAX;
    played.sdo_is_deaf = true;
    run_ms(995);
    TEST_ASSERT_TRUE(played.moving);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    run_ms(10);
    TEST_ASSERT_FALSE(played.moving);
    TEST_ASSERT_EQUAL_UINT(1, played.nmt_stops);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    assert_told(TUMBLE_RUNG_NMT);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->clear_fault(bench.stand.self)); /* not before it is over */
    played.misses = 0;
    played.sdo_is_deaf = false;
    clear_fault();
    assert_counters(1, 1, 1, 1, 1);
    run_to(TUMBLE_STAND_READY, 500); /* and it must be homed again */
    TEST_ASSERT_EQUAL_UINT8(0, bench.node.emcy.error_register);
}

/* Nor that: our heartbeat is withheld for longer than the drive's consumer waits, and comes back. */
static void test_the_last_way_is_silence(void)
{
    stop_a_move(&common);
    played.misses = UINT32_MAX;
    played.sdo_is_deaf = true;
    played.ignores_nmt = true;
    played.watches_ms = common.heartbeat_timeout_ms;
    run_ms(1490);
    TEST_ASSERT_TRUE(played.moving);
    TEST_ASSERT_TRUE(played.silent_ms <= 101U);
    run_ms(610);
    TEST_ASSERT_FALSE(played.moving);
    TEST_ASSERT_TRUE(played.silent_ms > common.heartbeat_timeout_ms);
    assert_counters(1, 1, 1, 1, 0);
    run_ms(300);
    assert_told(TUMBLE_RUNG_UNCONFIRMED); /* nobody has seen it at rest */
    assert_counters(1, 1, 1, 1, 1);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
    played.silent_ms = 0;
    run_ms(1000);
    TEST_ASSERT_TRUE(played.silent_ms <= 101U);
    assert_counters(1, 1, 1, 1, 1);
}

/* The same from a fault, which stops the axis as well. */
static void test_a_fault_climbs_too(void)
{
    start_move(&common);
    played.never_reaches = true;
    played.misses = UINT32_MAX;
    played.bits |= 0x2000U;
    assert_fault_after(405, TUMBLE_STAND_FAULT_STALL);
    run_ms(50);
    TEST_ASSERT_FALSE(played.moving);
    assert_counters(1, 1, 0, 0, 0);
    assert_fault(TUMBLE_STAND_FAULT_STALL);
}

/* A drive that has been seen to brake gets the profile's time, and then no more. */
static void test_one_that_brakes_for_ever(void)
{
    stop_a_move(&common);
    played.quick_stop_stays = true;
    played.brakes_for_ms = 100000;
    played.goal = 10000000;
    run_ms(590);
    assert_counters(0, 0, 0, 0, 0);
    run_ms(20); /* 0.4 s for the brake, and 0.2 s */
    assert_counters(1, 0, 0, 0, 0);
    run_ms(800);
    assert_counters(1, 1, 1, 0, 0);
    assert_fault(TUMBLE_STAND_FAULT_STOP);
}

/* Without power it coasts: only a position that no longer changes is rest. */
static void test_a_coasting_axis_is_not_at_rest(void)
{
    start_move(&common);
    stop_for(0);
    played.state = IS_DISABLED;
    played.ignores_stop = true;
    played.never_reaches = true;
    run_ms(100);
    TEST_ASSERT_TRUE(played.moving);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    played.moving = false;
    run_to(TUMBLE_STAND_STOPPED, 60);
}

static void test_a_drive_that_boots_has_let_go(void)
{
    stop_a_move(&common);
    played.misses = UINT32_MAX;
    run_ms(300);
    drive_boots(3000);
    assert_counters(1, 0, 0, 0, 0);
    assert_fault(TUMBLE_STAND_FAULT_POWER);
}

/* The next moment is never missed: stepped at its deadlines alone it climbs at the same times. */
static void test_every_rung_is_a_deadline(void)
{
    static const uint64_t after_us[] = {200000, 400000, 1000000, 1500000, 2300000};
    stop_a_move(&common);
    const uint64_t told_us = bench.drive.told_us;
    played.dead = true;
    for (size_t i = 0; i < COUNT_OF(after_us); i++) {
        TEST_ASSERT_EQUAL_UINT64(told_us + after_us[i], tumble_drive_next_rung_us(&bench.drive));
        tumble_drive402_kind.step(&bench.drive, told_us + after_us[i] - 1U);
        TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_TOLD + i, bench.drive.rung);
        tumble_drive402_kind.step(&bench.drive, told_us + after_us[i]);
        TEST_ASSERT_EQUAL_UINT8(TUMBLE_RUNG_AGAIN + i, bench.drive.rung);
    }
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_drive_next_rung_us(&bench.drive));
}
