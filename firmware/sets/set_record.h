/* set_record.h - a set of coefficients with all that is known of it, and its bytes in non-volatile memory.
 *
 * The bytes are laid down in docs/store.md: little endian, 320 of them, a CRC-32 at the end. Encoding and decoding are pure
 * functions, byte by byte, the same on every machine. What is unknown has its flag cleared and is 0, never NaN.
 */
#ifndef TUMBLE_SETS_SET_RECORD_H
#define TUMBLE_SETS_SET_RECORD_H

#include "tumble/core.h"

#include <stdint.h>

#define TUMBLE_SET_SCHEMA 1U
#define TUMBLE_SET_BYTES 320U
#define TUMBLE_SET_SERIAL_BYTES 24U

/* How a set came to be where it is (`origin`). The store writes it. */
enum {
    TUMBLE_ORIGIN_FACTORY = 1,    /* written once, with the block */
    TUMBLE_ORIGIN_COMMITTED = 2,  /* by the rules, without an operator */
    TUMBLE_ORIGIN_ACCEPTED = 3,   /* a proposal that an operator accepted */
    TUMBLE_ORIGIN_ROLLED_BACK = 4, /* an earlier set that an operator brought back */
    TUMBLE_ORIGIN_HELD = 5,       /* a proposal */
    TUMBLE_ORIGIN_DECAYED = 6     /* in the history alone, no set has it: the active set was found to have decayed */
};

/* What is known of a set (bits of `flags`). */
#define TUMBLE_SET_HAS_TEMPERATURE 0x0001U
#define TUMBLE_SET_HAS_GRAVITY 0x0002U
#define TUMBLE_SET_HAS_UNCERTAINTY 0x0004U
#define TUMBLE_SET_HAS_CHECK 0x0008U   /* the gravity check: maxima, limit, positions */
#define TUMBLE_SET_HAS_CLOSURE 0x0010U
#define TUMBLE_SET_RESUMED 0x0020U     /* the run was interrupted by a loss of power, and went on after it */
#define TUMBLE_SET_OTHER_RULES 0x0040U /* judged, committed or accepted under rules other than the board's, or while those
                                        * could be changed (the service level was open) */
#define TUMBLE_SET_FLAGS 0x007FU

typedef struct {
    /* Written by the store; what a caller puts here is not read. */
    uint32_t sequence; /* one more with each commit; of a proposal, that which it would have had; 0: factory */
    uint32_t restores; /* origin rolled back: the sequence of the set that was brought back; else 0 */
    uint32_t from_crc; /* origin accepted or rolled back: CRC-32 at the end of the proposal's record; else 0 */
    uint8_t origin;    /* TUMBLE_ORIGIN_... */

    uint8_t estimator; /* its number in the procedure's configuration */
    uint16_t flags;
    uint8_t block_serial[TUMBLE_SET_SERIAL_BYTES]; /* UTF-8, padded with zeros; all zero: unknown */
    uint64_t date_utc_s;                           /* since 1970; 0: unknown */
    double temperature_c;
    double gravity_m_s2; /* local gravity: the size of the unit g of K; above 0 where known */
    tumble_coefficients_t coefficients;
    tumble_uncertainty_t uncertainty; /* each 0 or above */
    double max_abs_fit_g;             /* the gravity check on fit and on check positions, and its limit; 0 or above */
    double max_abs_check_g;
    double limit_g;
    double closure_v; /* the largest difference in magnitude; 0 or above */
    uint32_t samples; /* of the whole run; 0: unknown */
    uint8_t fit_positions;
    uint8_t check_positions;
    uint32_t schedule_crc; /* fingerprint, tumble_gain_record_schedule_crc; 0: unknown */
    uint32_t stand_crc;    /* fingerprint of the stand as the application makes it; 0: unknown */
    uint32_t reasons;      /* why it was held, bits of the application; 0: it was not */
    uint32_t record_crc;   /* read: CRC-32 at the end of the record; writing a record does not look at it */
} tumble_set_t;

/* Write the record of `set`. What a cleared flag says is unknown is written as 0. After a refusal `bytes` hold nothing of
 * use.
 * Returns TUMBLE_OK; _ARGUMENT (null, a flag or origin that does not exist, a serial with a byte behind its first zero,
 * or a number out of its range above); _NOT_FINITE (K, U0 or a number that is said to be known). */
tumble_status_t tumble_set_encode(const tumble_set_t *set, uint8_t bytes[TUMBLE_SET_BYTES]);

/* Read a record. `*set` is written on TUMBLE_OK alone. Costs one bitwise CRC over 320 bytes.
 * Returns TUMBLE_OK; _ARGUMENT (null); _FRAME (not the magic, schema and size of a set); _CRC; and under a right CRC, of a
 * writer that errs: _ARGUMENT or _NOT_FINITE as tumble_set_encode, and _FRAME (bytes that must be 0). */
tumble_status_t tumble_set_decode(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set);

/* For the store alone; no pointer is null. What it writes of a set itself: */
typedef struct {
    uint32_t sequence;
    uint32_t restores;
    uint32_t from_crc;
    uint8_t origin;
} tumble_set_stamp_t;

/* As tumble_set_encode and _decode, with another stamp; without looking into the fields. A null set is _ARGUMENT. */
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
