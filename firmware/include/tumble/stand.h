/* tumble/stand.h - the rotary stand as the rest of the firmware sees it, and how to write a stand of your own.
 *
 * A stand is a kind, a const table of functions, and the object that they work on. No function waits: home and move
 * start an action, `state` reports its progress. Angles are degrees of the table, counted from the home position,
 * over as many turns as the cable allows; they are the schedule's angles and not counts of an encoder.
 *
 * Three kinds come with Tumble: &tumble_drive402_kind, a CiA 402 drive in profile position mode,
 * &tumble_operator_kind, a person at a dividing head, and &tumble_positioner_kind, a motor controller with Modbus
 * registers (docs/porting.md). A stand of your own is a folder with a header that declares its
 * object, its profile and its kind; name them in the computer's tumble_navcomp_config_t. Nothing else in the firmware
 * asks of what kind a stand is.
 *
 * The shortest program, a table that reaches any target immediately:
 *
 *     #include <stddef.h>
 *     typedef struct { tumble_stand_report_t report; double angle_deg; uint8_t state; } table_t;
 *     static tumble_status_t table_init(void *self, const tumble_stand_setup_t *setup)
 *     {
 *         (void)setup;
 *         ((table_t *)self)->state = TUMBLE_STAND_READY;
 *         return TUMBLE_OK;
 *     }
 *     static void table_step(void *self, uint64_t now_us) { (void)self; (void)now_us; }
 *     static uint64_t table_next_us(const void *self) { (void)self; return UINT64_MAX; }
 *     static tumble_status_t table_move(void *self, double angle_deg)
 *     {
 *         ((table_t *)self)->angle_deg = angle_deg;
 *         ((table_t *)self)->state = TUMBLE_STAND_IN_POSITION;
 *         return TUMBLE_OK;
 *     }
 *     static tumble_status_t table_home(void *self) { return table_move(self, 0.0); }
 *     static void table_stop(void *self) { (void)self; }
 *     static tumble_status_t table_clear_fault(void *self) { (void)self; return TUMBLE_E_STAND_STATE; }
 *     static tumble_stand_state_t table_state(const void *self)
 *     {
 *         return (tumble_stand_state_t)((const table_t *)self)->state;
 *     }
 *     static tumble_stand_fault_t table_fault(const void *self) { (void)self; return TUMBLE_STAND_FAULT_NONE; }
 *     static double table_angle_deg(const void *self) { return ((const table_t *)self)->angle_deg; }
 *
 *     const tumble_stand_kind_t table_kind = {
 *         .bytes = sizeof(table_t), .report_at = offsetof(table_t, report), TUMBLE_STAND_FUNCTIONS(table),
 *     };
 *     static table_t table;
 *     tumble_stand_t stand = {&table_kind, &table}; // as a navcomp makes it of .stand and .stand_memory
 *
 * navcomp calls these functions from its own, never two at the same time on one object. They may use the node that they
 * were given (trigger its PDOs, use its SDO client, queue NMT commands, raise emergencies), but must not step it.
 */
#ifndef TUMBLE_STAND_H
#define TUMBLE_STAND_H

#include "tumble/status.h"

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" { /* for those of canopen as well */
#endif

#include "canopen/cia402.h"
#include "canopen/node.h"

/* ---- The reports of a stand. */

typedef enum {
    TUMBLE_STAND_OFFLINE = 0, /* no contact yet, or contact lost */
    TUMBLE_STAND_READY,       /* in contact, powered, not homed */
    TUMBLE_STAND_HOMING,
    TUMBLE_STAND_MOVING,
    TUMBLE_STAND_IN_POSITION, /* at rest at the last commanded angle (after homing: at home); never believed too early:
                               * from the moment that move or home returns, the old position does not count */
    TUMBLE_STAND_STOPPED,     /* at rest after stop; position known */
    TUMBLE_STAND_FAULT        /* see fault; leaves by clear_fault */
} tumble_stand_state_t;

typedef enum {
    TUMBLE_STAND_FAULT_NONE = 0,
    TUMBLE_STAND_FAULT_DRIVE,     /* the drive reports a fault; report.fault_code holds its own code */
    TUMBLE_STAND_FAULT_STALL,     /* following error: the axis does not follow its command */
    TUMBLE_STAND_FAULT_HEARTBEAT, /* the drive has fallen silent */
    TUMBLE_STAND_FAULT_HOMING,    /* homing failed */
    TUMBLE_STAND_FAULT_PROTOCOL,  /* refused or unanswered configuration, broken handshake */
    TUMBLE_STAND_FAULT_POWER,     /* the drive left Operation enabled by itself */
    TUMBLE_STAND_FAULT_TIMEOUT,   /* the angle was not reached, or not confirmed, in the stand's own time */
    TUMBLE_STAND_FAULT_STOP,      /* the axis was commanded to stop and not seen at rest */
    TUMBLE_STAND_FAULT_POSITION,  /* the position jumped, or changed at rest: it is unknown now */
    TUMBLE_STAND_FAULT_FOREIGN,   /* another node commands the axis, or has our node number */
    TUMBLE_STAND_FAULT_RUNAWAY,   /* it turned past its goal, or the other way */
    TUMBLE_STAND_FAULT_SCALE      /* it turns at a speed other than commanded: counts of a turn, or units, are wrong */
} tumble_stand_fault_t;

/* The rungs of a stop: by which means the axis is commanded. The numbers travel over CAN: new ones go to the end. */
typedef enum {
    TUMBLE_RUNG_NONE = 0, /* no stop is under way */
    TUMBLE_RUNG_TOLD,     /* once */
    TUMBLE_RUNG_AGAIN,
    TUMBLE_RUNG_SDO,
    TUMBLE_RUNG_NMT,
    TUMBLE_RUNG_SILENCE,
    TUMBLE_RUNG_UNCONFIRMED
} tumble_stop_rung_t;

/* How far stops had to go, and how many reports were not believed; monotonic, they stop at UINT32_MAX. */
typedef struct {
    uint32_t rungs[TUMBLE_RUNG_UNCONFIRMED - TUMBLE_RUNG_TOLD]; /* how often each was climbed to, from AGAIN on */
    uint32_t implausible;                                       /* position reports that were not believed */
} tumble_stop_counters_t;

/* What a drive was being asked for when it refused, or did not do it in time. The numbers travel over CAN: they don't
 * change. Y(number, name, what) */
#define TUMBLE_STAND_STEP_LIST(Y)                                                                                      \
    Y(0, CONTACT, "first contact")                                                                                     \
    Y(1, CONFIGURATION, "configuration")                                                                               \
    Y(2, START, "the first process data after NMT start")                                                              \
    Y(3, POWER, "the way up to Operation enabled")                                                                     \
    Y(5, HOMING_MODE, "the change to homing mode")                                                                     \
    Y(6, HOMING, "homing")                                                                                             \
    Y(7, POSITION_MODE, "the change to profile position mode")                                                         \
    Y(8, TARGET, "the target, before the set-point")                                                                   \
    Y(9, SET_POINT, "the set-point: bit 12 after bit 4 was set")                                                       \
    Y(10, RELEASE, "the set-point: bit 12 after bit 4 was cleared")                                                    \
    Y(11, MOTION, "the motion")                                                                                        \
    Y(12, VERIFY, "what a motion depends on, read back before it")

typedef enum {
#define TUMBLE_STAND_STEP(number, name, what) TUMBLE_STAND_STEP_##name = (number),
    TUMBLE_STAND_STEP_LIST(TUMBLE_STAND_STEP)
#undef TUMBLE_STAND_STEP
        TUMBLE_STAND_STEPS = 13
} tumble_stand_step_t;

/* What the stand refused, or did not do in time. */
typedef struct {
    uint16_t index; /* 0: nothing. Of a handshake: the object that did not show what was waited for */
    uint8_t subindex;
    uint8_t step; /* tumble_stand_step_t */
    uint32_t
        abort; /* the SDO abort code; TUMBLE_ABORT_TIMEOUT when it did not answer, or a handshake ran out of time */
} tumble_stand_refusal_t;

/* The motion that the axis makes now, for the bounds of its time and its progress. count_mdeg 0: it has not set out, or
 * the kind does not tell. */
typedef struct {
    uint32_t speed_mdeg_s; /* steady; in homing the faster one; 0: not known */
    uint32_t slow_mdeg_s;  /* in homing the slower one; 0: not known */
    uint16_t ramp_ms;      /* what starting and braking add to way / speed; 0: not known */
    uint16_t count_mdeg;   /* what reports may flicker by */
    int32_t to_mdeg;       /* where it ends; in homing how far it may turn in all, back and forth added up */
} tumble_stand_motion_t;

/* What is watched of a motion: private to stand/bounds.h. */
typedef struct {
    int32_t lowest_mdeg; /* where the reported angle may be */
    int32_t highest_mdeg;
    int32_t goal_mdeg;
    int32_t from_mdeg;     /* at the last look at its speed, */
    int32_t progress_mdeg; /* and at the last progress */
    uint32_t due;          /* when it should have ended, in units of 1024 us, as `looked` */
    uint32_t looked;       /* the last look at its speed, */
    uint32_t progressed;   /* and the last progress */
    uint32_t speed_mdeg_s; /* of the first of the looks that agree */
    uint8_t looks;         /* so many in a row agree */
    uint8_t fault;         /* tumble_stand_fault_t: it was given up */
    bool moves;
    bool homes;
    bool set_out;
    bool lost; /* its position is unknown until it is homed */
} tumble_motion_bounds_t;

/* The report of a stand, without a function call: a part of its object. Zeros: nothing to report. */
typedef struct {
    double asked_deg;               /* with `asks`: the angle, 0 for homing */
    tumble_stand_refusal_t refusal; /* what led to TUMBLE_STAND_FAULT_PROTOCOL */
    tumble_stop_counters_t stop;
    tumble_stand_motion_t motion;
    tumble_motion_bounds_t bounds; /* not the kind's: it only stands here */
    uint16_t fault_code;           /* the drive's own error code (EMCY) */
    bool asks;                     /* a person is to turn the head and to confirm */
    bool limited; /* the drive itself keeps to the cable's limits: they have been written and read back */
    uint8_t rung; /* tumble_stop_rung_t: how far a stop under way has gone; CLEAR_FAULT waits for its end */
} tumble_stand_report_t;

/* ---- What a stand is. */

/* What a stand is given to work with. */
typedef struct {
    const void *profile;           /* the kind's own configuration, const; outlives the object */
    tumble_node_t *node;           /* ours, initialised, watching `stand_node` (1016h) */
    tumble_drive_mirror_t *mirror; /* what the node's dictionary shows of a drive at 2040h, for its PDOs */
    double cable_min_deg;          /* the table may turn from here ... */
    double cable_max_deg;          /* ... to here */
    uint8_t stand_node;            /* 0: it is not on the bus */
} tumble_stand_setup_t;

/* A number of a profile that must not change in a run: if it has changed, a run that lost power is not resumed. */
typedef enum {
    TUMBLE_STAND_NUMBER_NONE = 0, /* no more of them */
    TUMBLE_STAND_NUMBER_F64,
    TUMBLE_STAND_NUMBER_I8
} tumble_stand_number_type_t;

typedef struct {
    uint8_t type; /* tumble_stand_number_type_t */
    uint8_t at;   /* its offset in the profile */
} tumble_stand_number_t;

#define TUMBLE_STAND_NUMBERS 3U

/* A kind of stand. No function may be null unless its comment says so. */
typedef struct {
    uint16_t bytes;     /* size of its object, which the caller of tumble_navcomp_init owns */
    uint16_t report_at; /* where in it the report stands */

    /* The numbers of the profile that decide where an angle is. */
    tumble_stand_number_t numbers[TUMBLE_STAND_NUMBERS];

    /* Get ready, at power-on (the object is all zero) and after every NMT reset of our node (the object is unchanged:
     * counters go on).
     * Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT: a profile or a node number that this kind cannot work with. */
    tumble_status_t (*init)(void *self, const tumble_stand_setup_t *setup);

    /* Go on and watch the time. Called after every frame and when next_us is over, before the node's own step, which
     * sends what this one has prepared. */
    void (*step)(void *self, uint64_t now_us);

    /* The next moment at which step has something to do by itself; 0: at once; UINT64_MAX: never. */
    uint64_t (*next_us)(const void *self);

    /* Start homing.
     * Returns TUMBLE_OK, or TUMBLE_E_STAND_STATE when the state does not allow it (offline, moving, fault). */
    tumble_status_t (*home)(void *self);

    /* Start a move to an absolute angle.
     * Returns TUMBLE_OK, TUMBLE_E_STAND_STATE (as home), TUMBLE_E_ARGUMENT (beyond what the stand's position can
     * express). */
    tumble_status_t (*move)(void *self, double angle_deg);

    /* Stop the axis as fast as the drive allows, whatever the state. Never refused. The stand goes on until the axis is
     * seen at rest: STOPPED, or FAULT (with TUMBLE_STAND_FAULT_STOP when it had to take harsher means). */
    void (*stop)(void *self);

    /* Begin to leave FAULT, towards READY or STOPPED.
     * Returns TUMBLE_OK, or TUMBLE_E_STAND_STATE: not in FAULT, or a stop is still being enforced, which takes seconds
     * at most: ask again. */
    tumble_status_t (*clear_fault)(void *self);

    /* The person says that the head stands at this angle. Called only while report.asks is set; null in a kind that
     * never sets it.
     * Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT: it is not the angle asked for (the request stands). */
    tumble_status_t (*confirm)(void *self, double angle_deg);

    tumble_stand_state_t (*state)(const void *self);
    tumble_stand_fault_t (*fault)(const void *self);
    double (*angle_deg)(const void *self); /* actual angle, last reported */

    /* The rest is for a kind that is on the bus, where stand_node must not be 0; in other kinds all of it is null. */

    /* Is a drive present? Then other nodes may not change objects that its stop depends on. */
    bool (*is_present)(const void *self);

    /* The node has received a heartbeat event, or an emergency message, of stand_node. */
    void (*heartbeat)(void *self, tumble_heartbeat_event_t event, tumble_nmt_state_t state);
    void (*emergency)(void *self, const tumble_emergency_t *message);

    /* Our receive PDO with this number (0 is 1400h) has been written, by any sender. */
    void (*pdo_received)(void *self, uint8_t number);

    /* A frame with this identifier has come that is no service of our node. `ours`: only our node may send it.
     * Returns true if `ours`, or if it is a frame by which we command the stand: then somebody else commands the
     * axis. */
    bool (*foreign)(void *self, uint16_t id, bool ours);
} tumble_stand_kind_t;

/* For the initialiser of a kind: the functions that every kind must have, each named `name`_ and then as its member. */
#define TUMBLE_STAND_FUNCTIONS(name)                                                                                   \
    .init = name##_init, .step = name##_step, .next_us = name##_next_us, .home = name##_home, .move = name##_move,     \
    .stop = name##_stop, .clear_fault = name##_clear_fault, .state = name##_state, .fault = name##_fault,              \
    .angle_deg = name##_angle_deg

typedef struct {
    const tumble_stand_kind_t *kind;
    void *self;
} tumble_stand_t;

/* The numbers of a profile that decide where an angle is. `numbers` has room for TUMBLE_STAND_NUMBERS; returns how many
 * were written. */
uint8_t tumble_stand_numbers(const tumble_stand_kind_t *kind, const void *profile, double *numbers);

static inline const tumble_stand_report_t *tumble_stand_report(const tumble_stand_t *stand)
{
    const void *report = (const uint8_t *)stand->self + stand->kind->report_at;
    return (const tumble_stand_report_t *)report;
}

#ifdef __cplusplus
}
#endif

#endif
