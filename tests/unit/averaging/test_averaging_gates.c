/* Every gate in turn: what passes at its very edge, what does not, which status, which counter. */
#include "averaging_bench.h"

/* A sample with `value` in one channel and 0 in the others. */
static tumble_status_t add_in_channel(int channel, int32_t value)
{
    return add((channel == 0) ? value : 0, (channel == 1) ? value : 0, (channel == 2) ? value : 0);
}

static void assert_finish_refused(tumble_status_t expected)
{
    ASSERT_STATUS(expected, finish());
    assert_position_is_empty(0);
    TEST_ASSERT_EQUAL_UINT32(0, averaging.averages[0].samples);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_averaging_samples(&averaging));
    ASSERT_STATUS(TUMBLE_E_NOT_OPEN, finish());
}

static void test_a_sample_at_the_range_of_the_converter_is_refused(void)
{
    static const int32_t beyond[] = {1000, -1000, 1001, -1001, INT32_MAX, INT32_MIN};
    config.saturation_counts = 1000;
    uint32_t refused = 0;
    for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
        for (size_t i = 0; i < COUNT_OF(beyond); i++) {
            ASSERT_STATUS(TUMBLE_E_SATURATED, add_in_channel(channel, beyond[i]));
            refused++;
            assert_counters(refused, 0, 0, 0, 0);
        }
        add_good(0, 0, 0);
        ASSERT_STATUS(TUMBLE_OK, add_in_channel(channel, 999));
        ASSERT_STATUS(TUMBLE_OK, add_in_channel(channel, -999));
    }
    TEST_ASSERT_EQUAL_UINT32(9, tumble_averaging_samples(&averaging));
    assert_finish_refused(TUMBLE_E_SATURATED);
}

static void test_the_widest_range_still_refuses_its_ends(void)
{
    ASSERT_STATUS(TUMBLE_E_SATURATED, add(INT32_MAX, 0, 0));
    ASSERT_STATUS(TUMBLE_E_SATURATED, add(0, -INT32_MAX, 0));
    ASSERT_STATUS(TUMBLE_E_SATURATED, add(0, 0, INT32_MIN));
    ASSERT_STATUS(TUMBLE_OK, add(INT32_MAX - 1, -INT32_MAX + 1, 0));
    assert_counters(3, 0, 0, 0, 0);
}

static void test_a_sample_too_far_from_the_first_is_refused(void)
{
    static const int32_t firsts[] = {0, 12345, -MOST_DEVIATION, 1000000000, -1000000000};
    for (size_t i = 0; i < COUNT_OF(firsts); i++) {
        for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
            bench_start();
            begin(0);
            ASSERT_STATUS(TUMBLE_OK, add_in_channel(channel, firsts[i]));
            ASSERT_STATUS(TUMBLE_OK, add_in_channel(channel, firsts[i] + MOST_DEVIATION));
            ASSERT_STATUS(TUMBLE_OK, add_in_channel(channel, firsts[i] - MOST_DEVIATION));
            ASSERT_STATUS(TUMBLE_E_DEVIATION, add_in_channel(channel, firsts[i] + MOST_DEVIATION + 1));
            ASSERT_STATUS(TUMBLE_E_DEVIATION, add_in_channel(channel, firsts[i] - MOST_DEVIATION - 1));
            assert_counters(0, 2, 0, 0, 0);
            TEST_ASSERT_EQUAL_UINT32(3, tumble_averaging_samples(&averaging));
            assert_finish_refused(TUMBLE_E_DEVIATION);
        }
    }
}

static void test_the_widest_deviation_does_not_overflow(void)
{
    add_good(INT32_MAX - 1, -INT32_MAX + 1, 0);
    ASSERT_STATUS(TUMBLE_E_DEVIATION, add(-INT32_MAX + 1, -INT32_MAX + 1, 0));
    ASSERT_STATUS(TUMBLE_E_DEVIATION, add(INT32_MAX - 1, INT32_MAX - 1, 0));
    assert_counters(0, 2, 0, 0, 0);
}

/* The limit holds from the first sample that was taken, in this position. */
static void test_deviation_is_from_the_first_sample_taken(void)
{
    add_good(MOST_DEVIATION, 0, 0);
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(0);
    ASSERT_STATUS(TUMBLE_E_SATURATED, add(INT32_MAX, 0, 0));
    add_good(-MOST_DEVIATION, 0, 0);
    add_good(0, 0, 0);
    ASSERT_STATUS(TUMBLE_E_DEVIATION, add(1, 0, 0));
}

static void test_refused_samples_change_neither_sums_nor_scatter(void)
{
    begin(1);
    for (int32_t k = 0; k < 20; k++) {
        add_good(k, 2 * k, -k);
        ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter((uint16_t)(next_counter - 1U), 500, 500, 500));
        ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter((uint16_t)(next_counter - 9U), 500, 500, 500));
    }
    assert_counters(0, 0, 20, 20, 0);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_mean(1, 9.5, 19.0, -9.5);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, 5.9160798F, averaging.averages[1].scatter_counts[0]);
}

static void test_too_few_samples(void)
{
    config.min_samples = 5;
    for (int32_t k = 0; k < 4; k++) {
        add_good(k, k, k);
    }
    assert_finish_refused(TUMBLE_E_TOO_FEW);
    begin(0);
    for (int32_t k = 0; k < 5; k++) {
        add_good(k, k, k);
    }
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(0);
    assert_finish_refused(TUMBLE_E_TOO_FEW);
}

/* One channel gives `run` equal values in a row, after `before` lively ones and before a last lively one. */
static tumble_status_t finish_after_run(int channel, int before, int run)
{
    int32_t lively = 0;
    begin(0);
    for (int k = 0; k < before + run + 1; k++) {
        lively++;
        const bool stuck = (k >= before) && (k < before + run);
        int32_t counts[3] = {lively, -lively, 2 * lively};
        counts[channel] = stuck ? -77 : counts[channel];
        add_good(counts[0], counts[1], counts[2]);
    }
    return finish();
}

static void test_a_channel_that_repeats_a_value_too_often_is_stuck(void)
{
    config.stuck_run = 5;
    for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
        for (int before = 0; before < 3; before++) {
            ASSERT_STATUS(TUMBLE_OK, finish_after_run(channel, before, 4));
            ASSERT_STATUS(TUMBLE_E_STUCK, finish_after_run(channel, before, 5));
            ASSERT_STATUS(TUMBLE_E_STUCK, finish_after_run(channel, before, 6));
            assert_position_is_empty(0);
        }
    }
    config.stuck_run = 2;
    ASSERT_STATUS(TUMBLE_OK, finish_after_run(1, 2, 1));
    ASSERT_STATUS(TUMBLE_E_STUCK, finish_after_run(1, 2, 2));
    config.stuck_run = 0;
    ASSERT_STATUS(TUMBLE_OK, finish_after_run(1, 2, 200));
}

/* Broken runs, runs of different channels, of different positions, and repeated frames do not add up. */
static void test_only_samples_in_a_row_make_a_run(void)
{
    config.stuck_run = 3;
    add_good(1, 5, 1);
    add_good(1, 6, 2);
    add_good(2, 6, 3);
    add_good(1, 7, 3);
    add_good(1, 8, 4);
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter((uint16_t)(next_counter - 1U), 1, 8, 4));
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(1);
    add_good(1, 9, 5);
    add_good(1, 10, 6);
    add_good(2, 10, 7);
    ASSERT_STATUS(TUMBLE_OK, finish());
}

/* With fewer samples than the gate counts no run is long enough: there all of them must not be equal. */
static void test_a_position_too_short_for_the_gate_shows_a_stuck_channel_too(void)
{
    config.stuck_run = 20;
    for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
        for (int samples = 2; samples < 20; samples++) {
            for (int alive = 0; alive < 2; alive++) { /* the last sample differs */
                begin(0);
                for (int32_t k = 0; k < samples; k++) {
                    int32_t counts[3] = {k, -k, 2 * k};
                    counts[channel] = ((alive != 0) && (k == (samples - 1))) ? -76 : -77;
                    add_good(counts[0], counts[1], counts[2]);
                }
                ASSERT_STATUS((alive != 0) ? TUMBLE_OK : TUMBLE_E_STUCK, finish());
            }
        }
    }
    config.stuck_run = 0;
    ASSERT_STATUS(TUMBLE_OK, finish_after_run(1, 0, 1));
}

static void test_the_longest_run_is_counted_to_its_end(void)
{
    config.stuck_run = UINT16_MAX;
    ASSERT_STATUS(TUMBLE_OK, finish_after_run(0, 1, UINT16_MAX - 1));
    ASSERT_STATUS(TUMBLE_E_STUCK, finish_after_run(0, 1, UINT16_MAX));
    ASSERT_STATUS(TUMBLE_E_STUCK, finish_after_run(0, 1, UINT16_MAX + 2));
}

static tumble_status_t finish_with_scatter_of_one(int channel)
{
    begin(0);
    for (int32_t value = -1; value <= 1; value++) {
        ASSERT_STATUS(TUMBLE_OK, add_in_channel(channel, value));
    }
    return finish();
}

/* -1, 0, 1 scatter by exactly 1. */
static void test_scatter_beyond_the_declared_noise_is_motion(void)
{
    for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
        config.noise_counts = 0.5F;
        config.stillness_ratio = 2.0F;
        ASSERT_STATUS(TUMBLE_OK, finish_with_scatter_of_one(channel));
        config.stillness_ratio = 1.999F;
        ASSERT_STATUS(TUMBLE_E_NOT_STILL, finish_with_scatter_of_one(channel));
        assert_position_is_empty(0);
        config.noise_counts = 0.49F;
        config.stillness_ratio = 2.0F;
        ASSERT_STATUS(TUMBLE_E_NOT_STILL, finish_with_scatter_of_one(channel));
        config.noise_counts = 0.0F; /* unknown noise: the gate is off */
        ASSERT_STATUS(TUMBLE_OK, finish_with_scatter_of_one(channel));
    }
}

static void test_a_single_sample_is_still(void)
{
    config.noise_counts = 1e-3F;
    add_good(5, 6, 7);
    ASSERT_STATUS(TUMBLE_OK, finish());
    TEST_ASSERT_EQUAL_FLOAT(0.0F, averaging.averages[0].scatter_counts[0]);
}

/* Every combination of the six faults of a position: the first in the documented order is the one reported. */
static void test_finish_judges_in_the_documented_order(void)
{
    static const tumble_status_t order[] = {TUMBLE_E_SATURATED, TUMBLE_E_DEVIATION, TUMBLE_E_LOST,
                                            TUMBLE_E_TOO_FEW,   TUMBLE_E_STUCK,     TUMBLE_E_NOT_STILL};
    config.min_samples = 10;
    config.max_lost = 2;
    config.stuck_run = 5;
    config.noise_counts = 1.0F;
    config.stillness_ratio = 3.0F;
    for (unsigned faults = 0; faults < 64U; faults++) {
        begin(0);
        const int32_t lively = (faults & 8U) ? 2 : 12;
        for (int32_t k = 0; k < lively; k++) {
            add_good(k % 3, k % 2, -(k % 3));
        }
        for (int32_t k = 0; k < 5 && (faults & 16U); k++) {
            add_good(k % 2, 1, k % 3);
        }
        ASSERT_STATUS(TUMBLE_OK, (faults & 32U) ? add(50, 0, 0) : TUMBLE_OK);
        ASSERT_STATUS((faults & 1U) ? TUMBLE_E_SATURATED : TUMBLE_OK, (faults & 1U) ? add(INT32_MAX, 0, 0) : TUMBLE_OK);
        ASSERT_STATUS((faults & 2U) ? TUMBLE_E_DEVIATION : TUMBLE_OK,
                      (faults & 2U) ? add(0, MOST_DEVIATION + 9, 0) : TUMBLE_OK);
        next_counter = (uint16_t)(next_counter + ((faults & 4U) ? 3U : 2U));
        add_good(-1, -1, 1);
        size_t first = 0;
        while (first < COUNT_OF(order) && !(faults & (1U << first))) {
            first++;
        }
        ASSERT_STATUS((first < COUNT_OF(order)) ? order[first] : TUMBLE_OK, finish());
    }
}

/* Not even its counter is followed. */
static void test_a_sample_that_the_block_calls_faulty_is_refused(void)
{
    begin(0);
    add_good(1, 2, 3);
    const tumble_averaging_t before = averaging;
    for (unsigned status = 1; status <= UINT8_MAX; status++) {
        const tumble_sample_t sample = {{1, 2, 3}, next_counter, (uint8_t)status};
        ASSERT_STATUS(TUMBLE_E_UNHEALTHY, tumble_averaging_add(&averaging, &config, &sample));
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &averaging, sizeof averaging);
    add_good(1, 2, 3);
    assert_counters(0, 0, 0, 0, 0);
    next_counter++; /* that of a faulty sample: with the next one it counts as lost */
    add_good(1, 2, 3);
    assert_counters(0, 0, 0, 0, 1);
}

/* As many samples of the largest output that passes, of either sign, and not one count more. */
static void test_a_mean_is_restored_up_to_the_saturation(void)
{
    static const struct {
        int64_t sum_counts;
        tumble_status_t wanted;
    } cases[] = {{4 * 999, TUMBLE_OK},
                 {4 * 999 + 1, TUMBLE_E_ARGUMENT},
                 {-4 * 999, TUMBLE_OK},
                 {-4 * 999 - 1, TUMBLE_E_ARGUMENT}};
    config.saturation_counts = 1000;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const tumble_average_t average = {.samples = 4, .sum_counts = {0, cases[i].sum_counts, 0}};
        ASSERT_STATUS(cases[i].wanted, tumble_averaging_restore(&averaging, &config, 3, &average));
        TEST_ASSERT_EQUAL_UINT32((cases[i].wanted == TUMBLE_OK) ? 4U : 0U, averaging.averages[3].samples);
    }
}

static const around_t around_each = {bench_begin, NULL};
