/* The block's own sample counter: lost, repeated and reordered samples, and the counters that tell of them. */
#include "averaging_bench.h"

static void add_counter(uint16_t counter)
{
    ASSERT_STATUS(TUMBLE_OK, add_with_counter(counter, 1, 2, 3));
}

static void test_the_counter_may_start_anywhere_and_wraps(void)
{
    static const uint16_t starts[] = {0, 1, 32767, 32768, 65534, 65535};
    for (size_t i = 0; i < COUNT_OF(starts); i++) {
        begin(0);
        for (unsigned k = 0; k < 4U; k++) {
            add_counter((uint16_t)(starts[i] + k));
        }
        ASSERT_STATUS(TUMBLE_OK, finish());
    }
    assert_counters(0, 0, 0, 0, 0);
}

static void test_missing_counter_values_are_lost(void)
{
    config.max_lost = 5;
    add_counter(65534);
    add_counter(1); /* 65535 and 0 are missing */
    assert_counters(0, 0, 0, 0, 2);
    add_counter(5);
    assert_counters(0, 0, 0, 0, 5);
    TEST_ASSERT_EQUAL_UINT32(3, tumble_averaging_samples(&averaging));
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(0);
    add_counter(100);
    add_counter(107);
    ASSERT_STATUS(TUMBLE_E_LOST, finish());
    assert_position_is_empty(0);
    assert_counters(0, 0, 0, 0, 11);
}

static void test_with_no_loss_allowed_one_is_too_many(void)
{
    add_counter(7);
    add_counter(9);
    ASSERT_STATUS(TUMBLE_E_LOST, finish());
}

static void test_nothing_is_lost_between_positions(void)
{
    add_counter(10);
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(1);
    add_counter(500);
    add_counter(501);
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(1);
    add_counter(3);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_counters(0, 0, 0, 0, 0);
}

/* A position that lost too many does not pass its debt on. */
static void test_losses_count_for_their_own_position(void)
{
    config.max_lost = 1;
    add_counter(0);
    add_counter(9);
    begin(0);
    add_counter(20);
    add_counter(22);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_counters(0, 0, 0, 0, 9);
}

static void test_a_counter_that_comes_twice_is_refused(void)
{
    add_counter(0);
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(0, 9, 9, 9));
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(0, INT32_MAX, 9, 9)); /* before the other gates */
    add_counter(1);
    assert_counters(0, 0, 2, 0, 0);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_mean(0, 1.0, 2.0, 3.0);
}

static void test_a_counter_that_goes_backwards_is_refused(void)
{
    add_counter(1);
    ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter(0, 9, 9, 9));
    ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter(65535, 9, 9, 9));
    ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter(65000, INT32_MAX, 9, 9));
    add_counter(2); /* the refused ones did not move it */
    assert_counters(0, 0, 0, 3, 0);
    ASSERT_STATUS(TUMBLE_OK, finish());
    assert_mean(0, 1.0, 2.0, 3.0);
}

static void test_a_lost_sample_that_comes_late_stays_lost(void)
{
    config.max_lost = 1;
    add_counter(10);
    add_counter(12);
    ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter(11, 9, 9, 9));
    add_counter(13);
    assert_counters(0, 0, 0, 1, 1);
    ASSERT_STATUS(TUMBLE_OK, finish());
}

static void test_half_the_range_divides_forwards_from_backwards(void)
{
    add_counter(1000);
    ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter(1000 + 32768, 1, 2, 3));
    assert_counters(0, 0, 0, 1, 0);
    add_counter(1000 + 32767);
    assert_counters(0, 0, 0, 1, 32766);
}

/* A refused sample did arrive: its counter value is not lost, and may not come again. */
static void test_a_sample_refused_for_its_value_is_not_lost(void)
{
    add_counter(10);
    ASSERT_STATUS(TUMBLE_E_SATURATED, add_with_counter(11, INT32_MAX, 0, 0));
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(11, 1, 2, 3));
    ASSERT_STATUS(TUMBLE_E_DEVIATION, add_with_counter(12, 2 + MOST_DEVIATION, 0, 0));
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(12, 1, 2, 3));
    add_counter(13);
    assert_counters(1, 1, 2, 0, 0);
}

static void test_a_gap_before_a_refused_sample_is_counted(void)
{
    add_counter(10);
    ASSERT_STATUS(TUMBLE_E_SATURATED, add_with_counter(15, INT32_MAX, 0, 0));
    add_counter(16);
    assert_counters(1, 0, 0, 0, 4);
}

static void test_a_refused_first_sample_starts_the_count(void)
{
    ASSERT_STATUS(TUMBLE_E_SATURATED, add_with_counter(5, INT32_MAX, 0, 0));
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(5, 1, 2, 3));
    add_counter(8);
    assert_counters(1, 0, 1, 0, 2);
}

static void test_saturation_comes_before_deviation(void)
{
    config.saturation_counts = MOST_DEVIATION;
    add_counter(1);
    ASSERT_STATUS(TUMBLE_E_SATURATED, add_with_counter(2, -MOST_DEVIATION, 2 + MOST_DEVIATION, 0));
    assert_counters(1, 0, 0, 0, 0);
}

/* Three of the widest gaps lose more than 16 bits can tell. */
static void test_losses_beyond_16_bits_are_not_forgiven(void)
{
    static const uint16_t limits[] = {0, 32761, 32762, 40000, 65534, 65535};
    for (size_t i = 0; i < COUNT_OF(limits); i++) {
        bench_begin();
        config.max_lost = limits[i];
        for (unsigned k = 0; k < 4U; k++) {
            add_counter((uint16_t)(k * 32767U));
        }
        assert_counters(0, 0, 0, 0, 3U * 32766U);
        ASSERT_STATUS(TUMBLE_E_LOST, finish());
    }
}

static void test_the_most_that_may_be_lost_may_be_lost(void)
{
    config.max_lost = UINT16_MAX;
    add_counter(0);
    add_counter(32767);
    add_counter(65534);
    add_counter(2); /* 32766 + 32766 + 3 = 65535 */
    assert_counters(0, 0, 0, 0, 65535);
    ASSERT_STATUS(TUMBLE_OK, finish());
}

static void test_counters_stop_instead_of_wrapping(void)
{
    averaging.counters = (tumble_averaging_counters_t){UINT32_MAX - 1U, UINT32_MAX - 1U, UINT32_MAX - 1U,
                                                       UINT32_MAX - 1U, UINT32_MAX - 9U};
    for (unsigned round = 0; round < 3U; round++) {
        begin(0);
        add_counter(100);
        add_counter(106);
        ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(106, 1, 2, 3));
        ASSERT_STATUS(TUMBLE_E_REORDERED, add_with_counter(105, 1, 2, 3));
        ASSERT_STATUS(TUMBLE_E_SATURATED, add_with_counter(107, INT32_MAX, 2, 3));
        ASSERT_STATUS(TUMBLE_E_DEVIATION, add_with_counter(108, 2 + MOST_DEVIATION, 2, 3));
        const uint32_t lost = (round == 0U) ? UINT32_MAX - 4U : UINT32_MAX;
        assert_counters(UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, lost);
    }
}

static void test_counters_live_until_init(void)
{
    add_counter(1);
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(1, 1, 2, 3));
    ASSERT_STATUS(TUMBLE_OK, finish());
    begin(1);
    add_counter(1);
    ASSERT_STATUS(TUMBLE_E_REPEATED, add_with_counter(1, 1, 2, 3));
    assert_counters(0, 0, 2, 0, 0);
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_init(&averaging, &config));
    assert_counters(0, 0, 0, 0, 0);
}

static const around_t around_each = {bench_begin, NULL};
