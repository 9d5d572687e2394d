/* bit_timing.h - how a CAN controller of this chip divides its clock into bits.
 *
 * A bit is 1 + segment1 + segment2 time quanta, each `prescaler` periods of the clock long; it is sampled between the
 * segments. The fields hold these numbers themselves; the registers hold each less one.
 */
#ifndef ZCU102_BIT_TIMING_H
#define ZCU102_BIT_TIMING_H

#include "tumble/status.h"

#include <stdint.h>

#define ZCU102_SAMPLE_POINT_PERMILLE 875U /* where CANopen wants it, at every rate */
#define ZCU102_MOST_ERROR_PPM 1000U       /* of the rate; both ends together may be off by about 5000 */

typedef struct {
    uint32_t prescaler; /* 1 to 256 */
    uint32_t segment1;  /* 1 to 16, propagation included */
    uint32_t segment2;  /* 1 to 8 */
    uint32_t jump;      /* 1 to 4, at most segment2 */
} zcu102_bit_timing_t;

/* The division with the smallest error of the rate; among equals that with the sample point nearest to
 * ZCU102_SAMPLE_POINT_PERMILLE, then that with the finest quanta. Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT: a rate of 0
 * or above 1 Mbit/s, or one that this clock reaches with no error of ZCU102_MOST_ERROR_PPM or less. */
tumble_status_t zcu102_bit_timing(uint32_t clock_hz, uint32_t bits_per_second, zcu102_bit_timing_t *timing);

#endif
