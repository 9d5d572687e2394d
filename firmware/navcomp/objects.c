/* Written by tools/objects/generate from tools/objects/navcomp.toml: change it there. */
#include "navcomp/objects.h"

#include "canopen/cia402.h"
#include "canopen/table_checks.h"
#include "tumble/navcomp.h"

#include <assert.h>
#include <stddef.h>

const tumble_navcomp_objects_t tumble_navcomp_objects_initial = {
    0,
};

typedef struct {
    char value_1008_0[27];
    char value_1009_0[10];
    char value_100a_0[6];
    uint32_t value_1018_2;
    uint32_t value_1018_3;
} constants_t;

static const constants_t constants = {
    .value_1008_0 = "Tumble navigation computer",
    .value_1009_0 = "any board",
    .value_100a_0 = "0.2.0",
    .value_1018_2 = 1413611521,
    .value_1018_3 = 65536,
};

static const tumble_limit_t limits[] = {
    {-3600.0, 3600.0},
    {0.0, 2.0},
    {0.0, 255.0},
    {0.0, 4095.0},
    {1e-12, 1.0},
    {1.0, 1048576.0},
};

TUMBLE_HAS_SIZE("2000h:0", tumble_navcomp_progress_t, as_byte.state, 1U);
TUMBLE_HAS_SIZE("2001h:0", tumble_navcomp_progress_t, as_byte.reason, 1U);
TUMBLE_HAS_SIZE("2003h:1", tumble_navcomp_progress_t, run.index, 1U);
TUMBLE_FOLLOWS("2003h:2", tumble_navcomp_progress_t, run.index, run.count, 1U);
TUMBLE_FOLLOWS("2003h:3", tumble_navcomp_progress_t, run.count, run.finished, 1U);
TUMBLE_FOLLOWS("2003h:4", tumble_navcomp_progress_t, run.finished, run.mounting, 1U);
TUMBLE_FOLLOWS("2003h:5", tumble_navcomp_progress_t, run.mounting, run.position, 1U);
TUMBLE_FOLLOWS("2003h:6", tumble_navcomp_progress_t, run.position, run.attempt, 1U);
TUMBLE_HAS_SIZE("2003h:7", tumble_navcomp_progress_t, run.samples, 4U);
TUMBLE_FOLLOWS("2003h:8", tumble_navcomp_progress_t, run.samples, run.samples_wanted, 4U);
TUMBLE_HAS_SIZE("2003h:9", tumble_navcomp_progress_t, run.target_deg, 8U);
TUMBLE_HAS_SIZE("2003h:10", tumble_navcomp_progress_t, angle_deg, 8U);
TUMBLE_HAS_SIZE("2003h:11", tumble_navcomp_progress_t, temperature_half_c, 1U);
TUMBLE_HAS_SIZE("2003h:12", tumble_navcomp_progress_t, as_byte.stand, 1U);
TUMBLE_FOLLOWS("2003h:13", tumble_navcomp_progress_t, as_byte.stand, as_byte.stays_bolted, 1U);
TUMBLE_HAS_SIZE("2003h:14", tumble_navcomp_progress_t, run.inclination_deg, 8U);
TUMBLE_HAS_SIZE("2004h:1", tumble_navcomp_progress_t, as_byte.failed_in, 1U);
TUMBLE_FOLLOWS("2004h:2", tumble_navcomp_progress_t, as_byte.failed_in, as_byte.status, 1U);
TUMBLE_HAS_SIZE("2004h:3", tumble_navcomp_progress_t, run.drive_code, 2U);
TUMBLE_HAS_SIZE("2004h:4", tumble_navcomp_progress_t, stand_fault, 1U);
TUMBLE_FOLLOWS("2004h:5", tumble_navcomp_progress_t, stand_fault, limited, 1U);
TUMBLE_HAS_SIZE("2004h:6", tumble_navcomp_progress_t, refusal.index, 2U);
TUMBLE_HAS_SIZE("2004h:7", tumble_navcomp_progress_t, refusal.subindex, 1U);
TUMBLE_HAS_SIZE("2004h:8", tumble_navcomp_progress_t, refusal.abort, 4U);
TUMBLE_HAS_SIZE("2004h:9", tumble_navcomp_progress_t, refusal.step, 1U);
TUMBLE_HAS_SIZE("2004h:10", tumble_navcomp_progress_t, rung, 1U);
TUMBLE_IS_ARRAY("2010h:1", tumble_navcomp_progress_t, mean_v, mean_v[0], 8U, 3U);
TUMBLE_IS_ARRAY("2011h:1", tumble_navcomp_progress_t, standard_error_v, standard_error_v[0], 8U, 3U);
TUMBLE_IS_ARRAY("2020h:1", tumble_coefficients_t, k_v_per_g, k_v_per_g[0][0], 8U, 9U);
TUMBLE_IS_ARRAY("2021h:1", tumble_coefficients_t, u0_v, u0_v[0], 8U, 3U);
TUMBLE_HAS_SIZE("2022h:1", tumble_gravity_check_t, max_abs_fit_g, 8U);
TUMBLE_FOLLOWS("2022h:2", tumble_gravity_check_t, max_abs_fit_g, max_abs_check_g, 8U);
TUMBLE_HAS_SIZE("2022h:3", tumble_procedure_config_t, gravity_limit_g, 8U);
TUMBLE_HAS_SIZE("2022h:4", tumble_gravity_check_t, fit_positions, 1U);
TUMBLE_FOLLOWS("2022h:5", tumble_gravity_check_t, fit_positions, check_positions, 1U);
TUMBLE_HAS_SIZE("2022h:6", tumble_gravity_check_t, pass, 1U);
TUMBLE_HAS_SIZE("2030h:1", tumble_navcomp_counters_t, link.sent, 4U);
TUMBLE_FOLLOWS("2030h:2", tumble_navcomp_counters_t, link.sent, link.received, 4U);
TUMBLE_FOLLOWS("2030h:3", tumble_navcomp_counters_t, link.received, link.busy, 4U);
TUMBLE_FOLLOWS("2030h:4", tumble_navcomp_counters_t, link.busy, link.down, 4U);
TUMBLE_FOLLOWS("2030h:5", tumble_navcomp_counters_t, link.down, link.invalid, 4U);
TUMBLE_HAS_SIZE("2031h:1", tumble_navcomp_counters_t, events.frames_ignored, 4U);
TUMBLE_FOLLOWS("2031h:2", tumble_navcomp_counters_t, events.frames_ignored, events.source_corrupted, 4U);
TUMBLE_FOLLOWS("2031h:3", tumble_navcomp_counters_t, events.source_corrupted, events.source_faults, 4U);
TUMBLE_FOLLOWS("2031h:4", tumble_navcomp_counters_t, events.source_faults, events.commands_refused, 4U);
TUMBLE_FOLLOWS("2031h:5", tumble_navcomp_counters_t, events.commands_refused, events.heartbeats_lost, 4U);
TUMBLE_FOLLOWS("2031h:6", tumble_navcomp_counters_t, events.heartbeats_lost, events.boot_ups, 4U);
TUMBLE_FOLLOWS("2031h:7", tumble_navcomp_counters_t, events.boot_ups, events.starts, 4U);
TUMBLE_FOLLOWS("2031h:8", tumble_navcomp_counters_t, events.starts, events.emergencies, 4U);
TUMBLE_FOLLOWS("2031h:9", tumble_navcomp_counters_t, events.emergencies, events.foreign, 4U);
TUMBLE_HAS_SIZE("2032h:1", tumble_navcomp_counters_t, block.samples, 4U);
TUMBLE_FOLLOWS("2032h:2", tumble_navcomp_counters_t, block.samples, block.lost, 4U);
TUMBLE_FOLLOWS("2032h:3", tumble_navcomp_counters_t, block.lost, block.repeated, 4U);
TUMBLE_FOLLOWS("2032h:4", tumble_navcomp_counters_t, block.repeated, block.reordered, 4U);
TUMBLE_FOLLOWS("2032h:5", tumble_navcomp_counters_t, block.reordered, block.wrong_length, 4U);
TUMBLE_FOLLOWS("2032h:6", tumble_navcomp_counters_t, block.wrong_length, block.wrong_crc, 4U);
TUMBLE_FOLLOWS("2032h:7", tumble_navcomp_counters_t, block.wrong_crc, block.wrong_pair, 4U);
TUMBLE_FOLLOWS("2032h:8", tumble_navcomp_counters_t, block.wrong_pair, block.lone_halves, 4U);
TUMBLE_HAS_SIZE("2033h:1", tumble_navcomp_counters_t, averaging.saturated, 4U);
TUMBLE_FOLLOWS("2033h:2", tumble_navcomp_counters_t, averaging.saturated, averaging.deviating, 4U);
TUMBLE_FOLLOWS("2033h:3", tumble_navcomp_counters_t, averaging.deviating, averaging.repeated, 4U);
TUMBLE_FOLLOWS("2033h:4", tumble_navcomp_counters_t, averaging.repeated, averaging.reordered, 4U);
TUMBLE_FOLLOWS("2033h:5", tumble_navcomp_counters_t, averaging.reordered, averaging.lost, 4U);
TUMBLE_HAS_SIZE("2034h:1", tumble_navcomp_counters_t, procedure.samples, 4U);
TUMBLE_FOLLOWS("2034h:2", tumble_navcomp_counters_t, procedure.samples, procedure.corrupted, 4U);
TUMBLE_FOLLOWS("2034h:3", tumble_navcomp_counters_t, procedure.corrupted, procedure.lost, 4U);
TUMBLE_FOLLOWS("2034h:4", tumble_navcomp_counters_t, procedure.lost, procedure.averaged, 4U);
TUMBLE_FOLLOWS("2034h:5", tumble_navcomp_counters_t, procedure.averaged, procedure.positions, 4U);
TUMBLE_FOLLOWS("2034h:6", tumble_navcomp_counters_t, procedure.positions, procedure.refused, 4U);
TUMBLE_FOLLOWS("2034h:7", tumble_navcomp_counters_t, procedure.refused, procedure.retries, 4U);
TUMBLE_FOLLOWS("2034h:8", tumble_navcomp_counters_t, procedure.retries, procedure.timeouts, 4U);
TUMBLE_FOLLOWS("2034h:9", tumble_navcomp_counters_t, procedure.timeouts, procedure.moves, 4U);
TUMBLE_FOLLOWS("2034h:10", tumble_navcomp_counters_t, procedure.moves, procedure.unwinds, 4U);
TUMBLE_FOLLOWS("2034h:11", tumble_navcomp_counters_t, procedure.unwinds, procedure.homings, 4U);
TUMBLE_FOLLOWS("2034h:12", tumble_navcomp_counters_t, procedure.homings, procedure.faults, 4U);
TUMBLE_FOLLOWS("2034h:13", tumble_navcomp_counters_t, procedure.faults, procedure.resumes, 4U);
TUMBLE_FOLLOWS("2034h:14", tumble_navcomp_counters_t, procedure.resumes, procedure.commands_refused, 4U);
TUMBLE_HAS_SIZE("2035h:1", tumble_navcomp_counters_t, stop.rungs[0], 4U);
TUMBLE_FOLLOWS("2035h:2", tumble_navcomp_counters_t, stop.rungs[0], stop.rungs[1], 4U);
TUMBLE_FOLLOWS("2035h:3", tumble_navcomp_counters_t, stop.rungs[1], stop.rungs[2], 4U);
TUMBLE_FOLLOWS("2035h:4", tumble_navcomp_counters_t, stop.rungs[2], stop.rungs[3], 4U);
TUMBLE_FOLLOWS("2035h:5", tumble_navcomp_counters_t, stop.rungs[3], stop.rungs[4], 4U);
TUMBLE_FOLLOWS("2035h:6", tumble_navcomp_counters_t, stop.rungs[4], stop.implausible, 4U);
TUMBLE_HAS_SIZE("2040h:1", tumble_drive_mirror_t, controlword, 2U);
TUMBLE_HAS_SIZE("2040h:2", tumble_drive_mirror_t, target_position, 4U);
TUMBLE_HAS_SIZE("2040h:3", tumble_drive_mirror_t, mode, 1U);
TUMBLE_HAS_SIZE("2040h:4", tumble_drive_mirror_t, statusword, 2U);
TUMBLE_HAS_SIZE("2040h:5", tumble_drive_mirror_t, actual_position, 4U);
TUMBLE_HAS_SIZE("2040h:6", tumble_drive_mirror_t, mode_display, 1U);
TUMBLE_HAS_SIZE("2040h:7", tumble_drive_mirror_t, actual_velocity, 4U);
TUMBLE_HAS_SIZE("2040h:8", tumble_drive_mirror_t, error_code, 2U);
TUMBLE_HAS_SIZE("2050h:1", tumble_procedure_config_t, samples, 4U);
TUMBLE_HAS_SIZE("2050h:3", tumble_procedure_config_t, settle_ms, 2U);
TUMBLE_HAS_SIZE("2050h:4", tumble_procedure_config_t, retries, 1U);
TUMBLE_HAS_SIZE("2050h:5", tumble_procedure_config_t, gravity_limit_g, 8U);

static const tumble_entry_t entries[] = {
    /* Dummy UNSIGNED8 */
    {0x0005U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_IMMEDIATE,
     TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 1U, 0U, 0U, 0U, 0U, 0U},
    /* Dummy UNSIGNED16 */
    {0x0006U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_IMMEDIATE,
     TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 2U, 0U, 0U, 0U, 0U, 0U},
    /* Dummy UNSIGNED32 */
    {0x0007U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE,
     TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 4U, 0U, 0U, 0U, 0U, 0U},
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
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 0U, 3U, 0U, 0U},
    /* Producer heartbeat time */
    {0x1017U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 2U, 0U, 0U, 0U, 0U, 0U},
    /* Identity object */
    {0x1018U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, 0U},
    {0x1018U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(constants_t, value_1018_2), 0U},
    {0x1018U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_CONSTANT,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(constants_t, value_1018_3), 0U},
    {0x1018U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 1U, 0U},
    /* Error behaviour */
    {0x1029U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 2U, 0U, 0U, 0U, 0U},
    /* SDO server parameter, and 1 more */
    {0x1200U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 4U, 0U, 1U, 1U, 0U, 0U},
    /* SDO client parameter */
    {0x1280U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 4U, 0U, 0U, 1U, 0U, 0U},
    {0x1280U, 3U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION, TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, 0U, 0U},
    /* Receive PDO 1 parameter, and 1 more */
    {0x1400U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 1U, 0U, 0U, 0U},
    {0x1400U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 0U, 1U, 0U, 0U, 0U},
    /* Receive PDO 1 mapping, and 1 more */
    {0x1600U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 0U, 1U, 0U, 0U, 0U},
    {0x1600U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 1U, 7U, 0U, 0U},
    /* Transmit PDO 1 parameter, and 1 more */
    {0x1800U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 1U, 0U, 0U, 0U},
    {0x1800U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 0U, 1U, 0U, 0U, 0U},
    {0x1800U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 2U, 0U, 1U, 0U, 0U, 0U},
    {0x1800U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 2U, 0U, 1U, 0U, 0U, 0U},
    /* Transmit PDO 3 parameter, and 2 more */
    {0x1802U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 2U, 0U, 0U, 0U},
    {0x1802U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 2U, 0U, 0U, 0U},
    {0x1802U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 2U, 0U, 0U, 0U},
    {0x1802U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 2U, 0U, 0U, 0U},
    /* Transmit PDO 1 mapping, and 1 more */
    {0x1A00U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 0U, 1U, 0U, 0U, 0U},
    {0x1A00U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 1U, 7U, 0U, 0U},
    /* Transmit PDO 3 mapping, and 2 more */
    {0x1A02U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 2U, 0U, 0U, 0U},
    {0x1A02U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMMUNICATION,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 2U, 7U, 0U, 0U},
    /* State */
    {0x2000U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, as_byte.state), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    /* Reason */
    {0x2001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, as_byte.reason), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    /* Command */
    {0x2002U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_objects_t, command_argument), 0U},
    {0x2002U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_COMMAND},
    {0x2002U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 8U, 1U, 0U, 0U, offsetof(tumble_navcomp_objects_t, command_angle), 0U},
    {0x2002U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_VARIABLES,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_navcomp_objects_t, command_proposal), 0U},
    /* Progress */
    {0x2003U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 5U, offsetof(tumble_navcomp_progress_t, run.index), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2003U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 1U, offsetof(tumble_navcomp_progress_t, run.samples), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2003U, 9U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 8U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, run.target_deg), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2003U, 10U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 8U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, angle_deg), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2003U, 11U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, temperature_half_c), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2003U, 12U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 1U, offsetof(tumble_navcomp_progress_t, as_byte.stand), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2003U, 14U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 8U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, run.inclination_deg), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    /* Failure */
    {0x2004U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 1U, offsetof(tumble_navcomp_progress_t, as_byte.failed_in), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 2U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, run.drive_code), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 1U, offsetof(tumble_navcomp_progress_t, stand_fault), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 6U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 2U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, refusal.index), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 7U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, refusal.subindex), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, refusal.abort), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 9U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, refusal.step), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    {0x2004U, 10U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_navcomp_progress_t, rung), TUMBLE_NAVCOMP_SOURCE_PROGRESS},
    /* Service level */
    {0x2006U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_SERVICE_KEY},
    {0x2006U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_SERVICE_LEVEL},
    {0x2006U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 2U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_SERVICE_LEFT},
    /* Run number */
    {0x2007U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_RUN},
    /* Run */
    {0x2008U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_RUN},
    {0x2008U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_RUN_OF_RESULT},
    {0x2008U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_RUN_OF_MEAN},
    /* Running mean */
    {0x2010U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 2U, offsetof(tumble_navcomp_progress_t, mean_v[0]), TUMBLE_NAVCOMP_SOURCE_MEAN},
    /* Standard error */
    {0x2011U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 2U, offsetof(tumble_navcomp_progress_t, standard_error_v[0]), TUMBLE_NAVCOMP_SOURCE_MEAN},
    /* K */
    {0x2020U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 8U, offsetof(tumble_coefficients_t, k_v_per_g[0][0]), TUMBLE_NAVCOMP_SOURCE_COEFFICIENTS},
    /* U0 */
    {0x2021U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 2U, offsetof(tumble_coefficients_t, u0_v[0]), TUMBLE_NAVCOMP_SOURCE_COEFFICIENTS},
    /* Gravity check */
    {0x2022U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 1U, offsetof(tumble_gravity_check_t, max_abs_fit_g), TUMBLE_NAVCOMP_SOURCE_CHECK},
    {0x2022U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 0U, offsetof(tumble_procedure_config_t, gravity_limit_g), TUMBLE_NAVCOMP_SOURCE_LIMIT},
    {0x2022U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 1U, offsetof(tumble_gravity_check_t, fit_positions), TUMBLE_NAVCOMP_SOURCE_CHECK},
    {0x2022U, 6U, TUMBLE_TYPE_BOOLEAN, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_gravity_check_t, pass), TUMBLE_NAVCOMP_SOURCE_CHECK},
    /* Bus counters */
    {0x2030U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 4U, offsetof(tumble_navcomp_counters_t, link.sent), TUMBLE_NAVCOMP_SOURCE_COUNTERS},
    /* Node counters */
    {0x2031U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 8U, offsetof(tumble_navcomp_counters_t, events.frames_ignored), TUMBLE_NAVCOMP_SOURCE_COUNTERS},
    /* Block counters */
    {0x2032U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 7U, offsetof(tumble_navcomp_counters_t, block.samples), TUMBLE_NAVCOMP_SOURCE_COUNTERS},
    /* Averaging counters */
    {0x2033U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 4U, offsetof(tumble_navcomp_counters_t, averaging.saturated), TUMBLE_NAVCOMP_SOURCE_COUNTERS},
    /* Procedure counters */
    {0x2034U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 13U, offsetof(tumble_navcomp_counters_t, procedure.samples), TUMBLE_NAVCOMP_SOURCE_COUNTERS},
    /* Stop counters */
    {0x2035U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 5U, offsetof(tumble_navcomp_counters_t, stop.rungs[0]), TUMBLE_NAVCOMP_SOURCE_COUNTERS},
    /* Drive */
    {0x2040U, 1U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 2U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, controlword), 0U},
    {0x2040U, 2U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, target_position), 0U},
    {0x2040U, 3U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, mode), 0U},
    {0x2040U, 4U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 2U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, statusword), 0U},
    {0x2040U, 5U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, actual_position), 0U},
    {0x2040U, 6U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 1U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, mode_display), 0U},
    {0x2040U, 7U, TUMBLE_TYPE_INTEGER32, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 4U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, actual_velocity), 0U},
    {0x2040U, 8U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_OTHER,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, 2U, 0U, 0U, 0U, offsetof(tumble_drive_mirror_t, error_code), 0U},
    /* Configuration */
    {0x2050U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 6U, 0U, 0U, offsetof(tumble_procedure_config_t, samples), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION},
    {0x2050U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 2U, 0U, 0U, 0U, TUMBLE_NAVCOMP_SOURCE_ESTIMATOR},
    {0x2050U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 4U, 0U, 0U, offsetof(tumble_procedure_config_t, settle_ms), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION},
    {0x2050U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 3U, 0U, 0U, offsetof(tumble_procedure_config_t, retries), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION},
    {0x2050U, 5U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 8U, 5U, 0U, 0U, offsetof(tumble_procedure_config_t, gravity_limit_g), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION},
};

const tumble_object_table_t tumble_navcomp_table = {
    .entries = entries,
    .limits = limits,
    .constants = &constants,
    .count = sizeof entries / sizeof entries[0],
};

static const tumble_pdo_setup_t transmit[] = {
    {.cob_id = 0x180U, .type = 255U, .count = 5U, .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x20000008U, 0x20010008U, 0x20030108U, 0x20030308U, 0x20030720U, 0U, 0U, 0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x6C1U, .type = 255U, .count = 3U, .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x20060208U, 0x20060310U, 0x20070020U, 0U, 0U, 0U, 0U, 0U}},
};
static_assert((sizeof transmit / sizeof transmit[0]) <= TUMBLE_MAX_TRANSMIT_PDOS, "transmit");

const tumble_node_defaults_t tumble_navcomp_defaults = {
    .receive = NULL,
    .first_receive = 2U,
    .receive_count = 0U,
    .transmit = transmit,
    .first_transmit = 2U,
    .transmit_count = 3U,
    .heartbeat_ms = 100U,
    .consumers = {0x000201F4U, 0x000301F4U, 0x00000000U, 0x00000000U},
    .on_error = 1U,
};
