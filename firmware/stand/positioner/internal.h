/* internal.h - what the files of positioner share (private to it).
 *
 *     positioner.c  time, the exchange, the stand's functions
 *     report.c      what follows from what the controller reports
 *     orders.c      what it is ordered: the ground, on which both stand
 */
#ifndef TUMBLE_STAND_POSITIONER_INTERNAL_H
#define TUMBLE_STAND_POSITIONER_INTERNAL_H

#include "stand/positioner/positioner.h"

enum { ORDER_STOP = 0, ORDER_HOME, ORDER_GO, ORDER_RESET };
enum { READ_IDENTITY = 0, READ_STATUS, READ_NUMBER, READ_FAULT, READ_ANGLE, READ_ANGLE_LOW, READ_COUNT };

static inline bool is(const tumble_positioner_t *axis, tumble_stand_state_t state)
{
    return axis->state == (uint8_t)state;
}

static inline int64_t distance(int64_t a, int64_t b)
{
    return (a > b) ? (a - b) : (b - a);
}

static inline bool is_stopping(const tumble_positioner_t *axis)
{
    return axis->rung != (uint8_t)TUMBLE_RUNG_NONE;
}

static inline bool is_at_rest(const tumble_positioner_t *axis)
{
    return is(axis, TUMBLE_STAND_READY) || is(axis, TUMBLE_STAND_IN_POSITION) || is(axis, TUMBLE_STAND_STOPPED);
}

/* Tell the order once more, as a new one: with the next exchange, which goes at once. No order has the number 0. */
void tumble_positioner_tell(tumble_positioner_t *axis);

/* Order it, as something new. */
void tumble_positioner_give(tumble_positioner_t *axis, unsigned order);

/* Order a stop. One that is under way is not begun anew: its harsher means must come. */
void tumble_positioner_halt(tumble_positioner_t *axis);

/* Stop and wait for clear_fault; in FAULT, stop again. */
void tumble_positioner_fail(tumble_positioner_t *axis, tumble_stand_fault_t fault);

/* The READ_COUNT registers have come. */
void tumble_positioner_report(tumble_positioner_t *axis, const uint16_t *values);

#endif
