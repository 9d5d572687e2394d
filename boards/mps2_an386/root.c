/* root.c - the square root, correctly rounded as IEEE 754 has it, one bit at a time. newlib's is right as well, but takes
 * three times the code, and sets errno, which takes RAM.
 */
#include <stdint.h>
#include <string.h>

#define FRACTION_BITS 52
#define IMPLIED_ONE (UINT64_C(1) << FRACTION_BITS)
#define FRACTION_MASK (IMPLIED_ONE - 1U)
#define BIAS 1023
#define INFINITE (UINT64_C(0x7FF) << FRACTION_BITS)
#define NOT_A_NUMBER (UINT64_C(0x7FF8) << (FRACTION_BITS - 4))
#define MINUS_ZERO (UINT64_C(1) << 63)

double sqrt(double x);

/* The root of m / 2^52, for m from 2^52 to below 2^54, as a multiple of 2^-52. A 54th bit rounds it; there is no tie,
 * because the square of a number of 54 bits has more bits than m. */
static uint64_t rounded_root(uint64_t m)
{
    uint64_t twice = 0; /* the root so far, as a multiple of 2^-54 */
    uint64_t rest = m << 1;
    for (uint64_t bit = IMPLIED_ONE << 1; bit != 0U; bit >>= 1) {
        const uint64_t trial = twice + bit;
        if (rest >= trial) {
            rest -= trial;
            twice = trial + bit;
        }
        rest <<= 1;
    }
    return ((twice >> 1) + 1U) >> 1;
}

/* Of a positive number: m * 2^exponent / 2^52, the exponent made even. */
static uint64_t root_of_bits(uint64_t bits)
{
    int32_t exponent = (int32_t)(bits >> FRACTION_BITS);
    uint64_t m = bits & FRACTION_MASK;
    if (exponent != 0) {
        m |= IMPLIED_ONE;
    } else {
        exponent = 1; /* subnormal */
    }
    while (m < IMPLIED_ONE) {
        m <<= 1;
        exponent--;
    }
    exponent -= BIAS;
    if ((exponent & 1) != 0) {
        m <<= 1;
        exponent--;
    }
    return ((uint64_t)(uint32_t)((exponent / 2) + BIAS - 1) << FRACTION_BITS) + rounded_root(m);
}

double sqrt(double x)
{
    uint64_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    if (bits > MINUS_ZERO) {
        bits = NOT_A_NUMBER;
    } else if ((bits != 0U) && (bits < INFINITE)) {
        bits = root_of_bits(bits);
    } else {
        /* itself */
    }
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}
