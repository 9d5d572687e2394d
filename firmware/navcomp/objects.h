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

/* Indices of the objects of its own. */
#define TUMBLE_NAVCOMP_INDEX_STATE 0x2000U
#define TUMBLE_NAVCOMP_INDEX_REASON 0x2001U
#define TUMBLE_NAVCOMP_INDEX_COMMAND 0x2002U
#define TUMBLE_NAVCOMP_INDEX_PROGRESS 0x2003U
#define TUMBLE_NAVCOMP_INDEX_FAILURE 0x2004U
#define TUMBLE_NAVCOMP_INDEX_SERVICE_LEVEL 0x2006U
#define TUMBLE_NAVCOMP_INDEX_RUN_NUMBER 0x2007U
#define TUMBLE_NAVCOMP_INDEX_RUN 0x2008U
#define TUMBLE_NAVCOMP_INDEX_RUNNING_MEAN 0x2010U
#define TUMBLE_NAVCOMP_INDEX_STANDARD_ERROR 0x2011U
#define TUMBLE_NAVCOMP_INDEX_K 0x2020U
#define TUMBLE_NAVCOMP_INDEX_U0 0x2021U
#define TUMBLE_NAVCOMP_INDEX_GRAVITY_CHECK 0x2022U
#define TUMBLE_NAVCOMP_INDEX_BUS_COUNTERS 0x2030U
#define TUMBLE_NAVCOMP_INDEX_NODE_COUNTERS 0x2031U
#define TUMBLE_NAVCOMP_INDEX_BLOCK_COUNTERS 0x2032U
#define TUMBLE_NAVCOMP_INDEX_AVERAGING_COUNTERS 0x2033U
#define TUMBLE_NAVCOMP_INDEX_PROCEDURE_COUNTERS 0x2034U
#define TUMBLE_NAVCOMP_INDEX_STOP_COUNTERS 0x2035U
#define TUMBLE_NAVCOMP_INDEX_DRIVE 0x2040U
#define TUMBLE_NAVCOMP_INDEX_CONFIGURATION 0x2050U

/* The variables: TUMBLE_HOME_VARIABLES. */
typedef struct {
    double command_angle; /* 2002h:3, deg */
    uint32_t command_proposal; /* 2002h:4 */
    uint8_t command_argument; /* 2002h:1 */
} tumble_navcomp_objects_t;

/* Their power-on values. */
extern const tumble_navcomp_objects_t tumble_navcomp_objects_initial;

extern const tumble_object_table_t tumble_navcomp_table;
extern const tumble_node_defaults_t tumble_navcomp_defaults;

#endif
