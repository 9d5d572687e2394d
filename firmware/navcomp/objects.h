/* objects.h - the object dictionary of node 1, navcomp.
 *
 * Written by tools/objects/generate from tools/objects/navcomp.toml: change it there.
 */
#ifndef TUMBLE_NAVCOMP_OBJECTS_H
#define TUMBLE_NAVCOMP_OBJECTS_H

#include "canopen/node.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_NAVCOMP_NODE 1U

/* The variables: TUMBLE_HOME_VARIABLES. */
typedef struct {
    double command_angle; /* 2002h:3, deg */
    uint32_t command_proposal; /* 2002h:4 */
    uint8_t command_argument; /* 2002h:1 */
} tumble_navcomp_objects_t;

/* Their power-on values. */
extern const tumble_navcomp_objects_t tumble_navcomp_objects_initial;

/* Where what is computed comes from: tumble_entry_t.source. */
typedef enum {
    TUMBLE_NAVCOMP_SOURCE_PROGRESS, /* tumble_navcomp_progress */
    TUMBLE_NAVCOMP_SOURCE_MEAN, /* of the open position, as progress has it */
    TUMBLE_NAVCOMP_SOURCE_COEFFICIENTS, /* of the result */
    TUMBLE_NAVCOMP_SOURCE_CHECK, /* of gravity, with the result */
    TUMBLE_NAVCOMP_SOURCE_LIMIT, /* of that check */
    TUMBLE_NAVCOMP_SOURCE_CONFIGURATION, /* procedure_config of the navigation computer */
    TUMBLE_NAVCOMP_SOURCE_ESTIMATOR, /* of that, a byte on the bus */
    TUMBLE_NAVCOMP_SOURCE_COUNTERS, /* tumble_navcomp_counters */
    TUMBLE_NAVCOMP_SOURCE_COMMAND, /* tumble_navcomp_command */
    TUMBLE_NAVCOMP_SOURCE_SERVICE_KEY, /* tumble_service_unlock */
    TUMBLE_NAVCOMP_SOURCE_SERVICE_LEVEL, /* tumble_service_is_open */
    TUMBLE_NAVCOMP_SOURCE_SERVICE_LEFT, /* tumble_service_left_s */
    TUMBLE_NAVCOMP_SOURCE_RUN, /* tumble_service_runs */
    TUMBLE_NAVCOMP_SOURCE_RUN_OF_RESULT, /* the same, where there is a result */
    TUMBLE_NAVCOMP_SOURCE_RUN_OF_MEAN, /* the same, where there is a running mean */
} tumble_navcomp_source_t;

extern const tumble_object_table_t tumble_navcomp_table;
extern const tumble_node_defaults_t tumble_navcomp_defaults;

#endif
