/* internal.h - what the files of drive402 share (private to it).
 *
 *     drive402.c  what the node tells, time, the stand's functions
 *     phases.c    what happens in each phase, from the first heartbeat to a stop; the table of phases
 *     axis.c      angles and counts, words to and from the drive, which reports are believed, the ladder of a stop
 *     profile.c   the profile: is it usable, what to write into the drive, our own PDOs
 */
#ifndef TUMBLE_STAND_DRIVE402_INTERNAL_H
#define TUMBLE_STAND_DRIVE402_INTERNAL_H

#include "stand/drive402/drive402.h"

/* Their numbers travel over CAN (tumble_stand_step_t). */
typedef enum {
    PHASE_ABSENT = 0, /* no heartbeat; it is asked for one */
    PHASE_CONFIGURE,  /* objects are written by SDO */
    PHASE_START,      /* NMT start; waiting for its first transmit PDO */
    PHASE_POWER,      /* up to Operation enabled, then on to `wanted` */
    PHASE_IDLE,       /* enabled, at rest */
    PHASE_HOME_MODE,  /* changing to homing mode */
    PHASE_HOMING,
    PHASE_MOVE_MODE, /* changing back to profile position mode */
    PHASE_TARGET,    /* the target is sent and read back, bit 4 low */
    PHASE_SET_POINT, /* bit 4 high, waiting for bit 12 */
    PHASE_RELEASE,   /* bit 4 low again, waiting for bit 12 to fall */
    PHASE_MOVING,    /* waiting for target reached */
    PHASE_VERIFY,    /* before a motion: what it depends on is read back, and written again where it differs */
    PHASE_STOPPING,
    PHASE_STOPPED, /* at rest, maybe without power */
    PHASE_FAULT,
    PHASE_COUNT
} tumble_drive_phase_t;

/* tumble_drive402_t.asked */
enum { ASKED_NOTHING = 0, ASKED_WRITE, ASKED_READ, ASKED_START };

/* tumble_drive_row_t.watch: what is a fault while the phase lasts. */
enum {
    WATCH_POWER = 1, /* leaving Operation enabled */
    WATCH_MOTION = 2 /* bit 13, a following error */
};

typedef struct {
    void (*enter)(tumble_drive402_t *drive);
    void (*check)(tumble_drive402_t *drive);
    uint8_t timeout; /* where it stands in the profile; 0: none */
    uint8_t late;    /* tumble_stand_fault_t at the timeout */
    uint8_t state;   /* tumble_stand_state_t; of IDLE, STOPPED and POWER see drive_state in drive402.c */
    uint8_t watch;   /* WATCH_... */
} tumble_drive_row_t;

extern const tumble_drive_row_t tumble_drive_rows[PHASE_COUNT];

/* Enter a phase. */
void tumble_drive_go(tumble_drive402_t *drive, tumble_drive_phase_t phase);

/* Stop and wait for clear_fault. */
void tumble_drive_fail(tumble_drive402_t *drive, tumble_stand_fault_t fault);

/* Fail for an object that the drive has refused, or not shown in time: it is told with the phase. */
void tumble_drive_refused(tumble_drive402_t *drive, uint16_t index, uint8_t subindex, uint32_t abort);

/* Follow the phases as far as they lead by themselves. `fresh`: a statusword has just come. */
void tumble_drive_check(tumble_drive402_t *drive, bool fresh);

/* Have all process data that were asked for been handed to the port? */
bool tumble_drive_is_sent(const tumble_drive402_t *drive);

/* Must process data go out first? Notes it, so that the next step comes as soon as they are gone. */
bool tumble_drive_is_blocked(tumble_drive402_t *drive);

/* Set the controlword and ask for the process data to go. */
void tumble_drive_control(tumble_drive402_t *drive, unsigned word);

/* Is one of these bits set in the last statusword? */
bool tumble_drive_has(const tumble_drive402_t *drive, unsigned bits);

/* The ladder of a stop: begin to watch a stop (from the node's last time on); leave the ladder; is it being
 * climbed; when its next rung is due; climb. */
void tumble_drive_watch_stop(tumble_drive402_t *drive);
void tumble_drive_end_stop(tumble_drive402_t *drive);
bool tumble_drive_is_stopping(const tumble_drive402_t *drive);
uint64_t tumble_drive_next_rung_us(const tumble_drive402_t *drive);
void tumble_drive_climb(tumble_drive402_t *drive, uint64_t now_us);

/* The controlword by SDO, too. */
void tumble_drive_tell_by_sdo(tumble_drive402_t *drive);

/* Does the statusword that has just come, or a position that no longer changes, show the axis at rest after a stop?
 * Notes whether the drive obeys. */
bool tumble_drive_rests(tumble_drive402_t *drive);

/* A position has come: is it believed, and what follows from it. */
void tumble_drive_take_position(tumble_drive402_t *drive);

/* The position is unknown from now on; a drive that is led comes to FAULT with `fault`, an emergency message of `code`
 * tells of it. */
void tumble_drive_lose_position(tumble_drive402_t *drive, tumble_stand_fault_t fault, uint16_t code, uint16_t detail);

/* When the axis, if it turns, has been unseen for too long. */
uint64_t tumble_drive_blind_us(const tumble_drive402_t *drive);

/* Give up what is under way by SDO or NMT. */
void tumble_drive_leave_sdo(tumble_drive402_t *drive);

#define TUMBLE_DRIVE_HEARTBEAT 0x1017U /* of the drive: what it is to send */

/* The state of the power state machine in the last statusword, one of TUMBLE_402_STATE_... */
uint16_t tumble_drive_power_state(const tumble_drive402_t *drive);
bool tumble_drive_is_faulty(const tumble_drive402_t *drive);

/* Is the axis under power, so that it moves or brakes, or may? */
bool tumble_drive_may_turn(const tumble_drive402_t *drive);

/* Has the motion, or the stop, come to its end? */
bool tumble_drive_is_at_rest(const tumble_drive402_t *drive);

/* The configuration, one object after the other: false after the last. `write->size` 0: nothing to write at this step;
 * TUMBLE_DRIVE_READS: the value is to be read, and must be this one. */
#define TUMBLE_DRIVE_READS 0xFFU
bool tumble_drive_configuration(const tumble_drive402_t *drive, uint8_t step, tumble_object_write_t *write);

/* The step of the configuration at which what a motion depends on begins: speeds, accelerations, limits. They end where
 * the objects of the device profile end. */
uint8_t tumble_drive_first_of_motion(const tumble_drive402_t *drive);
#define TUMBLE_DRIVE_PROFILE_OBJECTS 0x6000U

/* Is this object (as in a mapping) in this PDO? */
bool tumble_drive_carries(const tumble_drive_pdo_t *pdo, uint32_t object);
#define TUMBLE_DRIVE_STATUS TUMBLE_MAP(TUMBLE_402_STATUSWORD, 0, 16)
#define TUMBLE_DRIVE_POSITION TUMBLE_MAP(TUMBLE_402_POSITION_ACTUAL, 0, 32)

/* Set up our own PDOs as the other end of the drive's. Before START those that command it stay invalid. False: the
 * dictionary cannot take them. */
bool tumble_drive_map_own(const tumble_drive402_t *drive);

/* Units. False: beyond what the drive can express. */
bool tumble_drive_counts(const tumble_drive_profile_t *profile, double angle_deg, int64_t *counts);
double tumble_drive_angle_deg(const tumble_drive_profile_t *profile, int64_t counts);

/* A way in counts, whatever its direction, and at least one; limited to 32 bits. */
uint32_t tumble_drive_way(const tumble_drive_profile_t *profile, double way_deg);

/* A position as the drive writes it: itself, or within 0 to wrap_counts - 1. */
int32_t tumble_drive_wrapped(const tumble_drive_profile_t *profile, int64_t counts);

/* The unwrapped position nearest to `before` that the drive reports as `raw`. */
int64_t tumble_drive_unwrapped(const tumble_drive_profile_t *profile, int32_t raw, int64_t before);

#endif
