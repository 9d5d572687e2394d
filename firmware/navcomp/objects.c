/* Written by tools/objects/generate from tools/objects/navcomp.toml: change it there. */
#include "navcomp/objects.h"

#include "canopen/cia402.h"
#include "navcomp/navcomp.h"

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
    .value_100a_0 = "0.1.0",
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

/* How far behind another a member lies. */
#define BYTES_TO(type, from, member) (offsetof(type, member) - offsetof(type, from))

static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.index) == 1U, "2003h:1");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.count) == 1U, "2003h:2");
static_assert(BYTES_TO(tumble_navcomp_progress_t, run.index, run.count) == 1U, "2003h:2");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.finished) == 1U, "2003h:3");
static_assert(BYTES_TO(tumble_navcomp_progress_t, run.index, run.finished) == 2U, "2003h:3");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.mounting) == 1U, "2003h:4");
static_assert(BYTES_TO(tumble_navcomp_progress_t, run.index, run.mounting) == 3U, "2003h:4");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.position) == 1U, "2003h:5");
static_assert(BYTES_TO(tumble_navcomp_progress_t, run.index, run.position) == 4U, "2003h:5");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.attempt) == 1U, "2003h:6");
static_assert(BYTES_TO(tumble_navcomp_progress_t, run.index, run.attempt) == 5U, "2003h:6");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.samples) == 4U, "2003h:7");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.samples_wanted) == 4U, "2003h:8");
static_assert(BYTES_TO(tumble_navcomp_progress_t, run.samples, run.samples_wanted) == 4U, "2003h:8");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.target_deg) == 8U, "2003h:9");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->angle_deg) == 8U, "2003h:10");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->temperature_half_c) == 1U, "2003h:11");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.drive_code) == 2U, "2004h:3");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->mean_v[0]) == 8U, "2010h:1");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->mean_v[1]) == 8U, "2010h:2");
static_assert(BYTES_TO(tumble_navcomp_progress_t, mean_v[0], mean_v[1]) == 8U, "2010h:2");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->mean_v[2]) == 8U, "2010h:3");
static_assert(BYTES_TO(tumble_navcomp_progress_t, mean_v[0], mean_v[2]) == 16U, "2010h:3");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->standard_error_v[0]) == 8U, "2011h:1");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->standard_error_v[1]) == 8U, "2011h:2");
static_assert(BYTES_TO(tumble_navcomp_progress_t, standard_error_v[0], standard_error_v[1]) == 8U, "2011h:2");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->standard_error_v[2]) == 8U, "2011h:3");
static_assert(BYTES_TO(tumble_navcomp_progress_t, standard_error_v[0], standard_error_v[2]) == 16U, "2011h:3");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[0][0]) == 8U, "2020h:1");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[0][1]) == 8U, "2020h:2");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[0][1]) == 8U, "2020h:2");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[0][2]) == 8U, "2020h:3");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[0][2]) == 16U, "2020h:3");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[1][0]) == 8U, "2020h:4");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[1][0]) == 24U, "2020h:4");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[1][1]) == 8U, "2020h:5");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[1][1]) == 32U, "2020h:5");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[1][2]) == 8U, "2020h:6");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[1][2]) == 40U, "2020h:6");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[2][0]) == 8U, "2020h:7");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[2][0]) == 48U, "2020h:7");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[2][1]) == 8U, "2020h:8");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[2][1]) == 56U, "2020h:8");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[2][2]) == 8U, "2020h:9");
static_assert(BYTES_TO(tumble_coefficients_t, k_v_per_g[0][0], k_v_per_g[2][2]) == 64U, "2020h:9");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->u0_v[0]) == 8U, "2021h:1");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->u0_v[1]) == 8U, "2021h:2");
static_assert(BYTES_TO(tumble_coefficients_t, u0_v[0], u0_v[1]) == 8U, "2021h:2");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->u0_v[2]) == 8U, "2021h:3");
static_assert(BYTES_TO(tumble_coefficients_t, u0_v[0], u0_v[2]) == 16U, "2021h:3");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->max_abs_fit_g) == 8U, "2022h:1");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->max_abs_check_g) == 8U, "2022h:2");
static_assert(BYTES_TO(tumble_gravity_check_t, max_abs_fit_g, max_abs_check_g) == 8U, "2022h:2");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->gravity_limit_g) == 8U, "2022h:3");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->fit_positions) == 1U, "2022h:4");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->check_positions) == 1U, "2022h:5");
static_assert(BYTES_TO(tumble_gravity_check_t, fit_positions, check_positions) == 1U, "2022h:5");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->pass) == 1U, "2022h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.sent) == 4U, "2030h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.received) == 4U, "2030h:2");
static_assert(BYTES_TO(tumble_navcomp_counters_t, link.sent, link.received) == 4U, "2030h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.busy) == 4U, "2030h:3");
static_assert(BYTES_TO(tumble_navcomp_counters_t, link.sent, link.busy) == 8U, "2030h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.down) == 4U, "2030h:4");
static_assert(BYTES_TO(tumble_navcomp_counters_t, link.sent, link.down) == 12U, "2030h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.invalid) == 4U, "2030h:5");
static_assert(BYTES_TO(tumble_navcomp_counters_t, link.sent, link.invalid) == 16U, "2030h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.frames_ignored) == 4U, "2031h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.source_corrupted) == 4U, "2031h:2");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.source_corrupted) == 4U, "2031h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.source_faults) == 4U, "2031h:3");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.source_faults) == 8U, "2031h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.commands_refused) == 4U, "2031h:4");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.commands_refused) == 12U, "2031h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.heartbeats_lost) == 4U, "2031h:5");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.heartbeats_lost) == 16U, "2031h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.boot_ups) == 4U, "2031h:6");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.boot_ups) == 20U, "2031h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.starts) == 4U, "2031h:7");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.starts) == 24U, "2031h:7");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.emergencies) == 4U, "2031h:8");
static_assert(BYTES_TO(tumble_navcomp_counters_t, events.frames_ignored, events.emergencies) == 28U, "2031h:8");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.samples) == 4U, "2032h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.lost) == 4U, "2032h:2");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.lost) == 4U, "2032h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.repeated) == 4U, "2032h:3");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.repeated) == 8U, "2032h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.reordered) == 4U, "2032h:4");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.reordered) == 12U, "2032h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.wrong_length) == 4U, "2032h:5");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.wrong_length) == 16U, "2032h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.wrong_crc) == 4U, "2032h:6");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.wrong_crc) == 20U, "2032h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.wrong_pair) == 4U, "2032h:7");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.wrong_pair) == 24U, "2032h:7");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.lone_halves) == 4U, "2032h:8");
static_assert(BYTES_TO(tumble_navcomp_counters_t, block.samples, block.lone_halves) == 28U, "2032h:8");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.saturated) == 4U, "2033h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.deviating) == 4U, "2033h:2");
static_assert(BYTES_TO(tumble_navcomp_counters_t, averaging.saturated, averaging.deviating) == 4U, "2033h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.repeated) == 4U, "2033h:3");
static_assert(BYTES_TO(tumble_navcomp_counters_t, averaging.saturated, averaging.repeated) == 8U, "2033h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.reordered) == 4U, "2033h:4");
static_assert(BYTES_TO(tumble_navcomp_counters_t, averaging.saturated, averaging.reordered) == 12U, "2033h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.lost) == 4U, "2033h:5");
static_assert(BYTES_TO(tumble_navcomp_counters_t, averaging.saturated, averaging.lost) == 16U, "2033h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.samples) == 4U, "2034h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.corrupted) == 4U, "2034h:2");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.corrupted) == 4U, "2034h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.lost) == 4U, "2034h:3");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.lost) == 8U, "2034h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.averaged) == 4U, "2034h:4");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.averaged) == 12U, "2034h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.positions) == 4U, "2034h:5");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.positions) == 16U, "2034h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.refused) == 4U, "2034h:6");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.refused) == 20U, "2034h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.retries) == 4U, "2034h:7");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.retries) == 24U, "2034h:7");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.timeouts) == 4U, "2034h:8");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.timeouts) == 28U, "2034h:8");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.moves) == 4U, "2034h:9");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.moves) == 32U, "2034h:9");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.unwinds) == 4U, "2034h:10");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.unwinds) == 36U, "2034h:10");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.homings) == 4U, "2034h:11");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.homings) == 40U, "2034h:11");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.faults) == 4U, "2034h:12");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.faults) == 44U, "2034h:12");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.resumes) == 4U, "2034h:13");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.resumes) == 48U, "2034h:13");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.commands_refused) == 4U, "2034h:14");
static_assert(BYTES_TO(tumble_navcomp_counters_t, procedure.samples, procedure.commands_refused) == 52U, "2034h:14");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->controlword) == 2U, "2040h:1");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->target_position) == 4U, "2040h:2");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->mode) == 1U, "2040h:3");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->statusword) == 2U, "2040h:4");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->actual_position) == 4U, "2040h:5");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->mode_display) == 1U, "2040h:6");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->actual_velocity) == 4U, "2040h:7");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->error_code) == 2U, "2040h:8");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->samples) == 4U, "2050h:1");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->settle_ms) == 2U, "2050h:3");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->retries) == 1U, "2050h:4");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->gravity_limit_g) == 8U, "2050h:5");

static const tumble_entry_t entries[] = {
    /* Dummy UNSIGNED8 */
    {0x0005U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 0U, 0U, 0U},
    /* Dummy UNSIGNED16 */
    {0x0006U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_IMMEDIATE, 2U, 0U, 0U, 0U, 0U},
    /* Dummy UNSIGNED32 */
    {0x0007U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_IMMEDIATE, 4U, 0U, 0U, 0U, 0U},
    /* Device type */
    {0x1000U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_IMMEDIATE, 4U, 0U, 0U, 0U, 0U},
    /* Error register */
    {0x1001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 0U},
    /* Pre-defined error field */
    {0x1003U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 0U},
    {0x1003U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 3U, 0U},
    /* COB-ID SYNC message */
    {0x1005U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_IMMEDIATE, 4U, 0U, 128U, 0U, 0U},
    /* Manufacturer device name */
    {0x1008U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 26U, 0U, offsetof(constants_t, value_1008_0), 0U, 0U},
    /* Manufacturer hardware version */
    {0x1009U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 9U, 0U, offsetof(constants_t, value_1009_0), 0U, 0U},
    /* Manufacturer software version */
    {0x100AU, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 5U, 0U, offsetof(constants_t, value_100a_0), 0U, 0U},
    /* COB-ID EMCY */
    {0x1014U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 0U, 0U},
    /* Consumer heartbeat time */
    {0x1016U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 3U, 0U},
    /* Producer heartbeat time */
    {0x1017U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U, 0U, 0U},
    /* Identity object */
    {0x1018U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_IMMEDIATE, 4U, 0U, 0U, 0U, 0U},
    {0x1018U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 4U, 0U, offsetof(constants_t, value_1018_2), 0U, 0U},
    {0x1018U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 4U, 0U, offsetof(constants_t, value_1018_3), 0U, 0U},
    {0x1018U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_IMMEDIATE, 4U, 0U, 1U, 0U, 0U},
    /* Error behaviour */
    {0x1029U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 2U, 0U, 0U, 0U},
    /* SDO server parameter */
    {0x1200U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 1U, 0U},
    /* SDO client parameter */
    {0x1280U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 1U, 0U},
    {0x1280U, 3U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 0U},
    /* Receive PDO 1 parameter, and 1 more */
    {0x1400U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 0U, 1U},
    {0x1400U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 1U},
    /* Receive PDO 1 mapping, and 1 more */
    {0x1600U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 1U},
    {0x1600U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 7U, 1U},
    /* Transmit PDO 1 parameter, and 2 more */
    {0x1800U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 0U, 2U},
    {0x1800U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 2U},
    {0x1800U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U, 0U, 2U},
    {0x1800U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U, 0U, 2U},
    /* Transmit PDO 1 mapping, and 2 more */
    {0x1A00U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 2U},
    {0x1A00U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 7U, 2U},
    /* State */
    {0x2000U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    /* Reason */
    {0x2001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    /* Command */
    {0x2002U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_VARIABLES, 1U, 0U, offsetof(tumble_navcomp_objects_t, command_argument), 0U, 0U},
    {0x2002U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_WRITE, TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    {0x2002U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_VARIABLES, 8U, 1U, offsetof(tumble_navcomp_objects_t, command_angle), 0U, 0U},
    /* Progress */
    {0x2003U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.index), 5U, 0U},
    {0x2003U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_progress_t, run.samples), 1U, 0U},
    {0x2003U, 9U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, run.target_deg), 0U, 0U},
    {0x2003U, 10U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, angle_deg), 0U, 0U},
    {0x2003U, 11U, TUMBLE_TYPE_INTEGER8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, temperature_half_c), 0U, 0U},
    {0x2003U, 12U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    /* Failure */
    {0x2004U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    {0x2004U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    {0x2004U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 2U, 0U, offsetof(tumble_navcomp_progress_t, run.drive_code), 0U, 0U},
    /* Running mean */
    {0x2010U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, mean_v[0]), 2U, 0U},
    /* Standard error */
    {0x2011U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, standard_error_v[0]), 2U, 0U},
    /* K */
    {0x2020U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[0][0]), 8U, 0U},
    /* U0 */
    {0x2021U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, u0_v[0]), 2U, 0U},
    /* Gravity check */
    {0x2022U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_gravity_check_t, max_abs_fit_g), 1U, 0U},
    {0x2022U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_procedure_config_t, gravity_limit_g), 0U, 0U},
    {0x2022U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_gravity_check_t, fit_positions), 1U, 0U},
    {0x2022U, 6U, TUMBLE_TYPE_BOOLEAN, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_gravity_check_t, pass), 0U, 0U},
    /* Bus counters */
    {0x2030U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, link.sent), 4U, 0U},
    /* Node counters */
    {0x2031U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.frames_ignored), 7U, 0U},
    /* Block counters */
    {0x2032U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.samples), 7U, 0U},
    /* Averaging counters */
    {0x2033U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, averaging.saturated), 4U, 0U},
    /* Procedure counters */
    {0x2034U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.samples), 13U, 0U},
    /* Drive */
    {0x2040U, 1U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_OTHER, 2U, 0U, offsetof(tumble_drive_mirror_t, controlword), 0U, 0U},
    {0x2040U, 2U, TUMBLE_TYPE_INTEGER32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_OTHER, 4U, 0U, offsetof(tumble_drive_mirror_t, target_position), 0U, 0U},
    {0x2040U, 3U, TUMBLE_TYPE_INTEGER8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_OTHER, 1U, 0U, offsetof(tumble_drive_mirror_t, mode), 0U, 0U},
    {0x2040U, 4U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 2U, 0U, offsetof(tumble_drive_mirror_t, statusword), 0U, 0U},
    {0x2040U, 5U, TUMBLE_TYPE_INTEGER32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 4U, 0U, offsetof(tumble_drive_mirror_t, actual_position), 0U, 0U},
    {0x2040U, 6U, TUMBLE_TYPE_INTEGER8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 1U, 0U, offsetof(tumble_drive_mirror_t, mode_display), 0U, 0U},
    {0x2040U, 7U, TUMBLE_TYPE_INTEGER32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 4U, 0U, offsetof(tumble_drive_mirror_t, actual_velocity), 0U, 0U},
    {0x2040U, 8U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 2U, 0U, offsetof(tumble_drive_mirror_t, error_code), 0U, 0U},
    /* Configuration */
    {0x2050U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 6U, offsetof(tumble_procedure_config_t, samples), 0U, 0U},
    {0x2050U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 2U, 0U, 0U, 0U},
    {0x2050U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 2U, 4U, offsetof(tumble_procedure_config_t, settle_ms), 0U, 0U},
    {0x2050U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 3U, offsetof(tumble_procedure_config_t, retries), 0U, 0U},
    {0x2050U, 5U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 8U, 5U, offsetof(tumble_procedure_config_t, gravity_limit_g), 0U, 0U},
};

const tumble_object_table_t tumble_navcomp_table = {
    .entries = entries,
    .limits = limits,
    .constants = &constants,
    .count = sizeof entries / sizeof entries[0],
};

static const tumble_pdo_setup_t receive[] = {
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
};
static_assert((sizeof receive / sizeof receive[0]) <= TUMBLE_MAX_RECEIVE_PDOS, "receive");

static const tumble_pdo_setup_t transmit[] = {
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x180U, .type = 255U, .count = 5U, .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x20000008U, 0x20010008U, 0x20030108U, 0x20030308U, 0x20030720U, 0U, 0U, 0U}},
};
static_assert((sizeof transmit / sizeof transmit[0]) <= TUMBLE_MAX_TRANSMIT_PDOS, "transmit");

const tumble_node_defaults_t tumble_navcomp_defaults = {
    .receive = receive,
    .transmit = transmit,
    .receive_count = 2U,
    .transmit_count = 3U,
    .heartbeat_ms = 100U,
    .consumers = {0x000201F4U, 0x000301F4U, 0x00000000U, 0x00000000U},
    .on_error = 1U,
};
