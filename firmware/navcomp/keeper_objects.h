/* keeper_objects.h - the further objects of node 1, with a keeper.
 *
 * Written by tools/objects/generate from tools/objects/keeper.toml: change it there.
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_OBJECTS_H
#define TUMBLE_NAVCOMP_KEEPER_OBJECTS_H

#include "canopen/node.h"

#include <stdbool.h>
#include <stdint.h>

/* Where what is computed comes from: tumble_entry_t.source. */
typedef enum {
    TUMBLE_KEEPER_SOURCE_SAVE, /* tumble_parameters_save */
    TUMBLE_KEEPER_SOURCE_LOAD, /* tumble_parameters_forget */
    TUMBLE_KEEPER_SOURCE_UNCERTAINTY, /* tumble_keeper_uncertainty, of the result */
    TUMBLE_KEEPER_SOURCE_FIT, /* tumble_keeper_whole_model, of the result */
    TUMBLE_KEEPER_SOURCE_NOISE, /* tumble_navcomp_noise */
    TUMBLE_KEEPER_SOURCE_SET, /* tumble_store_read, which one by the index */
    TUMBLE_KEEPER_SOURCE_STATE, /* tumble_keeper_state */
    TUMBLE_KEEPER_SOURCE_CALENDAR, /* of that, to tumble_keeper_set_utc */
    TUMBLE_KEEPER_SOURCE_INHIBIT, /* of that, to tumble_keeper_inhibit */
    TUMBLE_KEEPER_SOURCE_SETTINGS, /* settings of the keeper, to tumble_keeper_change */
    TUMBLE_KEEPER_SOURCE_COUNTERS, /* counters of the keeper */
    TUMBLE_KEEPER_SOURCE_STORES, /* the keeper itself: of each store its own counters */
    TUMBLE_KEEPER_SOURCE_STAND, /* the board's stand_view */
    TUMBLE_KEEPER_SOURCE_INCLINATIONS, /* the board's inclinations_view */
    TUMBLE_KEEPER_SOURCE_SHOWN_POSITION, /* shown_position of the keeper */
    TUMBLE_KEEPER_SOURCE_POSITION, /* the mean of that position */
    TUMBLE_KEEPER_SOURCE_POSITIONS, /* of the schedule */
    TUMBLE_KEEPER_SOURCE_SCHEDULE, /* that position in it */
    TUMBLE_KEEPER_SOURCE_AT_REST_COUNT, /* of the measurement at rest: numbers of samples, which are there before all else */
    TUMBLE_KEEPER_SOURCE_AT_REST, /* its result */
    TUMBLE_KEEPER_SOURCE_SHOWN_ENTRY, /* shown_entry of the keeper */
    TUMBLE_KEEPER_SOURCE_ENTRIES, /* tumble_history_count */
    TUMBLE_KEEPER_SOURCE_HISTORY, /* tumble_history_read, that entry */
    TUMBLE_KEEPER_SOURCE_HISTORY_U, /* of that, where it has uncertainties */
    TUMBLE_KEEPER_SOURCE_TREND, /* tumble_keeper_trend, per_month */
    TUMBLE_KEEPER_SOURCE_TREND_U, /* the same, u_per_month */
    TUMBLE_KEEPER_SOURCE_PARAMETERS, /* view of the parameters */
} tumble_keeper_source_t;

/* What 1010h keeps: objects with so many subindices, of either table. */
typedef struct {
    uint16_t index;
    uint8_t count; /* of subindices, from 1 on */
} tumble_saved_t;
#define TUMBLE_KEEPER_SAVED 6
#define TUMBLE_KEEPER_SAVED_BYTES 252 /* in navcomp/parameters.h */
extern const tumble_saved_t tumble_keeper_saved[TUMBLE_KEEPER_SAVED];

extern const tumble_object_table_t tumble_keeper_table;

#define TUMBLE_KEEPER_TRANSMIT 1U
#define TUMBLE_KEEPER_FIRST_TRANSMIT 3U
/* Transmit PDOs, from that number (0 is 1800h) on. */
extern const tumble_pdo_setup_t tumble_keeper_transmit[TUMBLE_KEEPER_TRANSMIT];

#endif
