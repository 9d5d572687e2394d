/* record.h - fields of a struct as little-endian bytes, one after the other, by a table of const rows (private to the
 * store). Signed values travel as two's complement, floating point as IEEE 754.
 */
#ifndef TUMBLE_SETS_RECORD_H
#define TUMBLE_SETS_RECORD_H

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

static_assert((sizeof(float) == 4U) && (sizeof(double) == 8U), "floating point travels as IEEE 754 single and double");

/* `count` elements of `width` bytes each, from `offset` of the struct on. */
typedef struct {
    uint16_t offset;
    uint8_t width;
    uint8_t count;
} tumble_field_t;

void tumble_record_encode(const tumble_field_t *fields, uint32_t field_count, const uint8_t *object, uint8_t *bytes);
void tumble_record_decode(const tumble_field_t *fields, uint32_t field_count, const uint8_t *bytes, uint8_t *object);

void tumble_record_put_u32(uint8_t *bytes, uint32_t value);
uint32_t tumble_record_get_u32(const uint8_t *bytes);

/* The CRC-32 over `size` bytes, going on from `crc_before`, stands behind them. */
void tumble_record_seal(uint8_t *bytes, uint32_t size, uint32_t crc_before);
bool tumble_record_is_sealed(const uint8_t *bytes, uint32_t size, uint32_t crc_before);

#endif
