/* Averaging as long as needed: positions that end early, positions that never become certain enough. */
#include "procedure_bench.h"

/* Standard deviation of noise uniform within plus or minus so many counts. */
#define COUNT_SIGMA_V(counts) ((counts) * 0.57735 * V_PER_COUNT)

static void set_up(void)
{
    bench_init(&bench);
    bench.averaging.stillness_ratio = 100.0F;
    bench.config.samples = 400;
    bench.config.average_timeout_ms = 10000;
    bench.config.error_budget_v = 10e-6;
}

static const tumble_average_t *average_of(uint8_t index)
{
    return &tumble_procedure_averages(&bench.procedure)->averages[index];
}

static double largest_error_v(uint8_t index)
{
    double mean[3];
    double error[3];
    double largest = 0.0;
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(tumble_procedure_averages(&bench.procedure), index, mean, error));
    for (int i = 0; i < 3; i++) {
        largest = (error[i] > largest) ? error[i] : largest;
    }
    return largest * V_PER_COUNT;
}

static void run(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run(&bench);
}

static void test_a_quiet_block_takes_the_fewest_samples(void)
{
    bench_start_to_done(&bench);
    for (uint8_t p = 0; p < 18U; p++) {
        TEST_ASSERT_EQUAL_UINT32(bench.averaging.min_samples, average_of(p)->samples);
    }
    TEST_ASSERT_EQUAL_UINT32(180, counters()->averaged);
}

static void test_without_a_budget_all_are_taken(void)
{
    bench.config.error_budget_v = 0.0;
    bench.config.samples = 50;
    bench_start_to_done(&bench);
    for (uint8_t p = 0; p < 18U; p++) {
        TEST_ASSERT_EQUAL_UINT32(50, average_of(p)->samples);
    }
}

/* Each position ends at the first look at which its largest standard error is within the budget. */
static void test_a_noisy_position_takes_as_many_as_it_needs(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 9, TUMBLE_STATE_SETTLE);
    bench.block.noise_counts = 200;
    bench_run_to_done(&bench);
    const double needed = (COUNT_SIGMA_V(200) / 10e-6) * (COUNT_SIGMA_V(200) / 10e-6); /* 133 */
    for (uint8_t p = 9; p < 18U; p++) {
        const uint32_t taken = average_of(p)->samples;
        TEST_ASSERT_EQUAL_UINT32(0, (taken - bench.averaging.min_samples) % TUMBLE_BUDGET_CHECK_SAMPLES);
        TEST_ASSERT_DOUBLE_WITHIN(0.35 * needed, needed, (double)taken);
        TEST_ASSERT_TRUE(largest_error_v(p) <= bench.config.error_budget_v);
        TEST_ASSERT_TRUE(largest_error_v(p) > 0.8 * bench.config.error_budget_v);
    }
}

/* One noisy channel is enough: the others wait for it. */
static void test_the_worst_channel_decides(void)
{
    bench.block.add_counts = 300; /* on x, every other sample: a scatter of 150 counts */
    bench_start_to_done(&bench);
    TEST_ASSERT_DOUBLE_WITHIN(40.0, 228.0, (double)average_of(3)->samples);
}

static void test_the_number_of_steps_makes_no_difference(void)
{
    uint32_t taken[18];
    bench.block.noise_counts = 150;
    run();
    for (uint8_t p = 0; p < 18U; p++) {
        taken[p] = average_of(p)->samples;
    }
    set_up();
    bench.block.noise_counts = 150;
    bench.step_us = 0;
    bench_start_to_done(&bench);
    for (uint8_t p = 0; p < 18U; p++) {
        TEST_ASSERT_EQUAL_UINT32(taken[p], average_of(p)->samples);
    }
}

/* With all samples allowed it is still too uncertain: once more, then a fault that keeps no such mean. */
static void test_a_position_that_never_gets_there_is_a_fault(void)
{
    bench.config.samples = 60;
    bench.block.noise_counts = 200;
    run();
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_UNCERTAIN);
    const tumble_progress_t progress = bench_progress(&bench);
    ASSERT_STATUS(TUMBLE_E_UNCERTAIN, progress.status);
    TEST_ASSERT_EQUAL_UINT8(0, progress.finished);
    TEST_ASSERT_EQUAL_UINT32(2, counters()->refused);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->retries);
    TEST_ASSERT_EQUAL_UINT32(120, counters()->averaged);

    bench.block.noise_counts = 30; /* what shook it has been switched off */
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    bench_run_to_done(&bench);
    TEST_ASSERT_EQUAL_UINT32(10, average_of(0)->samples);
}

/* The last sample allowed may lie between two looks: it is looked at all the same. */
static void test_the_last_sample_counts(void)
{
    bench.config.samples = 13;
    bench.config.error_budget_v = 1e-5;
    bench.averaging.min_samples = 12;
    bench.block.noise_counts = 61; /* a standard error of about 10 uV at 13 samples: some pass, some do not */
    bench.config.retries = 200;
    bench.config.schedule = &tumble_schedule_paper;
    bench_start_to_done(&bench);
    unsigned at_the_last = 0;
    for (uint8_t p = 0; p < 18U; p++) {
        at_the_last += (average_of(p)->samples == 13U) ? 1U : 0U;
        TEST_ASSERT_TRUE(largest_error_v(p) <= bench.config.error_budget_v);
    }
    TEST_ASSERT_TRUE(at_the_last > 0U);
    TEST_ASSERT_TRUE(counters()->retries > 0U);
}

static void test_a_budget_must_be_a_size(void)
{
    static const double bad[] = {-1e-9, -1.0, 1.0 / 0.0, 0.0 / 0.0};
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        tumble_reason_t reason;
        bench.config.error_budget_v = bad[i];
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_validate(&bench.config, &reason));
        TEST_ASSERT_EQUAL(TUMBLE_REASON_CONFIGURATION, reason);
    }
}
