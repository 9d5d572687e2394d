/* Written by tools/objects/generate from tools/objects/navcomp.toml: change it there. */
#include "navcomp/objects.h"

#include "canopen/cia402.h"
#include "canopen/table.h"
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

TUMBLE_HAS_SIZE("2000h:0", tumble_navcomp_progress_t, 1U, as_byte.state);
TUMBLE_HAS_SIZE("2001h:0", tumble_navcomp_progress_t, 1U, as_byte.reason);
TUMBLE_IN_LINE_4("2003h:1", tumble_navcomp_progress_t, 1U, run.index, run.count, run.finished, run.mounting);
TUMBLE_IN_LINE_3("2003h:4", tumble_navcomp_progress_t, 1U, run.mounting, run.position, run.attempt);
TUMBLE_IN_LINE_2("2003h:7", tumble_navcomp_progress_t, 4U, run.samples, run.samples_wanted);
TUMBLE_HAS_SIZE("2003h:9", tumble_navcomp_progress_t, 8U, run.target_deg);
TUMBLE_HAS_SIZE("2003h:10", tumble_navcomp_progress_t, 8U, angle_deg);
TUMBLE_HAS_SIZE("2003h:11", tumble_navcomp_progress_t, 1U, temperature_half_c);
TUMBLE_IN_LINE_2("2003h:12", tumble_navcomp_progress_t, 1U, as_byte.stand, as_byte.stays_bolted);
TUMBLE_HAS_SIZE("2003h:14", tumble_navcomp_progress_t, 8U, run.inclination_deg);
TUMBLE_IN_LINE_2("2004h:1", tumble_navcomp_progress_t, 1U, as_byte.failed_in, as_byte.status);
TUMBLE_HAS_SIZE("2004h:3", tumble_navcomp_progress_t, 2U, run.drive_code);
TUMBLE_IN_LINE_2("2004h:4", tumble_navcomp_progress_t, 1U, stand_fault, limited);
TUMBLE_HAS_SIZE("2004h:6", tumble_navcomp_progress_t, 2U, refusal.index);
TUMBLE_HAS_SIZE("2004h:7", tumble_navcomp_progress_t, 1U, refusal.subindex);
TUMBLE_HAS_SIZE("2004h:8", tumble_navcomp_progress_t, 4U, refusal.abort);
TUMBLE_HAS_SIZE("2004h:9", tumble_navcomp_progress_t, 1U, refusal.step);
TUMBLE_HAS_SIZE("2004h:10", tumble_navcomp_progress_t, 1U, rung);
TUMBLE_IS_ARRAY("2010h:1", tumble_navcomp_progress_t, 8U, mean_v, mean_v[0], 3U);
TUMBLE_IS_ARRAY("2011h:1", tumble_navcomp_progress_t, 8U, standard_error_v, standard_error_v[0], 3U);
TUMBLE_IS_ARRAY("2020h:1", tumble_coefficients_t, 8U, k_v_per_g, k_v_per_g[0][0], 9U);
TUMBLE_IS_ARRAY("2021h:1", tumble_coefficients_t, 8U, u0_v, u0_v[0], 3U);
TUMBLE_IN_LINE_2("2022h:1", tumble_gravity_check_t, 8U, max_abs_fit_g, max_abs_check_g);
TUMBLE_HAS_SIZE("2022h:3", tumble_procedure_config_t, 8U, gravity_limit_g);
TUMBLE_IN_LINE_2("2022h:4", tumble_gravity_check_t, 1U, fit_positions, check_positions);
TUMBLE_HAS_SIZE("2022h:6", tumble_gravity_check_t, 1U, pass);
TUMBLE_IN_LINE_4("2030h:1", tumble_navcomp_counters_t, 4U, link.sent, link.received, link.busy, link.down);
TUMBLE_IN_LINE_2("2030h:4", tumble_navcomp_counters_t, 4U, link.down, link.invalid);
TUMBLE_IN_LINE_4("2031h:1", tumble_navcomp_counters_t, 4U,
                 events.frames_ignored, events.source_corrupted, events.source_faults, events.commands_refused);
TUMBLE_IN_LINE_4("2031h:4", tumble_navcomp_counters_t, 4U,
                 events.commands_refused, events.heartbeats_lost, events.boot_ups, events.starts);
TUMBLE_IN_LINE_3("2031h:7", tumble_navcomp_counters_t, 4U, events.starts, events.emergencies, events.foreign);
TUMBLE_IN_LINE_4("2032h:1", tumble_navcomp_counters_t, 4U, block.samples, block.lost, block.repeated, block.reordered);
TUMBLE_IN_LINE_4("2032h:4", tumble_navcomp_counters_t, 4U,
                 block.reordered, block.wrong_length, block.wrong_crc, block.wrong_pair);
TUMBLE_IN_LINE_2("2032h:7", tumble_navcomp_counters_t, 4U, block.wrong_pair, block.lone_halves);
TUMBLE_IN_LINE_4("2033h:1", tumble_navcomp_counters_t, 4U,
                 averaging.saturated, averaging.deviating, averaging.repeated, averaging.reordered);
TUMBLE_IN_LINE_2("2033h:4", tumble_navcomp_counters_t, 4U, averaging.reordered, averaging.lost);
TUMBLE_IN_LINE_4("2034h:1", tumble_navcomp_counters_t, 4U,
                 procedure.samples, procedure.corrupted, procedure.lost, procedure.averaged);
TUMBLE_IN_LINE_4("2034h:4", tumble_navcomp_counters_t, 4U,
                 procedure.averaged, procedure.positions, procedure.refused, procedure.retries);
TUMBLE_IN_LINE_4("2034h:7", tumble_navcomp_counters_t, 4U,
                 procedure.retries, procedure.timeouts, procedure.moves, procedure.unwinds);
TUMBLE_IN_LINE_4("2034h:10", tumble_navcomp_counters_t, 4U,
                 procedure.unwinds, procedure.homings, procedure.faults, procedure.resumes);
TUMBLE_IN_LINE_2("2034h:13", tumble_navcomp_counters_t, 4U, procedure.resumes, procedure.commands_refused);
TUMBLE_IN_LINE_4("2035h:1", tumble_navcomp_counters_t, 4U, stop.rungs[0], stop.rungs[1], stop.rungs[2], stop.rungs[3]);
TUMBLE_IN_LINE_3("2035h:4", tumble_navcomp_counters_t, 4U, stop.rungs[3], stop.rungs[4], stop.implausible);
TUMBLE_HAS_SIZE("2040h:1", tumble_drive_mirror_t, 2U, controlword);
TUMBLE_HAS_SIZE("2040h:2", tumble_drive_mirror_t, 4U, target_position);
TUMBLE_HAS_SIZE("2040h:3", tumble_drive_mirror_t, 1U, mode);
TUMBLE_HAS_SIZE("2040h:4", tumble_drive_mirror_t, 2U, statusword);
TUMBLE_HAS_SIZE("2040h:5", tumble_drive_mirror_t, 4U, actual_position);
TUMBLE_HAS_SIZE("2040h:6", tumble_drive_mirror_t, 1U, mode_display);
TUMBLE_HAS_SIZE("2040h:7", tumble_drive_mirror_t, 4U, actual_velocity);
TUMBLE_HAS_SIZE("2040h:8", tumble_drive_mirror_t, 2U, error_code);
TUMBLE_HAS_SIZE("2050h:1", tumble_procedure_config_t, 4U, samples);
TUMBLE_HAS_SIZE("2050h:3", tumble_procedure_config_t, 2U, settle_ms);
TUMBLE_HAS_SIZE("2050h:4", tumble_procedure_config_t, 1U, retries);
TUMBLE_HAS_SIZE("2050h:5", tumble_procedure_config_t, 8U, gravity_limit_g);

static const tumble_entry_t entries[] = {
    TUMBLE_ROW(0x0005, 0, UNSIGNED8, IMMEDIATE, WO | RPDO, 1, 0, 0, 0, 0, 0), /* Dummy UNSIGNED8 */
    TUMBLE_ROW(0x0006, 0, UNSIGNED16, IMMEDIATE, WO | RPDO, 2, 0, 0, 0, 0, 0), /* Dummy UNSIGNED16 */
    TUMBLE_ROW(0x0007, 0, UNSIGNED32, IMMEDIATE, WO | RPDO, 4, 0, 0, 0, 0, 0), /* Dummy UNSIGNED32 */
    TUMBLE_ROW(0x1000, 0, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 0, 0), /* Device type */
    TUMBLE_ROW(0x1001, 0, UNSIGNED8, COMMUNICATION, RO | TPDO, 1, 0, 0, 0, 0, 0), /* Error register */
    TUMBLE_ROW(0x1003, 0, UNSIGNED8, COMMUNICATION, RW, 1, 0, 0, 0, 0, 0), /* Pre-defined error field */
    TUMBLE_ROW(0x1003, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 3, 0, 0),
    TUMBLE_ROW(0x1005, 0, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 128, 0), /* COB-ID SYNC message */
    TUMBLE_ROW(0x1008, 0, VISIBLE_STRING, CONSTANT, RO, 26, 0, 0, 0, offsetof(constants_t, value_1008_0), 0), /* Manufacturer device name */
    TUMBLE_ROW(0x1009, 0, VISIBLE_STRING, CONSTANT, RO, 9, 0, 0, 0, offsetof(constants_t, value_1009_0), 0), /* Manufacturer hardware version */
    TUMBLE_ROW(0x100A, 0, VISIBLE_STRING, CONSTANT, RO, 5, 0, 0, 0, offsetof(constants_t, value_100a_0), 0), /* Manufacturer software version */
    TUMBLE_ROW(0x1014, 0, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 0, 0, 0), /* COB-ID EMCY */
    TUMBLE_ROW(0x1016, 1, UNSIGNED32, COMMUNICATION, RW | SERVICE, 4, 0, 0, 3, 0, 0), /* Consumer heartbeat time */
    TUMBLE_ROW(0x1017, 0, UNSIGNED16, COMMUNICATION, RW | SERVICE, 2, 0, 0, 0, 0, 0), /* Producer heartbeat time */
    TUMBLE_ROW(0x1018, 1, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 0, 0), /* Identity object */
    TUMBLE_ROW(0x1018, 2, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1018_2), 0),
    TUMBLE_ROW(0x1018, 3, UNSIGNED32, CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, value_1018_3), 0),
    TUMBLE_ROW(0x1018, 4, UNSIGNED32, IMMEDIATE, RO, 4, 0, 0, 0, 1, 0),
    TUMBLE_ROW(0x1029, 1, UNSIGNED8, COMMUNICATION, RW | SERVICE, 1, 2, 0, 0, 0, 0), /* Error behaviour */
    TUMBLE_ROW(0x1200, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 1, 1, 0, 0), /* SDO server parameter, and 1 more */
    TUMBLE_ROW(0x1280, 1, UNSIGNED32, COMMUNICATION, RO, 4, 0, 0, 1, 0, 0), /* SDO client parameter */
    TUMBLE_ROW(0x1280, 3, UNSIGNED8, COMMUNICATION, RO, 1, 0, 0, 0, 0, 0),
    TUMBLE_ROW(0x1400, 1, UNSIGNED32, COMMUNICATION, RW | SERVICE, 4, 0, 1, 0, 0, 0), /* Receive PDO 1 parameter, and 1 more */
    TUMBLE_ROW(0x1400, 2, UNSIGNED8, COMMUNICATION, RW | SERVICE, 1, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1600, 0, UNSIGNED8, COMMUNICATION, RW | SERVICE, 1, 0, 1, 0, 0, 0), /* Receive PDO 1 mapping, and 1 more */
    TUMBLE_ROW(0x1600, 1, UNSIGNED32, COMMUNICATION, RW | SERVICE, 4, 0, 1, 7, 0, 0),
    TUMBLE_ROW(0x1800, 1, UNSIGNED32, COMMUNICATION, RW | SERVICE, 4, 0, 1, 0, 0, 0), /* Transmit PDO 1 parameter, and 1 more */
    TUMBLE_ROW(0x1800, 2, UNSIGNED8, COMMUNICATION, RW | SERVICE, 1, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1800, 3, UNSIGNED16, COMMUNICATION, RW | SERVICE, 2, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1800, 5, UNSIGNED16, COMMUNICATION, RW | SERVICE, 2, 0, 1, 0, 0, 0),
    TUMBLE_ROW(0x1802, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 2, 0, 0, 0), /* Transmit PDO 3 parameter, and 2 more */
    TUMBLE_ROW(0x1802, 2, UNSIGNED8, COMMUNICATION, RW, 1, 0, 2, 0, 0, 0),
    TUMBLE_ROW(0x1802, 3, UNSIGNED16, COMMUNICATION, RW, 2, 0, 2, 0, 0, 0),
    TUMBLE_ROW(0x1802, 5, UNSIGNED16, COMMUNICATION, RW, 2, 0, 2, 0, 0, 0),
    TUMBLE_ROW(0x1A00, 0, UNSIGNED8, COMMUNICATION, RW | SERVICE, 1, 0, 1, 0, 0, 0), /* Transmit PDO 1 mapping, and 1 more */
    TUMBLE_ROW(0x1A00, 1, UNSIGNED32, COMMUNICATION, RW | SERVICE, 4, 0, 1, 7, 0, 0),
    TUMBLE_ROW(0x1A02, 0, UNSIGNED8, COMMUNICATION, RW, 1, 0, 2, 0, 0, 0), /* Transmit PDO 3 mapping, and 2 more */
    TUMBLE_ROW(0x1A02, 1, UNSIGNED32, COMMUNICATION, RW, 4, 0, 2, 7, 0, 0),
    TUMBLE_ROW(0x2000, 0, UNSIGNED8, COMPUTED, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_navcomp_progress_t, as_byte.state), TUMBLE_NAVCOMP_SOURCE_PROGRESS), /* State */
    TUMBLE_ROW(0x2001, 0, UNSIGNED8, COMPUTED, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_navcomp_progress_t, as_byte.reason), TUMBLE_NAVCOMP_SOURCE_PROGRESS), /* Reason */
    TUMBLE_ROW(0x2002, 1, UNSIGNED8, VARIABLES, RW, 1, 0, 0, 0, offsetof(tumble_navcomp_objects_t, command_argument), 0), /* Command */
    TUMBLE_ROW(0x2002, 2, UNSIGNED8, COMPUTED, WO, 1, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_COMMAND),
    TUMBLE_ROW(0x2002, 3, REAL64, VARIABLES, RW, 8, 1, 0, 0, offsetof(tumble_navcomp_objects_t, command_angle), 0),
    TUMBLE_ROW(0x2002, 4, UNSIGNED32, VARIABLES, RW, 4, 0, 0, 0, offsetof(tumble_navcomp_objects_t, command_proposal), 0),
    TUMBLE_ROW(0x2003, 1, UNSIGNED8, COMPUTED, RO | TPDO, 1, 0, 0, 5, offsetof(tumble_navcomp_progress_t, run.index), TUMBLE_NAVCOMP_SOURCE_PROGRESS), /* Progress */
    TUMBLE_ROW(0x2003, 7, UNSIGNED32, COMPUTED, RO | TPDO, 4, 0, 0, 1, offsetof(tumble_navcomp_progress_t, run.samples), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2003, 9, REAL64, COMPUTED, RO | TPDO, 8, 0, 0, 0, offsetof(tumble_navcomp_progress_t, run.target_deg), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2003, 10, REAL64, COMPUTED, RO | TPDO, 8, 0, 0, 0, offsetof(tumble_navcomp_progress_t, angle_deg), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2003, 11, INTEGER8, COMPUTED, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_navcomp_progress_t, temperature_half_c), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2003, 12, UNSIGNED8, COMPUTED, RO | TPDO, 1, 0, 0, 1, offsetof(tumble_navcomp_progress_t, as_byte.stand), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2003, 14, REAL64, COMPUTED, RO | TPDO, 8, 0, 0, 0, offsetof(tumble_navcomp_progress_t, run.inclination_deg), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 1, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 1, offsetof(tumble_navcomp_progress_t, as_byte.failed_in), TUMBLE_NAVCOMP_SOURCE_PROGRESS), /* Failure */
    TUMBLE_ROW(0x2004, 3, UNSIGNED16, COMPUTED, RO, 2, 0, 0, 0, offsetof(tumble_navcomp_progress_t, run.drive_code), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 4, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 1, offsetof(tumble_navcomp_progress_t, stand_fault), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 6, UNSIGNED16, COMPUTED, RO, 2, 0, 0, 0, offsetof(tumble_navcomp_progress_t, refusal.index), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 7, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 0, offsetof(tumble_navcomp_progress_t, refusal.subindex), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 8, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 0, offsetof(tumble_navcomp_progress_t, refusal.abort), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 9, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 0, offsetof(tumble_navcomp_progress_t, refusal.step), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2004, 10, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 0, offsetof(tumble_navcomp_progress_t, rung), TUMBLE_NAVCOMP_SOURCE_PROGRESS),
    TUMBLE_ROW(0x2006, 1, UNSIGNED32, COMPUTED, WO, 4, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_SERVICE_KEY), /* Service level */
    TUMBLE_ROW(0x2006, 2, UNSIGNED8, COMPUTED, RO | TPDO, 1, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_SERVICE_LEVEL),
    TUMBLE_ROW(0x2006, 3, UNSIGNED16, COMPUTED, RO | TPDO, 2, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_SERVICE_LEFT),
    TUMBLE_ROW(0x2007, 0, UNSIGNED32, COMPUTED, RO | TPDO, 4, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_RUN), /* Run number */
    TUMBLE_ROW(0x2008, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_RUN), /* Run */
    TUMBLE_ROW(0x2008, 2, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_RUN_OF_RESULT),
    TUMBLE_ROW(0x2008, 3, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_RUN_OF_MEAN),
    TUMBLE_ROW(0x2010, 1, REAL64, COMPUTED, RO, 8, 0, 0, 2, offsetof(tumble_navcomp_progress_t, mean_v[0]), TUMBLE_NAVCOMP_SOURCE_MEAN), /* Running mean */
    TUMBLE_ROW(0x2011, 1, REAL64, COMPUTED, RO, 8, 0, 0, 2, offsetof(tumble_navcomp_progress_t, standard_error_v[0]), TUMBLE_NAVCOMP_SOURCE_MEAN), /* Standard error */
    TUMBLE_ROW(0x2020, 1, REAL64, COMPUTED, RO, 8, 0, 0, 8, offsetof(tumble_coefficients_t, k_v_per_g[0][0]), TUMBLE_NAVCOMP_SOURCE_COEFFICIENTS), /* K */
    TUMBLE_ROW(0x2021, 1, REAL64, COMPUTED, RO, 8, 0, 0, 2, offsetof(tumble_coefficients_t, u0_v[0]), TUMBLE_NAVCOMP_SOURCE_COEFFICIENTS), /* U0 */
    TUMBLE_ROW(0x2022, 1, REAL64, COMPUTED, RO, 8, 0, 0, 1, offsetof(tumble_gravity_check_t, max_abs_fit_g), TUMBLE_NAVCOMP_SOURCE_CHECK), /* Gravity check */
    TUMBLE_ROW(0x2022, 3, REAL64, COMPUTED, RO, 8, 0, 0, 0, offsetof(tumble_procedure_config_t, gravity_limit_g), TUMBLE_NAVCOMP_SOURCE_LIMIT),
    TUMBLE_ROW(0x2022, 4, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 1, offsetof(tumble_gravity_check_t, fit_positions), TUMBLE_NAVCOMP_SOURCE_CHECK),
    TUMBLE_ROW(0x2022, 6, BOOLEAN, COMPUTED, RO, 1, 0, 0, 0, offsetof(tumble_gravity_check_t, pass), TUMBLE_NAVCOMP_SOURCE_CHECK),
    TUMBLE_ROW(0x2030, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 4, offsetof(tumble_navcomp_counters_t, link.sent), TUMBLE_NAVCOMP_SOURCE_COUNTERS), /* Bus counters */
    TUMBLE_ROW(0x2031, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 8, offsetof(tumble_navcomp_counters_t, events.frames_ignored), TUMBLE_NAVCOMP_SOURCE_COUNTERS), /* Node counters */
    TUMBLE_ROW(0x2032, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 7, offsetof(tumble_navcomp_counters_t, block.samples), TUMBLE_NAVCOMP_SOURCE_COUNTERS), /* Block counters */
    TUMBLE_ROW(0x2033, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 4, offsetof(tumble_navcomp_counters_t, averaging.saturated), TUMBLE_NAVCOMP_SOURCE_COUNTERS), /* Averaging counters */
    TUMBLE_ROW(0x2034, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 13, offsetof(tumble_navcomp_counters_t, procedure.samples), TUMBLE_NAVCOMP_SOURCE_COUNTERS), /* Procedure counters */
    TUMBLE_ROW(0x2035, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 5, offsetof(tumble_navcomp_counters_t, stop.rungs[0]), TUMBLE_NAVCOMP_SOURCE_COUNTERS), /* Stop counters */
    TUMBLE_ROW(0x2040, 1, UNSIGNED16, OTHER, RO | TPDO, 2, 0, 0, 0, offsetof(tumble_drive_mirror_t, controlword), 0), /* Drive */
    TUMBLE_ROW(0x2040, 2, INTEGER32, OTHER, RO | TPDO, 4, 0, 0, 0, offsetof(tumble_drive_mirror_t, target_position), 0),
    TUMBLE_ROW(0x2040, 3, INTEGER8, OTHER, RO | TPDO, 1, 0, 0, 0, offsetof(tumble_drive_mirror_t, mode), 0),
    TUMBLE_ROW(0x2040, 4, UNSIGNED16, OTHER, RW | RPDO, 2, 0, 0, 0, offsetof(tumble_drive_mirror_t, statusword), 0),
    TUMBLE_ROW(0x2040, 5, INTEGER32, OTHER, RW | RPDO, 4, 0, 0, 0, offsetof(tumble_drive_mirror_t, actual_position), 0),
    TUMBLE_ROW(0x2040, 6, INTEGER8, OTHER, RW | RPDO, 1, 0, 0, 0, offsetof(tumble_drive_mirror_t, mode_display), 0),
    TUMBLE_ROW(0x2040, 7, INTEGER32, OTHER, RW | RPDO, 4, 0, 0, 0, offsetof(tumble_drive_mirror_t, actual_velocity), 0),
    TUMBLE_ROW(0x2040, 8, UNSIGNED16, OTHER, RW | RPDO, 2, 0, 0, 0, offsetof(tumble_drive_mirror_t, error_code), 0),
    TUMBLE_ROW(0x2050, 1, UNSIGNED32, COMPUTED, RW, 4, 6, 0, 0, offsetof(tumble_procedure_config_t, samples), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION), /* Configuration */
    TUMBLE_ROW(0x2050, 2, UNSIGNED8, COMPUTED, RW, 1, 2, 0, 0, 0, TUMBLE_NAVCOMP_SOURCE_ESTIMATOR),
    TUMBLE_ROW(0x2050, 3, UNSIGNED16, COMPUTED, RW, 2, 4, 0, 0, offsetof(tumble_procedure_config_t, settle_ms), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION),
    TUMBLE_ROW(0x2050, 4, UNSIGNED8, COMPUTED, RW, 1, 3, 0, 0, offsetof(tumble_procedure_config_t, retries), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION),
    TUMBLE_ROW(0x2050, 5, REAL64, COMPUTED, RW | SERVICE, 8, 5, 0, 0, offsetof(tumble_procedure_config_t, gravity_limit_g), TUMBLE_NAVCOMP_SOURCE_CONFIGURATION),
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
