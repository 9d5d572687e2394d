/* frame_bits.h - how long a classic CAN frame occupies the bus, to the bit.
 *
 * Counted from the frame itself: its CRC-15 and every stuff bit that the transmitter inserts after five equal bits
 * between start of frame and the end of the CRC sequence (ISO 11898-1). Every frame of a run passes here, so both go a
 * byte at a time through tables, which the caller owns, builds once, and may share.
 */
#ifndef TUMBLE_SIMULATION_FRAME_BITS_H
#define TUMBLE_SIMULATION_FRAME_BITS_H

#include "tumble/port.h"

#include <stdint.h>

#define SIM_INTERFRAME_BITS 3
#define SIM_HEADER_BYTES 3 /* the 19 bits before the data, right-aligned */

/* What the header of a frame of eight bytes does. */
typedef struct {
    uint16_t crc;    /* its share of the CRC */
    uint16_t state;  /* before its last bit, x 256 */
    uint8_t stuffed; /* stuff bits sent until then */
} sim_wire_header_t;

typedef struct {
    /* What a byte does to the CRC when so many bytes follow it. */
    uint16_t crc[SIM_HEADER_BYTES + TUMBLE_CAN_MAX_BYTES][256];
    /* From state x 256 + byte: the next state x 256, and the stuff bits sent on the way. A state is the last bit sent
     * (bit 0) and how many equal ones end with it, less 1 (bits 1, 2). Two tables, so that the way from state to state,
     * which nothing can shorten, is one look-up a byte. */
    uint16_t next[8 * 256];
    uint8_t stuffed[8 * 256];
    /* By identifier: nearly all frames have eight bytes. */
    sim_wire_header_t full[TUMBLE_CAN_MAX_ID + 1];
} sim_wire_t;

void sim_wire_init(sim_wire_t *wire);

/* Length of a data frame with stuff bits and the interframe space: 111 bits and 0 to 24 stuff bits for eight bytes. */
uint32_t sim_frame_bits(const sim_wire_t *wire, const tumble_can_frame_t *frame);

/* Stuff bits alone. */
uint32_t sim_frame_stuff_bits(const sim_wire_t *wire, const tumble_can_frame_t *frame);

#endif
