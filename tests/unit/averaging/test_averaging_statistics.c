/* Means to the last bit, scatter against the textbook, and the hand-over to the estimators. */
#include "averaging_bench.h"

/* The double nearest to sum / n, by long division in integers: 54 bits of the quotient, the rest decides. */
static double nearest_ratio(int64_t sum, uint32_t n)
{
    const uint64_t size = (sum < 0) ? (uint64_t)-sum : (uint64_t)sum;
    if (size == 0U) {
        return 0.0;
    }
    uint64_t quotient = size / n;
    uint64_t rest = size % n;
    double unit = 1.0;
    while (quotient < (UINT64_C(1) << 53)) {
        rest *= 2U;
        quotient = 2U * quotient + ((rest >= n) ? 1U : 0U);
        rest -= (rest >= n) ? n : 0U;
        unit *= 0.5;
    }
    const bool half = (quotient & 1U) != 0U;
    quotient >>= 1;
    quotient += (half && (rest != 0U || (quotient & 1U) != 0U)) ? 1U : 0U;
    const double mean = (double)quotient * (2.0 * unit);
    return (sum < 0) ? -mean : mean;
}

static void test_the_oracle_of_means_itself(void)
{
    ASSERT_SAME_DOUBLE(0.5, nearest_ratio(1, 2));
    ASSERT_SAME_DOUBLE(-2147483648.0, nearest_ratio((int64_t)INT32_MIN * 1048576, 1048576));
    ASSERT_SAME_DOUBLE(0x1.5555555555555p-2, nearest_ratio(1, 3));
    ASSERT_SAME_DOUBLE(-0x1.5555555555555p-1, nearest_ratio(-2, 3));
    ASSERT_SAME_DOUBLE(0x1.999999999999ap-4, nearest_ratio(1, 10));
}

static void test_means_are_rounded_correctly(void)
{
    dice_t dice = {6};
    for (int round = 0; round < 20000; round++) {
        tumble_average_t *average = &averaging.averages[round % TUMBLE_MAX_POSITIONS];
        average->samples = 1U + dice_below(&dice, MOST_SAMPLES >> dice_below(&dice, 20));
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const int64_t most = (int64_t)average->samples * INT32_MAX;
            average->sum_counts[i] = (int64_t)(dice_u64(&dice) >> dice_below(&dice, 63)) % (most + 1);
            average->sum_counts[i] *= (dice_below(&dice, 2) == 0U) ? 1 : -1;
        }
        double mean[3];
        const uint8_t index = (uint8_t)(round % TUMBLE_MAX_POSITIONS);
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(&averaging, index, mean, NULL));
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            ASSERT_SAME_DOUBLE(nearest_ratio(average->sum_counts[i], average->samples), mean[i]);
        }
    }
}

/* Standard deviation in two passes, straight from its definition. */
static double textbook_scatter(const int32_t *values, size_t n)
{
    double mean = 0.0;
    double squares = 0.0;
    for (size_t k = 0; k < n; k++) {
        mean += (double)values[k] / (double)n;
    }
    for (size_t k = 0; k < n; k++) {
        squares += ((double)values[k] - mean) * ((double)values[k] - mean);
    }
    return sqrt(squares / (double)(n - 1U));
}

static void test_scatter_is_that_of_the_textbook(void)
{
    static int32_t values[TUMBLE_CHANNELS][500];
    static const int32_t spreads[] = {1, 3, 1000, MOST_DEVIATION / 2};
    dice_t dice = {7};
    for (int round = 0; round < 60; round++) {
        const size_t n = 2U + dice_below(&dice, 499);
        const int32_t spread = spreads[round % 4];
        const int32_t offset = dice_between(&dice, -2000000000, 2000000000);
        begin(0);
        for (size_t k = 0; k < n; k++) {
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                values[i][k] = offset + dice_between(&dice, -spread, spread);
            }
            add_good(values[0][k], values[1][k], values[2][k]);
        }
        double running[3];
        double running_error[3];
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_running(&averaging, running, running_error));
        ASSERT_STATUS(TUMBLE_OK, finish());
        double mean[3];
        double error[3];
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(&averaging, 0, mean, error));
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double scatter = textbook_scatter(values[i], n);
            const double expected_error = scatter / sqrt((double)n);
            TEST_ASSERT_DOUBLE_WITHIN(1.2e-7 * scatter, scatter, (double)averaging.averages[0].scatter_counts[i]);
            TEST_ASSERT_DOUBLE_WITHIN(1.2e-7 * expected_error, expected_error, error[i]);
            TEST_ASSERT_DOUBLE_WITHIN(1.2e-7 * expected_error, expected_error, running_error[i]);
            ASSERT_SAME_DOUBLE(running[i], mean[i]);
        }
    }
}

/* All but the first sample as far away as allowed, with the largest sums: scatter d / sqrt(n), exactly 2048. */
static void test_scatter_at_its_largest_sums(void)
{
    int32_t counts[3] = {0, INT32_MIN, INT32_MAX};
    begin(0);
    for (uint32_t k = 0; k < MOST_SAMPLES; k++) {
        tumble_averaging_accumulate(&averaging, counts);
        counts[0] = -MOST_DEVIATION;
        counts[1] = INT32_MIN + MOST_DEVIATION;
        counts[2] = INT32_MAX - MOST_DEVIATION;
    }
    ASSERT_STATUS(TUMBLE_OK, finish());
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        TEST_ASSERT_EQUAL_FLOAT(2048.0F, averaging.averages[0].scatter_counts[i]);
    }
    const int64_t sum_counts = -TUMBLE_MAX_DEVIATION_COUNTS * (TUMBLE_MAX_SAMPLES - 1);
    TEST_ASSERT_EQUAL_INT64(sum_counts, averaging.averages[0].sum_counts[0]);
}

static void test_equal_samples_have_no_scatter(void)
{
    begin(0);
    for (int k = 0; k < 1000; k++) {
        add_good(1234567891, -7, 0);
    }
    ASSERT_STATUS(TUMBLE_OK, finish());
    double mean[3];
    double error[3];
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(&averaging, 0, mean, error));
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        ASSERT_SAME_DOUBLE(0.0, (double)averaging.averages[0].scatter_counts[i]);
        ASSERT_SAME_DOUBLE(0.0, error[i]);
    }
}

static void test_accumulate_counts_as_add_does(void)
{
    for (uint8_t p = 0; p < 2U; p++) {
        dice_t dice = {8};
        begin(p);
        for (int32_t k = 0; k < 200; k++) {
            const int32_t x = dice_between(&dice, -9, 9);
            const int32_t counts[3] = {x, dice_between(&dice, -999, 999), k};
            if (p == 0U) {
                add_good(counts[0], counts[1], counts[2]);
            } else {
                tumble_averaging_accumulate(&averaging, counts);
            }
        }
        ASSERT_STATUS(TUMBLE_OK, finish());
    }
    TEST_ASSERT_EQUAL_MEMORY(&averaging.averages[0], &averaging.averages[1], sizeof averaging.averages[0]);
}

static void test_running_needs_two_samples(void)
{
    double mean[3] = {7, 7, 7};
    double error[3] = {7, 7, 7};
    begin(0);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_averaging_running(&averaging, mean, error));
    add_good(1, 2, 3);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_averaging_running(&averaging, mean, error));
    ASSERT_SAME_DOUBLE(7.0, mean[0]);
    ASSERT_SAME_DOUBLE(7.0, error[2]);
    add_good(3, 2, -1);
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_running(&averaging, mean, error));
    ASSERT_SAME_DOUBLE(2.0, mean[0]);
    ASSERT_SAME_DOUBLE(1.0, mean[2]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 1.0, error[0]); /* sqrt(2) / sqrt(2) */
    ASSERT_SAME_DOUBLE(0.0, error[1]);
    TEST_ASSERT_DOUBLE_WITHIN(2e-7, 2.0, error[2]);
}

static void test_null_pointers_are_refused(void)
{
    double mean[3];
    double error[3];
    tumble_means_t means;
    begin(0);
    add_good(1, 2, 3);
    add_good(1, 2, 3);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_running(NULL, mean, error));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_running(&averaging, NULL, error));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_running(&averaging, mean, NULL));
    ASSERT_STATUS(TUMBLE_OK, finish());
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_mean(NULL, 0, mean, error));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_mean(&averaging, 0, NULL, error));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_mean(&averaging, TUMBLE_MAX_POSITIONS, mean, error));
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(&averaging, 0, mean, NULL));
    ASSERT_STATUS(TUMBLE_E_MISSING_POSITION, tumble_averaging_mean(&averaging, TUMBLE_MAX_POSITIONS - 1, mean, error));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_means(NULL, 1.0, &means));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_means(&averaging, 1.0, NULL));
}

static void test_means_need_a_size_of_a_count(void)
{
    static const double bad[] = {0.0, -0.0, NOT_A_NUMBER, INFINITE, -INFINITE};
    tumble_means_t means;
    tumble_means_t as_it_was;
    memset(&means, 0, sizeof means);
    as_it_was = means;
    begin(0);
    add_good(1, 2, 3);
    ASSERT_STATUS(TUMBLE_OK, finish());
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_averaging_means(&averaging, bad[i], &means));
    }
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &means, sizeof means);
}

static void test_means_are_scaled_and_mark_what_was_measured(void)
{
    static const double sizes[] = {1.0, 0x1p-20, -0x1p-3, 1.1920929e-6};
    tumble_means_t means;
    for (uint8_t p = 0; p < TUMBLE_MAX_POSITIONS; p += 3U) {
        begin(p);
        add_good(p + 1, -5 * p, 70000000);
        add_good(p + 2, -5 * p, 70000001);
        ASSERT_STATUS(TUMBLE_OK, finish());
    }
    for (size_t s = 0; s < COUNT_OF(sizes); s++) {
        memset(&means, 0xFF, sizeof means.u_v);
        memset(means.measured, 1, sizeof means.measured);
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_means(&averaging, sizes[s], &means));
        for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
            TEST_ASSERT_EQUAL_INT(p % 3 == 0, means.measured[p]);
            if (p % 3 == 0) {
                ASSERT_SAME_DOUBLE(sizes[s] * ((double)p + 1.5), means.u_v[p][0]);
                ASSERT_SAME_DOUBLE(sizes[s] * (-5.0 * (double)p), means.u_v[p][1]);
                ASSERT_SAME_DOUBLE(sizes[s] * 70000000.5, means.u_v[p][2]);
            }
        }
    }
}

static const around_t around_each = {bench_start, NULL};
