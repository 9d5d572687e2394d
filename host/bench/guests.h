/* guests.h - others on the simulated bus: programs that connect to a local socket.
 *
 * A stream socket of the Unix domain. Either side sends records of 16 bytes, laid out as struct can_frame of Linux with
 * the identifier in little endian: identifier (4 bytes), length (1), three bytes 0, data (8). Every guest receives
 * every frame of the bus but its own, at the end of the frame. What a guest sends takes part in arbitration as the
 * frames of one more node; a record that is no classic data frame with an 11-bit identifier ends the connection. What a
 * guest does not take at once waits for it, up to BENCH_GUEST_BACKLOG records: on a busy machine it may stand still for
 * seconds. One that is further behind is sent away.
 *
 * Identifier 0x80000000 is no frame but turns the table of the simulated stand, for a drive that runs outside (with
 * present.drive = no): data 0-3 the angle, int32, data 4-7 the speed, uint32 above 0, both in units of 1e-5 degrees (a
 * second).
 *
 * Virtual time follows the wall's while guests may come. If the firmware is not in the process either (present.navcomp
 * = no), the run ends when the last guest leaves.
 */
#ifndef TUMBLE_BENCH_GUESTS_H
#define TUMBLE_BENCH_GUESTS_H

#include "bench/world.h"
#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BENCH_GUEST_RECORD 16
#define BENCH_GUEST_BACKLOG 8192 /* 30 s of a run with 100 samples a second */

typedef struct {
    int socket;                        /* -1: nobody */
    uint8_t bytes[BENCH_GUEST_RECORD]; /* a record that has not come whole */
    uint32_t have;
    uint8_t backlog[BENCH_GUEST_BACKLOG * BENCH_GUEST_RECORD]; /* a ring: what its socket has not taken yet */
    uint32_t first;
    uint32_t waiting; /* bytes from `first` on */
} bench_guest_t;

typedef struct {
    const char *path;
    int listener; /* -1: not open */
    bench_guest_t guests[BENCH_MAX_GUESTS];
    uint32_t present;
    bool had_any;
} bench_guests_t;

/* Make the socket and wait until `awaited` guests have come. Null, or what is wrong. */
const char *bench_guests_open(bench_guests_t *guests, const char *path, uint32_t awaited);

/* Wait for at most `timeout_s` for something to come from a guest or a new one, or for a guest that is behind to take
 * more. True: that was so. */
bool bench_guests_poll(bench_guests_t *guests, double timeout_s);

/* Take what has come: frames go on the bus at the world's present time. */
void bench_guests_take(bench_guests_t *guests, bench_world_t *world);

/* A frame has gone over the bus: tell all but the bus node it came from. */
void bench_guests_tell(bench_guests_t *guests, uint8_t sender, const tumble_can_frame_t *frame);

/* There were guests, and all have left. */
bool bench_guests_have_left(const bench_guests_t *guests);

/* A guest that is behind gets the rest, if it takes some of it every ten seconds and the run was not interrupted. */
void bench_guests_close(bench_guests_t *guests);

/* A frame as such a record. */
void bench_guests_write(uint8_t *record, const tumble_can_frame_t *frame);

/* Do what the record of a bus node says: the frame waits for the bus, unless its queue is full; or turn the table.
 * False: this is no record. */
bool bench_guests_read(bench_world_t *world, uint8_t node, const uint8_t *record);

#endif
