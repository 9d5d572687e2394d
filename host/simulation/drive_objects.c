/* Written by tools/objects/generate from tools/objects/drive.toml: change it there. */
#include "simulation/drive_objects.h"

#include <assert.h>
#include <stddef.h>

const tumble_drive_objects_t tumble_drive_objects_initial = {
    .following_error_window = 2000,
    .position_window = 10,
    .profile_velocity = 90000,
    .profile_acceleration = 180000,
    .profile_deceleration = 180000,
    .quick_stop_deceleration = 360000,
    .position_encoder_resolution_encoder_increments = 360000,
    .position_encoder_resolution_motor_revolutions = 1,
    .homing_speeds_speed_during_search_for_switch = 45000,
    .homing_speeds_speed_during_search_for_zero = 4500,
    .homing_acceleration = 180000,
    .abort_connection_option_code = 1,
    .quick_stop_option_code = 2,
    .following_error_time_out = 100,
    .position_window_time = 20,
    .modes_of_operation = 1,
    .modes_of_operation_display = 1,
    .homing_method = 35,
};

typedef struct {
    uint32_t value_1000_0;
    char value_1008_0[23];
    char value_1009_0[10];
    char value_100a_0[6];
    uint32_t value_1018_2;
    uint32_t value_1018_3;
} constants_t;

static const constants_t constants = {
    .value_1000_0 = 131474,
    .value_1008_0 = "Tumble turntable drive",
    .value_1009_0 = "simulated",
    .value_100a_0 = "0.2.0",
    .value_1018_2 = 1413611522,
    .value_1018_3 = 65536,
};

static const tumble_limit_t limits[] = {
    {0.0, 2.0},
    {0.0, 3.0},
    {1.0, 2.0},
    {1.0, 4294967295.0},
};

static const tumble_entry_t entries[] = {
    /* Device type */
    {0x1000U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(constants_t, value_1000_0), 0U},
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
     TUMBLE_ACCESS_READ, 22U, 0U, 0U, 0U, offsetof(constants_t, value_1008_0), 0U},
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
    {0x1018U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 2U, 0U},
    /* Error behaviour */
    {0x1029U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 1U, 0U, 0U, 0U, 0U},
    /* SDO server parameter */
    {0x1200U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 1U, 0U, 0U},
    /* Receive PDO 1 parameter */
    {0x1400U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, 0U, 0U},
    {0x1400U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, 0U, 0U},
    /* Receive PDO 1 mapping */
    {0x1600U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, 0U, 0U},
    {0x1600U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 7U, 0U, 0U},
    /* Transmit PDO 1 parameter, and 1 more */
    {0x1800U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 1U, 0U, 0U, 0U},
    {0x1800U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 1U, 0U, 0U, 0U},
    {0x1800U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 1U, 0U, 0U, 0U},
    {0x1800U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 1U, 0U, 0U, 0U},
    /* Transmit PDO 1 mapping, and 1 more */
    {0x1A00U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 1U, 0U, 0U, 0U},
    {0x1A00U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 1U, 7U, 0U, 0U},
    /* Abort connection option code */
    {0x6007U, 0U, TUMBLE_TYPE_INTEGER16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 2U, 0U, 0U, offsetof(tumble_drive_objects_t, abort_connection_option_code), 0U},
    /* Error code */
    {0x603FU, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 2U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, error_code), 0U},
    /* Controlword */
    {0x6040U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 2U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, controlword), 0U},
    /* Statusword */
    {0x6041U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 2U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, statusword), 0U},
    /* Quick stop option code */
    {0x605AU, 0U, TUMBLE_TYPE_INTEGER16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 3U, 0U, 0U, offsetof(tumble_drive_objects_t, quick_stop_option_code), 0U},
    /* Modes of operation */
    {0x6060U, 0U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 1U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, modes_of_operation), 0U},
    /* Modes of operation display */
    {0x6061U, 0U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, modes_of_operation_display), 0U},
    /* Position actual value */
    {0x6064U, 0U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, position_actual_value), 0U},
    /* Following error window */
    {0x6065U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, following_error_window), 0U},
    /* Following error time out */
    {0x6066U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, following_error_time_out), 0U},
    /* Position window */
    {0x6067U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, position_window), 0U},
    /* Position window time */
    {0x6068U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, position_window_time), 0U},
    /* Velocity actual value */
    {0x606CU, 0U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, velocity_actual_value), 0U},
    /* Target position */
    {0x607AU, 0U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, target_position), 0U},
    /* Home offset */
    {0x607CU, 0U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, home_offset), 0U},
    /* Software position limit */
    {0x607DU, 1U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, software_position_limit_min_position_limit), 0U},
    {0x607DU, 2U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, software_position_limit_max_position_limit), 0U},
    /* Profile velocity */
    {0x6081U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, profile_velocity), 0U},
    /* Profile acceleration */
    {0x6083U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, profile_acceleration), 0U},
    /* Profile deceleration */
    {0x6084U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, profile_deceleration), 0U},
    /* Quick stop deceleration */
    {0x6085U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, quick_stop_deceleration), 0U},
    /* Position encoder resolution */
    {0x608FU, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, position_encoder_resolution_encoder_increments), 0U},
    {0x608FU, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, position_encoder_resolution_motor_revolutions), 0U},
    /* Homing method */
    {0x6098U, 0U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, offsetof(tumble_drive_objects_t, homing_method), 0U},
    /* Homing speeds */
    {0x6099U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, homing_speeds_speed_during_search_for_switch), 0U},
    {0x6099U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, homing_speeds_speed_during_search_for_zero), 0U},
    /* Homing acceleration */
    {0x609AU, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 4U, 0U, 0U, offsetof(tumble_drive_objects_t, homing_acceleration), 0U},
    /* Supported drive modes */
    {0x6502U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 33U, 0U},
};

const tumble_object_table_t tumble_drive_table = {
    .entries = entries,
    .limits = limits,
    .constants = &constants,
    .count = sizeof entries / sizeof entries[0],
};

static const tumble_pdo_setup_t receive[] = {
    {.cob_id = 0x200U, .type = 255U, .count = 1U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0x60400010U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
};
static_assert((sizeof receive / sizeof receive[0]) <= TUMBLE_MAX_RECEIVE_PDOS, "receive");

static const tumble_pdo_setup_t transmit[] = {
    {.cob_id = 0x180U, .type = 255U, .count = 1U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0x60410010U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
};
static_assert((sizeof transmit / sizeof transmit[0]) <= TUMBLE_MAX_TRANSMIT_PDOS, "transmit");

const tumble_node_defaults_t tumble_drive_defaults = {
    .receive = receive,
    .first_receive = 0U,
    .receive_count = 1U,
    .transmit = transmit,
    .first_transmit = 0U,
    .transmit_count = 2U,
    .heartbeat_ms = 100U,
    .consumers = {0x000101F4U, 0x00000000U, 0x00000000U, 0x00000000U},
    .on_error = 0U,
};
