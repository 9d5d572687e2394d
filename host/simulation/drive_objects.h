/* drive_objects.h - the object dictionary of node 2, drive.
 *
 * Written by tools/objects/generate from tools/objects/drive.toml: change it there.
 */
#ifndef TUMBLE_SIMULATION_DRIVE_OBJECTS_H
#define TUMBLE_SIMULATION_DRIVE_OBJECTS_H

#include "canopen/node.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_DRIVE_NODE 2U

/* The variables: TUMBLE_HOME_VARIABLES. */
typedef struct {
    int32_t position_actual_value; /* 6064h:0, counts */
    uint32_t following_error_window; /* 6065h:0, counts */
    uint32_t position_window; /* 6067h:0, counts */
    int32_t velocity_actual_value; /* 606Ch:0, counts/s */
    int32_t target_position; /* 607Ah:0, counts */
    int32_t home_offset; /* 607Ch:0, counts */
    int32_t software_position_limit_min_position_limit; /* 607Dh:1, counts */
    int32_t software_position_limit_max_position_limit; /* 607Dh:2, counts */
    uint32_t profile_velocity; /* 6081h:0, counts/s */
    uint32_t profile_acceleration; /* 6083h:0, counts/s^2 */
    uint32_t profile_deceleration; /* 6084h:0, counts/s^2 */
    uint32_t quick_stop_deceleration; /* 6085h:0, counts/s^2 */
    uint32_t position_encoder_resolution_encoder_increments; /* 608Fh:1, counts */
    uint32_t position_encoder_resolution_motor_revolutions; /* 608Fh:2 */
    uint32_t homing_speeds_speed_during_search_for_switch; /* 6099h:1, counts/s */
    uint32_t homing_speeds_speed_during_search_for_zero; /* 6099h:2, counts/s */
    uint32_t homing_acceleration; /* 609Ah:0, counts/s^2 */
    int16_t abort_connection_option_code; /* 6007h:0 */
    uint16_t error_code; /* 603Fh:0 */
    uint16_t controlword; /* 6040h:0 */
    uint16_t statusword; /* 6041h:0 */
    int16_t quick_stop_option_code; /* 605Ah:0 */
    uint16_t following_error_time_out; /* 6066h:0, ms */
    uint16_t position_window_time; /* 6068h:0, ms */
    int8_t modes_of_operation; /* 6060h:0 */
    int8_t modes_of_operation_display; /* 6061h:0 */
    int8_t homing_method; /* 6098h:0 */
} tumble_drive_objects_t;

/* Their power-on values. */
extern const tumble_drive_objects_t tumble_drive_objects_initial;

extern const tumble_object_table_t tumble_drive_table;
extern const tumble_node_defaults_t tumble_drive_defaults;

#endif
