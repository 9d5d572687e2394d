/* The procedure to the sample and to the millisecond: warm-up, settling, legs of a move, what a refusal counts. */
#include "procedure_bench.h"

/* So many samples of these temperatures warm it up, not one earlier. */
static void expect_warm_after(const int8_t *temperatures_half_c, size_t count)
{
    bench_start(&bench);
    bench.operator_is_away = true;
    bench.config.warm_up_samples = 3;
    bench_run_to(&bench, TUMBLE_STATE_WARM_UP);
    for (size_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
        bench.block.temperature_half_c = temperatures_half_c[i];
        bench_tick(&bench);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_state_of(&bench));
}

static void test_warm_up_wherever_the_temperature_is(void)
{
    static const int8_t around_zero[] = {0, 1, 0};
    static const int8_t hot[] = {120, 122, 121};
    static const int8_t cold[] = {-120, -122, -121};
    static const int8_t from_end_to_end[] = {-128, 127, -128, -127, -126};
    static const int8_t rising[] = {10, 12, 13, 14, 15};
    expect_warm_after(around_zero, COUNT_OF(around_zero));
    expect_warm_after(hot, COUNT_OF(hot));
    expect_warm_after(cold, COUNT_OF(cold));
    expect_warm_after(from_end_to_end, COUNT_OF(from_end_to_end));
    expect_warm_after(rising, COUNT_OF(rising));
}

static void expect_settled_after(uint16_t settle_ms, int expected_ticks)
{
    bench_start(&bench);
    bench.config.settle_ms = settle_ms;
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    TEST_ASSERT_EQUAL_UINT(expected_ticks, bench_ticks_in(&bench, TUMBLE_STATE_SETTLE));
}

static void test_settling_to_the_millisecond(void)
{
    expect_settled_after(200, 20);
    expect_settled_after(201, 21);
    expect_settled_after(209, 21);
    expect_settled_after(210, 21);
    expect_settled_after(1, 1);
}

/* 12 bits of milliseconds wrap within every longer run; here within one settling. */
static void test_settling_over_the_wrap_of_the_timestamp(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_MOVE);
    while (bench_state_of(&bench) == TUMBLE_STATE_MOVE) {
        bench.block.timestamp_ms = 4000;
        bench_tick(&bench);
    }
    TEST_ASSERT_EQUAL_UINT(20, bench_ticks_in(&bench, TUMBLE_STATE_SETTLE));
    TEST_ASSERT_TRUE(bench.block.timestamp_ms < 4000U);
}

static void test_corrupted_frames_while_settling(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    tumble_procedure_sample_faults(&bench.procedure, 3, 0);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->refused);
    tumble_procedure_sample_faults(&bench.procedure, 1, 0);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->refused);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
}

/* Down to below the angle and up to it: each takes nearly all the time that one move may take. */
static void test_each_leg_of_a_move_has_its_own_time(void)
{
    bench_run_to(&bench, TUMBLE_STATE_MOVE);
    for (int leg = 0; leg < 2; leg++) {
        bench.stand.arrives_us = bench.now_us + 900000U;
        bench_ticks(&bench, 89);
        TEST_ASSERT_EQUAL(TUMBLE_STATE_MOVE, bench_state_of(&bench));
        bench_tick(&bench);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
}

static void test_running_error_is_never_negative(void)
{
    static const double v_per_count[] = {V_PER_COUNT, -V_PER_COUNT};
    for (size_t i = 0; i < COUNT_OF(v_per_count); i++) {
        double mean_v[3];
        double error_v[3];
        bench_start(&bench);
        bench_run_to(&bench, TUMBLE_STATE_AVERAGE);
        bench.config.v_per_count = v_per_count[i];
        bench_ticks(&bench, 10);
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_running(&bench.procedure, mean_v, error_v));
        TEST_ASSERT_TRUE((error_v[0] > 1e-7) && (error_v[0] < 2e-5));
        TEST_ASSERT_TRUE((mean_v[2] < 0.0) == (v_per_count[i] > 0.0));
    }
}

/* The converter's sign may be turned round; then so is the scale in volts. */
static void test_counts_that_go_down(void)
{
    bench_init(&bench);
    bench.config.v_per_count = -V_PER_COUNT;
    bench.config.nominal_scale_v_per_g = 2.0;
    bench_start_to_done(&bench);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 2.0, bench_result(&bench).coefficients->k_v_per_g[0][0]);
}

static void test_a_wrong_mounting_counts_as_refused(void)
{
    bench.operator_mounts = 1;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_WRONG_MOUNTING);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->refused);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->positions);
}

/* Nothing is gained by measuring these again. */
static void test_saturated_and_stuck_are_not_tried_again(void)
{
    bench.block.dead[1] = true;
    bench.averaging.stuck_run = 15;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_STUCK);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->retries);
    bench_start(&bench);
    bench.block.u0_v[2] = -12.0;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SATURATED);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->retries);
}

/* What kept the last preflight from passing is not the reason of this one. */
static void test_every_preflight_has_its_own_reason(void)
{
    bench.block.status = TUMBLE_SAMPLE_SELF_TEST;
    tumble_procedure_sample_faults(&bench.procedure, 100, 0);
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_BLOCK_STATUS);
    bench.block.silent = true;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_NO_SAMPLES);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    tumble_procedure_sample_faults(&bench.procedure, 3, 0); /* as many as are allowed */
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_NO_SAMPLES);
}

/* A block that fell silent is missed before the table moves again. */
static void test_every_preflight_wants_samples_of_its_own(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_AVERAGE);
    bench.stand.error_deg = 1.0;
    bench_run(&bench);
    bench.stand.error_deg = 0.0;
    bench.block.silent = true;
    const unsigned moves = bench.stand.moves;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_NO_SAMPLES);
    TEST_ASSERT_EQUAL_UINT(moves, bench.stand.moves);
}

static void test_every_run_warms_up_for_itself(void)
{
    bench_run(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to(&bench, TUMBLE_STATE_WARM_UP);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
}

/* ... but what goes on after a fault has been mended is the same run. */
static void test_a_run_that_goes_on_is_warm(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_AVERAGE);
    bench.stand.error_deg = 1.0;
    bench_run(&bench);
    bench.stand.error_deg = 0.0;
    bench.visited = 0;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    bench_run_to_done(&bench);
    TEST_ASSERT_EQUAL_HEX32(0, bench.visited & ((uint32_t)1U << (unsigned)TUMBLE_STATE_WARM_UP));
}

/* What happens to the stand after the table was stopped for another reason does not hide that reason. */
static void test_the_first_reason_stands(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_AVERAGE);
    bench.stand.error_deg = 1.0;
    bench_run(&bench);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_HEARTBEAT, 0);
    bench_tick(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
}

static const around_t around_each = {begin_run, NULL};
