/* operator.h - a person at a dividing head as the stand: asks for an angle, waits for the confirmation.
 *
 * The user interface shows what is asked for (request) and calls confirm with the angle that the head stands at;
 * homing is a request for angle 0. The caller owns the object; nothing waits. Not re-entrant on one object.
 */
#ifndef TUMBLE_STAND_OPERATOR_H
#define TUMBLE_STAND_OPERATOR_H

#include "tumble/status.h"
#include "stand/stand.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double tolerance_deg; /* a confirmed angle may be this far off the one asked for; 0 or more */
    uint32_t timeout_ms;  /* of one request; above 0 */
} tumble_operator_config_t;

/* The object; its fields are private. */
typedef struct {
    const tumble_operator_config_t *config;
    uint64_t asked_us;
    double request_deg;
    double angle_deg; /* as last confirmed */
    uint8_t state;    /* tumble_stand_state_t */
    bool homed;
    bool restart_timer;
} tumble_operator_t;

/* Get ready: READY at once. Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_operator_init(tumble_operator_t *person, const tumble_operator_config_t *config);

/* Watch the time: a request that is not confirmed in time is TUMBLE_STAND_FAULT_TIMEOUT. */
void tumble_operator_step(tumble_operator_t *person, uint64_t now_us);

/* The next moment at which step has something to do; 0: at once; UINT64_MAX: never. */
uint64_t tumble_operator_next_us(const tumble_operator_t *person);

/* Is an angle asked for, and which (degrees of the table)? */
bool tumble_operator_request(const tumble_operator_t *person, double *angle_deg);

/* The head stands at this angle. Returns TUMBLE_OK, TUMBLE_E_STATE when nothing is asked for, or TUMBLE_E_ARGUMENT when
 * it is not the angle asked for (the request stands). */
tumble_status_t tumble_operator_confirm(tumble_operator_t *person, double angle_deg);

/* The person as a stand. The table holds the object's address. */
tumble_stand_t tumble_operator_stand(tumble_operator_t *person);

/* All of this as a table: a computer that is built for a drive alone does not name it, and so links nothing of it. */
typedef struct {
    tumble_status_t (*init)(tumble_operator_t *person, const tumble_operator_config_t *config);
    void (*step)(tumble_operator_t *person, uint64_t now_us);
    uint64_t (*next_us)(const tumble_operator_t *person);
    bool (*request)(const tumble_operator_t *person, double *angle_deg);
    tumble_status_t (*confirm)(tumble_operator_t *person, double angle_deg);
    tumble_stand_t (*stand)(tumble_operator_t *person);
} tumble_operator_calls_t;

extern const tumble_operator_calls_t tumble_operator_calls;

#endif
