/* operator.h - a person at a dividing head as the stand: asks for an angle, waits for the confirmation.
 *
 * The user interface shows what is asked for (the report's asked_deg) and confirms with the angle that the head stands
 * at; homing is a request for angle 0. READY at once; a request that is not confirmed in time is
 * TUMBLE_STAND_FAULT_TIMEOUT. The caller owns the object; nothing waits. Not re-entrant on one object.
 */
#ifndef TUMBLE_STAND_OPERATOR_H
#define TUMBLE_STAND_OPERATOR_H

#include "tumble/stand.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double tolerance_deg; /* a confirmed angle may be this far off the one asked for; 0 or more */
    uint32_t timeout_ms;  /* of one request; above 0 */
} tumble_operator_config_t;

/* The object; its fields are private. */
typedef struct {
    tumble_stand_report_t report;
    const tumble_operator_config_t *config;
    uint64_t asked_us;
    double angle_deg; /* as last confirmed */
    uint8_t state;    /* tumble_stand_state_t */
    bool homed;
    bool restart_timer;
} tumble_operator_t;

/* The kind: its object is a tumble_operator_t, its profile a tumble_operator_config_t. It is not on the bus. */
extern const tumble_stand_kind_t tumble_operator_kind;

#endif
