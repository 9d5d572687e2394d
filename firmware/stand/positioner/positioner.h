/* positioner.h - a plain motor controller with holding registers (Modbus) as the stand's axis.
 *
 * The controller turns the axis, closes its loop and knows home. This side orders, and reads what has become of it. In
 * every exchange, one each cycle_ms, the first register is written, or all five until an order is taken; then six are
 * read.
 *
 *     written  0      watch      ms. Every write starts the controller's watchdog anew. When it runs out the controller
 *                                stops the axis by itself
 *              1      number     of the order: an order is taken when its number differs from that of the one before
 *              2      order      0 stop, 1 home, 2 go to the target (if it is homed), 3 reset a fault (and
 *                                stay stopped)
 *              3, 4   target     counts
 *     read     16     identity   5450h: this is such a controller
 *              17     status     bit 0: the axis moves; 1: it is where the order told it to be; 2: homed (0 from the
 *                                order to home until the zero is set); 3: fault; 4: the watchdog runs, and has not run
 *                                out since the order was taken. All others are 0
 *              18     number     of the order taken last, which the status tells of; 0 after power-on
 *              19     fault      a code of its own
 *              20, 21 angle      counts
 *
 * Counts are two's complement in two registers, the high one first. 0 is home.
 *
 * What can stop the axis:
 *   - an order to stop, repeated in every exchange until it is taken;
 *   - silence, if the axis is not seen at rest within stop_timeout_ms (TUMBLE_RUNG_SILENCE): nothing is exchanged, so that
 *     the watchdog runs out. Then it is told to stop again, and at last (TUMBLE_RUNG_UNCONFIRMED) somebody must look at
 *     the table;
 *   - the watchdog, when the link or this computer dies. A controller whose watchdog does not run is not moved.
 *
 * A fault besides what the controller tells: no answer for silence_ms (HEARTBEAT), a report that no such controller
 * sends (PROTOCOL), an order that is not ours (FOREIGN), a watchdog that ran out or a controller that was switched off
 * (POWER), an angle that is not possible (POSITION): beyond the cable while it moves, or changed at rest. Homing that turns
 * the table farther than the cable's span and one turn is a fault, too.
 *
 * The link carries one exchange at a time and never waits; host/node/modbus_link.h is one. The caller owns the object.
 * Not re-entrant on one object.
 */
#ifndef TUMBLE_STAND_POSITIONER_H
#define TUMBLE_STAND_POSITIONER_H

#include "tumble/stand.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_EXCHANGE_REGISTERS 6U /* most of one exchange, each way */

/* Some holding registers to be written, then some to be read. Addresses as they travel, from 0. */
typedef struct {
    uint16_t write_at;
    uint16_t read_at;
    uint8_t writes; /* how many; 0: nothing is written */
    uint8_t reads;
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS]; /* to be written */
} tumble_exchange_t;

/* The way to the controller. Neither function waits. */
typedef struct {
    void *context;

    /* Begin an exchange. What the one before has brought is dropped if nobody has asked for it.
     * Returns TUMBLE_OK, or TUMBLE_E_PORT_BUSY: the one before is still under way. */
    tumble_status_t (*begin)(void *context, const tumble_exchange_t *exchange);

    /* What has become of it.
     * Returns TUMBLE_OK with `values` as read; TUMBLE_E_PORT_BUSY: still under way; TUMBLE_E_PORT_DOWN: no answer;
     * TUMBLE_E_FRAME: the controller has refused, such as an address that it does not have. */
    tumble_status_t (*end)(void *context, uint16_t values[TUMBLE_EXCHANGE_REGISTERS]);
} tumble_exchange_link_t;

typedef struct {
    const tumble_exchange_link_t *link;
    double counts_per_deg;    /* of the table; below 0: counts rise when it turns down */
    double window_deg;        /* in position, and at rest, within this; above 0 */
    uint32_t home_timeout_ms; /* of homing and of a move; above 0 */
    uint32_t move_timeout_ms;
    uint16_t stop_timeout_ms; /* from the order to stop until the axis rests; above 0 */
    uint16_t cycle_ms;        /* from one exchange to the next; above 0 */
    uint16_t silence_ms;      /* without an answer: the link is dead; two cycles or more */
    uint16_t watch_ms;        /* of the controller's watchdog; two cycles or more */
    double speed_deg_s;       /* of a move, and the faster one of homing: bounds of time and progress follow from it
                               * (stand/bounds.h); 0: not known, the two timeouts alone bound the time */
} tumble_positioner_profile_t;

/* The object; its fields are private. */
typedef struct {
    tumble_stand_report_t report;
    const tumble_positioner_profile_t *profile;
    uint64_t now_us;       /* of the last step */
    uint64_t due_us;       /* the next exchange, or look at the one under way */
    uint64_t heard_us;     /* the last report */
    uint64_t since_us;     /* the order, or the rung of the stop */
    uint64_t travelled;    /* counts, since homing was ordered */
    uint64_t most_travel;  /* that homing may turn the table */
    int64_t lowest_counts; /* where the cable ends */
    int64_t highest_counts;
    int64_t window_counts;
    int32_t target;
    int32_t actual;
    uint16_t status;
    uint16_t number; /* of our order */
    uint8_t order;
    uint8_t state; /* tumble_stand_state_t */
    uint8_t fault; /* tumble_stand_fault_t */
    uint8_t rung;  /* tumble_stop_rung_t */
    bool known;    /* a report has come since power-on, or since the last fault was cleared */
    bool taken;    /* the controller has our order */
    bool under_way;
    bool restart_timer;
} tumble_positioner_t;

/* The kind: its object is a tumble_positioner_t, its profile a tumble_positioner_profile_t. It is not on the bus. */
extern const tumble_stand_kind_t tumble_positioner_kind;

#endif
