/* replay.h - a board without hardware: recorded frames come in, in order and at their recorded times, and what the
 * firmware sends goes nowhere. Time is virtual. On every processor the same record gives the same bits.
 *
 * A recording is a row of bytes, the same on every machine:
 *     header, 16 bytes: "TUMBLELG"; number of records, uint32; checksum of the records' bytes (FNV-1a, 32 bits)
 *     record, 20 bytes: time in us, uint64, never falling; identifier, uint16; length, uint8; 0; data, 8 bytes
 * all little endian. The identifier REPLAY_COMMAND marks a command that did not travel over the bus: data 0 its number,
 * data 1 its argument; 0 for the mounting that is asked for.
 *
 * No libc, no heap; the caller owns everything. One recording, one replay.
 */
#ifndef TUMBLE_BOARDS_REPLAY_H
#define TUMBLE_BOARDS_REPLAY_H

#include "tumble/navcomp.h"
#include "tumble/port.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define REPLAY_HEADER_BYTES 16U
#define REPLAY_RECORD_BYTES 20U
#define REPLAY_COMMAND 0xFFFFU

typedef struct {
    uint64_t time_us;
    tumble_can_frame_t frame;
} replay_record_t;

void replay_put_record(const replay_record_t *record, uint8_t bytes[REPLAY_RECORD_BYTES]);
void replay_get_record(const uint8_t bytes[REPLAY_RECORD_BYTES], replay_record_t *record);

/* The header of a recording of so many records, which lie behind it. */
void replay_put_header(uint8_t *recording, uint32_t count);

typedef struct {
    tumble_port_t port; /* what the firmware gets */
    const uint8_t *recording;
    uint32_t count;
    uint64_t now_us;
    tumble_can_frame_t frame; /* that waits to be received */
    bool waiting;
    uint32_t sent;             /* frames that the firmware would have sent */
    uint32_t commands_refused; /* recorded commands that the firmware did not take now */
} replay_t;

/* Take a recording, which must outlive the replay. Returns TUMBLE_OK; TUMBLE_E_FRAME: it is no recording, not whole, or
 * its times fall; TUMBLE_E_CRC. */
tumble_status_t replay_open(replay_t *replay, const uint8_t *recording, size_t size);

/* Play it to the end, and let the firmware finish its computations. `navcomp` is initialised, on this replay's port.
 * Called after every step: `watch` may be null. */
void replay_run(replay_t *replay, tumble_navcomp_t *navcomp, void (*watch)(void *context), void *context);

#endif
