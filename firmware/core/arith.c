#include "core/arith.h"

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

/* Doubles without a sign order as their bits do, and what is not a number lies above infinity. So these tests compare
 * integers: without floating point hardware that is a tenth of the work. */
static uint64_t bits_of(double x)
{
    uint64_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Float and double differ in the number of bits of the fraction, 29, and in what an exponent counts from. A fraction that is
 * rounded up beyond its bits carries into the exponent, as it should. */
float tumble_to_float(double x)
{
    const uint64_t size = bits_of(tumble_abs(x));
    const uint32_t sign = (uint32_t)(bits_of(x) >> 32) & 0x80000000U;
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
    return bits_of(tumble_abs(x)) < INFINITE_BITS;
}

bool tumble_is_positive(double x)
{
    return (bits_of(x) - 1U) < (INFINITE_BITS - 1U);
}

bool tumble_within(double x, double bound)
{
    return bits_of(tumble_abs(x)) <= bits_of(bound);
}

/* A difference is 0 between equal numbers alone, and may be infinite. */
bool tumble_exceeds(double a, double b)
{
    return (bits_of(a - b) - 1U) < INFINITE_BITS;
}

double tumble_larger(double a, double b)
{
    return (bits_of(a) > bits_of(b)) ? a : b;
}

uint64_t tumble_whole(double x)
{
    const uint64_t bits = bits_of(x);
    const uint64_t digits = (bits & (IMPLIED_ONE - 1U)) | IMPLIED_ONE;
    const uint32_t behind_point = (EXPONENT_OF_ONE + FRACTION_BITS) - (uint32_t)(bits >> FRACTION_BITS);
    return (behind_point <= FRACTION_BITS) ? (digits >> behind_point) : 0U;
}

int64_t tumble_nearest(double x)
{
    const int64_t size = (int64_t)tumble_whole(tumble_abs(x) + 0.5);
    return tumble_is_positive(-x) ? -size : size;
}
