#include "core/arith.h"

#define INFINITE_BITS (UINT64_C(0x7FF) << 52)

/* Doubles without a sign order as their bits do, and what is not a number lies above infinity. So these tests compare
 * integers: without floating point hardware that is a tenth of the work. */
static uint64_t bits_of(double x)
{
    uint64_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
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
