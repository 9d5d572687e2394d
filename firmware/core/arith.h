/* arith.h - the only arithmetic of the core beyond + - x /: square root, square, magnitude, rounding to a float, tests of one
 * number.
 *
 * All give the same bits on every target with IEEE 754 doubles; no other function of <math.h> may be used in
 * firmware/core, because libraries differ in their last bit. The tests are functions because without floating point
 * hardware comparing doubles is a call of the library: a test then costs one call instead of several. A navigation
 * computer compares only by these functions, and casts no double to an integer, so that it links neither the library's
 * comparisons nor its casts.
 */
#ifndef TUMBLE_CORE_ARITH_H
#define TUMBLE_CORE_ARITH_H

#include "core/one_copy.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static inline double tumble_sqrt(double x)
{
    return sqrt(x);
}

static inline double tumble_square(double x)
{
    return x * x;
}

/* Doubles without a sign order as their bits do, and what is not a number lies above infinity. So tests compare integers:
 * without floating point hardware that is a tenth of the work. */
static inline uint64_t tumble_bits(double x)
{
    uint64_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double tumble_from_bits(uint64_t bits)
{
    double x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

/* Clears the sign: of -0 it makes 0. */
static inline double tumble_abs(double x)
{
    return tumble_from_bits(tumble_bits(x) & ~(UINT64_C(1) << 63));
}

static inline uint64_t tumble_earlier(uint64_t a_us, uint64_t b_us)
{
    return (a_us < b_us) ? a_us : b_us;
}

/* The nearest float, of two equally near the even one: as a cast, but with 0 for what is below the smallest normal
 * float. `x` a number. Without floating point hardware a cast costs a member of the library. */
TUMBLE_ONE_COPY float tumble_to_float(double x);

TUMBLE_ONE_COPY bool tumble_is_finite(double x);

/* Above 0, and finite. */
TUMBLE_ONE_COPY bool tumble_is_positive(double x);

/* |x| <= bound, and false for a NaN: the comparison that validation wants. `bound` a number, 0 or above. */
TUMBLE_ONE_COPY bool tumble_within(double x, double bound);

/* a > b, and false where one of them is a NaN. */
TUMBLE_ONE_COPY bool tumble_exceeds(double a, double b);

/* The larger one of two numbers from 0 on. */
double tumble_larger(double a, double b);

/* x / n, the same bits, for a whole number `n` from 1 to TUMBLE_MAX_SAMPLES and a finite x, 0 or above 1e-300 in size (what
 * is smaller comes back as it is). Without floating point hardware a fifth of the library's instructions. */
TUMBLE_ONE_COPY double tumble_divide(double x, double n);

/* What stands before the point of a number from 0 to below 2^53, as a cast; 0 of any other. */
TUMBLE_ONE_COPY uint64_t tumble_whole(double x);

/* The nearest whole number, of two equally near the one farther from 0; |x| below 2^53. */
TUMBLE_ONE_COPY int64_t tumble_nearest(double x);

#endif
