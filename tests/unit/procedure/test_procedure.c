/* The procedure from start to end: results for every estimator, states, commands, the readable side, replay. */
#include "procedure_bench.h"

#include "angles.h"

static void assert_truth(const bench_t *b, const tumble_coefficients_t *found, double tolerance_v)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, b->block.k_v_per_g[i][j], found->k_v_per_g[i][j]);
        }
        TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, b->block.u0_v[i], found->u0_v[i]);
    }
}

static void run_with(tumble_estimate_t estimate)
{
    bench.config.estimate = estimate;
    bench_start_to_done(&bench);
}

static void test_every_estimator_finds_the_block(void)
{
    static const tumble_estimate_t estimates[] = {TUMBLE_ESTIMATE_AVERAGED, TUMBLE_ESTIMATE_REFINED,
                                                  TUMBLE_ESTIMATE_LEAST_SQUARES};
    for (size_t e = 0; e < COUNT_OF(estimates); e++) {
        bench_init(&bench);
        run_with(estimates[e]);
        const tumble_result_t result = bench_result(&bench);
        TEST_ASSERT_TRUE(result.pass);
        TEST_ASSERT_TRUE(result.check->pass);
        TEST_ASSERT_EQUAL_UINT8(18, result.check->fit_positions);
        assert_truth(&bench, result.coefficients, 2e-5);
    }
}

/* Without noise and with a block whose outputs are whole counts, nothing is left but the rounding of the means. */
static void test_result_is_what_the_core_makes_of_the_means(void)
{
    run_with(TUMBLE_ESTIMATE_REFINED);
    tumble_means_t means;
    tumble_coefficients_t coefficients;
    tumble_calibration_t calibration;
    tumble_gravity_check_t check;
    tumble_result_t result;
    const tumble_averaging_t *averages = tumble_procedure_averages(&bench.procedure);
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_means(averages, bench.config.v_per_count, &means));
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_refined(bench.config.schedule, &means, &coefficients, NULL));
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_invert(&coefficients, &calibration));
    ASSERT_STATUS(TUMBLE_OK, tumble_gravity_check(bench.config.schedule, &means, &calibration, 3e-4, &check));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_result(&bench.procedure, &result));
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            ASSERT_SAME_DOUBLE(coefficients.k_v_per_g[i][j], result.coefficients->k_v_per_g[i][j]);
            ASSERT_SAME_DOUBLE(calibration.k_inverse_g_per_v[i][j], result.calibration->k_inverse_g_per_v[i][j]);
        }
        ASSERT_SAME_DOUBLE(coefficients.u0_v[i], result.coefficients->u0_v[i]);
        ASSERT_SAME_DOUBLE(calibration.u0_v[i], result.calibration->u0_v[i]);
    }
    for (int p = 0; p < 18; p++) {
        ASSERT_SAME_DOUBLE(check.delta_g_g[p], result.check->delta_g_g[p]);
        TEST_ASSERT_EQUAL_UINT32(20, averages->averages[p].samples);
    }
    ASSERT_SAME_DOUBLE(check.max_abs_fit_g, result.check->max_abs_fit_g);
}

static void test_a_run_walks_the_schedule_in_order(void)
{
    run_with(TUMBLE_ESTIMATE_REFINED);
    TEST_ASSERT_EQUAL_UINT(2, bench.confirmations);
    TEST_ASSERT_EQUAL_UINT(1, bench.stand.homes);
    TEST_ASSERT_EQUAL_UINT(0, bench.stand.stops);
    TEST_ASSERT_EQUAL_UINT32(18, counters()->positions);
    TEST_ASSERT_EQUAL_UINT32(18U * 20U, counters()->averaged);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->homings);
    TEST_ASSERT_EQUAL_UINT32(bench.stand.moves, counters()->moves);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->retries);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->refused);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->timeouts);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->faults);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->unwinds);
}

static void test_every_state_is_visited_and_seen(void)
{
    run_with(TUMBLE_ESTIMATE_LEAST_SQUARES);
    const uint32_t passed = (1UL << TUMBLE_STATE_IDLE) | (1UL << TUMBLE_STATE_NEXT) | (1UL << TUMBLE_STATE_FAULT) |
                            (1UL << TUMBLE_STATE_ABORT);
    bench_tick(&bench);
    TEST_ASSERT_EQUAL_HEX32((1UL << TUMBLE_STATE_COUNT) - 1U, bench.visited | passed);
}

static void test_progress_tells_where_it_stands(void)
{
    tumble_progress_t progress = bench_progress(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, progress.state);
    TEST_ASSERT_EQUAL_UINT8(0, progress.count);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 11, TUMBLE_STATE_AVERAGE);
    bench_ticks(&bench, 7);
    progress = bench_progress(&bench);
    TEST_ASSERT_EQUAL_UINT8(11, progress.index);
    TEST_ASSERT_EQUAL_UINT8(18, progress.count);
    TEST_ASSERT_EQUAL_UINT8(11, progress.finished);
    TEST_ASSERT_EQUAL_UINT8(3, progress.position);
    TEST_ASSERT_EQUAL_UINT8(2, progress.mounting);
    TEST_ASSERT_EQUAL_UINT8(0, progress.attempt);
    TEST_ASSERT_EQUAL_UINT32(7, progress.samples);
    TEST_ASSERT_EQUAL_UINT32(20, progress.samples_wanted);
    ASSERT_SAME_DOUBLE(90.0, progress.target_deg);
    TEST_ASSERT_EQUAL_UINT64(bench.now_us - 5010000U, progress.elapsed_us);
    TEST_ASSERT_EQUAL_UINT8(11, bench.last_index);
    TEST_ASSERT_EQUAL_UINT32(7, bench.highest_ordinal);
}

static void test_running_mean_is_in_volts(void)
{
    double mean_v[3];
    double error_v[3];
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, tumble_procedure_running(&bench.procedure, mean_v, error_v));
    bench.block.noise_counts = 0;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to(&bench, TUMBLE_STATE_AVERAGE);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_procedure_running(&bench.procedure, mean_v, error_v));
    bench_ticks(&bench, 2);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_running(&bench.procedure, mean_v, error_v));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.1 - 2.1, mean_v[2]);
    ASSERT_SAME_DOUBLE(0.0, error_v[2]);
}

static void test_schedule_with_check_positions_and_interleaved_mountings(void)
{
    static const tumble_mounting_t mountings[] = {
        {1, {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, LEVEL, 0},
        {7, {{-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}}, LEVEL, 0},
    };
    static const tumble_position_t positions[] = {
        {1, 1, TUMBLE_USE_FIT, {0.0, 0.0, 1.0}},
        {7, 1, TUMBLE_USE_FIT, {0.0, 0.0, 1.0}},
        {1, 2, TUMBLE_USE_FIT, {90.0, 1.0, 0.0}},
        {7, 2, TUMBLE_USE_FIT, {180.0, 0.0, -1.0}},
        {1, 3, TUMBLE_USE_FIT, {180.0, 0.0, -1.0}},
        {7, 3, TUMBLE_USE_FIT, {270.0, -1.0, 0.0}},
        {1, 4, TUMBLE_USE_CHECK, {30.0, 0.5, 0.8660254037844386}},
    };
    static const tumble_schedule_t schedule = {mountings, positions, 2, 7};
    bench.config.schedule = &schedule;
    run_with(TUMBLE_ESTIMATE_LEAST_SQUARES);
    const tumble_result_t result = bench_result(&bench);
    TEST_ASSERT_EQUAL_UINT(2, bench.confirmations); /* all of a mounting before the next */
    TEST_ASSERT_EQUAL_UINT8(1, result.check->check_positions);
    TEST_ASSERT_TRUE(result.pass);
    assert_truth(&bench, result.coefficients, 5e-5);
}

static void test_closure_is_known_when_a_mounting_is_complete(void)
{
    bench.block.noise_counts = 0;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 8, TUMBLE_STATE_AVERAGE);
    bench.block.drift_v = 0.0004; /* 2e-4 g of drift until position 9 */
    ASSERT_SAME_DOUBLE(0.0, tumble_procedure_closure_g(&bench.procedure, 0));
    bench_run(&bench);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2e-4, tumble_procedure_closure_g(&bench.procedure, 0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, tumble_procedure_closure_g(&bench.procedure, 1));
    ASSERT_SAME_DOUBLE(0.0, tumble_procedure_closure_g(&bench.procedure, TUMBLE_MAX_MOUNTINGS));
}

static void test_no_warm_up_when_none_is_asked_for(void)
{
    bench.config.warm_up_samples = 0;
    bench_start_to_done(&bench);
    TEST_ASSERT_EQUAL_HEX32(0, bench.visited & (1UL << TUMBLE_STATE_WARM_UP));
}

/* 10 ticks of warming by half a degree, then the band of 1 degree holds for ten samples. */
static void test_warm_up_waits_for_the_band(void)
{
    bench.block.warming_half_c = 1;
    bench.operator_is_away = true;
    bench.config.warm_up_samples = 5; /* a rising temperature stays within the band for three samples only */
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_ticks(&bench, 20);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
    bench.block.warming_half_c = 0;
    bench_ticks(&bench, 6);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_state_of(&bench));
}

static void test_a_cold_block_warms_up_without_being_a_fault(void)
{
    bench.block.status = TUMBLE_SAMPLE_TEMPERATURE;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_ticks(&bench, 50);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
    bench.block.status = 0;
    bench_run_to_done(&bench);
}

/* Settling takes the block's time: at 10 ms a sample, 200 ms after the first sample in position. */
static void test_settling_counts_the_blocks_milliseconds(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    TEST_ASSERT_EQUAL_UINT(20, bench_ticks_in(&bench, TUMBLE_STATE_SETTLE));
}

static void test_settling_ignores_old_samples(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    tumble_block_sample_t sample = bench_make_sample(&bench);
    for (int i = 0; i < 10; i++) {
        (void)tumble_procedure_sample(&bench.procedure, &sample, NULL);
        sample.raw.counter--; /* backwards, with a timestamp that leaps ahead */
        sample.timestamp_ms = (uint16_t)((sample.timestamp_ms + 3000U) % TUMBLE_TIMESTAMP_PERIOD_MS);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
}

static void test_settling_starts_again_when_the_table_moves_again(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    bench_ticks(&bench, 15);
    bench.stand.state = TUMBLE_STAND_MOVING; /* within tolerance, but the drive is not content */
    bench.stand.arrives_us = bench.now_us + 20000U;
    TEST_ASSERT_EQUAL_UINT(22, bench_ticks_in(&bench, TUMBLE_STATE_SETTLE));
}

static void test_no_settling_time_at_all(void)
{
    bench.config.settle_ms = 0;
    run_with(TUMBLE_ESTIMATE_REFINED);
}

/* Replay: how often step is called, and what the clock says, must not matter. Without steps a run goes through on
 * samples alone, up to the computing at its end. */
static void test_the_clock_does_not_matter(void)
{
    static const uint64_t steps_us[] = {SAMPLE_US, 0, 1000, 2500, 100};
    static const uint64_t starts_us[] = {5000000, 5000000, 0, UINT64_C(1) << 60, 1};
    static bench_t first;
    for (size_t run = 0; run < COUNT_OF(steps_us); run++) {
        bench_init(&bench);
        bench.step_us = steps_us[run];
        bench.now_us = starts_us[run];
        bench.block.lose_every = 37;
        bench.block.corrupt_every = 91;
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
        bench_run_to(&bench, TUMBLE_STATE_SOLVE);
        const tumble_procedure_counters_t counters = bench.procedure.counters;
        bench_run_to_done(&bench);
        bench.procedure.counters = counters; /* what comes while it computes is a matter of steps */
        if (run == 0U) {
            first = bench;
        }
        TEST_ASSERT_EQUAL_MEMORY(&first.procedure.averaging, &bench.procedure.averaging,
                                 sizeof first.procedure.averaging);
        TEST_ASSERT_EQUAL_MEMORY(&first.procedure.coefficients, &bench.procedure.coefficients,
                                 sizeof first.procedure.coefficients);
        TEST_ASSERT_EQUAL_MEMORY(&first.procedure.work.found.check, &bench.procedure.work.found.check,
                                 sizeof first.procedure.work.found.check);
        TEST_ASSERT_EQUAL_MEMORY(&first.procedure.counters, &bench.procedure.counters, sizeof first.procedure.counters);
    }
}

static void test_commands_are_allowed_where_the_table_says(void)
{
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_abort(&bench.procedure));
    TEST_ASSERT_EQUAL_UINT(1, bench.stand.stops); /* stops all the same */
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_resume(&bench.procedure));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_confirm_mounting(&bench.procedure, 1));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_position(&bench.procedure, 0));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_mounting(&bench.procedure, 1));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_start(&bench.procedure));
    bench.operator_is_away = true;
    bench_run_to(&bench, TUMBLE_STATE_WAIT_MOUNTING);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_confirm_mounting(&bench.procedure, 2));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_repeat_mounting(&bench.procedure, 3));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_repeat_position(&bench.procedure, 18));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_position(&bench.procedure, 0)); /* nothing is mounted */
    bench.operator_is_away = false;
    bench_run_to(&bench, TUMBLE_STATE_MOVE);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_confirm_mounting(&bench.procedure, 1));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_repeat_position(&bench.procedure, 0));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_resume(&bench.procedure));
    TEST_ASSERT_EQUAL_UINT32(13, counters()->commands_refused);
}

static void test_abort_stops_the_table_in_every_state(void)
{
    static const tumble_state_t states[] = {TUMBLE_STATE_PREFLIGHT, TUMBLE_STATE_WARM_UP, TUMBLE_STATE_WAIT_MOUNTING,
                                            TUMBLE_STATE_HOME,      TUMBLE_STATE_MOVE,    TUMBLE_STATE_SETTLE,
                                            TUMBLE_STATE_AVERAGE,   TUMBLE_STATE_SOLVE,   TUMBLE_STATE_VERIFY,
                                            TUMBLE_STATE_PROPOSE};
    for (size_t s = 0; s < COUNT_OF(states); s++) {
        bench_start(&bench);
        bench.operator_is_away = (states[s] == TUMBLE_STATE_WAIT_MOUNTING);
        bench_run_to(&bench, states[s]);
        TEST_ASSERT_EQUAL(states[s], bench_state_of(&bench));
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_abort(&bench.procedure));
        ASSERT_ENDED(&bench, TUMBLE_STATE_ABORT, TUMBLE_REASON_COMMAND);
        TEST_ASSERT_EQUAL_UINT(1, bench.stand.stops);
        TEST_ASSERT_EQUAL(states[s], bench_progress(&bench).failed_in);
        tumble_result_t result;
        ASSERT_STATUS((states[s] == TUMBLE_STATE_COUNT) ? TUMBLE_OK : TUMBLE_E_STATE,
                      tumble_procedure_result(&bench.procedure, &result));
        ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_resume(&bench.procedure));
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    }
}

static void test_a_second_run_starts_from_nothing(void)
{
    run_with(TUMBLE_ESTIMATE_REFINED);
    bench.block.u0_v[1] += 0.05;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_result(&bench.procedure, &result));
    bench_run(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_result(&bench.procedure, &result));
    assert_truth(&bench, result.coefficients, 2e-5);
    TEST_ASSERT_EQUAL_UINT(2, bench.stand.homes);
    TEST_ASSERT_EQUAL_UINT(4, bench.confirmations);
}

static void test_init_refuses_nothing_at_all(void)
{
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_init(NULL, &bench.config, &bench.table));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_init(&bench.procedure, NULL, &bench.table));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_init(&bench.procedure, &bench.config, NULL));
}

static const around_t around_each = {begin, NULL};
