/* Whole numbers of the closed forms, held against products modulo 2^64. */
#include "core/arith.h"
#include "core/fixed.h"
#include "model.h"

static int64_t random_whole(dice_t *dice, uint32_t bits)
{
    const uint64_t size = dice_u64(dice) >> (64U - bits);
    return (dice_below(dice, 2) != 0U) ? (int64_t)size : -(int64_t)size;
}

/* a b - found 2^53 modulo 2^64 is the error, as doubles show that it is no multiple of 2^64 away: half a unit, and what the
 * lower halves leave out, 2^-21 of one. */
static void assert_product(int64_t a, int64_t b, int64_t found)
{
    const int64_t error = (int64_t)(((uint64_t)a * (uint64_t)b) - ((uint64_t)found << 53));
    const int64_t bound = (INT64_C(1) << 52) + (INT64_C(1) << 32);
    TEST_ASSERT_TRUE((error <= bound) && (error >= -bound));
    TEST_ASSERT_TRUE(fabs((double)a * (double)b * 0x1p-53 - (double)found) < 1000.0);
}

static void test_a_product_is_the_nearest(void)
{
    dice_t dice = {31};
    for (int round = 0; round < 100000; round++) {
        const int64_t a = random_whole(&dice, 1U + dice_below(&dice, 59));
        const int64_t b = random_whole(&dice, 1U + dice_below(&dice, 56));
        const int64_t product = tumble_fixed_product(a, b);
        assert_product(a, b, product);
        TEST_ASSERT_EQUAL_INT64(product, tumble_fixed_product(b, a));
        TEST_ASSERT_EQUAL_INT64(-product, tumble_fixed_product(-a, b));
        TEST_ASSERT_EQUAL_INT64(product, tumble_fixed_product(-a, -b));
    }
    const int64_t largest = INT64_C(1) << 59;
    const int64_t factor = (INT64_C(1) << 56) - 1;
    assert_product(largest, factor, tumble_fixed_product(largest, factor));
}

static void test_a_factor_of_one_changes_nothing(void)
{
    dice_t dice = {32};
    for (int round = 0; round < 1000; round++) {
        const int64_t a = random_whole(&dice, 59);
        TEST_ASSERT_EQUAL_INT64(a, tumble_fixed_times(a, 1.0));
        TEST_ASSERT_EQUAL_INT64(-a, tumble_fixed_times(a, -1.0));
        TEST_ASSERT_EQUAL_INT64(0, tumble_fixed_times(a, 0.0));
        TEST_ASSERT_EQUAL_INT64(0, tumble_fixed_times(a, -0.0));
        TEST_ASSERT_EQUAL_INT64(a, tumble_fixed_product(a, INT64_C(1) << 53));
    }
}

static void test_a_factor_is_a_part(void)
{
    dice_t dice = {33};
    for (int round = 0; round < 10000; round++) {
        const int64_t a = random_whole(&dice, 59);
        const double factor = dice_signed_unit(&dice) * ((round % 2 == 0) ? 1.0 : 0x1p-20);
        assert_product(a, tumble_fixed_of(factor, 1023), tumble_fixed_times(a, factor));
    }
}

/* The largest of a channel keeps its bits; what is smaller loses half a unit at most. */
static void test_a_number_is_the_nearest_in_its_unit(void)
{
    dice_t dice = {34};
    for (int round = 0; round < 100000; round++) {
        const double x = dice_signed_unit(&dice) * ldexp(1.0, dice_between(&dice, -300, 300));
        const uint32_t scale = tumble_fixed_scale(tumble_bits(fabs(x)));
        const double unit = tumble_fixed_unit(scale);
        ASSERT_SAME_DOUBLE(x, (double)tumble_fixed_of(x, scale) * unit);
        ASSERT_SAME_DOUBLE(ldexp(1.0, (int)scale - (int)TUMBLE_FIXED_WHOLE), unit);
        const uint32_t coarser = scale + dice_below(&dice, 80);
        const int64_t found = tumble_fixed_of(x, coarser);
        TEST_ASSERT_EQUAL_INT64(-found, tumble_fixed_of(-x, coarser));
        TEST_ASSERT_TRUE(fabs(x / tumble_fixed_unit(coarser) - (double)found) <= 0.5);
        TEST_ASSERT_TRUE((found < (INT64_C(1) << 54)) && (found > -(INT64_C(1) << 54)));
    }
}

static void test_zero_and_what_is_next_to_it(void)
{
    static const double none[] = {0.0, -0.0, 4.9e-324, -2.2e-308, 1e-300};
    const uint32_t scale = tumble_fixed_scale(0);
    TEST_ASSERT_TRUE(tumble_fixed_unit(scale) > 0.0);
    for (size_t n = 0; n < COUNT_OF(none); n++) {
        TEST_ASSERT_EQUAL_UINT32(scale, tumble_fixed_scale(tumble_bits(fabs(none[n]))));
        TEST_ASSERT_TRUE(fabs((double)tumble_fixed_of(none[n], scale) * tumble_fixed_unit(scale) - none[n]) <= 1e-304);
        TEST_ASSERT_EQUAL_INT64(0, tumble_fixed_of(none[n], 1023));
    }
}
