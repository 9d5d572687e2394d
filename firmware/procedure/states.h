/* states.h - the closed lists of the procedure's states and of its reasons to stop.
 *
 * Each has a number that travels over CAN and Modbus (new ones go to the end), a name, and a sentence for a person.
 */
#ifndef TUMBLE_PROCEDURE_STATES_H
#define TUMBLE_PROCEDURE_STATES_H

#define TUMBLE_STATE_LIST(X)                                                                                           \
    X(TUMBLE_STATE_IDLE, "waiting for a start command")                                                                \
    X(TUMBLE_STATE_PREFLIGHT, "checking schedule, stand and block")                                                    \
    X(TUMBLE_STATE_WARM_UP, "waiting for the block's temperature to settle")                                           \
    X(TUMBLE_STATE_WAIT_MOUNTING, "waiting for the operator to mount the block, or incline the stand, and confirm")    \
    X(TUMBLE_STATE_HOME, "homing the table")                                                                           \
    X(TUMBLE_STATE_MOVE, "turning the table")                                                                          \
    X(TUMBLE_STATE_SETTLE, "waiting for the table and the block to come to rest")                                      \
    X(TUMBLE_STATE_AVERAGE, "averaging samples")                                                                       \
    X(TUMBLE_STATE_NEXT, "choosing the next position")                                                                 \
    X(TUMBLE_STATE_SOLVE, "computing the coefficients")                                                                \
    X(TUMBLE_STATE_VERIFY, "checking the result against gravity")                                                      \
    X(TUMBLE_STATE_PROPOSE, "offering the result")                                                                     \
    X(TUMBLE_STATE_DONE, "finished")                                                                                   \
    X(TUMBLE_STATE_FAULT, "stopped by a fault; can resume after a repair")                                             \
    X(TUMBLE_STATE_ABORT, "given up, table stopped")

#define TUMBLE_REASON_LIST(X)                                                                                          \
    X(TUMBLE_REASON_NONE, "nothing is wrong")                                                                          \
    X(TUMBLE_REASON_COMMAND, "aborted by command")                                                                     \
    X(TUMBLE_REASON_SCHEDULE, "the schedule is not valid or cannot identify the coefficients")                         \
    X(TUMBLE_REASON_CONFIGURATION, "the configuration is out of range")                                                \
    X(TUMBLE_REASON_STAND_OFFLINE, "the stand did not come up")                                                        \
    X(TUMBLE_REASON_STAND_HEARTBEAT, "the stand's heartbeat was lost")                                                 \
    X(TUMBLE_REASON_STAND_PROTOCOL, "the stand refused its configuration or broke the handshake")                      \
    X(TUMBLE_REASON_DRIVE_FAULT, "the drive reported a fault")                                                         \
    X(TUMBLE_REASON_DRIVE_POWER, "the drive lost power or was switched off")                                           \
    X(TUMBLE_REASON_STALL, "the axis did not follow its command")                                                      \
    X(TUMBLE_REASON_HOMING, "homing failed, took too long, turned too far or left a position that is not home")        \
    X(TUMBLE_REASON_TARGET_NOT_REACHED, "the table did not reach its target in time")                                  \
    X(TUMBLE_REASON_SLIP, "the table or the block left its position")                                                  \
    X(TUMBLE_REASON_CABLE_LIMIT, "the next position lies beyond the cable's limit")                                    \
    X(TUMBLE_REASON_BLOCK_HEARTBEAT, "the accelerometer block's heartbeat was lost")                                   \
    X(TUMBLE_REASON_NO_SAMPLES, "no samples arrive from the block")                                                    \
    X(TUMBLE_REASON_SAMPLES_LOST, "too many samples were lost")                                                        \
    X(TUMBLE_REASON_SAMPLES_CORRUPTED, "too many corrupted frames from the block")                                     \
    X(TUMBLE_REASON_BLOCK_STATUS, "the block reports a fault of its own")                                              \
    X(TUMBLE_REASON_SATURATED, "a channel is saturated")                                                               \
    X(TUMBLE_REASON_STUCK, "a channel repeats one value")                                                              \
    X(TUMBLE_REASON_NOT_STILL, "the scatter exceeds the declared noise")                                               \
    X(TUMBLE_REASON_WARM_UP, "the temperature did not settle in time")                                                 \
    X(TUMBLE_REASON_MOUNTING_NOT_CONFIRMED, "the operator did not confirm the mounting in time")                       \
    X(TUMBLE_REASON_WRONG_MOUNTING, "gravity points another way: wrong mounting, or wrong inclination")                \
    X(TUMBLE_REASON_SWAPPED_CHANNELS, "gravity appears on the wrong channels: channels are swapped or inverted")       \
    X(TUMBLE_REASON_SINGULAR, "the coefficients found cannot be inverted")                                             \
    X(TUMBLE_REASON_GRAVITY_CHECK, "the result fails the gravity check")                                               \
    X(TUMBLE_REASON_BUS, "the CAN controller is off the bus")                                                          \
    X(TUMBLE_REASON_UNCERTAIN, "a mean is too noisy for its budget even with the most samples allowed")                \
    X(TUMBLE_REASON_INHIBITED, "host or board does not allow a run now")                                               \
    X(TUMBLE_REASON_STOP_NOT_CONFIRMED, "the stop is not confirmed: check that the table is at rest")                  \
    X(TUMBLE_REASON_FOREIGN_COMMAND, "another node commands the drive, or has this computer's number")                 \
    X(TUMBLE_REASON_SUPERVISION, "heartbeats or process data do not monitor stand and block")                          \
    X(TUMBLE_REASON_RUNAWAY, "the table passed its target or turned backwards")                                        \
    X(TUMBLE_REASON_SCALE, "the reported speed is not the commanded one: check counts per turn and units")

typedef enum {
#define TUMBLE_STATE_ENUM(name, sentence) name,
    TUMBLE_STATE_LIST(TUMBLE_STATE_ENUM)
#undef TUMBLE_STATE_ENUM
        TUMBLE_STATE_COUNT
} tumble_state_t;

typedef enum {
#define TUMBLE_REASON_ENUM(name, sentence) name,
    TUMBLE_REASON_LIST(TUMBLE_REASON_ENUM)
#undef TUMBLE_REASON_ENUM
        TUMBLE_REASON_COUNT
} tumble_reason_t;

/* Name and sentence, as in tumble/status.h; safe for values outside the lists, never null. */
const char *tumble_state_name(tumble_state_t state);
const char *tumble_state_sentence(tumble_state_t state);
const char *tumble_reason_name(tumble_reason_t reason);
const char *tumble_reason_sentence(tumble_reason_t reason);

#endif
