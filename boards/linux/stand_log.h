/* stand_log.h - the events of tumble-stand (event_log.h): what its operator does, what the scenario breaks. */
#ifndef TUMBLE_LINUX_STAND_LOG_H
#define TUMBLE_LINUX_STAND_LOG_H

#include "link_log.h"
#include "stand_operator.h"
#include "stand_options.h"
#include "world/world.h"

#include <stdbool.h>
#include <stdint.h>

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
void stand_log_look(stand_log_t *log, const bench_world_t *world, const can_socket_t *can);

/* The program ends with this exit code: the last line. */
void stand_log_end(const bench_world_t *world, int code);

#endif
