#include "sets/record.h"

#include "core/crc32.h"

/* Where the machine keeps byte `i`, counted from the lowest, of a number of `width` bytes. */
static uint32_t place_of(uint32_t i, uint32_t width)
{
#if defined(__BYTE_ORDER__) && (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)
    return width - 1U - i;
#else
    (void)width;
    return i;
#endif
}

void tumble_record_encode(const tumble_field_t *fields, uint32_t field_count, const uint8_t *object, uint8_t *bytes)
{
    uint32_t at = 0;
    for (uint32_t f = 0; f < field_count; f++) {
        const uint32_t width = fields[f].width;
        for (uint32_t i = 0; i < (width * fields[f].count); i++) {
            bytes[at] = object[fields[f].offset + i - (i % width) + place_of(i % width, width)];
            at++;
        }
    }
}

void tumble_record_decode(const tumble_field_t *fields, uint32_t field_count, const uint8_t *bytes, uint8_t *object)
{
    uint32_t at = 0;
    for (uint32_t f = 0; f < field_count; f++) {
        const uint32_t width = fields[f].width;
        for (uint32_t i = 0; i < (width * fields[f].count); i++) {
            object[fields[f].offset + i - (i % width) + place_of(i % width, width)] = bytes[at];
            at++;
        }
    }
}

void tumble_record_put_u32(uint8_t *bytes, uint32_t value)
{
    for (uint32_t i = 0; i < 4U; i++) {
        bytes[i] = (uint8_t)((value >> (8U * i)) & 0xFFU);
    }
}

uint32_t tumble_record_get_u32(const uint8_t *bytes)
{
    uint32_t value = 0;
    for (uint32_t i = 0; i < 4U; i++) {
        value |= (uint32_t)bytes[i] << (8U * i);
    }
    return value;
}

void tumble_record_seal(uint8_t *bytes, uint32_t size, uint32_t crc_before)
{
    tumble_record_put_u32(&bytes[size], tumble_crc32(crc_before, bytes, size));
}

bool tumble_record_is_sealed(const uint8_t *bytes, uint32_t size, uint32_t crc_before)
{
    return tumble_record_get_u32(&bytes[size]) == tumble_crc32(crc_before, bytes, size);
}
