/* fault.h - what can go wrong in a simulated run, and what of it is in force.
 *
 * Each part of the simulation (drive, block, its sensor) has a row of effects, one a kind of fault, and looks at those
 * that concern it.
 */
#ifndef TUMBLE_SIMULATION_FAULT_H
#define TUMBLE_SIMULATION_FAULT_H

#include <stdbool.h>
#include <stdint.h>

/* What can go wrong, of what: a drive, any table, the block, the navigation computer, frames on the bus. The word in quotes
 * is the name in a scenario file. Those of frames are in the order of sim_frame_fault_t. */
#define SIM_FAULT_LIST(X)                                                                                              \
    X(SIM_FAULT_DRIVE_FAULT, DRIVE, "drive_fault", "the drive reports an error and stops; value: its code")            \
    X(SIM_FAULT_STALL, TABLE, "stall", "the table jams")                                                               \
    X(SIM_FAULT_DRIVE_SILENT, DRIVE, "drive_silent", "the drive is off the bus")                                       \
    X(SIM_FAULT_DRIVE_POWER_CYCLE, DRIVE, "drive_power_cycle", "the drive loses power and comes back")                 \
    X(SIM_FAULT_NEVER_REACHED, DRIVE, "never_reached",                                                                 \
      "the table stops short of its target; value: by how many degrees")                                               \
    X(SIM_FAULT_RUNAWAY, DRIVE, "runaway",                                                                             \
      "the drive runs on past its target; value: by how many degrees, 0: without end")                                 \
    X(SIM_FAULT_FROZEN_POSITION, DRIVE, "frozen_position", "the drive reports one position, whatever the table does")  \
    X(SIM_FAULT_POSITION_SCALE, DRIVE, "position_scale", "reported positions are too large; value: by this factor")    \
    X(SIM_FAULT_SLIP, TABLE, "slip", "the table slips on its shaft; value: degrees; count 1: the encoder sees it")     \
    X(SIM_FAULT_HOMING_FAILS, DRIVE, "homing_fails", "the home mark is not found")                                     \
    X(SIM_FAULT_HOMING_ENDLESS, DRIVE, "homing_endless", "homing never ends")                                          \
    X(SIM_FAULT_SATURATED, BLOCK, "saturated", "channels beyond their range")                                          \
    X(SIM_FAULT_STUCK, BLOCK, "stuck", "channels repeat one value")                                                    \
    X(SIM_FAULT_NOISY, BLOCK, "noisy", "channels with more noise; value: standard deviation, V")                       \
    X(SIM_FAULT_SWAPPED, BLOCK, "swapped", "two channels have changed places")                                         \
    X(SIM_FAULT_INVERTED, BLOCK, "inverted", "channels with the wrong sign")                                           \
    X(SIM_FAULT_STEP, BLOCK, "step", "a step of channels' outputs; value: V")                                          \
    X(SIM_FAULT_BLOCK_SILENT, BLOCK, "block_silent", "the block is off the bus")                                       \
    X(SIM_FAULT_BLOCK_POWER_CYCLE, BLOCK, "block_power_cycle", "the block loses power and comes back")                 \
    X(SIM_FAULT_NO_SAMPLES, BLOCK, "no_samples", "the block's heartbeat goes on, its samples do not")                  \
    X(SIM_FAULT_LOST_SAMPLES, BLOCK, "lost_samples", "samples are counted but not sent; count: how many")              \
    X(SIM_FAULT_REPEATED_SAMPLES, BLOCK, "repeated_samples", "samples are sent twice; count: how many")                \
    X(SIM_FAULT_REORDERED_SAMPLES, BLOCK, "reordered_samples",                                                         \
      "samples are sent one behind the next; count: how many")                                                         \
    X(SIM_FAULT_WRONG_CRC, BLOCK, "wrong_crc", "samples with a wrong checksum; count: how many")                       \
    X(SIM_FAULT_STATUS, BLOCK, "status", "status bits are set; value: the bits")                                       \
    X(SIM_FAULT_WARM, BLOCK, "warm", "the block's temperature is off; value: degrees")                                 \
    X(SIM_FAULT_BUS_OFF, NODE, "bus_off", "the navigation computer's controller is off the bus")                       \
    X(SIM_FAULT_FRAME_DROP, FRAMES, "frame_drop", "frames are lost; id, mask, count, probability")                     \
    X(SIM_FAULT_FRAME_CORRUPT, FRAMES, "frame_corrupt", "frames with a bit flipped; id, mask, count, probability")     \
    X(SIM_FAULT_FRAME_TRUNCATE, FRAMES, "frame_truncate",                                                              \
      "frames with the last byte missing; id, mask, count, probability")                                               \
    X(SIM_FAULT_FRAME_DELAY, FRAMES, "frame_delay", "frames come late; value: s; id, mask, count, probability")        \
    X(SIM_FAULT_FRAME_DUPLICATE, FRAMES, "frame_duplicate", "frames come twice; id, mask, count, probability")         \
    X(SIM_FAULT_FRAME_REORDER, FRAMES, "frame_reorder", "frames come behind the next one; id, mask, count, probability")

typedef enum {
#define SIM_FAULT_ENUM(name, of, word, sentence) name,
    SIM_FAULT_LIST(SIM_FAULT_ENUM)
#undef SIM_FAULT_ENUM
        SIM_FAULT_KINDS
} sim_fault_kind_t;

typedef enum { SIM_OF_DRIVE, SIM_OF_TABLE, SIM_OF_BLOCK, SIM_OF_NODE, SIM_OF_FRAMES } sim_fault_of_t;

sim_fault_of_t sim_fault_of(sim_fault_kind_t kind);

/* Its word in scenario files and documents. */
const char *sim_fault_word(sim_fault_kind_t kind);

/* All zero: the fault is not in force. */
typedef struct {
    bool on;
    uint8_t channels; /* one bit per channel */
    uint32_t count;   /* how many are still to come; UINT32_MAX: without end */
    double value;
} sim_fault_effect_t;

typedef sim_fault_effect_t sim_fault_effects_t[SIM_FAULT_KINDS];

#endif
