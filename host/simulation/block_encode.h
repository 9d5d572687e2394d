/* block_encode.h - a sample of the accelerometer block as its two frames (docs/bus/block.dbc).
 *
 * An encoder of the simulation's own, so that a mistake in the firmware's cannot hide in a shared function.
 */
#ifndef TUMBLE_SIMULATION_BLOCK_ENCODE_H
#define TUMBLE_SIMULATION_BLOCK_ENCODE_H

#include "core/limits.h"
#include "port/port.h"

#include <stdint.h>

/* One sample on its way to the bus. */
typedef struct {
    tumble_can_frame_t xy;
    tumble_can_frame_t z;
} sim_block_frames_t;

/* Counts within int24, the low 8 bits of the counter, milliseconds modulo 4096, four status bits, temperature in half
 * degrees. */
void sim_block_encode(const int32_t counts[TUMBLE_CHANNELS], uint32_t counter, uint64_t milliseconds, uint8_t status,
                      int8_t half_degrees, sim_block_frames_t *frames);

/* Put the checksum of the other seven bytes, under the frame's identifier, into byte 7. */
void sim_block_seal(tumble_can_frame_t *frame);

#endif
