/* log.h - a bus log as candump -L writes it, turned into a recording for the firmware of node 1.
 *
 * Left out: what node 1 itself sends (its CANopen services, and the drive's receive PDOs), and what is no classic data
 * frame with an 11-bit identifier; the latter are counted; and all that was there before node 1 came to life, shortly
 * before its (last) boot-up message, where time begins. A time that falls counts as its predecessor's.
 *
 * Commands that came over the bus (SDO writes of 2002h) are frames like others. Those of a kind that the bus never
 * carried were given inside the process. They are put in where the log shows that they had been given: START at the
 * beginning, or when node 1 is seen to leave IDLE; CONFIRM_MOUNTING when it is seen to leave WAIT_MOUNTING, or when the
 * drive is moved meanwhile; RESUME, or CONFIRM_MOUNTING after a fault of the mounting, when it leaves FAULT; ABORT when
 * it is seen in ABORT. Repetitions asked for by a person leave no such trace: those runs cannot be replayed.
 */
#ifndef TUMBLE_REPLAY_LOG_H
#define TUMBLE_REPLAY_LOG_H

#include "bench/config.h"
#include "tumble/port.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef struct {
    uint64_t time_us; /* since the first */
    tumble_can_frame_t frame;
} log_line_t;

typedef struct {
    log_line_t *lines; /* all classic data frames, node 1's included */
    size_t count;
    size_t foreign;
    uint64_t first_us; /* as logged */
} bus_log_t;

/* Read a log. Null, or what is wrong; `line` (from 1; 0: none) then says where. */
const char *log_read(bus_log_t *log, FILE *file, size_t *line);

/* The recording, for a firmware configured like this. The caller frees it. Null: no memory, or more frames than fit. */
uint8_t *log_recording(const bus_log_t *log, const bench_config_t *config, size_t *size);

void log_free(bus_log_t *log);

#endif
