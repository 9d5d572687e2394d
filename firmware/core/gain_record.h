/* gain_record.h - a table of stand-optimal gains as it lies in non-volatile memory, validated and read in place.
 *
 * The bytes are laid down in docs/gain-record.md. Nothing is copied: a record that passed is used where it is mapped, and
 * must stay there, unchanged, as long as the pointer to it is in use. These functions only read; no state is kept.
 */
#ifndef TUMBLE_CORE_GAIN_RECORD_H
#define TUMBLE_CORE_GAIN_RECORD_H

#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

#include <stddef.h>
#include <stdint.h>

#if defined(__BYTE_ORDER__) && (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)
#error "a gain record is read in place and is little endian: this target needs a reader of its own"
#endif

#define TUMBLE_GAIN_RECORD_SCHEMA 1
#define TUMBLE_MAX_SIGMA_RAD 1.0 /* of a stand's errors */

/* The head of a record. Behind it, up to its last 8 bytes: the gains. */
typedef struct {
    uint8_t magic[4]; /* "TGR1" */
    uint32_t size_bytes;
    uint16_t schema;
    uint8_t fit_positions;
    uint8_t mountings;
    uint8_t yaws; /* 1: one yaw for all mountings; else one for each */
    uint8_t reserved[3];
    uint32_t schedule_crc;
    uint32_t block_crc; /* CRC-32 of the block's serial, UTF-8; 0: for any block. For people: nothing here checks it */
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS]; /* the K that the gains were linearised at; not all 0 */
    double sigma_rad[4];                                /* standard deviations of alpha1 .. alpha4; 0: no such error */
    double sigma_mean_v;                                /* of a position mean; above 0 */
    double u_k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS]; /* standard uncertainties of the result, at that K */
    double u_u0_v[TUMBLE_CHANNELS];
} tumble_gain_record_t;

static_assert(offsetof(tumble_gain_record_t, k_v_per_g) == 24, "the numbers follow the head's first 24 bytes");
static_assert(sizeof(tumble_gain_record_t) == 232, "the gains follow the head's 232 bytes");

/* Is there a record of gains for this schedule in the `size` bytes at `memory`? Checks in this order: pointers and alignment
 * (to 8 bytes); magic, size and schema; CRC-32; counts and schedule fingerprint; that every number is finite, at most
 * TUMBLE_MAX_GAIN in magnitude, and in its range. The record may be shorter than the memory. `*record` is written only on
 * TUMBLE_OK. The schedule has passed its own validation. Reads every byte once bitwise (about 50 instructions a byte).
 * Returns TUMBLE_OK, _ARGUMENT, _GAIN_RECORD (nothing that this software reads), _CRC, _GAIN_TABLE (for another schedule),
 * _NOT_FINITE (a number, K, sigma, u or gain, that is none or is out of range). */
tumble_status_t tumble_gain_record_open(const void *memory, size_t size, const tumble_schedule_t *schedule,
                                        const tumble_gain_record_t **record);

/* Gains of the coefficients: TUMBLE_COEFFICIENTS rows of 3 x fit_positions, as in tumble_gain_table_t. */
const double *tumble_gain_record_gains(const tumble_gain_record_t *record);

/* Gains (rad per V) of the stand's own errors: rows alpha1, alpha2, then each yaw; columns as above. */
const double *tumble_gain_record_stand_gains(const tumble_gain_record_t *record);

/* The fingerprint of a schedule: CRC-32 over mountings and fit positions, see docs/gain-record.md. */
uint32_t tumble_gain_record_schedule_crc(const tumble_schedule_t *schedule);

#endif
