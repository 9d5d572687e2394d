/* stand_bridge.h - the simulated bus of a world joined to a CAN interface.
 *
 * What drive, block and operator send on the simulated bus goes to the interface at the end of the frame; what comes
 * from the interface takes part in arbitration on the simulated bus as the frames of one more node. So an interface
 * without a bit rate (vcan) is as slow as the scenario's bus for the simulated nodes, and a flood of it delays them.
 *
 * An extended frame with identifier 0 turns the table, for a drive that runs elsewhere (with present.drive = no): data
 * 0-3 the angle, int32, data 4-7 the speed, uint32 above 0, both in units of 1e-5 degrees (a second). Other extended and
 * remote frames are counted and ignored.
 */
#ifndef TUMBLE_STAND_STAND_BRIDGE_H
#define TUMBLE_STAND_STAND_BRIDGE_H

#include "can_socket.h"
#include "world/world.h"

#include <stdint.h>

/* Nodes of the simulated bus. */
enum { STAND_BUS_INTERFACE = BENCH_BUS_GUEST, STAND_BUS_OPERATOR };

/* Frames that wait, first in, first out; what finds no room is counted. */
#define FRAME_QUEUE_DEPTH 16384U /* of 8-byte frames: four seconds of a full bus */

typedef struct {
    tumble_can_frame_t frames[FRAME_QUEUE_DEPTH];
    uint32_t first;
    uint32_t count;
    uint64_t overflow;
} frame_queue_t;

_Static_assert((FRAME_QUEUE_DEPTH & (FRAME_QUEUE_DEPTH - 1U)) == 0U, "a power of two");

typedef struct {
    can_socket_t can;
    frame_queue_t in;  /* from the interface, not yet taken by the simulated bus */
    frame_queue_t out; /* to the interface, which had no room */
    uint64_t foreign;
    uint64_t unsent; /* the interface was down */
} stand_bridge_t;

/* The next frame that has come, and when the kernel received it (UTC). False: there is none. */
bool stand_bridge_next(stand_bridge_t *bridge, struct can_frame *raw, uint64_t *utc_us);

/* Take such a frame, at the world's present time. */
void stand_bridge_take(stand_bridge_t *bridge, bench_world_t *world, const struct can_frame *raw);

/* Hand to the simulated bus what waits and it has room for. */
void stand_bridge_feed(stand_bridge_t *bridge, bench_world_t *world);

/* A frame has gone over the simulated bus. */
void stand_bridge_tell(stand_bridge_t *bridge, uint8_t sender, const tumble_can_frame_t *frame);

/* Offer again what the interface had no room for. True: some of it still waits. */
bool stand_bridge_flush(stand_bridge_t *bridge);

#endif
