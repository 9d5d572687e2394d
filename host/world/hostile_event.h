/* hostile_event.h - what may happen in a hostile life (lives.h): faults, commands, frames of a stranger, power cuts. */
#ifndef TUMBLE_WORLD_HOSTILE_EVENT_H
#define TUMBLE_WORLD_HOSTILE_EVENT_H

#include "navcomp/commands.h"
#include "simulation/scenario.h"
#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

/* The word is the name in the summary. */
#define BENCH_HOSTILE_LIST(X)                                                                                          \
    X(BENCH_HOSTILE_FAULT, "fault")                                                                                    \
    X(BENCH_HOSTILE_COMMAND, "command")                                                                                \
    X(BENCH_HOSTILE_CUT, "power_cut")                                                                                  \
    X(BENCH_HOSTILE_SDO_NAVCOMP, "sdo_navcomp")                                                                        \
    X(BENCH_HOSTILE_SDO_DRIVE, "sdo_drive")                                                                            \
    X(BENCH_HOSTILE_SDO_ANSWER, "sdo_answer")                                                                          \
    X(BENCH_HOSTILE_SET_POINT, "set_point")                                                                            \
    X(BENCH_HOSTILE_SDO_SET_POINT, "sdo_set_point")                                                                    \
    X(BENCH_HOSTILE_POSITION, "position")                                                                              \
    X(BENCH_HOSTILE_NEAR_POSITION, "near_position")                                                                    \
    X(BENCH_HOSTILE_SAMPLE, "sample")                                                                                  \
    X(BENCH_HOSTILE_SPOILT_SAMPLE, "spoilt_sample")                                                                    \
    X(BENCH_HOSTILE_NMT, "nmt")                                                                                        \
    X(BENCH_HOSTILE_HEARTBEAT, "heartbeat")                                                                            \
    X(BENCH_HOSTILE_EMERGENCY, "emergency")                                                                            \
    X(BENCH_HOSTILE_SYNC, "sync")                                                                                      \
    X(BENCH_HOSTILE_LSS, "lss")                                                                                        \
    X(BENCH_HOSTILE_ANY_FRAME, "any_frame")

typedef enum {
#define BENCH_HOSTILE_ENUM(name, word) name,
    BENCH_HOSTILE_LIST(BENCH_HOSTILE_ENUM)
#undef BENCH_HOSTILE_ENUM
        BENCH_HOSTILE_KINDS
} bench_hostile_t;

/* A moment: a time, or the first one from that time on at which the firmware is in one of these states or the memory
 * is at work, and then some more. */
typedef struct {
    uint64_t at_us;
    uint32_t states; /* bit per tumble_state_t; 0: any */
    bool writing;    /* the memory is erasing or programming */
    uint32_t delay_us;
} bench_moment_t;

typedef struct {
    bench_hostile_t kind;
    uint32_t number; /* in the list as drawn: names its stream of random numbers */
    bench_moment_t moment;
    sim_fault_t fault; /* of BENCH_HOSTILE_FAULT, which has its moment in here */
    tumble_command_t command;
    uint8_t argument;
    double angle_deg; /* of a turn; of a set-point: where to; of positions: how far each is off the one before */
    bool relative;    /* of a set-point: so far off the drive's present target */
    bool by_host;     /* the command comes from the board itself, not over CAN */
    tumble_can_frame_t frame; /* as it is sent, where neither position, set-point nor sample is forged */
    uint32_t count;           /* forged positions; flipped bits */
    int32_t counts;           /* added to a forged sample */
    uint32_t off_us;          /* without power */
} bench_event_t;

const char *bench_hostile_name(bench_hostile_t kind);

/* Does the node's or the drive's own setting, instead of a command, get rewritten in the drive? Not one that the
 * navigation computer reads back before each motion. */
bool bench_event_rewrites_drive(const bench_event_t *event);

/* May the drive be commanded by this past the navigation computer? */
bool bench_event_commands_drive(const bench_event_t *event);

#endif
