/* set_record.h - what the store does with the bytes of a set (private to the room). No pointer is null. */
#ifndef TUMBLE_SETS_SET_RECORD_H
#define TUMBLE_SETS_SET_RECORD_H

#include "tumble/sets.h"

/* As tumble_set_encode and _decode, with another stamp; without looking into the fields. A null set is
 * TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_set_encode_as(const tumble_set_t *set, const tumble_set_stamp_t *stamp,
                                     uint8_t bytes[TUMBLE_SET_BYTES]);
tumble_status_t tumble_set_check(const uint8_t bytes[TUMBLE_SET_BYTES]);

/* Put another stamp on a record, and take it off. */
void tumble_set_stamp(uint8_t bytes[TUMBLE_SET_BYTES], const tumble_set_stamp_t *stamp);
void tumble_set_get_stamp(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_stamp_t *stamp);

/* Set further flags in a record; then it needs its stamp. */
void tumble_set_add_flags(uint8_t bytes[TUMBLE_SET_BYTES], uint16_t flags);

/* The CRC-32 at the end of a record. */
uint32_t tumble_set_crc(const uint8_t bytes[TUMBLE_SET_BYTES]);

#endif
