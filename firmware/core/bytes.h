/* bytes.h - little-endian packing, as CAN frames and object values travel.
 *
 * No alignment, no aliasing, and any byte order of the machine: one that is little-endian copies, which is an instruction
 * or two where bytes and shifts are a function; any other goes byte by byte. `at` must hold the bytes named by the
 * function. Signed values travel as two's complement, REAL32 and REAL64 as IEEE 754.
 */
#ifndef TUMBLE_CORE_BYTES_H
#define TUMBLE_CORE_BYTES_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static_assert((sizeof(float) == 4U) && (sizeof(double) == 8U), "REAL32 and REAL64 are IEEE 754 single and double");

#if defined(__BYTE_ORDER__) && (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)

static inline void tumble_put_u16(uint8_t *at, uint16_t value)
{
    (void)memcpy(at, &value, sizeof value);
}

static inline void tumble_put_u32(uint8_t *at, uint32_t value)
{
    (void)memcpy(at, &value, sizeof value);
}

static inline void tumble_put_u64(uint8_t *at, uint64_t value)
{
    (void)memcpy(at, &value, sizeof value);
}

static inline uint16_t tumble_get_u16(const uint8_t *at)
{
    uint16_t value;

    (void)memcpy(&value, at, sizeof value);
    return value;
}

static inline uint32_t tumble_get_u32(const uint8_t *at)
{
    uint32_t value;

    (void)memcpy(&value, at, sizeof value);
    return value;
}

static inline uint64_t tumble_get_u64(const uint8_t *at)
{
    uint64_t value;

    (void)memcpy(&value, at, sizeof value);
    return value;
}

/* Between the machine's own form of `count` numbers of `width` bytes each and this one, either way. */
static inline void tumble_copy_numbers(uint8_t *to, const uint8_t *from, uint32_t width, uint32_t count)
{
    (void)memcpy(to, from, (size_t)width * count);
}

#else

static inline void tumble_put_u16(uint8_t *at, uint16_t value)
{
    at[0] = (uint8_t)(value & 0xFFU);
    at[1] = (uint8_t)(value >> 8);
}

static inline void tumble_put_u32(uint8_t *at, uint32_t value)
{
    tumble_put_u16(at, (uint16_t)(value & 0xFFFFU));
    tumble_put_u16(at + 2, (uint16_t)(value >> 16));
}

static inline void tumble_put_u64(uint8_t *at, uint64_t value)
{
    tumble_put_u32(at, (uint32_t)(value & 0xFFFFFFFFU));
    tumble_put_u32(at + 4, (uint32_t)(value >> 32));
}

static inline uint16_t tumble_get_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | ((uint32_t)at[1] << 8));
}

static inline uint32_t tumble_get_u32(const uint8_t *at)
{
    return tumble_get_u16(at) | ((uint32_t)tumble_get_u16(at + 2) << 16);
}

static inline uint64_t tumble_get_u64(const uint8_t *at)
{
    return tumble_get_u32(at) | ((uint64_t)tumble_get_u32(at + 4) << 32);
}

static inline void tumble_copy_numbers(uint8_t *to, const uint8_t *from, uint32_t width, uint32_t count)
{
    const uint16_t one = 1;
    const bool same = *(const uint8_t *)&one == 1U; /* where the compiler does not tell the order */

    for (uint32_t i = 0; i < (width * count); i++) {
        const uint32_t within = i % width;
        to[i] = same ? from[i] : from[(i - within) + (width - 1U - within)];
    }
}

#endif

static inline void tumble_put_i32(uint8_t *at, int32_t value)
{
    tumble_put_u32(at, (uint32_t)value);
}

/* Two's complement without relying on how the machine converts an unsigned value that does not fit. */
static inline int32_t tumble_get_i32(const uint8_t *at)
{
    uint32_t bits = tumble_get_u32(at);

    return (bits <= 0x7FFFFFFFU) ? (int32_t)bits : (int32_t)(-1 - (int32_t)(0xFFFFFFFFU - bits));
}

static inline int16_t tumble_get_i16(const uint8_t *at)
{
    int32_t bits = (int32_t)tumble_get_u16(at);

    return (int16_t)((bits < 0x8000) ? bits : (bits - 0x10000));
}

static inline int8_t tumble_get_i8(const uint8_t *at)
{
    int32_t bits = (int32_t)at[0];

    return (int8_t)((bits < 0x80) ? bits : (bits - 0x100));
}

static inline void tumble_put_f64(uint8_t *at, double value)
{
    uint64_t bits;

    (void)memcpy(&bits, &value, sizeof bits);
    tumble_put_u64(at, bits);
}

static inline double tumble_get_f64(const uint8_t *at)
{
    uint64_t bits = tumble_get_u64(at);
    double value;

    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void tumble_put_f32(uint8_t *at, float value)
{
    uint32_t bits;

    (void)memcpy(&bits, &value, sizeof bits);
    tumble_put_u32(at, bits);
}

static inline float tumble_get_f32(const uint8_t *at)
{
    uint32_t bits = tumble_get_u32(at);
    float value;

    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
