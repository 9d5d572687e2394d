/* node_log.h - the events of tumble-node (event_log.h). Where they are not wanted each call costs next to nothing. */
#ifndef TUMBLE_NODE_NODE_LOG_H
#define TUMBLE_NODE_NODE_LOG_H

#include "run_log.h"
#include "world/world.h"

#include <stdbool.h>
#include <stdint.h>

/* The command line of tumble-node. */
typedef struct {
    const char *interface;
    const char *scenario; /* file, "-" for standard input, null for the defaults */
    const char *out;      /* run folder, or null */
    const char *gains;    /* file of a gain record, or null */
    const char *nv;       /* file of the non-volatile memory, or null: there is none */
    int progress_fd;      /* -1: none */
    double patience_s;    /* after a fault, for a command to go on */
    bool start;
} node_options_t;

/* What was told last. */
typedef struct {
    uint8_t asked_by[2]; /* the command that was written last, through either SDO server */
    bool in_segments[2]; /* it is still to come, in a segment */
    uint8_t asked;       /* the one that was refused last */
    link_log_t link;
    run_log_sets_t sets;
    bool is_unlocked;
    uint8_t stand_fault; /* the one that was told last */
    bool unread_documents;
    bool unread_progress;
} node_log_t;

/* It serves. Without --log also tells it, unless it makes a single run or standard error has its progress. */
void node_log_ready(const node_options_t *options);

/* A frame has come or gone: it may be a command. */
void node_log_frame(node_log_t *log, const tumble_can_frame_t *frame);

/* A command was refused; `rung`: of a stop under way, which CLEAR_FAULT waits for. */
void node_log_refused(const node_log_t *log, const tumble_progress_t *now, uint8_t rung);

/* After every step: the interface; the service level; a fault of the stand, also between runs; what became of a result (`keeper` null: nothing is kept). */
void node_log_update(node_log_t *log, const tumble_navcomp_t *navcomp, const tumble_keeper_t *keeper,
                     const can_socket_t *can);

/* So many lines of an output were left out, for nobody reads them: told once, which `told` notes. */
void node_log_unread(bool *told, uint32_t lost, const char *output);

/* The folder of --out could not be written in the end. Returns the exit code. */
int node_log_unwritten(const char *folder, const char *why);

/* The program ends with this exit code: the last line. */
void node_log_end(const bench_world_t *world, int code, const tumble_progress_t *cause);

#endif
