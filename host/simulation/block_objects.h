/* block_objects.h - the object dictionary of node 3, block.
 *
 * Written by tools/objects/generate from tools/objects/block.toml: change it there.
 */
#ifndef TUMBLE_SIMULATION_BLOCK_OBJECTS_H
#define TUMBLE_SIMULATION_BLOCK_OBJECTS_H

#include "canopen/node.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_BLOCK_NODE 3U

/* The variables: TUMBLE_HOME_VARIABLES. */
typedef struct {
    double converter_range; /* 2004h:2, V */
    uint32_t samples_sent; /* 2003h:0 */
    uint16_t sample_rate; /* 2000h:0, Hz */
    uint8_t status; /* 2001h:0 */
    int8_t temperature; /* 2002h:0, half degrees C */
    uint8_t converter_bits; /* 2004h:1, bits */
    char note[32]; /* 2005h:0 */
} tumble_block_objects_t;

/* Their power-on values. */
extern const tumble_block_objects_t tumble_block_objects_initial;

extern const tumble_object_table_t tumble_block_table;
extern const tumble_node_defaults_t tumble_block_defaults;

#endif
