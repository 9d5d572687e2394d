/* Written by tools/objects/generate from tools/objects/block.toml: change it there. */
#include "simulation/block_objects.h"

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
    /* Device type */
    {0x1000U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, 0U},
    /* Error register */
    {0x1001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, 0U, 0U},
    /* Pre-defined error field */
    {0x1003U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, 0U, 0U},
    {0x1003U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 3U, 0U, 0U},
    /* COB-ID SYNC message */
    {0x1005U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 128U, 0U},
    /* Manufacturer device name */
    {0x1008U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 26U, 0U, 0U, 0U, offsetof(constants_t, value_1008_0), 0U},
    /* Manufacturer hardware version */
    {0x1009U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 9U, 0U, 0U, 0U, offsetof(constants_t, value_1009_0), 0U},
    /* Manufacturer software version */
    {0x100AU, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 5U, 0U, 0U, 0U, offsetof(constants_t, value_100a_0), 0U},
    /* COB-ID EMCY */
    {0x1014U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, 0U},
    /* Consumer heartbeat time */
    {0x1016U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 3U, 0U, 0U},
    /* Producer heartbeat time */
    {0x1017U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 0U, 0U, 0U, 0U},
    /* Identity object */
    {0x1018U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, 0U},
    {0x1018U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(constants_t, value_1018_2), 0U},
    {0x1018U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(constants_t, value_1018_3), 0U},
    {0x1018U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 3U, 0U},
    /* Error behaviour */
    {0x1029U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 1U, 0U, 0U, 0U, 0U},
    /* SDO server parameter */
    {0x1200U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 1U, 0U, 0U},
    /* Sample rate */
    {0x2000U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 2U, 0U, 0U, offsetof(tumble_block_objects_t, sample_rate), 0U},
    /* Status */
    {0x2001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_block_objects_t, status), 0U},
    /* Temperature */
    {0x2002U, 0U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_block_objects_t, temperature), 0U},
    /* Samples sent */
    {0x2003U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 0U, offsetof(tumble_block_objects_t, samples_sent), 0U},
    /* Converter */
    {0x2004U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_block_objects_t, converter_bits), 0U},
    {0x2004U, 2U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 0U, offsetof(tumble_block_objects_t, converter_range), 0U},
    /* Note */
    {0x2005U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 32U, 0U, 0U, 0U, offsetof(tumble_block_objects_t, note), 0U},
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
