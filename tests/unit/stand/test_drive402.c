/* The CiA 402 master with a drive that behaves: power, homing, moving, stopping. */
#include "drive_bench.h"

static void test_absent_until_it_is_heard(void)
{
    bench_setup(&common);
    assert_state_after(1000, TUMBLE_STAND_OFFLINE);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->home(bench.stand.self));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 0.0));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->clear_fault(bench.stand.self));
    stop_for(0);
    TEST_ASSERT_EQUAL_UINT(0, played.write_count);
    boot_drive();
}

static void test_power_goes_up_step_by_step(void)
{
    static const uint16_t expected[] = {0x0000, 0x0006, 0x0007, 0x000F};
    bring_up(&common);
    TEST_ASSERT_EQUAL_UINT(COUNT_OF(expected), played.control_count);
    for (size_t i = 0; i < COUNT_OF(expected); i++) {
        TEST_ASSERT_EQUAL_HEX16(expected[i], played.controls[i].control);
    }
    TEST_ASSERT_EQUAL_HEX16(IS_ENABLED, played.state);
}

/* A drive that nobody reset while we were away: enabled, moving, or in quick stop. It brakes, and loses its power when
 * it stands: without power it would coast. */
static void test_a_drive_found_running_is_taken_down_first(void)
{
    static const uint16_t states[] = {IS_ENABLED, IS_QUICK_STOP, IS_ON, IS_READY};
    static const uint16_t words[] = {0x0002, 0x0002, 0x0000, 0x0000};
    static const unsigned lost[] = {0, 3};
    for (size_t i = 0; i < COUNT_OF(states) * COUNT_OF(lost); i++) {
        bench_setup(&common);
        drive_boots(0);
        played.state = states[i / COUNT_OF(lost)];
        played.moving = ((played.state == IS_ENABLED) || (played.state == IS_QUICK_STOP));
        played.goal = 100000;
        played.mode = 1;
        played.quick_stop_stays = true;
        played.brakes_for_ms = 45;
        played.braking_ms = 45;
        played.misses = (played.state == IS_ENABLED) ? lost[i % COUNT_OF(lost)] : 0U;
        run_to(TUMBLE_STAND_READY, 500);
        TEST_ASSERT_FALSE(played.moving);
        TEST_ASSERT_FALSE(played.coasted);
        TEST_ASSERT_EQUAL_HEX16(words[i / COUNT_OF(lost)], played.controls[0].control);
        go_home();
    }
}

/* Before anybody has told it anything, what goes out when we become Operational must not let go of a moving axis. */
static void test_the_first_word_is_a_quick_stop(void)
{
    bench_setup(&common);
    TEST_ASSERT_EQUAL_HEX16(0x0002, bench.mirror.controlword);
}

static void test_homing(void)
{
    bring_up(&common);
    played.actual = 12345;
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->move(bench.stand.self, 10.0)); /* not homed */
    home_for(0);
    assert_state_after(0, TUMBLE_STAND_HOMING);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench.stand.kind->home(bench.stand.self));
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    assert_angle(0.0);
    TEST_ASSERT_EQUAL_INT8(1, played.mode);
    TEST_ASSERT_EQUAL_HEX16(0x000F, played.control); /* bit 4 is down again */
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, bench.stand.kind->fault(bench.stand.self));
}

/* The drive's last homing shows in its statusword when the new one starts, and for some reports after. */
static void test_homing_does_not_believe_the_last_one(void)
{
    for (unsigned reports = 0; reports <= 2U; reports++) {
        bring_up(&common);
        played.attained_from_before = true;
        played.old_reports = reports;
        played.actual = 12345;
        go_home();
        assert_angle(0.0);
    }
}

static void test_the_handshake_of_a_move(void)
{
    static const scripted_control_t expected[] = {
        {0x000F, 4500}, /* the target first, bit 4 low */
        {0x001F, 4500}, /* then the edge */
        {0x000F, 4500}, /* and down after the acknowledgement */
    };
    bring_home(&common);
    const unsigned first = played.control_count;
    move_to(45.0);
    assert_angle(45.0);
    TEST_ASSERT_EQUAL_UINT(first + COUNT_OF(expected), played.control_count);
    for (size_t i = 0; i < COUNT_OF(expected); i++) {
        TEST_ASSERT_EQUAL_HEX16(expected[i].control, played.controls[first + i].control);
        TEST_ASSERT_EQUAL_INT32(expected[i].target, played.controls[first + i].target);
    }
}

static void test_moves_over_several_turns_both_ways(void)
{
    static const double angles_deg[] = {0.0, 360.0, -5.0, 0.0, 135.01, 719.99, -400.0};
    bring_home(&common);
    for (size_t i = 0; i < COUNT_OF(angles_deg); i++) {
        move_to(angles_deg[i]);
        assert_angle(angles_deg[i]);
    }
}

/* Bit 10 says "reached" from the last target on: only the position tells. */
static void test_a_lingering_target_reached_is_not_believed(void)
{
    bring_home(&common);
    played.bits |= 0x0400U;
    played.reached_lingers = true;
    move_for(60, 90.0);
    assert_state_after(0, TUMBLE_STAND_MOVING);
    run_to(TUMBLE_STAND_IN_POSITION, 100);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 90.0, bench.stand.kind->angle_deg(bench.stand.self));
}

static void test_a_drive_that_slips_off_its_target_is_not_in_position(void)
{
    bring_home(&common);
    move_to(45.0);
    played.bits &= (uint16_t)~0x0400U;
    assert_state_after(15, TUMBLE_STAND_MOVING);
    played.bits |= 0x0400U;
    assert_state_after(15, TUMBLE_STAND_IN_POSITION);
}

/* Target reached has no meaning after homing before the first set-point. */
static void test_at_home_without_target_reached(void)
{
    bring_home(&common);
    played.bits = 0;
    assert_state_after(50, TUMBLE_STAND_IN_POSITION);
}

static void test_a_busy_port_delays_and_breaks_nothing(void)
{
    bring_home(&common);
    move_for(0, 45.0);
    port.send_room = 0;
    run_ms(50);
    const unsigned before = played.control_count;
    port.send_room = SIZE_MAX;
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    assert_angle(45.0);
    TEST_ASSERT_EQUAL_HEX16(0x000F, played.controls[before].control); /* the target has not been skipped */
    TEST_ASSERT_EQUAL_INT32(4500, played.controls[before].target);
}

static void test_stop_by_quick_stop_then_on_from_there(void)
{
    static const bool stays[] = {false, true};
    for (size_t i = 0; i < COUNT_OF(stays); i++) {
        bring_home(&common);
        played.quick_stop_stays = stays[i];
        move_for(40, 90.0);
        stop_at_rest();
        TEST_ASSERT_FALSE(played.moving);
        TEST_ASSERT_EQUAL_HEX16(0x0002, played.control);
        const double here_deg = bench.stand.kind->angle_deg(bench.stand.self);
        TEST_ASSERT_TRUE((here_deg > 1.0) && (here_deg < 89.0));
        assert_state_after(200, TUMBLE_STAND_STOPPED);
        move_to(45.0);
        assert_angle(45.0);
    }
}

static void test_stop_by_halt_leaves_no_old_set_point(void)
{
    bring_home(MADE(halting()));
    move_for(40, 90.0);
    stop_at_rest();
    TEST_ASSERT_EQUAL_HEX16(0x010F, played.control);
    const unsigned before = played.control_count;
    go_home();                                                        /* the mode is not changed under Halt */
    TEST_ASSERT_EQUAL_HEX16(0x0000, played.controls[before].control); /* power off clears what Halt held back */
}

static void test_stop_while_homing(void)
{
    bring_up(&common);
    home_for(15);
    TEST_ASSERT_TRUE(played.homing);
    stop_for(0);
    run_to(TUMBLE_STAND_READY, 200); /* at rest, and not homed */
    TEST_ASSERT_FALSE(played.homing);
    go_home();
}

static void test_stop_in_the_middle_of_a_mode_change(void)
{
    bring_up(&common);
    home_for(0);
    played.sdo_is_deaf = true;
    run_ms(3);
    stop_for(0);
    run_to(TUMBLE_STAND_READY, 200);
    played.sdo_is_deaf = false;
    go_home();
}

static void test_next_deadline_is_never_forgotten(void)
{
    bench_setup(&common);
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_drive402_kind.next_us(&bench.drive));
    boot_drive();
    run_ms(5);
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_drive402_kind.next_us(&bench.drive));
    home_for(0);
    TEST_ASSERT_EQUAL_UINT64(0, tumble_drive402_kind.next_us(&bench.drive)); /* its time must begin */
    run_ms(20);
    const uint64_t deadline_us = tumble_drive402_kind.next_us(&bench.drive);
    TEST_ASSERT_TRUE(deadline_us > port.now_us + 900000U); /* the axis would be unseen for too long */
    TEST_ASSERT_TRUE(deadline_us <= port.now_us + 1200000U);
}

/* Told only when it is due or a frame comes, it goes as far as when it is told all the time. */
static void test_steps_when_due_are_enough(void)
{
    bring_home(&common);
    move_for(0, 45.0);
    played.event_only = true;
    for (unsigned i = 0; (i < 2000U) && (stand_state() != TUMBLE_STAND_IN_POSITION); i++) {
        const uint64_t drive_us = tumble_drive402_kind.next_us(&bench.drive);
        const uint64_t node_us = tumble_node_next_us(&bench.node);
        port.now_us += 1000U;
        scripted_drive_step(&played, &port);
        tumble_can_frame_t frame;
        bool due = (drive_us <= port.now_us) || (node_us <= port.now_us);
        while (tumble_link_receive(&bench.node.link, &frame) == TUMBLE_OK) {
            (void)tumble_node_receive(&bench.node, &frame, port.now_us);
            due = true;
        }
        if (due) {
            tumble_drive402_kind.step(&bench.drive, port.now_us);
            tumble_node_step(&bench.node, port.now_us);
        }
        while (fake_port_take(&port, &frame)) {
            scripted_drive_hear(&played, &port, &frame);
        }
    }
    assert_angle(45.0);
}
