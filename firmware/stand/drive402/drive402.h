/* drive402.h - a CiA 402 drive in profile position mode as the stand's axis: the master's side.
 *
 * It lives on a canopen node (ours). It writes the drive's configuration by SDO, starts the drive by NMT, leads it
 * through its statusword up to Operation enabled, homes and moves it through process data, and watches it. A const
 * profile holds what differs from maker to maker. Everything goes on in steps; nothing waits; every phase has a bounded
 * time.
 *
 * What happens to the axis follows from received frames and their order; the clock drives timeouts alone.
 *
 * The caller owns the object, one per drive. Not re-entrant on one object. The node's first TUMBLE_DRIVE402_PDOS transmit
 * and receive PDOs belong to the drive, as many of them as the profile has, and so does the node's SDO client while
 * it is busy here. The node's dictionary holds the drive's objects in 2040h: controlword, target, mode, statusword,
 * actual position, mode display, velocity, error code, as subindices 1 to 8, at home in the mirror.
 *
 * The life of a drive: it is absent until its heartbeat is heard; then it is configured, started and powered up, and is
 * READY. A drive that is found under power is stopped first, and powered up by the next home or move. Until it has
 * homed, moves are refused. If its heartbeat, its power or its configuration is lost, that is a fault until
 * clear_fault, which does all of this again and resets a fault of the drive's own. A drive that has booted, was
 * switched off, or was seen in another NMT state than Operational must be homed again.
 *
 * A stop is over when the axis is seen at rest. Until then the drive is told again, by harsher means from rung to rung;
 * each rung raises TUMBLE_EMCY_STOP and is counted. The times count from the stop, or from the end of stop_timeout_ms
 * if the drive has been seen to obey:
 *
 *     at once   process data     controlword, and again at every report that still shows Operation enabled
 *     0.2 s     process data     again, unasked
 *     0.4 s     SDO              6040h
 *     1.0 s     NMT stop         of the drive: CiA 402 stops an axis that leaves Operational
 *     1.5 s     silence          our own heartbeat is withheld, so that the drive's consumer (1016h) stops the axis
 *     later     not confirmed    nothing is left to try: somebody must look at the table
 *
 * A position is believed when it can have been reached since the last one, at twice profile velocity (and a quarter of
 * a second more in all, for reports that waited). One report that is not believed is dropped; a second in a row, or an axis
 * that strays at rest, makes the position unknown: a fault, and the axis must be homed again.
 */
#ifndef TUMBLE_STAND_DRIVE402_H
#define TUMBLE_STAND_DRIVE402_H

#include "canopen/cia402.h"
#include "canopen/node.h"
#include "tumble/stand.h"
#include "tumble/status.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_DRIVE402_PDOS 2U        /* most of each direction */
#define TUMBLE_DRIVE402_MIRROR 0x2040U /* where the node's dictionary holds the drive's objects */

/* Emergency messages that it raises on the node (bit PROFILE of the error register). */
#define TUMBLE_EMCY_STOP 0xFF10U     /* info[0]: tumble_stop_rung_t */
#define TUMBLE_EMCY_POSITION 0xFF11U /* the position is unknown now */
#define TUMBLE_EMCY_FOREIGN 0xFF12U  /* info[0] and [1]: the identifier, low byte first */

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

    /* Motion, written at configuration; what is 0 is left as the drive has it, which need not have the object. */
    double velocity_deg_s;
    double acceleration_deg_s2;
    double deceleration_deg_s2;
    double quick_stop_deg_s2;
    double homing_fast_deg_s;
    double homing_slow_deg_s;
    double homing_acceleration_deg_s2;
    int8_t homing_method;     /* 6098h; 0: left as the drive has it */
    uint8_t stop;             /* tumble_drive_stop_t */
    bool software_limits;     /* it has 607Dh and keeps to it: the cable's limits are written there and read back. Not
                               * used where positions wrap */
    double homing_travel_deg; /* the table may turn so far in one homing; 0: the cable's span and one turn */

    /* The bus. The drive's receive PDOs, one or two, must carry 6040h and 607Ah, and may carry 6060h; its transmit
     * PDOs, one or two, must carry 6041h and 6064h, and may carry what else they like (8, 16 or 32 bits each). Give
     * the one with 6041h an event timer. Their identifiers are all different, within 181h to 57Fh, where CiA 301 has
     * nothing but PDOs, and not 180h + our node. 607Ah is read back by SDO before every set-point. */
    const tumble_drive_pdo_t *receive;
    const tumble_drive_pdo_t *transmit;
    uint8_t receive_count;
    uint8_t transmit_count;
    uint8_t write_count;
    const tumble_object_write_t *writes; /* further objects, written first; null with write_count 0 */
    uint16_t heartbeat_ms;               /* 1017h of the drive; 0: left, it sends a heartbeat by itself */
    uint16_t heartbeat_timeout_ms; /* 1016h:1 of the drive: our silence after which it must stop; 0: not written */

    /* Bounds, all above 0. */
    uint32_t start_timeout_ms;     /* NMT start to the first transmit PDO */
    uint32_t power_timeout_ms;     /* from there to Operation enabled */
    uint32_t handshake_timeout_ms; /* of a mode change or a set-point */
    uint32_t home_timeout_ms;
    uint32_t move_timeout_ms;
    uint32_t stop_timeout_ms;

    /* Habits. */
    bool keeps_pdos;            /* its PDOs cannot be written: they are read, and must be as they are given here */
    bool acknowledges_enabling; /* bit 12 is set from Operation enabled on, and its first set-point clears it */
} tumble_drive_profile_t;

/* The object; its fields are private. */
typedef struct {
    uint8_t drive_node;
    uint8_t phase;
    uint8_t write;  /* next step of the configuration */
    uint8_t fault;  /* tumble_stand_fault_t */
    uint8_t wanted; /* phase to go to when powered */
    uint8_t stale;  /* statuswords that may be from before homing began */
    uint8_t asked;  /* what is under way by SDO or NMT */
    uint8_t still;  /* how often in a row the same position has been reported again */
    bool restart_timer;
    bool blocked;   /* a PDO must go before anything else */
    bool present;   /* its heartbeat is there */
    bool may_reset; /* a fault of the drive may be reset */
    bool homed;
    bool arrived;     /* at home or at the goal; */
    bool at_goal;     /* the latter, so that target reached must stay */
    bool begun;       /* a stop: the drive has been seen to obey */
    bool timed;       /* its reports come by a timer, too, also while nothing changes */
    bool tracked;     /* actual_counts is what the next report is compared with */
    bool settled;     /* at rest long enough for `strayed` to count */
    bool falls;       /* bit 12 will acknowledge this set-point by falling */
    bool placed;      /* a position has come since the statusword showed target reached */
    bool fresh;       /* a statusword has just come */
    uint8_t rung;     /* tumble_stop_rung_t: how far a stop has gone */
    uint8_t doubtful; /* reports in a row that were not believed */
    const tumble_drive_profile_t *profile;
    tumble_node_t *node;
    tumble_drive_mirror_t *mirror;
    uint64_t entered_us;
    uint64_t told_us;       /* when the stop under way began */
    uint64_t reported_us;   /* last position, or the begin of a motion if later */
    int64_t actual_counts;  /* unwrapped */
    int64_t goal_counts;    /* of the move under way */
    int64_t set_counts;     /* of its present set-point; the goal but for long ways of a wrapping drive */
    int32_t strayed;        /* counts since it settled */
    uint32_t travel;        /* counts turned in this homing, back and forth added up */
    uint32_t homing_counts; /* the most of that; 0: no bound */
    uint32_t counts_per_s;  /* at profile velocity */
    uint32_t spare_counts;  /* of the way that reports may still jump */
    uint32_t rest_counts;   /* an axis at rest may stray so far */
    int32_t low_counts;     /* software limits; both 0: none */
    int32_t high_counts;
    tumble_stand_report_t report; /* fault_code is that of the last emergency message */
} tumble_drive402_t;

/* Is a profile usable on the bus of our node? Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_drive402_validate(const tumble_drive_profile_t *profile, uint8_t node);

/* The kind: its object is a tumble_drive402_t, its profile a tumble_drive_profile_t. Its init sets up the node's own
 * PDOs and leaves the drive absent; it refuses a profile or a node number that is not usable, and a mapping that the
 * node's dictionary cannot take. The cable's limits decide how far homing may turn and what is written to 607Dh. Once
 * the drive is led, a foreign frame stops the axis: a fault, and its position is unknown. */
extern const tumble_stand_kind_t tumble_drive402_kind;

#endif
