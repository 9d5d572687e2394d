/* lock_step.h - one guest to whom the time belongs: the run goes on only while he waits, and only so far.
 *
 * Records as of guests.h through a stream socket that the program was started with. The guest sends frames, which wait
 * for the bus at the present time, and, with a moment of virtual time as data (uint64, us),
 *
 *     0x80000001  go on until that moment, or until the first frame of another node has gone over the bus
 *     0x80000002  go on until that moment, whatever goes over the bus
 *
 * The answer to either is what has gone over the bus meanwhile, but what the guest sent: a record 0x80000002 with the
 * moment when the frame ended, and the frame; and at last a record 0x80000001 with the present time. The guest reads
 * all that before he sends again.
 *
 * Nothing else gives the run a time or an order, so what the guest does determines it to the last bit. It ends when he
 * closes the socket, or sends what is no record.
 */
#ifndef TUMBLE_BENCH_LOCK_STEP_H
#define TUMBLE_BENCH_LOCK_STEP_H

#include "bench/guests.h"

typedef struct {
    int socket;        /* -1: there is no such guest */
    bool asked;        /* he waits for the answer */
    bool stops;        /* at the first frame */
    uint64_t until_us; /* the run may go on */
    uint8_t out[256 * BENCH_GUEST_RECORD];
    uint32_t out_size;
    bool left;
} bench_lock_step_t;

/* `descriptor`: the socket, or -1. Null, or what is wrong with it. */
const char *bench_lock_step_open(bench_lock_step_t *step, int descriptor);

/* Answer and wait until the run may go on to its next event. False: the guest has left, or the program is interrupted. */
bool bench_lock_step_wait(bench_lock_step_t *step, bench_world_t *world);

/* A frame has gone over the bus. */
void bench_lock_step_tell(bench_lock_step_t *step, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame);

#endif
