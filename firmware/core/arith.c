#include "core/arith.h"

#include "tumble/core.h"

#define FRACTION_BITS 52U
#define EXPONENT_OF_ONE 1023U
#define IMPLIED_ONE (UINT64_C(1) << FRACTION_BITS)
#define INFINITE_BITS (UINT64_C(0x7FF) << FRACTION_BITS)

/* 2^128 and 2^-126 as doubles, infinity as a float; how far the exponents of float and double are apart, 1023 - 127, at the
 * place of a float's, of which 32 bits are left. */
#define BEYOND_FLOAT_BITS (UINT64_C(1151) << 52)
#define SMALLEST_FLOAT_BITS (UINT64_C(897) << 52)
#define INFINITE_FLOAT_BITS 0x7F800000U
#define EXPONENT_DIFFERENCE 0xC0000000U

/* Float and double differ in the number of bits of the fraction, 29, and in what an exponent counts from. A fraction that is
 * rounded up beyond its bits carries into the exponent, as it should. */
float tumble_to_float(double x)
{
    const uint64_t size = tumble_bits(tumble_abs(x));
    const uint32_t sign = (uint32_t)(tumble_bits(x) >> 32) & 0x80000000U;
    const uint32_t even = (uint32_t)(size >> 29) & 1U;
    const uint32_t rounded = (uint32_t)((size + 0x0FFFFFFFU + even) >> 29);
    uint32_t bits = 0;
    if (size >= BEYOND_FLOAT_BITS) {
        bits = INFINITE_FLOAT_BITS;
    } else if (size >= SMALLEST_FLOAT_BITS) {
        bits = rounded - EXPONENT_DIFFERENCE;
    } else {
        /* nothing that a normal float could tell */
    }
    bits |= sign;
    float narrow;
    (void)memcpy(&narrow, &bits, sizeof narrow);
    return narrow;
}

bool tumble_is_finite(double x)
{
    return tumble_bits(tumble_abs(x)) < INFINITE_BITS;
}

bool tumble_is_positive(double x)
{
    return (tumble_bits(x) - 1U) < (INFINITE_BITS - 1U);
}

bool tumble_within(double x, double bound)
{
    return tumble_bits(tumble_abs(x)) <= tumble_bits(bound);
}

/* A difference is 0 between equal numbers alone, and may be infinite. */
bool tumble_exceeds(double a, double b)
{
    return (tumble_bits(a - b) - 1U) < INFINITE_BITS;
}

double tumble_larger(double a, double b)
{
    return (tumble_bits(a) > tumble_bits(b)) ? a : b;
}

uint64_t tumble_whole(double x)
{
    const uint64_t bits = tumble_bits(x);
    const uint64_t digits = (bits & (IMPLIED_ONE - 1U)) | IMPLIED_ONE;
    const uint32_t behind_point = (EXPONENT_OF_ONE + FRACTION_BITS) - (uint32_t)(bits >> FRACTION_BITS);
    return (behind_point <= FRACTION_BITS) ? (digits >> behind_point) : 0U;
}

int64_t tumble_nearest(double x)
{
    const int64_t size = (int64_t)tumble_whole(tumble_abs(x) + 0.5);
    return tumble_is_positive(-x) ? -size : size;
}

#define UPPER_ONE 0x100000U /* of the upper word of a double: the digit that is implied */
#define UPPER_OF_HALF 0x3FE00000U
#define DIGIT_BITS 11U
#define QUOTIENT_DIGITS 5U
#define LEAST_EXPONENT (1U + 21U)
static_assert(TUMBLE_MAX_SAMPLES < INT64_C(0x200000), "a remainder and a digit must fit 32 bits");

static uint32_t upper_digits(uint32_t upper)
{
    return (upper & (UPPER_ONE - 1U)) | UPPER_ONE;
}

/* Long division in base 2^11: a remainder below 2^21 and the next digit fit 32 bits. It leaves 55 or 56 bits, of which 53
 * stay. Nothing lies halfway between two doubles: a quotient of 54 bits, the last one 1, times `n` would have more bits
 * than x has. So half of the last place is added, the rest is cut off, and neither remainder nor evenness is asked for. */
double tumble_divide(double x, double n)
{
    const uint64_t bits = tumble_bits(x);
    const uint32_t upper = (uint32_t)(bits >> 32);
    const uint32_t upper_of_n = (uint32_t)(tumble_bits(n) >> 32);
    if (((upper >> 20) & 0x7FFU) < LEAST_EXPONENT) {
        return x; /* 0, or so small that the quotient might have fewer digits */
    }
    const uint32_t divisor = upper_digits(upper_of_n);
    uint32_t rest = upper_digits(upper);
    uint32_t head = ((upper - rest) - (upper_of_n - divisor)) + UPPER_OF_HALF;
    uint32_t below = (uint32_t)bits;
    uint64_t found = 0;
    for (uint32_t digits = QUOTIENT_DIGITS; digits > 0U; digits--) {
        const uint32_t dividend = (rest << DIGIT_BITS) | (below >> (32U - DIGIT_BITS));
        const uint32_t quotient = dividend / divisor;
        rest = dividend - (quotient * divisor);
        below <<= DIGIT_BITS;
        found = (found << DIGIT_BITS) | quotient;
    }
    if ((found >> 55) == 0U) {
        found <<= 1;
        head -= UPPER_ONE;
    }
    found = ((found + 4U) >> 3) + ((uint64_t)head << 32);
    return tumble_from_bits(found);
}
