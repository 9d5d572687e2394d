/* averaging_bench.h - one averaging state with open gates, and a block that counts its samples. */
#ifndef TUMBLE_TESTS_UNIT_AVERAGING_BENCH_H
#define TUMBLE_TESTS_UNIT_AVERAGING_BENCH_H

#include "support.h"
#include "tumble/core.h"

#define MOST_SAMPLES ((uint32_t)TUMBLE_MAX_SAMPLES)
#define MOST_DEVIATION ((int32_t)TUMBLE_MAX_DEVIATION_COUNTS)

static tumble_averaging_t averaging;
static tumble_averaging_config_t config;
static uint16_t next_counter;

/* Every gate as wide as it goes; tests narrow the one they are about. */
static inline void bench_start(void)
{
    config = (tumble_averaging_config_t){
        .saturation_counts = INT32_MAX,
        .min_samples = 1,
        .max_lost = 0,
        .stuck_run = 0,
        .noise_counts = 0.0F,
        .stillness_ratio = 1.0F,
    };
    next_counter = 65530; /* most tests go over the wrap */
    memset(&averaging, 0xA5, sizeof averaging);
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_init(&averaging, &config));
}

static inline void begin(uint8_t index)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_begin(&averaging, index));
}

static inline void bench_begin(void)
{
    bench_start();
    begin(0);
}

static inline tumble_status_t add_with_counter(uint16_t counter, int32_t x, int32_t y, int32_t z)
{
    const tumble_sample_t sample = {{x, y, z}, counter, 0};
    return tumble_averaging_add(&averaging, &config, &sample);
}

static inline tumble_status_t add(int32_t x, int32_t y, int32_t z)
{
    const uint16_t counter = next_counter;
    next_counter = (uint16_t)(next_counter + 1U);
    return add_with_counter(counter, x, y, z);
}

static inline void add_good(int32_t x, int32_t y, int32_t z)
{
    ASSERT_STATUS(TUMBLE_OK, add(x, y, z));
}

static inline tumble_status_t finish(void)
{
    return tumble_averaging_finish(&averaging, &config);
}

static inline void assert_counters(uint32_t saturated, uint32_t deviating, uint32_t repeated, uint32_t reordered,
                                   uint32_t lost)
{
    TEST_ASSERT_EQUAL_UINT32(saturated, averaging.counters.saturated);
    TEST_ASSERT_EQUAL_UINT32(deviating, averaging.counters.deviating);
    TEST_ASSERT_EQUAL_UINT32(repeated, averaging.counters.repeated);
    TEST_ASSERT_EQUAL_UINT32(reordered, averaging.counters.reordered);
    TEST_ASSERT_EQUAL_UINT32(lost, averaging.counters.lost);
}

static inline void assert_position_is_empty(uint8_t index)
{
    double mean[TUMBLE_CHANNELS];
    ASSERT_STATUS(TUMBLE_E_MISSING_POSITION, tumble_averaging_mean(&averaging, index, mean, NULL));
}

static inline void assert_mean(uint8_t index, double x, double y, double z)
{
    double mean[TUMBLE_CHANNELS];
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(&averaging, index, mean, NULL));
    ASSERT_SAME_DOUBLE(x, mean[0]);
    ASSERT_SAME_DOUBLE(y, mean[1]);
    ASSERT_SAME_DOUBLE(z, mean[2]);
}

#endif
