/* stand_log.h - the events of tumble-stand (event_log.h): what its operator does, what the scenario breaks. */
#ifndef TUMBLE_STAND_STAND_LOG_H
#define TUMBLE_STAND_STAND_LOG_H

#include "run_log.h"
#include "stand_operator.h"
#include "world/world.h"

#include <stdbool.h>
#include <stdint.h>

/* The command line of tumble-stand. */
typedef struct {
    const char *interface;
    const char *scenario; /* file, "-" for standard input, null for the defaults */
    uint64_t seed;
    stand_operator_kind_t operator;
} stand_options_t;

/* What was told last. */
typedef struct {
    uint32_t mounted[TUMBLE_MAX_MOUNTINGS];
    uint32_t mended;
    uint32_t faults[SIM_MAX_FAULTS];
    link_log_t link;
} stand_log_t;

/* It serves. */
void stand_log_ready(const stand_options_t *options);

/* Node 1 has answered the operator; `before`: as he was before he heard it. */
void stand_log_answer(const stand_operator_t *before, const stand_operator_t *now, const tumble_can_frame_t *frame);

/* After every step. */
void stand_log_update(stand_log_t *log, const bench_world_t *world, const can_socket_t *can);

/* The program ends with this exit code: the last line. */
void stand_log_end(const bench_world_t *world, int code);

#endif
