/* Bit timing, against a search of everything that the registers can hold. */
#include "bit_timing.h"
#include "suite.h"

#include <stdbool.h>

static const uint32_t CLOCKS[] = {24000000, 99990005, 100000000, 80000000, 40000000, 33333333, 25000000, 16000000};
static const uint32_t RATES[] = {10000, 20000, 50000, 125000, 250000, 500000, 800000, 1000000};

static uint32_t quanta_of(const zcu102_bit_timing_t *timing)
{
    return 1U + timing->segment1 + timing->segment2;
}

static double error_of(uint32_t clock_hz, uint32_t rate, uint32_t prescaler, uint32_t quanta)
{
    const double got = (double)clock_hz / ((double)prescaler * quanta);
    const double off = got / rate - 1.0;
    return (off < 0.0) ? -off : off;
}

/* The smallest error of any division. */
static double best_error(uint32_t clock_hz, uint32_t rate)
{
    double best = 1e9;
    for (uint32_t prescaler = 1; prescaler <= 256U; prescaler++) {
        for (uint32_t quanta = 8; quanta <= 25U; quanta++) {
            const double error = error_of(clock_hz, rate, prescaler, quanta);
            best = (error < best) ? error : best;
        }
    }
    return best;
}

static void check(uint32_t clock_hz, uint32_t rate)
{
    zcu102_bit_timing_t timing = {0};
    const double best = best_error(clock_hz, rate);
    const tumble_status_t status = zcu102_bit_timing(clock_hz, rate, &timing);
    if (best > 1.01e-3) {
        TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, status);
        TEST_ASSERT_EQUAL_UINT32(0, timing.prescaler);
        return;
    }
    TEST_ASSERT_EQUAL(TUMBLE_OK, status);
    TEST_ASSERT_TRUE(timing.prescaler >= 1U && timing.prescaler <= 256U);
    TEST_ASSERT_TRUE(timing.segment1 >= 1U && timing.segment1 <= 16U);
    TEST_ASSERT_TRUE(timing.segment2 >= 1U && timing.segment2 <= 8U);
    TEST_ASSERT_TRUE(timing.jump >= 1U && timing.jump <= 4U && timing.jump <= timing.segment2);
    const double error = error_of(clock_hz, rate, timing.prescaler, quanta_of(&timing));
    TEST_ASSERT_TRUE(error <= best + 2.2e-6); /* judged in whole millionths, of the clock */
    const double sample_point = (1.0 + timing.segment1) / quanta_of(&timing);
    TEST_ASSERT_TRUE(sample_point >= 0.68 && sample_point <= 0.90);
}

static void test_no_division_is_nearer_the_rate(void)
{
    for (unsigned c = 0; c < sizeof CLOCKS / sizeof CLOCKS[0]; c++) {
        for (unsigned r = 0; r < sizeof RATES / sizeof RATES[0]; r++) {
            check(CLOCKS[c], RATES[r]);
        }
    }
}

/* By hand: 24 MHz / 500 kbit/s = 48 = 3 x 16 = 2 x 24; 7/8 of both is whole. */
static void test_the_usual_ones(void)
{
    zcu102_bit_timing_t timing;
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_bit_timing(24000000, 500000, &timing));
    TEST_ASSERT_EQUAL_UINT32(3, timing.prescaler);
    TEST_ASSERT_EQUAL_UINT32(13, timing.segment1);
    TEST_ASSERT_EQUAL_UINT32(2, timing.segment2);
    TEST_ASSERT_EQUAL_UINT32(2, timing.jump);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_bit_timing(100000000, 500000, &timing)); /* 200 = 20 x 10 = 25 x 8 */
    TEST_ASSERT_EQUAL_UINT32(25, timing.prescaler);
    TEST_ASSERT_EQUAL_UINT32(6, timing.segment1);
    TEST_ASSERT_EQUAL_UINT32(1, timing.segment2);
}

static void test_what_cannot_be_reached_is_refused(void)
{
    zcu102_bit_timing_t timing = {0};
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_bit_timing(0, 500000, &timing));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_bit_timing(24000000, 0, &timing));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_bit_timing(24000000, 1000001, &timing));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_bit_timing(7000000, 1000000, &timing)); /* 7 quanta */
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_bit_timing(24100000, 500000, &timing)); /* 0.4 % off */
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_bit_timing(100000000, 10000, &timing)); /* 10000 > 256 x 25 */
    TEST_ASSERT_EQUAL_UINT32(0, timing.prescaler);
}
