/* The life of a position, exact sums, and what init and begin accept. */
#include "averaging_bench.h"

static void assert_config_refused(void)
{
    tumble_averaging_t state;
    tumble_averaging_t as_it_was;
    memset(&state, 0x5A, sizeof state);
    as_it_was = state;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_init(&state, &config));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &state, sizeof state);
    bench_start();
}

static void assert_config_accepted(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_init(&averaging, &config));
    bench_start();
}

static void test_init_refuses_null(void)
{
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_init(NULL, &config));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_init(&averaging, NULL));
}

#define REFUSED(change) (ROW(#change), (change), assert_config_refused())
#define ACCEPTED(change) (ROW(#change), (change), assert_config_accepted())

/* The saturation, the least number of samples, the stuck run, noise and stillness: out of range and at its ends. */
static void test_init_refuses_what_is_out_of_range(void)
{
    REFUSED(config.saturation_counts = 0);
    REFUSED(config.saturation_counts = INT32_MIN);
    ACCEPTED(config.saturation_counts = 1);
    REFUSED(config.min_samples = 0);
    REFUSED(config.min_samples = MOST_SAMPLES + 1U);
    REFUSED(config.min_samples = UINT32_MAX);
    ACCEPTED(config.min_samples = MOST_SAMPLES);
    REFUSED(config.stuck_run = 1);
    ACCEPTED(config.stuck_run = 2);
    ACCEPTED(config.stuck_run = UINT16_MAX);
    REFUSED(config.noise_counts = -1.0F);
    REFUSED(config.noise_counts = NAN);
    REFUSED(config.noise_counts = INFINITY);
    REFUSED(config.stillness_ratio = INFINITY);
    REFUSED(config.stillness_ratio = 0.0F);
    REFUSED(config.stillness_ratio = -3.0F);
    REFUSED(config.stillness_ratio = NAN);
    ACCEPTED((config.noise_counts = 12.5F, config.stillness_ratio = 1e-3F));
}

static void test_init_empties_everything(void)
{
    for (uint8_t p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        assert_position_is_empty(p);
    }
    assert_counters(0, 0, 0, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_averaging_samples(&averaging));
}

static void test_nothing_is_open_before_begin(void)
{
    double mean[3];
    double error[3];
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, add(1, 2, 3));
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, finish());
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, tumble_averaging_running(&averaging, mean, error));
    assert_counters(0, 0, 0, 0, 0);
}

static void test_begin_refuses_null_and_an_index_out_of_range(void)
{
    begin(3);
    add_good(1, 2, 3);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_begin(NULL, 0));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_begin(&averaging, TUMBLE_MAX_POSITIONS));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_begin(&averaging, UINT8_MAX));
    TEST_ASSERT_EQUAL_UINT32(1, tumble_averaging_samples(&averaging)); /* the open one goes on */
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_mean(3, 1.0, 2.0, 3.0);
    begin(TUMBLE_MAX_POSITIONS - 1);
}

static void test_a_position_from_begin_to_finish(void)
{
    begin(7);
    for (int32_t k = 1; k <= 8; k++) {
        add_good(k, -10 * k, 1000 + k);
        TEST_ASSERT_EQUAL_UINT32(k, tumble_averaging_samples(&averaging));
    }
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_mean(7, 4.5, -45.0, 1004.5);
    TEST_ASSERT_EQUAL_INT64(36, averaging.averages[7].sum_counts[0]);
    TEST_ASSERT_EQUAL_UINT32(8, averaging.averages[7].samples);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_averaging_samples(&averaging));
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, finish());
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, add(1, 1, 1));
    assert_counters(0, 0, 0, 0, 0);
}

static void test_an_open_position_is_not_finished(void)
{
    tumble_means_t means;
    begin(5);
    add_good(1, 2, 3);
    assert_position_is_empty(5);
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_means(&averaging, 1.0, &means));
    TEST_ASSERT_FALSE(means.measured[5]);
}

static void test_begin_abandons_the_open_position(void)
{
    begin(0);
    add_good(1, 2, 3);
    begin(1);
    assert_position_is_empty(0);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_averaging_samples(&averaging));
    add_good(4, 5, 6);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_position_is_empty(0);
    assert_mean(1, 4.0, 5.0, 6.0);
}

static void test_begin_forgets_what_the_position_held(void)
{
    begin(4);
    add_good(100, 100, 100);
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(4);
    assert_position_is_empty(4);
    add_good(-1, 0, 7);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_mean(4, -1.0, 0.0, 7.0);
    begin(4);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, finish());
    assert_position_is_empty(4);
}

static void test_positions_do_not_touch_each_other(void)
{
    for (uint8_t p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        begin(p);
        add_good(p, -p, 3 * p);
        add_good(p + 1, -p, 3 * p);
        ASSERT_STATUS(TUMBLE_OK, finish());
    }
    for (uint8_t p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        assert_mean(p, (double)p + 0.5, -(double)p, 3.0 * (double)p);
    }
}

static void test_sums_are_exact_at_the_ends_of_the_range(void)
{
    static const int32_t lowest[3] = {INT32_MIN, INT32_MAX, -1};
    begin(0);
    for (uint32_t k = 0; k < MOST_SAMPLES; k++) {
        tumble_averaging_accumulate(&averaging, lowest);
    }
    ASSERT_STATUS(TUMBLE_E_FULL, add(INT32_MIN + 1, INT32_MAX - 1, -1));
    TEST_ASSERT_EQUAL_UINT32(MOST_SAMPLES, tumble_averaging_samples(&averaging));
    ASSERT_STATUS(TUMBLE_OK, finish());
    TEST_ASSERT_EQUAL_INT64((int64_t)INT32_MIN * TUMBLE_MAX_SAMPLES, averaging.averages[0].sum_counts[0]);
    TEST_ASSERT_EQUAL_INT64((int64_t)INT32_MAX * TUMBLE_MAX_SAMPLES, averaging.averages[0].sum_counts[1]);
    TEST_ASSERT_EQUAL_INT64(-TUMBLE_MAX_SAMPLES, averaging.averages[0].sum_counts[2]);
    assert_mean(0, (double)INT32_MIN, (double)INT32_MAX, -1.0);
    TEST_ASSERT_EQUAL_FLOAT(0.0F, averaging.averages[0].scatter_counts[0]);
}

static void test_the_last_sample_that_fits_is_taken(void)
{
    static const int32_t zero[3] = {0, 0, 0};
    begin(0);
    for (uint32_t k = 0; k < MOST_SAMPLES - 1U; k++) {
        tumble_averaging_accumulate(&averaging, zero);
    }
    add_good(0, 0, 0);
    const uint16_t again = (uint16_t)(next_counter - 1U);
    ASSERT_STATUS(TUMBLE_E_FULL, add_with_counter(again, 0, 0, 0)); /* full comes before all other gates */
    ASSERT_STATUS(TUMBLE_E_FULL, add(INT32_MAX, 0, 0));
    assert_counters(0, 0, 0, 0, 0);
    ASSERT_STATUS(TUMBLE_OK, finish());
}

static void test_the_order_of_samples_does_not_change_the_mean(void)
{
    int32_t values[100];
    dice_t dice = {5};
    for (size_t k = 0; k < COUNT_OF(values); k++) {
        values[k] = dice_between(&dice, -1000000, 1000000);
    }
    for (uint8_t p = 0; p < 2U; p++) {
        begin(p);
        for (size_t k = 0; k < COUNT_OF(values); k++) {
            const int32_t value = values[(p == 0U) ? k : (k * 37U + 5U) % COUNT_OF(values)];
            add_good(value, -value, value);
        }
        ASSERT_STATUS(TUMBLE_OK, finish());
    }
    TEST_ASSERT_EQUAL_MEMORY(averaging.averages[0].sum_counts, averaging.averages[1].sum_counts,
                             sizeof averaging.averages[0].sum_counts);
}

static const around_t around_each = {bench_start, NULL};
