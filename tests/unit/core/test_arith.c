/* The conversion to float that the firmware makes by itself, against the one of the machine. */
#include "core/arith.h"
#include "suite.h"

#include <float.h>

static uint32_t float_bits(float x)
{
    uint32_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double from_bits(uint64_t bits)
{
    double x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

static void assert_as_cast(double x)
{
    TEST_ASSERT_EQUAL_HEX32(float_bits((float)x), float_bits(tumble_to_float(x)));
    TEST_ASSERT_EQUAL_HEX32(float_bits((float)-x), float_bits(tumble_to_float(-x)));
}

static void test_it_rounds_as_a_cast_does(void)
{
    uint64_t random = 1;
    for (int i = 0; i < 1000000; i++) {
        random = (random * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
        const uint64_t exponent = 897U + ((random >> 33) % 253U);
        assert_as_cast(from_bits((exponent << 52) | (random >> 12)));
    }
    assert_as_cast(0.0);
    assert_as_cast((double)FLT_MIN);
    assert_as_cast((double)FLT_MAX);
}

/* Halfway between two floats, and next to it on both sides; the fraction may carry into the exponent. */
static void test_halves_go_to_the_even_neighbour(void)
{
    const uint64_t half = UINT64_C(1) << 28;
    for (uint64_t fraction = 0x7FFFF0U; fraction <= 0x7FFFFFU; fraction++) {
        for (uint64_t exponent = 897; exponent < 1150U; exponent++) {
            const uint64_t bits = (exponent << 52) | (fraction << 29) | half;
            assert_as_cast(from_bits(bits - 1U));
            assert_as_cast(from_bits(bits));
            assert_as_cast(from_bits(bits + 1U));
        }
    }
}

static void test_what_no_normal_float_holds_is_infinite_or_0(void)
{
    TEST_ASSERT_EQUAL_HEX32(0x7F800000U, float_bits(tumble_to_float(1e300)));
    TEST_ASSERT_EQUAL_HEX32(0xFF800000U, float_bits(tumble_to_float(-1e39)));
    TEST_ASSERT_EQUAL_HEX32(0x7F800000U, float_bits(tumble_to_float(from_bits((UINT64_C(1151) << 52) - 1U))));
    TEST_ASSERT_EQUAL_HEX32(0, float_bits(tumble_to_float(1e-39)));
    TEST_ASSERT_EQUAL_HEX32(0x80000000U, float_bits(tumble_to_float(-1e-300)));
}

static void assert_as_divided(double x, double n)
{
    const double quotient = x / n;
    const double found = tumble_divide(x, n);
    TEST_ASSERT_EQUAL_HEX64_ARRAY(&quotient, &found, 1);
}

static uint64_t next_random(uint64_t random)
{
    return (random * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
}

static void test_it_divides_sums_as_the_machine_does(void)
{
    uint64_t random = 2;
    for (int i = 0; i < 100000; i++) {
        random = next_random(random);
        const double n = (double)(((random >> 44) >> (random % 20U)) + 1U);
        random = next_random(random);
        const double sum = (double)((random >> 11) >> (random % 52U));
        assert_as_divided(sum, n);
        assert_as_divided(-sum, n);
    }
}

/* A quotient of 54 digits that ends with 1 lies halfway between two doubles; the nearest double to its product with n
 * has a quotient next to it. */
static void test_it_divides_where_the_quotient_is_nearly_halfway(void)
{
    uint64_t random = 3;
    for (int i = 0; i < 100000; i++) {
        random = next_random(random);
        const uint64_t halfway = (random >> 10) | (UINT64_C(1) << 53) | 1U;
        const uint64_t n = 1U + (random % 1023U);
        assert_as_divided((double)(halfway * n), (double)n);
    }
}

static void test_it_divides_0_and_what_is_tiny_or_huge(void)
{
    const double all[] = {0.0, 1e-300, 1e-16, 1e300, DBL_MAX};
    for (size_t i = 0; i < (sizeof all / sizeof all[0]); i++) {
        for (uint32_t n = 1; n <= 1048576U; n = (n * 3U) + 1U) {
            assert_as_divided(all[i], (double)n);
            assert_as_divided(-all[i], (double)n);
        }
        assert_as_divided(all[i], 1048576.0);
    }
}

static void test_it_leaves_what_is_too_small(void)
{
    const double smallest = from_bits(1);
    const double found = tumble_divide(smallest, 3.0);
    TEST_ASSERT_EQUAL_HEX64_ARRAY(&smallest, &found, 1);
}
