/* replay.h - a recorded bus log through the firmware of a world again, here or on the board zcu102.
 *
 * `frames` are those of the log, node 1's included, in their order; their times never fall, and of each only time,
 * identifier, length and data count. world_check is content with the keys, and power is off. A sentence that a function returns says
 * what is wrong, as those of border.h.
 *
 * Left out are what node 1 itself sent (its CANopen services, and the drive's receive PDOs), and all that was there
 * before node 1 came to life, shortly before its (last) boot-up message, where time begins.
 *
 * Commands that came over the bus (SDO writes of 2002h) are frames like others. Those of a kind that the bus never
 * carried were given inside the process. They are put in where the log shows that they had been given: START at the
 * beginning, or when node 1 is seen to leave IDLE; CONFIRM_MOUNTING when it is seen to leave WAIT_MOUNTING, or when the
 * drive is moved meanwhile; RESUME, or CONFIRM_MOUNTING after a fault of the mounting, when it leaves FAULT; ABORT when
 * it is seen in ABORT. Repetitions asked for by a person leave no such trace: those runs cannot be replayed.
 */
#ifndef TUMBLE_WORLD_REPLAY_H
#define TUMBLE_WORLD_REPLAY_H

#include "world/border.h"

/* Power on, and play them to the firmware, which hears nothing else; what it sends goes nowhere. Afterwards the world
 * has ended, and tells of the firmware what it found; what it tells of bus, table and truth means nothing.
 * `commands_refused`: put in, and not taken. */
const char *world_replay(world_t *world, const world_frame_t *frames, size_t count, uint32_t *commands_refused);

/* The recording for the board (boards/replay/replay.h); valid until the next call. */
const char *world_recording(world_t *world, const world_frame_t *frames, size_t count, const uint8_t **recording,
                            size_t *size);

#define WORLD_COMMISSIONING_BYTES 8192

/* The record that tells the board what the keys say of its stand and block (boards/zcu102/commissioning.h): its bytes,
 * of which there is room for WORLD_COMMISSIONING_BYTES. */
const char *world_commissioning(world_t *world, uint8_t *record, size_t *size);

#endif
