/* stand.h - the rotary stand as the procedure sees it: turn, wait, ask.
 *
 * A stand is a const table of functions and the object they work on. No function waits: home and move start an
 * action, `state` tells how far it has come. Angles are degrees of the table, counted from the home position, over
 * as many turns as the cable allows; they are the schedule's angles and not counts of an encoder.
 *
 * Behind it: drive402.h (a CiA 402 drive in profile position mode) or operator.h (a person at a dividing head).
 */
#ifndef TUMBLE_STAND_STAND_H
#define TUMBLE_STAND_STAND_H

#include "tumble/status.h"

#include <stdint.h>

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
    TUMBLE_STAND_FAULT_DRIVE,       /* the drive reports a fault; fault_code holds its own code */
    TUMBLE_STAND_FAULT_STALL,       /* following error: the axis does not follow its command */
    TUMBLE_STAND_FAULT_HEARTBEAT,   /* the drive has fallen silent */
    TUMBLE_STAND_FAULT_HOMING,      /* homing failed */
    TUMBLE_STAND_FAULT_PROTOCOL,    /* refused or unanswered configuration, broken handshake */
    TUMBLE_STAND_FAULT_POWER,       /* the drive left Operation enabled by itself */
    TUMBLE_STAND_FAULT_TIMEOUT,     /* the angle was not reached, or not confirmed, in the stand's own time */
    TUMBLE_STAND_FAULT_STOP,        /* the axis was told to stop and was not seen to rest */
    TUMBLE_STAND_FAULT_POSITION,    /* the position jumped, or changed at rest: it is unknown now */
    TUMBLE_STAND_FAULT_FOREIGN      /* somebody else commands the axis, or has our node number */
} tumble_stand_fault_t;

typedef struct {
    void *self;

    /* Start homing. TUMBLE_OK, or TUMBLE_E_STAND_STATE when the state does not allow it (offline, moving, fault). */
    tumble_status_t (*home)(void *self);

    /* Start a move to an absolute angle. TUMBLE_OK, TUMBLE_E_STAND_STATE, TUMBLE_E_ARGUMENT (beyond what the drive's
     * position can express). */
    tumble_status_t (*move)(void *self, double angle_deg);

    /* Stop the axis as fast as the drive allows, whatever the state. Never refused. The stand goes on until the axis is
     * seen at rest: STOPPED, or FAULT (with TUMBLE_STAND_FAULT_STOP when it had to take harsher means). */
    void (*stop)(void *self);

    /* Begin to leave FAULT, towards READY or STOPPED. TUMBLE_OK; TUMBLE_E_STAND_STATE: not in FAULT, or a stop is still
     * being enforced, which takes seconds at most: ask again. */
    tumble_status_t (*clear_fault)(void *self);

    tumble_stand_state_t (*state)(void *self);
    tumble_stand_fault_t (*fault)(void *self);
    uint16_t (*fault_code)(void *self); /* the drive's own error code (EMCY), 0 if none */
    double (*angle_deg)(void *self);    /* actual angle, last reported */
} tumble_stand_t;

#endif
