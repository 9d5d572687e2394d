/* Blocks: exact small cases, the ends of the ranges, refusals. The rule and its statistics are tested from Python. */
#include "support.h"
#include "tumble/core.h"

#include <math.h>

#define FAR ((int32_t)TUMBLE_MAX_DEVIATION_COUNTS)

static const tumble_averaging_config_t config = {
    .saturation_counts = INT32_MAX, .min_samples = 1, .stillness_ratio = 1.0F};
static tumble_averaging_t averaging;
static tumble_blocks_t blocks;
static tumble_stand_record_t stand;
static tumble_noise_t noise;

static void set_up(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_init(&averaging, &config));
    ASSERT_STATUS(TUMBLE_OK, tumble_blocks_init(&blocks, 8));
    stand = (tumble_stand_record_t){.samples = 1};
}

/* A position that counts up by `step` in the first channel, down in the second, and stays in the third. */
static void take(uint8_t position, int32_t from, int32_t step, int samples)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_begin(&averaging, position));
    tumble_blocks_begin(&blocks);
    for (int n = 0; n < samples; n++) {
        const tumble_sample_t sample = {{from + (n * step), -from - (n * step), 5}, (uint16_t)n, 0};
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_add(&averaging, &config, &sample));
        tumble_blocks_add(&blocks, sample.counts);
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_finish(&averaging, &config));
    tumble_blocks_finish(&blocks);
}

static tumble_status_t look(void)
{
    return tumble_blocks_noise(&blocks, &averaging, &stand, 1.0, &noise);
}

/* Of the mean of so many samples, beyond what the stand declares. */
static double excess_v2(int channel, uint32_t samples)
{
    const double declared_v2 = stand.noise_v * stand.noise_v / samples;
    const double least_v2 = stand.least_noise_v * stand.least_noise_v;
    return tumble_noise_excess(&noise, channel, samples, (declared_v2 > least_v2) ? declared_v2 : least_v2);
}

/* On a ramp neighbouring blocks of m samples differ by m^2 steps. */
static void test_sums_of_a_ramp(void)
{
    take(0, INT32_MAX - 200, 3, 8);
    take(7, -INT32_MAX + 200, -3, 13);
    TEST_ASSERT_EQUAL_UINT32(2, blocks.block_samples);
    TEST_ASSERT_EQUAL_UINT32(5, blocks.pairs[0]);
    TEST_ASSERT_EQUAL_UINT32(2, blocks.pairs[1]);
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_INT64(5 * 12 * 12, blocks.square_sum[0][i]);
        TEST_ASSERT_EQUAL_INT64(2 * 48 * 48, blocks.square_sum[1][i]);
    }
    TEST_ASSERT_EQUAL_INT64(0, blocks.square_sum[0][2]);
    TEST_ASSERT_EQUAL_INT64(0, blocks.square_sum[1][2]);
}

/* 32 samples i of 100 i counts, two lengths of 8 and 16. Every sum is exact: the scatter is 100^2 (32^2 - 1) 32 / 12 / 31,
 * the energies (A - B)^2 / 2m are 100^2 m^3 / 2, and the steepest line through them is cut to 1/f noise. */
static void test_a_ramp_is_no_white_noise(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_blocks_init(&blocks, 32));
    take(0, 0, 100, 32);
    ASSERT_STATUS(TUMBLE_OK, look());
    const double energy = 1e4 * 16.0 * 16.0 * 16.0 / 2.0;
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_TRUE((noise.variance_v2[i] == energy) && (noise.line_v2[i] == energy));
        TEST_ASSERT_TRUE(noise.noise_v[i] == sqrt(2.0 * energy)); /* 32 samples: one length more */
        TEST_ASSERT_TRUE(excess_v2(i, 32) == energy * 2.0 / 32.0);
        TEST_ASSERT_TRUE(excess_v2(i, 64) == energy * 4.0 / 64.0);
    }
}

/* The first two channels show the same noise: declared for one of them, it is above in the other alone. */
static void test_each_channel_is_held_against_its_own_noise(void)
{
    take(0, 0, 100, 32);
    stand.channel_noise_v[1] = 1e5;
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_EQUAL_HEX8(1, noise.above);
    TEST_ASSERT_TRUE(noise.declared_v == 1e5);
}

static void test_the_declared_noise_is_left_out(void)
{
    take(0, 0, 100, 32);
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_EQUAL_HEX8(3, noise.above);
    TEST_ASSERT_TRUE(excess_v2(2, 32) == 1.0 / 12.0); /* the third channel stays */
    const double found = excess_v2(0, 32);
    TEST_ASSERT_TRUE((found > 1e4) && (found < 1e7)); /* the variance of a sample is 9e5 */
    TEST_ASSERT_TRUE(excess_v2(1, 32) == found);
    stand.noise_v = 1e-3;
    ASSERT_STATUS(TUMBLE_OK, tumble_blocks_noise(&blocks, &averaging, &stand, -1e-3, &noise));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, found - (1.0 / 32.0), excess_v2(0, 32) * 1e6);
    TEST_ASSERT_TRUE(noise.declared_v == 1e-3);
    stand.noise_v = 1e6;
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_TRUE((noise.above == 0U) && (excess_v2(0, 32) == 0.0));
}

static void test_a_noise_that_no_mean_falls_below_is_declared_too(void)
{
    take(0, 0, 100, 32);
    ASSERT_STATUS(TUMBLE_OK, look());
    const double found = excess_v2(0, 32);
    stand.least_noise_v = 10.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, found - 100.0, excess_v2(0, 32));
    stand.least_noise_v = 1e6;
    TEST_ASSERT_TRUE(excess_v2(0, 32) == 0.0);
}

/* Samples 0 0 0 1 or 0 0 1 1, over and over: a variance of 1/4 of 8 / 7, below a third, and 2 / 7 * 4 = 0.286 as well; of
 * -1 and 1, over it. */
static void test_samples_that_round_alike_keep_the_rounding_of_one_count(void)
{
    const int32_t patterns[3][4] = {{0, 0, 0, 1}, {0, 1, 0, 1}, {-1, 1, -1, 1}};
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_begin(&averaging, 4));
    tumble_blocks_begin(&blocks);
    for (int n = 0; n < 8; n++) {
        const tumble_sample_t sample = {{patterns[0][n % 4], patterns[1][n % 4], patterns[2][n % 4]}, (uint16_t)n, 0};
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_add(&averaging, &config, &sample));
        tumble_blocks_add(&blocks, sample.counts);
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_finish(&averaging, &config));
    tumble_blocks_finish(&blocks);
    stand.noise_v = 0.1;
    ASSERT_STATUS(TUMBLE_OK, tumble_blocks_noise(&blocks, &averaging, &stand, 0.1, &noise));
    TEST_ASSERT_EQUAL_HEX8(3, noise.undithered);
    TEST_ASSERT_EQUAL_HEX8(0, noise.above);
    TEST_ASSERT_DOUBLE_WITHIN(1e-16, 0.01 / 12.0, excess_v2(0, 8));
    TEST_ASSERT_TRUE((excess_v2(0, 1000000) == excess_v2(1, 8)) && (excess_v2(2, 8) == 0.0));
}

/* A blocks that was never begun: the scatter alone. */
static void test_without_blocks_the_scatter_speaks_alone(void)
{
    const tumble_blocks_t none = {.block_samples = 0};
    take(0, 0, 100, 3);
    take(1, 0, 100, 3);
    ASSERT_STATUS(TUMBLE_OK, tumble_blocks_noise(&none, &averaging, &stand, 1.0, &noise));
    TEST_ASSERT_TRUE((noise.variance_v2[0] == 1e4) && (noise.line_v2[0] == 0.0) && (noise.noise_v[0] == 100.0));
    TEST_ASSERT_TRUE(excess_v2(0, 1000) == 10.0);
}

static void test_a_sum_stops_at_its_end(void)
{
    const int32_t high[TUMBLE_CHANNELS] = {FAR, -FAR, 0};
    const int32_t low[TUMBLE_CHANNELS] = {-FAR, FAR, 0};
    ASSERT_STATUS(TUMBLE_OK, tumble_blocks_init(&blocks, (uint32_t)TUMBLE_MAX_SAMPLES));
    tumble_blocks_begin(&blocks);
    for (int n = 0; n < (1 << 15); n++) {
        tumble_blocks_add(&blocks, ((n & 128) == 0) ? high : low);
    }
    TEST_ASSERT_EQUAL_INT64(INT64_MAX, blocks.open_square_sum[1][0]);
    TEST_ASSERT_EQUAL_INT64(INT64_MAX, blocks.open_square_sum[1][1]);
    TEST_ASSERT_EQUAL_INT64(0, blocks.open_square_sum[0][0]);
    tumble_blocks_finish(&blocks);
    take(0, 0, 1, 8);
    ASSERT_STATUS(TUMBLE_E_DEVIATION, look());
}

static void test_refusals(void)
{
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_init(NULL, 8));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_init(&blocks, 7));
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, look());
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_noise(NULL, &averaging, &stand, 1.0, &noise));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_noise(&blocks, NULL, &stand, 1.0, &noise));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_noise(&blocks, &averaging, NULL, 1.0, &noise));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_noise(&blocks, &averaging, &stand, 1.0, NULL));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_noise(&blocks, &averaging, &stand, 0.0, &noise));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_blocks_noise(&blocks, &averaging, &stand, NOT_A_NUMBER, &noise));
    take(0, 0, 1, 1);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, look());
}
