/* block_encode.h - a sample of the accelerometer block as its two frames (docs/bus/block.dbc).
 *
 * The only encoder: the firmware just receives. The two share nothing, not even the table of the checksum, so that a
 * mistake of one cannot hide in the other.
 */
#ifndef TUMBLE_SIMULATION_BLOCK_ENCODE_H
#define TUMBLE_SIMULATION_BLOCK_ENCODE_H

#include "sample/block_sample.h"
#include "tumble/port.h"

/* One sample on its way to the bus. */
typedef struct {
    tumble_can_frame_t xy;
    tumble_can_frame_t z;
} sim_block_frames_t;

/* Counts within int24; of the counter the low 8 bits travel, of the timestamp 12, of the status 4. */
void sim_block_encode(const tumble_block_sample_t *sample, sim_block_frames_t *frames);

#endif
