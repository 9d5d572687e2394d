/* limits.h - the compile-time sizes of the core, and the relations between them that must hold. */
#ifndef TUMBLE_CORE_LIMITS_H
#define TUMBLE_CORE_LIMITS_H

#include <assert.h>
#include <stdint.h>

#define TUMBLE_CHANNELS 3
#define TUMBLE_COEFFICIENTS 12 /* K row by row, then U0 */
#define TUMBLE_UNKNOWNS 4      /* of one channel: K_ix, K_iy, K_iz, U0_i */
#define TUMBLE_MAX_POSITIONS 36
#define TUMBLE_MAX_MOUNTINGS 6

/* Averaging. A raw count is any int32; a sample may lie this far from the first one of its position. */
#define TUMBLE_MAX_SAMPLES (INT64_C(1) << 20)
#define TUMBLE_MAX_DEVIATION_COUNTS (INT64_C(1) << 21)

static_assert(TUMBLE_MAX_POSITIONS >= 18, "the default schedule must fit");
static_assert(TUMBLE_MAX_POSITIONS <= UINT8_MAX, "a position index is one byte");

/* The sum of counts must be exact as a double, or the mean would be rounded twice. */
static_assert(TUMBLE_MAX_SAMPLES <= (INT64_C(1) << 53) / (INT64_C(1) << 31), "a sum of int32 counts must stay within 2^53");

/* The sum of squared deviations must fit 64 bits for any allowed number of samples. */
static_assert(TUMBLE_MAX_SAMPLES <= INT64_MAX / (TUMBLE_MAX_DEVIATION_COUNTS * TUMBLE_MAX_DEVIATION_COUNTS),
              "a sum of squared deviations must fit an int64");

#endif
