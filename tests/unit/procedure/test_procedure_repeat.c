/* Repeating and resuming: one position, one mounting, after a fault, without starting over. */
#include "procedure_bench.h"

static uint8_t finished(void)
{
    return bench_progress(&bench).finished;
}

static void assert_done(void)
{
    bench_run_to_done(&bench);
    const tumble_result_t result = bench_result(&bench);
    TEST_ASSERT_TRUE(result.pass);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, bench.block.u0_v[i], result.coefficients->u0_v[i]);
    }
}

static void test_a_disturbed_position_is_tried_again_by_itself(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_AVERAGE);
    bench.block.noise_counts = 300;
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    bench.block.noise_counts = 30;
    const tumble_progress_t progress = bench_progress(&bench);
    TEST_ASSERT_EQUAL_UINT8(1, progress.attempt);
    ASSERT_STATUS(TUMBLE_E_NOT_STILL, progress.status);
    const unsigned moves = bench.stand.moves;
    bench_run_to_position(&bench, 4, TUMBLE_STATE_MOVE);
    TEST_ASSERT_EQUAL_UINT(moves + 1U, bench.stand.moves); /* settled and averaged again where it stood */
    assert_done();
    TEST_ASSERT_EQUAL_UINT32(1, counters()->retries);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->refused);
}

static void test_every_position_has_its_own_attempts(void)
{
    for (uint8_t p = 0; p < 18U; p++) {
        bench_run_to_position(&bench, p, TUMBLE_STATE_AVERAGE);
        bench.block.lose_every = 3;
        bench_run_to_position(&bench, p, TUMBLE_STATE_SETTLE);
        bench.block.lose_every = 0;
    }
    assert_done();
    TEST_ASSERT_EQUAL_UINT32(18, counters()->retries);
}

static void test_a_brief_movement_of_the_table_is_a_repetition(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_AVERAGE);
    bench.stand.state = TUMBLE_STAND_MOVING;
    bench.stand.arrives_us = bench.now_us + 50000U;
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    assert_done();
    TEST_ASSERT_EQUAL_UINT32(1, counters()->retries);
}

static void test_no_repetition_when_none_is_allowed(void)
{
    bench.config.retries = 0;
    bench_run_to_position(&bench, 3, TUMBLE_STATE_MOVE);
    bench.block.noise_counts = 300;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_NOT_STILL);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->retries);
}

static void break_at(uint8_t index, tumble_stand_fault_t fault)
{
    bench_run_to_position(&bench, index, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, fault, 0);
    bench_run(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_state_of(&bench));
    TEST_ASSERT_EQUAL_UINT8(index, finished());
}

static void test_resume_goes_on_at_the_failed_position(void)
{
    break_at(13, TUMBLE_STAND_FAULT_STALL);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    TEST_ASSERT_EQUAL_UINT(1, bench.stand.clears);
    TEST_ASSERT_EQUAL(TUMBLE_REASON_NONE, bench_reason_of(&bench));
    bench_run_to_position(&bench, 13, TUMBLE_STATE_MOVE);
    TEST_ASSERT_EQUAL_UINT8(13, finished());
    assert_done();
    TEST_ASSERT_EQUAL_UINT(1, bench.stand.homes); /* the position was not lost */
    TEST_ASSERT_EQUAL_UINT(2, bench.confirmations);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->resumes);
}

static void test_resume_homes_again_after_a_power_loss(void)
{
    bench.stand.loses_home = true;
    break_at(13, TUMBLE_STAND_FAULT_POWER);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    assert_done();
    TEST_ASSERT_EQUAL_UINT(2, bench.stand.homes);
    TEST_ASSERT_EQUAL_UINT(2, bench.confirmations);
}

static void test_resume_homes_again_after_a_failed_homing(void)
{
    bench_run_to(&bench, TUMBLE_STATE_HOME);
    bench.stand.never_arrives = true;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_HOMING);
    bench.stand.never_arrives = false;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    assert_done();
    TEST_ASSERT_EQUAL_UINT(2, bench.stand.homes);
}

static void test_resume_fails_again_while_nothing_is_mended(void)
{
    bench_run_to_position(&bench, 5, TUMBLE_STATE_AVERAGE);
    tumble_procedure_set_block_alive(&bench.procedure, false);
    bench_run(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_BLOCK_HEARTBEAT);
    tumble_procedure_set_block_alive(&bench.procedure, true);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    assert_done();
    TEST_ASSERT_EQUAL_UINT32(2, counters()->faults);
}

static void test_resume_from_every_position_ends_in_the_same_place(void)
{
    for (uint8_t p = 0; p < 18U; p++) {
        bench_start(&bench);
        bench_run_to_position(&bench, p, TUMBLE_STATE_AVERAGE);
        bench.stand.error_deg = 1.0;
        ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
        bench.stand.error_deg = 0.0;
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
        assert_done();
        TEST_ASSERT_EQUAL_UINT32(18, counters()->positions);
    }
}

static void test_the_operator_mends_a_mounting_that_nobody_confirmed(void)
{
    bench.operator_is_away = true;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_MOUNTING_NOT_CONFIRMED);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_confirm_mounting(&bench.procedure, 2));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_confirm_mounting(&bench.procedure, 1));
    bench.operator_is_away = false;
    assert_done();
}

static void test_the_operator_mends_a_wrong_mounting(void)
{
    bench_run_to_position(&bench, 8, TUMBLE_STATE_AVERAGE);
    bench.operator_mounts = 0; /* forgets to turn the block */
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_WRONG_MOUNTING);
    TEST_ASSERT_EQUAL_UINT8(9, finished());
    bench.mounted = 1;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_confirm_mounting(&bench.procedure, 2));
    TEST_ASSERT_EQUAL_UINT8(9, finished()); /* the first mounting stands */
    assert_done();
}

static void test_after_a_wrong_mounting_resume_asks_for_it_again(void)
{
    bench_run_to_position(&bench, 8, TUMBLE_STATE_AVERAGE);
    bench.operator_mounts = 0;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_WRONG_MOUNTING);
    bench.operator_mounts = UINT8_MAX;
    const unsigned confirmations = bench.confirmations;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    assert_done();
    TEST_ASSERT_EQUAL_UINT(confirmations + 1U, bench.confirmations);
}

/* Found at the second position; what was measured with swapped channels is measured again. */
static void test_swapped_channels_are_mended_without_starting_over(void)
{
    bench.block.channel[0] = 1;
    bench.block.channel[1] = 0;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SWAPPED_CHANNELS);
    TEST_ASSERT_EQUAL_UINT8(1, finished());
    bench.block.channel[0] = 0;
    bench.block.channel[1] = 1;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_confirm_mounting(&bench.procedure, 1));
    TEST_ASSERT_EQUAL_UINT8(0, finished());
    assert_done();
}

static void test_confirm_mends_nothing_but_mountings(void)
{
    break_at(4, TUMBLE_STAND_FAULT_DRIVE);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_confirm_mounting(&bench.procedure, 1));
}

static void test_repeat_one_position_while_running(void)
{
    bench_run_to_position(&bench, 6, TUMBLE_STATE_AVERAGE);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_position(&bench.procedure, 2));
    TEST_ASSERT_EQUAL_UINT8(5, finished()); /* the open one counts no more than the dropped one */
    bench_run_to_position(&bench, 2, TUMBLE_STATE_AVERAGE);
    bench_run_to_position(&bench, 6, TUMBLE_STATE_AVERAGE);
    assert_done();
    TEST_ASSERT_EQUAL_UINT32(19, counters()->positions);
}

static void test_repeat_one_position_after_the_end(void)
{
    assert_done();
    const unsigned confirmations = bench.confirmations;
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_position(&bench.procedure, 3)); /* of the other mounting */
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_position(&bench.procedure, 12));
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_result(&bench.procedure, &result));
    TEST_ASSERT_EQUAL_UINT8(17, finished());
    assert_done();
    TEST_ASSERT_EQUAL_UINT(confirmations, bench.confirmations);
    TEST_ASSERT_EQUAL_UINT32(19, counters()->positions);
}

static void test_repeat_one_mounting_after_the_end(void)
{
    assert_done();
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_mounting(&bench.procedure, 1));
    TEST_ASSERT_EQUAL_UINT8(9, finished());
    assert_done();
    TEST_ASSERT_EQUAL_UINT(3, bench.confirmations);
    TEST_ASSERT_EQUAL_UINT32(27, counters()->positions);
}

/* What is left of the mounting on the table comes before the one to be repeated. */
static void test_repeat_the_other_mounting_while_running(void)
{
    bench_run_to_position(&bench, 12, TUMBLE_STATE_SETTLE);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_mounting(&bench.procedure, 1));
    bench_run_to_position(&bench, 17, TUMBLE_STATE_AVERAGE);
    TEST_ASSERT_EQUAL_UINT(2, bench.confirmations);
    bench_run_to_position(&bench, 0, TUMBLE_STATE_AVERAGE);
    TEST_ASSERT_EQUAL_UINT(3, bench.confirmations);
    assert_done();
}

static void test_a_closure_that_fails_can_be_measured_again(void)
{
    bench_run_to_position(&bench, 8, TUMBLE_STATE_MOVE);
    bench.block.drift_v = 0.01;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
    TEST_ASSERT_EQUAL_UINT8(8, finished());
    ASSERT_SAME_DOUBLE(0.0, tumble_procedure_closure_g(&bench.procedure, 0)); /* the position is forgotten */
    bench.block.drift_v = 0.0;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    assert_done();
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, tumble_procedure_closure_g(&bench.procedure, 0));
}

static void test_a_new_configuration_mends_a_refused_one(void)
{
    bench_init(&bench);
    bench.config.samples = 3;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_CONFIGURATION);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_position(&bench.procedure, 0));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_mounting(&bench.procedure, 1));
    bench.config.samples = 20;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    assert_done();
}

static const around_t around_each = {begin_run, NULL};
