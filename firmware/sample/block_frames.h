/* block_frames.h - the accelerometer block's two frames per sample: byte layout, CRC, pairing, counting.
 *
 * docs/bus/block.dbc is the same layout for other tools; docs/bus/README.md has the reasons. Both frames are classic
 * CAN data frames of eight bytes, little endian:
 *
 *     0x683   x int24 (0-2)   y int24 (3-5)   sample_counter uint8 (6)                          crc (7)
 *     0x693   z int24 (0-2)   frame_counter uint8 (3)   timestamp 12 bits, status 4 bits (4-5)
 *             temperature int8, half degrees C (6)                                              crc (7)
 *
 * frame_counter = (2 sample_counter + 1) mod 256 ties the halves together. The CRC-8 (polynomial 0x2F, initial value
 * 0xFF, final xor 0xFF, not reflected) runs over the low byte of the identifier, then bytes 0 to 6: a frame delivered
 * under the other identifier fails.
 *
 * Nothing is allocated; the caller owns the receiver, one per block. Not re-entrant on one receiver. No clock: only the
 * frames and their order matter.
 */
#ifndef TUMBLE_SAMPLE_BLOCK_FRAMES_H
#define TUMBLE_SAMPLE_BLOCK_FRAMES_H

#include "sample/block_sample.h"
#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_BLOCK_ID_XY 0x683U
#define TUMBLE_BLOCK_ID_Z 0x693U
#define TUMBLE_BLOCK_FRAME_BYTES 8

#define TUMBLE_BLOCK_MAX_COUNTS 8388607 /* int24; the smallest is one farther from 0 */

/* How many bits the CRC takes at one time: 4, by a table of 16 bytes, or 8, by one of 256 in half the time. */
#ifndef TUMBLE_BLOCK_CRC_BITS
#define TUMBLE_BLOCK_CRC_BITS 4
#endif

/* The CRC that belongs in byte 7 of this frame: over the low byte of its identifier and bytes 0 to 6. */
uint8_t tumble_block_frame_crc(const tumble_can_frame_t *frame);

/* What a frame turned out to be. */
typedef enum {
    TUMBLE_BLOCK_OTHER = 0, /* not one of the two identifiers: not counted */
    TUMBLE_BLOCK_HALF,      /* taken, its sample is not complete (yet) */
    TUMBLE_BLOCK_SAMPLE,    /* completes a sample, which has been written */
    TUMBLE_BLOCK_REPEATED,  /* the sample, or a half of it, came before; dropped */
    TUMBLE_BLOCK_REORDERED, /* a sample older than the last, or its halves in the wrong order; dropped */
    TUMBLE_BLOCK_CORRUPTED  /* length, CRC, or halves that do not belong together; dropped */
} tumble_block_event_t;

/* Monotonic; they stop at UINT32_MAX. A sample spoilt by a refused half is also counted as lost, once a
 * later sample shows the gap. */
typedef struct {
    uint32_t samples; /* complete, in order, handed on */
    uint32_t lost;    /* missing in the sample counter between two samples handed on */
    uint32_t repeated;
    uint32_t reordered;
    uint32_t wrong_length; /* corrupted: not eight bytes */
    uint32_t wrong_crc;    /* corrupted: the checksum disagrees */
    uint32_t wrong_pair;   /* corrupted: counters of the two halves contradict each other */
    uint32_t lone_halves;  /* halves whose partner never came */
} tumble_block_counters_t;

/* All zero: nothing has come yet. */
typedef struct {
    tumble_block_counters_t counters;
    int32_t x_counts; /* of the pending first half */
    int32_t y_counts;
    uint16_t counter; /* widened counter of the last sample handed on */
    uint8_t pending_counter;
    uint8_t flags; /* private to block_frames.c */
} tumble_block_receiver_t;

/* The block has restarted: forget the pending half and the last counter, so that its new count is not taken for
 * reordering. The counters stay. */
void tumble_block_receiver_restart(tumble_block_receiver_t *receiver);

#define TUMBLE_BLOCK_MAX_GAP 127U

/* Take one frame. `sample` is written on TUMBLE_BLOCK_SAMPLE only: counts as sent, the sample counter widened to 16
 * bits (steps of 1 to TUMBLE_BLOCK_MAX_GAP advance it by what is missing; a longer one cannot be told from reordering or
 * from a shorter one by eight bits, so silence that long must be caught by a timeout). */
tumble_block_event_t tumble_block_receive(tumble_block_receiver_t *receiver, const tumble_can_frame_t *frame,
                                          tumble_block_sample_t *sample);

#endif
