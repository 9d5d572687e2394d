/* support.h - what all unit tests share: random numbers that are the same everywhere, and exact comparison of doubles.
 *
 * The tests run on the host and on the target, so they use no files, no heap, and nothing of libm.
 */
#ifndef TUMBLE_TESTS_UNIT_SUPPORT_H
#define TUMBLE_TESTS_UNIT_SUPPORT_H

#include "suite.h"
#include "tumble/status.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#if !defined(UNITY_SUPPORT_64) || defined(UNITY_EXCLUDE_DOUBLE)
#error "build Unity and the tests with UNITY_SUPPORT_64 and UNITY_INCLUDE_DOUBLE"
#endif

/* As doubles: those of <math.h> are floats. */
#define NOT_A_NUMBER ((double)NAN)
#define INFINITE ((double)INFINITY)

/* The row of a table that an assertion below is of: a failure tells it. */
#define ROW(what) (Unity.CurrentDetail1 = (what))

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* A status, by its name. */
static inline void assert_status(tumble_status_t expected, tumble_status_t status)
{
    TEST_ASSERT_EQUAL_STRING(tumble_status_name(expected), tumble_status_name(status));
}

/* Splitmix64: a fixed seed replays the same cases on every machine. */
typedef struct {
    uint64_t state;
} dice_t;

static inline uint64_t dice_u64(dice_t *dice)
{
    dice->state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t z = dice->state;
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

static inline uint32_t dice_below(dice_t *dice, uint32_t limit)
{
    return (uint32_t)(((dice_u64(dice) >> 32) * limit) >> 32);
}

static inline int32_t dice_between(dice_t *dice, int32_t low, int32_t high)
{
    return (int32_t)(low + (int64_t)dice_below(dice, (uint32_t)((int64_t)high - low) + 1U));
}

/* Uniform in [-1, 1). */
static inline double dice_signed_unit(dice_t *dice)
{
    return (double)(int64_t)(dice_u64(dice) >> 11) * 0x1p-52 - 1.0;
}

static inline double magnitude(double x)
{
    return (x < 0.0) ? -x : x;
}

/* The next double away from zero; `x` finite and not 0. */
static inline double one_ulp_beyond(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits += 1U;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline double one_ulp_within(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits -= 1U;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Equal to the last bit; only the two zeros are the same number (adding 0.0 turns -0.0 into 0.0). */
static inline void assert_same_double(double expected, double actual, int line)
{
    uint64_t expected_bits;
    uint64_t actual_bits;
    expected += 0.0;
    actual += 0.0;
    memcpy(&expected_bits, &expected, sizeof expected_bits);
    memcpy(&actual_bits, &actual, sizeof actual_bits);
    UNITY_TEST_ASSERT_EQUAL_HEX64(expected_bits, actual_bits, (UNITY_LINE_TYPE)line, "not the same double");
}

#define ASSERT_SAME_DOUBLE(expected, actual) assert_same_double((expected), (actual), __LINE__)

#define ASSERT_STATUS(expected, actual) TEST_ASSERT_EQUAL_INT((int)(expected), (int)(actual))

#endif
