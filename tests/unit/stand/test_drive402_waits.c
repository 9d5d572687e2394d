/* The CiA 402 master with a drive that keeps it waiting: every wait ends. */
#include "drive_bench.h"

static void test_an_unanswered_configuration(void)
{
    bench_setup(&common);
    played.sdo_is_deaf = true;
    drive_boots(600);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_HEX32(0x05040000, bench.drive.report.refusal.abort);
    TEST_ASSERT_EQUAL_HEX16(0x1016, bench.drive.report.refusal.index);
}

/* A drive that was there before us, without a heartbeat. */
static void find_mute_drive(void)
{
    bench_setup(&common);
    played.dead = false;
    played.state = IS_DISABLED;
    played.mute = true;
    for (unsigned n = 0; n < 4U; n++) {
        played.receive[n].cob_id = 0x80000000U;
        played.transmit[n].cob_id = 0x80000000U;
    }
}

static void test_a_drive_without_a_heartbeat_is_asked_for_one(void)
{
    find_mute_drive();
    run_to(TUMBLE_STAND_READY, 1200); /* the first request it may have missed */
    TEST_ASSERT_EQUAL_HEX16(0x1017, played.writes[0].index);
    TEST_ASSERT_EQUAL_UINT32(common.heartbeat_ms, played.writes[0].value & 0xFFFFU);
    played.mute = true;
    run_ms(600);
    assert_fault(TUMBLE_STAND_FAULT_HEARTBEAT); /* from now on it is watched */
}

static void test_a_drive_that_refuses_a_heartbeat_does_not_run(void)
{
    find_mute_drive();
    played.refuse_index = 0x1017;
    assert_fault_after(3000, TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_HEX16(0x1017, bench.drive.report.refusal.index);
    TEST_ASSERT_EQUAL_HEX32(0x06020000, bench.drive.report.refusal.abort);
    TEST_ASSERT_EQUAL_UINT32(1, played.refusals);
    TEST_ASSERT_EQUAL_UINT32(0, played.nmt_starts);
    clear_fault();
    assert_fault_after(1000, TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_UINT32(2, played.refusals);
    played.refuse_index = 0;
    clear_fault();
    run_to(TUMBLE_STAND_READY, 1200);
}

static void test_a_drive_that_promises_a_heartbeat_and_sends_none_stays_absent(void)
{
    find_mute_drive();
    played.stays_mute = true;
    assert_state_after(3000, TUMBLE_STAND_OFFLINE);
    TEST_ASSERT_EQUAL_UINT32(1, played.write_count);
    TEST_ASSERT_EQUAL_UINT32(0, played.nmt_starts);
    TEST_ASSERT_TRUE(tumble_drive402_kind.next_us(&bench.drive) > port.now_us); /* nothing keeps the computer busy */
}

/* Twice a second, as long as there is nobody. */
static void test_nobody_is_asked_again_and_again(void)
{
    bench_setup(&common);
    const uint32_t before = bench.node.link.counters.sent;
    assert_state_after(3000, TUMBLE_STAND_OFFLINE);
    TEST_ASSERT_UINT32_WITHIN(8, 30U + 12U, bench.node.link.counters.sent - before); /* heartbeats; asked, given up */
    boot_drive();
}

/* It runs this far, and then this habit makes it wait in vain. */
static void expect_late(tumble_stand_fault_t fault, unsigned least_ms, unsigned most_ms)
{
    run_ms(least_ms);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STAND_FAULT, stand_state());
    assert_fault_after(most_ms - least_ms, fault);
}

/* The same of an axis that does not turn then. */
#define EXPECT_LATE(begin, habit, order, fault, least_ms, most_ms)                                                     \
    do {                                                                                                               \
        ROW(#habit ", " #order);                                                                                       \
        begin;                                                                                                         \
        habit;                                                                                                         \
        order;                                                                                                         \
        expect_late(fault, least_ms, most_ms);                                                                         \
        TEST_ASSERT_FALSE(scripted_drive_moves(&played));                                                              \
    } while (0)

static void test_a_wait_in_vain_ends(void)
{
    EXPECT_LATE(bring_home(&common), played.never_acknowledges = true, move_for(0, 90.0), TUMBLE_STAND_FAULT_PROTOCOL,
                140, 170);
    EXPECT_LATE(bring_home(&common), played.keeps_acknowledging = true, move_for(0, 90.0), TUMBLE_STAND_FAULT_PROTOCOL,
                140, 170);
    EXPECT_LATE(bring_home(&common), played.misses = UINT32_MAX, move_for(0, 90.0), TUMBLE_STAND_FAULT_PROTOCOL, 80,
                320); /* targets that all get lost */
    EXPECT_LATE(bring_up(&common), played.homing_never_ends = true, home_for(0), TUMBLE_STAND_FAULT_HOMING, 1990, 2050);
    EXPECT_LATE(bring_up(&common), (played.mode_sticks = true, played.event_only = true), home_for(0),
                TUMBLE_STAND_FAULT_PROTOCOL, 140, 170);
}

static void test_no_process_data_after_the_start(void)
{
    bench_setup(&common);
    played.event_only = true;
    drive_boots(0);
    while (played.write_count < 24U) {
        run_ms(1);
    }
    played.transmit[0].cob_id = 0x80000000U;
    expect_late(TUMBLE_STAND_FAULT_PROTOCOL, 190, 220);
}

static void test_power_that_does_not_come_up(void)
{
    bench_setup(&common);
    played.stays_in_switched_on = true;
    drive_boots(40);
    assert_state_after(0, TUMBLE_STAND_OFFLINE);
    expect_late(TUMBLE_STAND_FAULT_POWER, 200, 320);
}

static void test_a_fault_that_stays(void)
{
    start_move(&common);
    drive_fails(0x4210, 5);
    played.resets_nothing = true;
    clear_fault();
    assert_fault_after(400, TUMBLE_STAND_FAULT_DRIVE);
    TEST_ASSERT_EQUAL_HEX16(IS_FAULT, played.state);
}

static void test_an_acknowledgement_left_over(void)
{
    bring_home(&common);
    played.bits |= 0x1000U;
    played.keeps_acknowledging = true;
    run_ms(15);
    move_for(0, 90.0);
    const unsigned before = played.control_count;
    expect_late(TUMBLE_STAND_FAULT_PROTOCOL, 140, 170);
    for (unsigned i = before; i < played.control_count; i++) {
        TEST_ASSERT_EQUAL_HEX16(0, played.controls[i].control & 0x0010U); /* bit 4 never rose */
    }
}

static void test_a_target_never_reached(void)
{
    bring_home(&common);
    played.never_reaches = true;
    move_for(0, 90.0);
    expect_late(TUMBLE_STAND_FAULT_TIMEOUT, 1490, 1530);
    TEST_ASSERT_FALSE(played.moving);
    played.never_reaches = false;
    recover(TUMBLE_STAND_STOPPED);
    move_to(30.0);
}

static void test_target_reached_somewhere_else(void)
{
    bring_home(&common);
    played.reached_lingers = true;
    played.never_reaches = true;
    played.bits |= 0x0400U;
    move_for(20, 90.0);
    played.moving = false; /* stands still a few degrees on and says that it is there */
    assert_fault_after(1520, TUMBLE_STAND_FAULT_TIMEOUT);
}

/* At one time there is only so much to be done. */
static void assert_steps_end(void)
{
    for (unsigned i = 0; (i < 4U) && (tumble_drive402_kind.next_us(&bench.drive) <= port.now_us); i++) {
        tumble_drive402_kind.step(&bench.drive, port.now_us);
        tumble_node_step(&bench.node, port.now_us);
    }
    TEST_ASSERT_TRUE(tumble_drive402_kind.next_us(&bench.drive) > port.now_us);
}

/* Whatever comes from the bus, no wait is without an end: where it waits by itself, it says until when. */
static void test_nonsense_from_the_bus(void)
{
    dice_t dice = {42};
    bring_home(&common);
    for (unsigned i = 0; i < 60000U; i++) {
        uint8_t data[8];
        const uint64_t random = dice_u64(&dice);
        memcpy(data, &random, sizeof data);
        static const uint16_t ids[] = {0x182, 0x182, 0x182, 0x082, 0x702, 0x582};
        if (dice_below(&dice, 4) == 0U) {
            scripted_drive_send(&played, ids[dice_below(&dice, COUNT_OF(ids))], (uint8_t)dice_below(&dice, 9), data);
        }
        switch (dice_below(&dice, 40)) {
        case 0:
            (void)bench.stand.kind->home(bench.stand.self);
            break;
        case 1:
            (void)bench.stand.kind->move(bench.stand.self, 100.0 * dice_signed_unit(&dice));
            break;
        case 2:
            stop_for(0);
            break;
        case 3:
            (void)bench.stand.kind->clear_fault(bench.stand.self);
            break;
        default:
            break;
        }
        played.control_count = 0;
        played.write_count = 0;
        run_ms(1 + dice_below(&dice, 3));
        const bool waits = (stand_state() == TUMBLE_STAND_HOMING) || (bench.drive.entered_us > port.now_us);
        TEST_ASSERT_TRUE(!waits || (tumble_drive402_kind.next_us(&bench.drive) != TUMBLE_NEVER));
        assert_steps_end();
    }
}

/* Process data are not acknowledged: one that is lost must not send the axis to the target before. */
static void test_a_target_that_gets_lost_is_sent_again(void)
{
    for (unsigned misses = 1; misses <= 3U; misses++) {
        bring_home(&common);
        played.misses = misses;
        move_to(90.0);
        TEST_ASSERT_EQUAL_UINT(0, played.misses);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, 90.0, bench.stand.kind->angle_deg(bench.stand.self));
    }
}

static void test_a_target_that_cannot_be_read_back_is_a_broken_handshake(void)
{
    bring_home(&common);
    played.refuse_index = 0x607A;
    move_for(20, 90.0);
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_HEX16(0x607A, bench.drive.report.refusal.index);
    TEST_ASSERT_FALSE(played.moving);
}

static void test_a_stop_gives_up_reading_the_target(void)
{
    bring_home(&common);
    played.sdo_is_deaf = true;
    move_for(20, 90.0);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    stop_at_rest();
    played.sdo_is_deaf = false;
    move_to(30.0);
}
