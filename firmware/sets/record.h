/* record.h - how all records are written and read (private to the room, and to those who keep a record in its memory).
 *
 * A record begins with its head: a magic, and in most a schema and a length. Then come the fields of a struct as
 * little-endian bytes, one after the other, by a table of const rows; then zeros; at the end a CRC-32 of all before.
 * Signed values travel as two's complement, floating point as IEEE 754.
 */
#ifndef TUMBLE_SETS_RECORD_H
#define TUMBLE_SETS_RECORD_H

#include "tumble/sets.h"

/* `count` elements of `width` bytes each, from `offset` of the struct on. */
typedef struct {
    uint16_t offset; /* TUMBLE_FIELD_NONE: bytes that are zero */
    uint8_t width;
    uint8_t count;
} tumble_field_t;

#define TUMBLE_FIELD_NONE 0xFFFFU

typedef struct {
    const uint8_t *head;
    const tumble_field_t *fields; /* from behind the head on */
    uint16_t crc_at;
    uint8_t head_bytes;
    uint8_t field_count;
} tumble_record_t;

/* All of a record but its CRC. */
void tumble_record_fill(const tumble_record_t *record, const void *object, uint8_t *bytes);

/* Its fields. */
void tumble_record_read(const tumble_record_t *record, const uint8_t *bytes, void *object);

/* Do the bytes hold this kind of record? Returns TUMBLE_OK, TUMBLE_E_FRAME (another head), TUMBLE_E_CRC. The CRC goes
 * on from `crc_before`. */
tumble_status_t tumble_record_check(const tumble_record_t *record, const uint8_t *bytes, uint32_t crc_before);

/* The CRC-32 over `size` bytes, going on from `crc_before`, stands behind them. */
void tumble_record_seal(uint8_t *bytes, uint32_t size, uint32_t crc_before);
bool tumble_record_is_sealed(const uint8_t *bytes, uint32_t size, uint32_t crc_before);

/* For the store. As tumble_set_encode, with another stamp; and as tumble_set_decode, where a null set is not written: the
 * record is only checked. The latter also without head and CRC. */
tumble_status_t tumble_set_encode_as(const tumble_set_t *set, const tumble_set_stamp_t *stamp,
                                     uint8_t bytes[TUMBLE_SET_BYTES]);
tumble_status_t tumble_set_read(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set);
tumble_status_t tumble_set_read_fields(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set);

/* Places in its bytes, for both versions (docs/embedding.md). */
#define TUMBLE_SET_AT_FIELDS 8U
#define TUMBLE_SET_AT_FLAGS 14U
#define TUMBLE_SET_AT_K 64U
#define TUMBLE_SET_AT_U 160U
#define TUMBLE_SET_AT_RANGE 294U
#define TUMBLE_SET_AT_CRC 316U

/* The mark behind a record that is complete. */
void tumble_store_mark(uint8_t bytes[TUMBLE_SET_PLACE_BYTES]);

/* For sets over temperature: as tumble_set_read, both versions; and the polynomials of a record that it has read into
 * `set`. */
tumble_status_t tumble_thermal_read_set(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set);
void tumble_thermal_from_record(const uint8_t bytes[TUMBLE_SET_BYTES], const tumble_set_t *set,
                                tumble_thermal_t *thermal);

/* The job that has just begun writes this set instead. */
tumble_status_t tumble_thermal_put(tumble_store_t *store, const tumble_set_t *set, const tumble_thermal_t *thermal);

/* Put another stamp on the record of a set, and take it off. */
void tumble_set_stamp(uint8_t bytes[TUMBLE_SET_BYTES], const tumble_set_stamp_t *stamp);
void tumble_set_get_stamp(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_stamp_t *stamp);

/* Set further flags in it; then it needs its stamp. */
void tumble_set_add_flags(uint8_t bytes[TUMBLE_SET_BYTES], uint16_t flags);

/* Is the number at this offset of the struct known? */
bool tumble_set_knows(const tumble_set_t *set, uint16_t offset);

/* The CRC-32 at its end. */
uint32_t tumble_set_crc(const uint8_t bytes[TUMBLE_SET_BYTES]);

/* Give an encoded entry of the history another number. */
void tumble_history_number(uint8_t bytes[TUMBLE_HISTORY_BYTES], uint32_t number);

#endif
