/* arith.h - the only arithmetic of the core beyond + - x /: square root, magnitude, a test for finite numbers.
 *
 * All three give the same bits on every target with IEEE 754 doubles; no other function of <math.h> may be used in
 * firmware/core, because libraries differ in their last bit.
 */
#ifndef TUMBLE_CORE_ARITH_H
#define TUMBLE_CORE_ARITH_H

#include <math.h>
#include <stdbool.h>

static inline double tumble_sqrt(double x)
{
    return sqrt(x);
}

static inline double tumble_abs(double x)
{
    return (x < 0.0) ? -x : x;
}

static inline bool tumble_is_finite(double x)
{
    return (x - x) == 0.0;
}

/* |x| <= bound, and false for a NaN: the comparison that validation wants. */
static inline bool tumble_within(double x, double bound)
{
    return (x <= bound) && (x >= -bound);
}

#endif
