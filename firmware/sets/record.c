#include "sets/record.h"

#include "core/bytes.h"
#include "core/crc32.h"

#include <string.h>

void tumble_record_fill(const tumble_record_t *record, const void *object, uint8_t *bytes)
{
    const uint8_t *from = object;
    uint32_t at = record->head_bytes;
    (void)memset(bytes, 0, record->crc_at);
    (void)memcpy(bytes, record->head, record->head_bytes);
    for (uint32_t f = 0; f < record->field_count; f++) {
        const tumble_field_t *field = &record->fields[f];
        if (field->offset != TUMBLE_FIELD_NONE) {
            tumble_copy_numbers(&bytes[at], &from[field->offset], field->width, field->count);
        }
        at += (uint32_t)field->width * field->count;
    }
}

void tumble_record_read(const tumble_record_t *record, const uint8_t *bytes, void *object)
{
    uint8_t *to = object;
    uint32_t at = record->head_bytes;
    for (uint32_t f = 0; f < record->field_count; f++) {
        const tumble_field_t *field = &record->fields[f];
        if (field->offset != TUMBLE_FIELD_NONE) {
            tumble_copy_numbers(&to[field->offset], &bytes[at], field->width, field->count);
        }
        at += (uint32_t)field->width * field->count;
    }
}

tumble_status_t tumble_record_check(const tumble_record_t *record, const uint8_t *bytes, uint32_t crc_before)
{
    if (memcmp(bytes, record->head, record->head_bytes) != 0) {
        return TUMBLE_E_FRAME;
    }
    return tumble_record_is_sealed(bytes, record->crc_at, crc_before) ? TUMBLE_OK : TUMBLE_E_CRC;
}

void tumble_record_seal(uint8_t *bytes, uint32_t size, uint32_t crc_before)
{
    tumble_put_u32(&bytes[size], tumble_crc32(crc_before, bytes, size));
}

bool tumble_record_is_sealed(const uint8_t *bytes, uint32_t size, uint32_t crc_before)
{
    return tumble_get_u32(&bytes[size]) == tumble_crc32(crc_before, bytes, size);
}
