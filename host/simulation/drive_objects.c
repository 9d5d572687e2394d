/* Written by tools/objects/generate from tools/objects/drive.toml: change it there. */
#include "simulation/drive_objects.h"

#include "canopen/table.h"

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
    TUMBLE_ROW(0x1000, 0, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1000_0), 0), /* Device type */
    TUMBLE_ROW(0x1001, 0, UNSIGNED8, COMMUNICATION, RO | TPDO, 1, 0, 0, 0, 0, 0), /* Error register */
    TUMBLE_ROW(0x1003, 0, UNSIGNED8, COMMUNICATION, RW, 1, 0, 0, 0, 0, 0), /* Pre-defined error field */
    TUMBLE_ROW(0x1003, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 3, 0, 0),
    TUMBLE_ROW(0x1005, 0, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 128, 0), /* COB-ID SYNC message */
    TUMBLE_ROW(0x1008, 0, VISIBLE_STRING, CONSTANT, RO, 22, 0, 0, 0, offsetof(constants_t, value_1008_0), 0), /* Manufacturer device name */
    TUMBLE_ROW(0x1009, 0, VISIBLE_STRING, CONSTANT, RO, 9, 0, 0, 0, offsetof(constants_t, value_1009_0), 0), /* Manufacturer hardware version */
    TUMBLE_ROW(0x100A, 0, VISIBLE_STRING, CONSTANT, RO, 5, 0, 0, 0, offsetof(constants_t, value_100a_0), 0), /* Manufacturer software version */
    TUMBLE_ROW(0x1014, 0, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 0, 0, 0), /* COB-ID EMCY */
    TUMBLE_ROW(0x1016, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 0, 3, 0, 0), /* Consumer heartbeat time */
    TUMBLE_ROW(0x1017, 0, UNSIGNED16, COMMUNICATION, RW, 2, 0, 0, 0, 0, 0), /* Producer heartbeat time */
    TUMBLE_ROW(0x1018, 1, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 0, 0), /* Identity object */
    TUMBLE_ROW(0x1018, 2, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1018_2), 0),
    TUMBLE_ROW(0x1018, 3, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1018_3), 0),
    TUMBLE_ROW(0x1018, 4, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 2, 0),
    TUMBLE_ROW(0x1029, 1, UNSIGNED8, COMMUNICATION, RW, 1, 1, 0, 0, 0, 0), /* Error behaviour */
    TUMBLE_ROW(0x1200, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 1, 0, 0), /* SDO server parameter */
    TUMBLE_ROW(0x1400, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 0, 0, 0, 0), /* Receive PDO 1 parameter */
    TUMBLE_ROW(0x1400, 2, UNSIGNED8, COMMUNICATION, RW, 1, 0, 0, 0, 0, 0),
    TUMBLE_ROW(0x1600, 0, UNSIGNED8, COMMUNICATION, RW, 1, 0, 0, 0, 0, 0), /* Receive PDO 1 mapping */
    TUMBLE_ROW(0x1600, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 0, 7, 0, 0),
    TUMBLE_ROW(0x1800, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 1, 0, 0, 0), /* Transmit PDO 1 parameter, and 1 more */
    TUMBLE_ROW(0x1800, 2, UNSIGNED8, COMMUNICATION, RW, 1, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1800, 3, UNSIGNED16, COMMUNICATION, RW, 2, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1800, 5, UNSIGNED16, COMMUNICATION, RW, 2, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1A00, 0, UNSIGNED8, COMMUNICATION, RW, 1, 0, 1, 0, 0, 0), /* Transmit PDO 1 mapping, and 1 more */
    TUMBLE_ROW(0x1A00, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 1, 7, 0, 0),
    TUMBLE_ROW(0x6007, 0, INTEGER16, VARIABLES, RW, 2, 2, 0, 0, offsetof(tumble_drive_objects_t, abort_connection_option_code), 0), /* Abort connection option code */
    TUMBLE_ROW(0x603F, 0, UNSIGNED16, VARIABLES, RO | TPDO, 2, 0, 0, 0, offsetof(tumble_drive_objects_t, error_code), 0), /* Error code */
    TUMBLE_ROW(0x6040, 0, UNSIGNED16, VARIABLES, RW | RPDO, 2, 0, 0, 0, offsetof(tumble_drive_objects_t, controlword), 0), /* Controlword */
    TUMBLE_ROW(0x6041, 0, UNSIGNED16, VARIABLES, RO | TPDO, 2, 0, 0, 0, offsetof(tumble_drive_objects_t, statusword), 0), /* Statusword */
    TUMBLE_ROW(0x605A, 0, INTEGER16, VARIABLES, RW, 2, 3, 0, 0, offsetof(tumble_drive_objects_t, quick_stop_option_code), 0), /* Quick stop option code */
    TUMBLE_ROW(0x6060, 0, INTEGER8, VARIABLES, RW | RPDO, 1, 0, 0, 0, offsetof(tumble_drive_objects_t, modes_of_operation), 0), /* Modes of operation */
    TUMBLE_ROW(0x6061, 0, INTEGER8, VARIABLES, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_drive_objects_t, modes_of_operation_display), 0), /* Modes of operation display */
    TUMBLE_ROW(0x6064, 0, INTEGER32, VARIABLES, RO | TPDO, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, position_actual_value), 0), /* Position actual value */
    TUMBLE_ROW(0x6065, 0, UNSIGNED32, VARIABLES, RW, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, following_error_window), 0), /* Following error window */
    TUMBLE_ROW(0x6066, 0, UNSIGNED16, VARIABLES, RW, 2, 0, 0, 0, offsetof(tumble_drive_objects_t, following_error_time_out), 0), /* Following error time out */
    TUMBLE_ROW(0x6067, 0, UNSIGNED32, VARIABLES, RW, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, position_window), 0), /* Position window */
    TUMBLE_ROW(0x6068, 0, UNSIGNED16, VARIABLES, RW, 2, 0, 0, 0, offsetof(tumble_drive_objects_t, position_window_time), 0), /* Position window time */
    TUMBLE_ROW(0x606C, 0, INTEGER32, VARIABLES, RO | TPDO, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, velocity_actual_value), 0), /* Velocity actual value */
    TUMBLE_ROW(0x607A, 0, INTEGER32, VARIABLES, RW | RPDO, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, target_position), 0), /* Target position */
    TUMBLE_ROW(0x607C, 0, INTEGER32, VARIABLES, RW, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, home_offset), 0), /* Home offset */
    TUMBLE_ROW(0x607D, 1, INTEGER32, VARIABLES, RW, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, software_position_limit_min_position_limit), 0), /* Software position limit */
    TUMBLE_ROW(0x607D, 2, INTEGER32, VARIABLES, RW, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, software_position_limit_max_position_limit), 0),
    TUMBLE_ROW(0x6081, 0, UNSIGNED32, VARIABLES, RW | RPDO, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, profile_velocity), 0), /* Profile velocity */
    TUMBLE_ROW(0x6083, 0, UNSIGNED32, VARIABLES, RW, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, profile_acceleration), 0), /* Profile acceleration */
    TUMBLE_ROW(0x6084, 0, UNSIGNED32, VARIABLES, RW, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, profile_deceleration), 0), /* Profile deceleration */
    TUMBLE_ROW(0x6085, 0, UNSIGNED32, VARIABLES, RW, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, quick_stop_deceleration), 0), /* Quick stop deceleration */
    TUMBLE_ROW(0x608F, 1, UNSIGNED32, VARIABLES, RO, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, position_encoder_resolution_encoder_increments), 0), /* Position encoder resolution */
    TUMBLE_ROW(0x608F, 2, UNSIGNED32, VARIABLES, RO, 4, 0, 0, 0, offsetof(tumble_drive_objects_t, position_encoder_resolution_motor_revolutions), 0),
    TUMBLE_ROW(0x6098, 0, INTEGER8, VARIABLES, RW, 1, 0, 0, 0, offsetof(tumble_drive_objects_t, homing_method), 0), /* Homing method */
    TUMBLE_ROW(0x6099, 1, UNSIGNED32, VARIABLES, RW, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, homing_speeds_speed_during_search_for_switch), 0), /* Homing speeds */
    TUMBLE_ROW(0x6099, 2, UNSIGNED32, VARIABLES, RW, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, homing_speeds_speed_during_search_for_zero), 0),
    TUMBLE_ROW(0x609A, 0, UNSIGNED32, VARIABLES, RW, 4, 4, 0, 0, offsetof(tumble_drive_objects_t, homing_acceleration), 0), /* Homing acceleration */
    TUMBLE_ROW(0x6502, 0, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 33, 0), /* Supported drive modes */
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
