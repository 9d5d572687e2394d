/* drive402.h - a CiA 402 drive in profile position mode as the stand's axis: the master's side.
 *
 * It lives on a canopen node (ours): writes the drive's configuration by SDO, starts it by NMT, leads it through its
 * statusword up to Operation enabled, homes and moves it through process data, and watches it. What differs from
 * maker to maker stands in a const profile. Everything goes on in steps; nothing waits; every phase has a bounded
 * time.
 *
 * What happens to the axis follows from received frames and their order; the clock drives timeouts alone.
 *
 * The caller owns the object, one per drive, and calls the four functions that take what the node tells: heartbeat,
 * emergency, pdo_received, and step. Not re-entrant on one object. The node's first TUMBLE_DRIVE402_PDOS transmit
 * and receive PDOs belong to the drive, as many of them as the profile has, and so does the node's SDO client while
 * it is busy here. The node's dictionary holds the drive's objects in 2040h: controlword, target, mode, statusword,
 * actual position, mode display, velocity, error code, as subindices 1 to 8, at home in the mirror.
 *
 * The life of a drive: absent; heartbeat heard: configure, start, power up: READY. One that is found under power is
 * stopped first, and powered up by the next home or move. Not homed after power-on: moves are refused until homing.
 * Losing its heartbeat, its power or its configuration is a fault until clear_fault, which does it all again and resets
 * a fault of the drive's own. A drive that has booted, was switched off, or was seen in another NMT state than
 * Operational must be homed again.
 */
#ifndef TUMBLE_STAND_DRIVE402_H
#define TUMBLE_STAND_DRIVE402_H

#include "canopen/cia402.h"
#include "canopen/node.h"
#include "core/status.h"
#include "stand/stand.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_DRIVE402_PDOS 2U        /* most of each direction */
#define TUMBLE_DRIVE402_MIRROR 0x2040U /* where the node's dictionary holds the drive's objects */

/* One object to be written into the drive. */
typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size; /* 1, 2 or 4 bytes */
    uint32_t value;
} tumble_drive_write_t;

/* One PDO of the drive, in the drive's own objects. `number` 0 is 1400h or 1800h. */
typedef struct {
    uint8_t number;
    tumble_pdo_setup_t setup;
} tumble_drive_pdo_t;

typedef enum {
    TUMBLE_STOP_BY_QUICK_STOP = 0, /* controlword 0002h */
    TUMBLE_STOP_BY_HALT            /* bit 8 */
} tumble_drive_stop_t;

typedef struct {
    /* Units: drive units per degree of the table and its time derivatives, gears included. */
    double counts_per_revolution;         /* of the table; above 0, need not be whole */
    double velocity_units_per_deg_s;      /* above 0 */
    double acceleration_units_per_deg_s2; /* above 0 */
    int8_t sign;                          /* +1, or -1: positive counts turn the table down */
    uint32_t wrap_counts;   /* 6064h and 607Ah count modulo this, the drive takes the shorter way; 0: they don't wrap */
    uint32_t window_counts; /* target reached is believed within this distance only; 0: always */

    /* Motion, written at configuration; what is 0 is left as the drive has it. */
    double velocity_deg_s;
    double acceleration_deg_s2;
    double deceleration_deg_s2;
    double quick_stop_deg_s2;
    double homing_fast_deg_s;
    double homing_slow_deg_s;
    double homing_acceleration_deg_s2;
    int8_t homing_method;
    uint8_t stop; /* tumble_drive_stop_t */

    /* The bus. The drive's receive PDOs, one or two, must carry 6040h and 607Ah, and may carry 6060h; its transmit
     * PDOs, one or two, must carry 6041h and 6064h, and may carry what else they like (8, 16 or 32 bits each). Give
     * the one with 6041h an event timer. Their identifiers are all different, within 181h to 57Fh, where CiA 301 has
     * nothing but PDOs, and not 180h + our node. 607Ah is read back by SDO before every set-point. */
    const tumble_drive_pdo_t *receive;
    const tumble_drive_pdo_t *transmit;
    uint8_t receive_count;
    uint8_t transmit_count;
    uint8_t write_count;
    const tumble_drive_write_t *writes; /* further objects, written first; null with write_count 0 */
    uint16_t heartbeat_ms;         /* 1017h of the drive; above 0 */
    uint16_t heartbeat_timeout_ms; /* 1016h:1 of the drive: our silence after which it must stop; 0: not written */

    /* Bounds, all above 0. */
    uint32_t start_timeout_ms;     /* NMT start to the first transmit PDO */
    uint32_t power_timeout_ms;     /* from there to Operation enabled */
    uint32_t handshake_timeout_ms; /* of a mode change or a set-point */
    uint32_t home_timeout_ms;
    uint32_t move_timeout_ms;
    uint32_t stop_timeout_ms;
} tumble_drive_profile_t;

/* What the drive refused of its configuration. */
typedef struct {
    uint16_t index; /* 0: nothing */
    uint8_t subindex;
    uint32_t abort; /* the SDO abort code; TUMBLE_ABORT_TIMEOUT when it did not answer */
} tumble_drive_refusal_t;

/* The object; its fields are private. */
typedef struct {
    uint8_t drive_node;
    uint8_t phase;
    uint8_t write;         /* next step of the configuration */
    uint8_t fault;         /* tumble_stand_fault_t */
    uint8_t wanted;        /* phase to go to when powered */
    uint8_t stale;         /* statuswords that may be from before homing began */
    uint8_t asked;         /* what is under way by SDO or NMT */
    uint8_t still;         /* how often in a row the same position has been reported again */
    bool restart_timer;
    bool blocked;          /* a PDO must go before anything else */
    bool present;          /* its heartbeat is there */
    bool may_reset;        /* a fault of the drive may be reset */
    bool homed;
    bool arrived;          /* at home or at the goal; */
    bool at_goal;          /* the latter, so that target reached must stay */
    uint16_t code;         /* of the last emergency message */
    const tumble_drive_profile_t *profile;
    tumble_node_t *node;
    tumble_drive_mirror_t *mirror;
    uint64_t entered_us;
    int64_t actual_counts; /* unwrapped */
    int64_t goal_counts;   /* of the move under way */
    int64_t set_counts;    /* of its present set-point; the goal but for long ways of a wrapping drive */
    tumble_drive_refusal_t refusal;
} tumble_drive402_t;

/* Is a profile usable on the bus of our node? Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_drive402_validate(const tumble_drive_profile_t *profile, uint8_t node);

/* Get ready, absent. `node` must be initialised and watch `drive_node` (1016h); `mirror` is the memory of its
 * objects for the drive. Sets up the node's own PDOs. Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT (null, profile, node
 * number, or a mapping that the node's dictionary cannot take). */
tumble_status_t tumble_drive402_init(tumble_drive402_t *drive, const tumble_drive_profile_t *profile,
                                     tumble_node_t *node, tumble_drive_mirror_t *mirror, uint8_t drive_node);

/* What the node tells: call them from its events; heartbeat and emergency for this drive's node only, pdo_received for
 * every PDO of ours with its number. */
void tumble_drive402_heartbeat(tumble_drive402_t *drive, tumble_heartbeat_event_t event, tumble_nmt_state_t state);
void tumble_drive402_emergency(tumble_drive402_t *drive, const tumble_emergency_t *emergency);
void tumble_drive402_pdo_received(tumble_drive402_t *drive, uint8_t number);

/* Go on, watch the time. Before the node's own step, which sends what this one has prepared. */
void tumble_drive402_step(tumble_drive402_t *drive, uint64_t now_us);

/* The next moment at which step has something to do by itself; 0: at once; TUMBLE_NEVER. */
uint64_t tumble_drive402_next_us(const tumble_drive402_t *drive);

/* The drive as a stand. The table holds the object's address. */
tumble_stand_t tumble_drive402_stand(tumble_drive402_t *drive);

/* What was refused when it came to FAULT with TUMBLE_STAND_FAULT_PROTOCOL; zeros otherwise. */
tumble_drive_refusal_t tumble_drive402_refusal(const tumble_drive402_t *drive);

#endif
