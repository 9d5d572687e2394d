#include "core/fixed.h"

#include "core/arith.h"

#define FRACTION_BITS 52U
#define EXPONENT_OF_ONE 1023U
#define IMPLIED_ONE (UINT64_C(1) << FRACTION_BITS)
#define LEAST_SCALE 64U /* its unit is a double, and no digit of a number without an implied one is left */
#define MOST_BITS 54U

static uint32_t exponent_of(uint64_t bits)
{
    return (uint32_t)(bits >> FRACTION_BITS) & 0x7FFU;
}

uint32_t tumble_fixed_scale(uint64_t bits)
{
    const uint32_t exponent = exponent_of(bits);
    return (exponent > LEAST_SCALE) ? exponent : LEAST_SCALE;
}

double tumble_fixed_unit(uint32_t scale)
{
    return tumble_from_bits((uint64_t)(scale - (TUMBLE_FIXED_WHOLE - EXPONENT_OF_ONE)) << FRACTION_BITS);
}

/* Two bits more than the fraction has: one for the unit, one to round by. */
int64_t tumble_fixed_of(double x, uint32_t scale)
{
    const uint64_t bits = tumble_bits(x);
    const uint64_t digits = ((bits & (IMPLIED_ONE - 1U)) | IMPLIED_ONE) << 2;
    const uint32_t below = scale - exponent_of(bits);
    const int64_t size = (below <= MOST_BITS) ? (int64_t)(((digits >> below) + 1U) >> 1) : 0;
    return ((bits >> 63) != 0U) ? -size : size;
}

static uint64_t size_of(int64_t a)
{
    return (uint64_t)((a < 0) ? -a : a);
}

/* By halves of 32 bits. Of what the lower halves give only the upper half reaches the last place, and is rounded. */
int64_t tumble_fixed_product(int64_t a, int64_t b)
{
    const uint64_t size_a = size_of(a);
    const uint64_t size_b = size_of(b);
    const uint64_t low_a = (uint32_t)size_a;
    const uint64_t low_b = (uint32_t)size_b;
    const uint64_t high_a = size_a >> 32;
    const uint64_t high_b = size_b >> 32;
    const uint64_t middle = (high_a * low_b) + (low_a * high_b) + ((low_a * low_b) >> 32) + (UINT64_C(1) << 20);
    const int64_t size = (int64_t)(((high_a * high_b) << 11) + (middle >> 21));
    return ((a < 0) != (b < 0)) ? -size : size;
}

/* Most factors are those of a block that is turned by right angles. */
int64_t tumble_fixed_times(int64_t a, double factor)
{
    const uint64_t bits = tumble_bits(factor);
    const uint64_t size = bits & (UINT64_MAX >> 1);
    if (size == 0U) {
        return 0;
    }
    if (size == ((uint64_t)EXPONENT_OF_ONE << FRACTION_BITS)) {
        return (bits == size) ? a : -a;
    }
    return tumble_fixed_product(a, tumble_fixed_of(factor, EXPONENT_OF_ONE));
}
