/* Written by tools/objects/generate from tools/objects/block.toml: change it there. */
#include "simulation/block_objects.h"

#include "canopen/table.h"

#include <assert.h>
#include <stddef.h>

const tumble_block_objects_t tumble_block_objects_initial = {
    .converter_range = 10.0,
    .sample_rate = 100,
    .converter_bits = 24,
    .note = "",
};

typedef struct {
    char value_1008_0[27];
    char value_1009_0[10];
    char value_100a_0[6];
    uint32_t value_1018_2;
    uint32_t value_1018_3;
} constants_t;

static const constants_t constants = {
    .value_1008_0 = "Tumble accelerometer block",
    .value_1009_0 = "simulated",
    .value_100a_0 = "0.2.0",
    .value_1018_2 = 1413611523,
    .value_1018_3 = 65536,
};

static const tumble_limit_t limits[] = {
    {0.0, 2.0},
    {1.0, 1000.0},
};

static const tumble_entry_t entries[] = {
    TUMBLE_ROW(0x1000, 0, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 0, 0), /* Device type */
    TUMBLE_ROW(0x1001, 0, UNSIGNED8, COMMUNICATION, RO | TPDO, 1, 0, 0, 0, 0, 0), /* Error register */
    TUMBLE_ROW(0x1003, 0, UNSIGNED8, COMMUNICATION, RW, 1, 0, 0, 0, 0, 0), /* Pre-defined error field */
    TUMBLE_ROW(0x1003, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 3, 0, 0),
    TUMBLE_ROW(0x1005, 0, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 128, 0), /* COB-ID SYNC message */
    TUMBLE_ROW(0x1008, 0, VISIBLE_STRING, CONSTANT, RO, 26, 0, 0, 0, offsetof(constants_t, value_1008_0), 0), /* Manufacturer device name */
    TUMBLE_ROW(0x1009, 0, VISIBLE_STRING, CONSTANT, RO, 9, 0, 0, 0, offsetof(constants_t, value_1009_0), 0), /* Manufacturer hardware version */
    TUMBLE_ROW(0x100A, 0, VISIBLE_STRING, CONSTANT, RO, 5, 0, 0, 0, offsetof(constants_t, value_100a_0), 0), /* Manufacturer software version */
    TUMBLE_ROW(0x1014, 0, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 0, 0, 0), /* COB-ID EMCY */
    TUMBLE_ROW(0x1016, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 0, 3, 0, 0), /* Consumer heartbeat time */
    TUMBLE_ROW(0x1017, 0, UNSIGNED16, COMMUNICATION, RW, 2, 0, 0, 0, 0, 0), /* Producer heartbeat time */
    TUMBLE_ROW(0x1018, 1, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 0, 0), /* Identity object */
    TUMBLE_ROW(0x1018, 2, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1018_2), 0),
    TUMBLE_ROW(0x1018, 3, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1018_3), 0),
    TUMBLE_ROW(0x1018, 4, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 3, 0),
    TUMBLE_ROW(0x1029, 1, UNSIGNED8, COMMUNICATION, RW, 1, 1, 0, 0, 0, 0), /* Error behaviour */
    TUMBLE_ROW(0x1200, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 1, 0, 0), /* SDO server parameter */
    TUMBLE_ROW(0x2000, 0, UNSIGNED16, VARIABLES, RW, 2, 2, 0, 0, offsetof(tumble_block_objects_t, sample_rate), 0), /* Sample rate */
    TUMBLE_ROW(0x2001, 0, UNSIGNED8, VARIABLES, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_block_objects_t, status), 0), /* Status */
    TUMBLE_ROW(0x2002, 0, INTEGER8, VARIABLES, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_block_objects_t, temperature), 0), /* Temperature */
    TUMBLE_ROW(0x2003, 0, UNSIGNED32, VARIABLES, RO | TPDO, 4, 0, 0, 0, offsetof(tumble_block_objects_t, samples_sent), 0), /* Samples sent */
    TUMBLE_ROW(0x2004, 1, UNSIGNED8, VARIABLES, RO, 1, 0, 0, 0, offsetof(tumble_block_objects_t, converter_bits), 0), /* Converter */
    TUMBLE_ROW(0x2004, 2, REAL64, VARIABLES, RO, 8, 0, 0, 0, offsetof(tumble_block_objects_t, converter_range), 0),
    TUMBLE_ROW(0x2005, 0, VISIBLE_STRING, VARIABLES, RW, 32, 0, 0, 0, offsetof(tumble_block_objects_t, note), 0), /* Note */
};

const tumble_object_table_t tumble_block_table = {
    .entries = entries,
    .limits = limits,
    .constants = &constants,
    .count = sizeof entries / sizeof entries[0],
};

const tumble_node_defaults_t tumble_block_defaults = {
    .receive = NULL,
    .first_receive = 0U,
    .receive_count = 0U,
    .transmit = NULL,
    .first_transmit = 0U,
    .transmit_count = 0U,
    .heartbeat_ms = 100U,
    .consumers = {0x000101F4U, 0x00000000U, 0x00000000U, 0x00000000U},
    .on_error = 1U,
};
