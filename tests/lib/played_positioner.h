/* played_positioner.h - a motor controller with holding registers as a script, and the link to it: the other end of
 * stand/positioner in all C tests.
 *
 * It is written from the registers as positioner.h tells them, and lives by the millisecond. Its bad habits are fields;
 * without them it behaves. The table counts 1000 to a degree; at power-on it stands 12.345 degrees above home, and the
 * controller calls that 0.
 */
#ifndef TUMBLE_TESTS_PLAYED_POSITIONER_H
#define TUMBLE_TESTS_PLAYED_POSITIONER_H

#include "stand/positioner/positioner.h"

#include <stdbool.h>
#include <stdint.h>

#define PLAYED_COUNTS_PER_DEG 1000
#define PLAYED_LATENCY_MS 3U

enum { PLAYED_MOVING = 1, PLAYED_IN_POSITION = 2, PLAYED_HOMED = 4, PLAYED_FAULT = 8, PLAYED_WATCHED = 16 };

typedef struct {
    tumble_exchange_link_t link;
    uint64_t now_ms;

    /* The link. */
    tumble_exchange_t exchange;
    uint64_t answers_ms;
    tumble_status_t answer;
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    bool under_way;
    unsigned exchanges;
    unsigned writes;   /* exchanges that wrote something */
    const char *wrong; /* what its master did against the rules first; null: nothing */

    /* The controller. */
    uint16_t number; /* of the order taken last */
    uint16_t order;
    uint16_t fault;    /* its code; 0: none */
    uint64_t watch_ms; /* when the watchdog runs out */
    bool watched;      /* since the order was taken */
    bool homed;
    int32_t zero;  /* of its counts, in those of the table */
    int32_t goal;  /* of the table */
    int32_t table; /* where the table is, in counts from home */
    int32_t counts_per_ms;
    bool moving;

    /* Habits. */
    bool dead;          /* nothing gets there or comes back; its watchdog goes on */
    bool refuses;       /* answers that it has no such register */
    bool never_watches; /* it has no watchdog */
    bool deaf;          /* takes no order */
    bool never_stops;   /* the watchdog alone stops it */
    bool has_no_brake;  /* nothing stops it */
    bool never_arrives;
    bool never_tells;   /* that it is in position */
    bool never_homes;   /* turns and turns */
    bool arrives_early; /* says that it is in position when it sets out */
    uint8_t spoilt;     /* this one of the registers that are read, from 0, ... */
    uint16_t spoils;    /* ... has these bits turned round */
} played_positioner_t;

/* Power on: the link gets to know where it leads. */
void played_positioner_init(played_positioner_t *played);

/* Off and on again: it has forgotten everything; the table stays where it stands. */
void played_positioner_boot(played_positioner_t *played);

/* A millisecond has passed. */
void played_positioner_step(played_positioner_t *played);

double played_positioner_angle_deg(const played_positioner_t *played);

/* For that link, with a window of 0.05 degrees. */
tumble_positioner_profile_t played_positioner_profile(const played_positioner_t *played);

#endif
