/* Whole runs of the navigation computer, frame by frame, and what stops them. */
#include "navcomp_bench.h"

static void assert_stopped_for(tumble_reason_t reason)
{
    const tumble_navcomp_progress_t progress = bench_progress(&bench);
    TEST_ASSERT_EQUAL_STRING(tumble_reason_name(reason), tumble_reason_name(progress.run.reason));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_STATE_FAULT", tumble_state_name(progress.run.state));
    bench_pass(&bench, 1.0);
    TEST_ASSERT_FALSE(scripted_drive_moves(&bench.drive));
}

/* Under way, in that state, at that position of the schedule. */
static void run_to(tumble_state_t state, uint8_t index)
{
    const uint64_t end_us = bench.fake.now_us + UINT64_C(600000000);
    tumble_navcomp_progress_t progress = bench_progress(&bench);
    while ((progress.run.state != state) || (progress.run.index != index)) {
        TEST_ASSERT_TRUE(bench.fake.now_us < end_us);
        TEST_ASSERT_TRUE_MESSAGE(progress.run.state != TUMBLE_STATE_FAULT, tumble_reason_name(progress.run.reason));
        bench_event(&bench);
        progress = bench_progress(&bench);
    }
}

static void start_and_run_to(tumble_state_t state, uint8_t index)
{
    bench_start(&bench);
    run_to(state, index);
}

static void assert_stops_for(tumble_reason_t reason, double most_s)
{
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_DONE, most_s));
    assert_stopped_for(reason);
}

static void assert_ends_well(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    assert_right_coefficients();
}

static void test_a_whole_calibration_finds_the_coefficients(void)
{
    tumble_result_t result;
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_E_STATE, tumble_navcomp_result(&bench.navcomp, &result));
    assert_ends_well();
    const tumble_navcomp_counters_t counters = bench_counters(&bench);
    TEST_ASSERT_EQUAL_UINT32(bench.block.sent, counters.block.samples);
    TEST_ASSERT_EQUAL_UINT32(0, counters.block.lost);
    TEST_ASSERT_EQUAL_UINT32(bench.logged - 3U, counters.link.received); /* less start and two confirmations */
    TEST_ASSERT_EQUAL_UINT32(0, counters.link.busy);
    TEST_ASSERT_EQUAL_UINT32(0, counters.link.down);
    TEST_ASSERT_EQUAL_UINT32(0, counters.events.frames_ignored);
    TEST_ASSERT_EQUAL_UINT32(0, counters.events.heartbeats_lost);
    TEST_ASSERT_EQUAL_UINT32(2, counters.events.boot_ups);
    TEST_ASSERT_EQUAL_UINT32(1, counters.events.starts);
    TEST_ASSERT_EQUAL_UINT32(18, counters.procedure.positions);
}

/* What the hook recorded is what was averaged: to the last count, at every position. */
static void test_the_hook_tells_exactly_the_samples_that_were_averaged(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    const tumble_averaging_t *averaging = tumble_procedure_averages(tumble_navcomp_procedure(&bench.navcomp));
    for (int p = 0; p < 18; p++) {
        TEST_ASSERT_EQUAL_UINT32(BENCH_SAMPLES, bench.recorded[p]);
        TEST_ASSERT_EQUAL_UINT32(BENCH_SAMPLES, averaging->averages[p].samples);
        TEST_ASSERT_EQUAL_INT64_ARRAY(bench.recorded_sum[p], averaging->averages[p].sum_counts, TUMBLE_CHANNELS);
    }
}

static void test_the_same_run_without_hooks(void)
{
    bench.config.hooks = NULL;
    bench_start(&bench);
    assert_ends_well();
}

static void test_nodes_of_other_numbers(void)
{
    bench.config.node = 77;
    bench_start(&bench);
    assert_ends_well();
}

static void test_a_repeated_position_replaces_the_mean(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    const uint32_t averaged = bench_counters(&bench).procedure.averaged;
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, 12));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 60.0));
    TEST_ASSERT_EQUAL_UINT32(averaged + BENCH_SAMPLES, bench_counters(&bench).procedure.averaged);
    TEST_ASSERT_EQUAL_UINT32(BENCH_SAMPLES, bench.recorded[12]);
    assert_right_coefficients();
}

static void test_a_repeated_mounting_is_asked_for_again(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    bench.never_confirm = true;
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_MOUNTING, 1));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_run(&bench, TUMBLE_STATE_WAIT_MOUNTING, 10.0));
    TEST_ASSERT_EQUAL_UINT8(1, bench_progress(&bench).run.mounting);
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, bench_command(&bench, TUMBLE_COMMAND_CONFIRM_MOUNTING, 2));
    bench.never_confirm = false;
    assert_ends_well();
}

static void test_a_wrong_mounting_is_found_and_mended(void)
{
    bench.keep_mounting = true;
    bench_start(&bench);
    assert_stops_for(TUMBLE_REASON_WRONG_MOUNTING, 600.0);
    TEST_ASSERT_EQUAL_UINT8(2, bench_progress(&bench).run.mounting);
    bench.block.mounting = &tumble_schedule_paper.mountings[1];
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_CONFIRM_MOUNTING, 2));
    assert_ends_well();
}

static void test_a_silent_drive_is_a_fault_and_the_run_can_go_on(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    const uint64_t silent_us = bench.fake.now_us;
    bench.drive.dead = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_DONE, 60.0));
    TEST_ASSERT_TRUE((bench.fake.now_us - silent_us) <= 600000U);
    assert_stopped_for(TUMBLE_REASON_STAND_HEARTBEAT);
    TEST_ASSERT_EQUAL_UINT32(1, bench_counters(&bench).events.heartbeats_lost);
    bench.drive.dead = false;
    scripted_drive_boot(&bench.drive, &bench.fake);
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_RESUME, 0));
    assert_ends_well();
}

static void test_a_drive_that_reboots_in_mid_run_has_lost_power(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    scripted_drive_boot(&bench.drive, &bench.fake);
    assert_stops_for(TUMBLE_REASON_DRIVE_POWER, 60.0);
    TEST_ASSERT_EQUAL_UINT32(3, bench_counters(&bench).events.boot_ups);
}

static void test_a_fault_of_the_drive_shows_its_code(void)
{
    start_and_run_to(TUMBLE_STATE_MOVE, 3);
    scripted_drive_fail(&bench.drive, &bench.fake, 0x4310);
    assert_stops_for(TUMBLE_REASON_DRIVE_FAULT, 60.0);
    TEST_ASSERT_EQUAL_HEX16(0x4310, bench_progress(&bench).run.drive_code);
    TEST_ASSERT_EQUAL_UINT32(1, bench_counters(&bench).events.emergencies);
}

static void test_a_drive_that_refuses_its_configuration(void)
{
    bench.drive.refuse_index = TUMBLE_402_HOMING_METHOD;
    bench_start(&bench);
    assert_stops_for(TUMBLE_REASON_STAND_PROTOCOL, 60.0);
    const tumble_stand_refusal_t refusal = tumble_navcomp_drive_refusal(&bench.navcomp);
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_402_HOMING_METHOD, refusal.index);
    TEST_ASSERT_EQUAL_HEX32(0x06020000, refusal.abort);
}

static void test_a_target_that_is_never_reached(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 2);
    bench.drive.never_reaches = true;
    assert_stops_for(TUMBLE_REASON_TARGET_NOT_REACHED, 10.0);
}

static void test_an_axis_that_does_not_turn(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 2);
    bench.drive.jammed = true;
    assert_stops_for(TUMBLE_REASON_STALL, 10.0);
}

static void test_a_silent_block_is_a_fault(void)
{
    start_and_run_to(TUMBLE_STATE_MOVE, 4);
    bench.drive.jammed = true; /* so that it is the heartbeat that is missed, not the samples */
    bench.block.dead = true;
    assert_stops_for(TUMBLE_REASON_BLOCK_HEARTBEAT, 5.0);
}

static void test_a_block_that_stops_to_stream_is_a_fault(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    bench.block.next_sample_us = UINT64_MAX; /* its heartbeat goes on */
    assert_stops_for(TUMBLE_REASON_NO_SAMPLES, 5.0);
}

/* No mean may run across a restart of the block, even when its new counter happens to fit. */
static void test_a_block_that_reboots_in_mid_average_is_a_fault_and_is_started_again(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    scripted_block_boot(&bench.block, &bench.fake);
    assert_stops_for(TUMBLE_REASON_BLOCK_HEARTBEAT, 5.0);
    TEST_ASSERT_EQUAL(TUMBLE_NMT_OPERATIONAL, bench.block.nmt);
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).block.reordered);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_RESUME, 0));
    assert_ends_well();
}

static void test_the_block_may_be_switched_off_while_it_is_remounted(void)
{
    bench_start(&bench);
    bench.never_confirm = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_run(&bench, TUMBLE_STATE_WAIT_MOUNTING, 60.0));
    bench.block.dead = true;
    bench_pass(&bench, 30.0);
    bench.block.dead = false;
    scripted_block_boot(&bench.block, &bench.fake);
    bench_pass(&bench, 0.5);
    bench.never_confirm = false;
    assert_ends_well();
}

static unsigned spoilt;

/* From a certain moment on, every third frame of the block has one wrong bit. */
static bool corrupt(tumble_can_frame_t *frame)
{
    if ((frame->id == TUMBLE_BLOCK_ID_XY) && ((++spoilt % 3U) == 0U)) {
        frame->data[spoilt % 8U] ^= 1U;
    }
    return true;
}

static void test_too_many_corrupted_frames_are_a_fault(void)
{
    spoilt = 0;
    bench.averaging.max_lost = 1000;
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    bench.spoil = corrupt;
    assert_stops_for(TUMBLE_REASON_SAMPLES_CORRUPTED, 60.0);
    TEST_ASSERT_TRUE(bench_counters(&bench).block.wrong_crc > 6U);
    TEST_ASSERT_EQUAL_UINT32(bench_counters(&bench).block.wrong_crc, bench_counters(&bench).procedure.corrupted);
}

static bool lose(tumble_can_frame_t *frame)
{
    return (frame->id != TUMBLE_BLOCK_ID_Z) || ((++spoilt % 3U) != 0U);
}

static void test_too_many_lost_samples_are_a_fault(void)
{
    spoilt = 0;
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    bench.spoil = lose;
    assert_stops_for(TUMBLE_REASON_SAMPLES_LOST, 60.0);
    const tumble_navcomp_counters_t counters = bench_counters(&bench);
    TEST_ASSERT_EQUAL_UINT32(counters.block.lost, counters.procedure.lost);
    TEST_ASSERT_EQUAL_UINT32(counters.block.lost, counters.block.lone_halves);
}

static void test_a_bus_that_goes_off_is_a_fault(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE, 4);
    bench.fake.send_status = TUMBLE_E_PORT_DOWN;
    bench.fake.receive_status = TUMBLE_E_PORT_DOWN;
    const uint64_t down_us = bench.fake.now_us;
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_progress(&bench).run.state);
    TEST_ASSERT_EQUAL(TUMBLE_REASON_BUS, bench_progress(&bench).run.reason);
    TEST_ASSERT_EQUAL_UINT64(down_us + 1000U, tumble_navcomp_next_deadline_us(&bench.navcomp)); /* looked after */
    TEST_ASSERT_TRUE(bench_counters(&bench).link.down >= 2U);
    bench.fake.send_status = TUMBLE_OK;
    bench.fake.receive_status = TUMBLE_OK;
    assert_stopped_for(TUMBLE_REASON_BUS);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_RESUME, 0));
    assert_ends_well();
}

static void test_an_abort_stops_the_table_in_mid_move(void)
{
    start_and_run_to(TUMBLE_STATE_MOVE, 5);
    bench_pass(&bench, 0.05);
    TEST_ASSERT_TRUE(scripted_drive_moves(&bench.drive));
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_ABORT, 0));
    bench_event(&bench);
    TEST_ASSERT_FALSE(scripted_drive_moves(&bench.drive));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_ABORT, bench_progress(&bench).run.state);
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
    assert_ends_well();
}

static const around_t around_each = {bench_begin, NULL};
