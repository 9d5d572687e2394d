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
    {0.0, 2.0},
    {0.0, 255.0},
    {0.0, 4095.0},
    {1e-12, 1.0},
    {1.0, 1048576.0},
};

static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.index) == 1, "2003h:1");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.count) == 1, "2003h:2");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.finished) == 1, "2003h:3");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.mounting) == 1, "2003h:4");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.position) == 1, "2003h:5");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.attempt) == 1, "2003h:6");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.samples) == 4, "2003h:7");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.samples_wanted) == 4, "2003h:8");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.target_deg) == 8, "2003h:9");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->angle_deg) == 8, "2003h:10");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->temperature_half_c) == 1, "2003h:11");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->run.drive_code) == 2, "2004h:3");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->mean_v[0]) == 8, "2010h:1");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->mean_v[1]) == 8, "2010h:2");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->mean_v[2]) == 8, "2010h:3");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->standard_error_v[0]) == 8, "2011h:1");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->standard_error_v[1]) == 8, "2011h:2");
static_assert(sizeof(((const tumble_navcomp_progress_t *)NULL)->standard_error_v[2]) == 8, "2011h:3");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[0][0]) == 8, "2020h:1");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[0][1]) == 8, "2020h:2");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[0][2]) == 8, "2020h:3");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[1][0]) == 8, "2020h:4");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[1][1]) == 8, "2020h:5");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[1][2]) == 8, "2020h:6");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[2][0]) == 8, "2020h:7");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[2][1]) == 8, "2020h:8");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->k_v_per_g[2][2]) == 8, "2020h:9");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->u0_v[0]) == 8, "2021h:1");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->u0_v[1]) == 8, "2021h:2");
static_assert(sizeof(((const tumble_coefficients_t *)NULL)->u0_v[2]) == 8, "2021h:3");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->max_abs_fit_g) == 8, "2022h:1");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->max_abs_check_g) == 8, "2022h:2");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->gravity_limit_g) == 8, "2022h:3");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->fit_positions) == 1, "2022h:4");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->check_positions) == 1, "2022h:5");
static_assert(sizeof(((const tumble_gravity_check_t *)NULL)->pass) == 1, "2022h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.sent) == 4, "2030h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.received) == 4, "2030h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.busy) == 4, "2030h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.down) == 4, "2030h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->link.invalid) == 4, "2030h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.frames_ignored) == 4, "2031h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.source_corrupted) == 4, "2031h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.source_faults) == 4, "2031h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.commands_refused) == 4, "2031h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.heartbeats_lost) == 4, "2031h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.boot_ups) == 4, "2031h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.starts) == 4, "2031h:7");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->events.emergencies) == 4, "2031h:8");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.samples) == 4, "2032h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.lost) == 4, "2032h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.repeated) == 4, "2032h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.reordered) == 4, "2032h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.wrong_length) == 4, "2032h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.wrong_crc) == 4, "2032h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.wrong_pair) == 4, "2032h:7");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->block.lone_halves) == 4, "2032h:8");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.saturated) == 4, "2033h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.deviating) == 4, "2033h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.repeated) == 4, "2033h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.reordered) == 4, "2033h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->averaging.lost) == 4, "2033h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.samples) == 4, "2034h:1");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.corrupted) == 4, "2034h:2");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.lost) == 4, "2034h:3");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.averaged) == 4, "2034h:4");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.positions) == 4, "2034h:5");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.refused) == 4, "2034h:6");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.retries) == 4, "2034h:7");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.timeouts) == 4, "2034h:8");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.moves) == 4, "2034h:9");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.unwinds) == 4, "2034h:10");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.homings) == 4, "2034h:11");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.faults) == 4, "2034h:12");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.resumes) == 4, "2034h:13");
static_assert(sizeof(((const tumble_navcomp_counters_t *)NULL)->procedure.commands_refused) == 4, "2034h:14");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->controlword) == 2, "2040h:1");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->target_position) == 4, "2040h:2");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->mode) == 1, "2040h:3");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->statusword) == 2, "2040h:4");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->actual_position) == 4, "2040h:5");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->mode_display) == 1, "2040h:6");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->actual_velocity) == 4, "2040h:7");
static_assert(sizeof(((const tumble_drive_mirror_t *)NULL)->error_code) == 2, "2040h:8");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->samples) == 4, "2050h:1");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->settle_ms) == 2, "2050h:3");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->retries) == 1, "2050h:4");
static_assert(sizeof(((const tumble_procedure_config_t *)NULL)->gravity_limit_g) == 8, "2050h:5");

static const tumble_entry_t entries[] = {
    /* Dummy UNSIGNED8 */
    {0x0005U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 0U},
    /* Dummy UNSIGNED16 */
    {0x0006U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_IMMEDIATE, 2U, 0U, 0U},
    /* Dummy UNSIGNED32 */
    {0x0007U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_IMMEDIATE, 4U, 0U, 0U},
    /* Device type */
    {0x1000U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 4U, 0U, 0U},
    /* Error register */
    {0x1001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    /* Pre-defined error field */
    {0x1003U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1003U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1003U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1003U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1003U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* COB-ID SYNC message */
    {0x1005U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 4U, 0U, 128U},
    /* Manufacturer device name */
    {0x1008U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 26U, 0U, offsetof(constants_t, value_1008_0)},
    /* Manufacturer hardware version */
    {0x1009U, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 9U, 0U, offsetof(constants_t, value_1009_0)},
    /* Manufacturer software version */
    {0x100AU, 0U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 5U, 0U, offsetof(constants_t, value_100a_0)},
    /* COB-ID EMCY */
    {0x1014U, 0U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* Consumer heartbeat time */
    {0x1016U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 4U},
    {0x1016U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1016U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1016U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1016U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* Producer heartbeat time */
    {0x1017U, 0U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    /* Identity object */
    {0x1018U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 4U},
    {0x1018U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 4U, 0U, 0U},
    {0x1018U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 4U, 0U, offsetof(constants_t, value_1018_2)},
    {0x1018U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_CONSTANT, 4U, 0U, offsetof(constants_t, value_1018_3)},
    {0x1018U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 4U, 0U, 1U},
    /* Error behaviour */
    {0x1029U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 1U},
    {0x1029U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 1U, 0U},
    /* SDO server parameter */
    {0x1200U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 2U},
    {0x1200U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1200U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* SDO client parameter */
    {0x1280U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 3U},
    {0x1280U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1280U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1280U, 3U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    /* Receive PDO 1 parameter */
    {0x1400U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 2U},
    {0x1400U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1400U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    /* Receive PDO 2 parameter */
    {0x1401U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 2U},
    {0x1401U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1401U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    /* Receive PDO 1 mapping */
    {0x1600U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1600U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1600U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* Receive PDO 2 mapping */
    {0x1601U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1601U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1601U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* Transmit PDO 1 parameter */
    {0x1800U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 5U},
    {0x1800U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1800U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1800U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    {0x1800U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    /* Transmit PDO 2 parameter */
    {0x1801U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 5U},
    {0x1801U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1801U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1801U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    {0x1801U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    /* Transmit PDO 3 parameter */
    {0x1802U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 5U},
    {0x1802U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1802U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1802U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    {0x1802U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U},
    /* Transmit PDO 1 mapping */
    {0x1A00U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1A00U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A00U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* Transmit PDO 2 mapping */
    {0x1A01U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1A01U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A01U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* Transmit PDO 3 mapping */
    {0x1A02U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U},
    {0x1A02U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    {0x1A02U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U},
    /* State */
    {0x2000U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U},
    /* Reason */
    {0x2001U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U},
    /* Command */
    {0x2002U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 2U},
    {0x2002U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_VARIABLES, 1U, 0U, offsetof(tumble_navcomp_objects_t, command_argument)},
    {0x2002U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U},
    /* Progress */
    {0x2003U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 11U},
    {0x2003U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.index)},
    {0x2003U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.count)},
    {0x2003U, 3U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.finished)},
    {0x2003U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.mounting)},
    {0x2003U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.position)},
    {0x2003U, 6U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, run.attempt)},
    {0x2003U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_progress_t, run.samples)},
    {0x2003U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_progress_t, run.samples_wanted)},
    {0x2003U, 9U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, run.target_deg)},
    {0x2003U, 10U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, angle_deg)},
    {0x2003U, 11U, TUMBLE_TYPE_INTEGER8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_navcomp_progress_t, temperature_half_c)},
    /* Failure */
    {0x2004U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 3U},
    {0x2004U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U},
    {0x2004U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, 0U},
    {0x2004U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 2U, 0U, offsetof(tumble_navcomp_progress_t, run.drive_code)},
    /* Running mean */
    {0x2010U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 3U},
    {0x2010U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, mean_v[0])},
    {0x2010U, 2U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, mean_v[1])},
    {0x2010U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, mean_v[2])},
    /* Standard error */
    {0x2011U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 3U},
    {0x2011U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, standard_error_v[0])},
    {0x2011U, 2U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, standard_error_v[1])},
    {0x2011U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_navcomp_progress_t, standard_error_v[2])},
    /* K */
    {0x2020U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 9U},
    {0x2020U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[0][0])},
    {0x2020U, 2U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[0][1])},
    {0x2020U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[0][2])},
    {0x2020U, 4U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[1][0])},
    {0x2020U, 5U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[1][1])},
    {0x2020U, 6U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[1][2])},
    {0x2020U, 7U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[2][0])},
    {0x2020U, 8U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[2][1])},
    {0x2020U, 9U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, k_v_per_g[2][2])},
    /* U0 */
    {0x2021U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 3U},
    {0x2021U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, u0_v[0])},
    {0x2021U, 2U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, u0_v[1])},
    {0x2021U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_coefficients_t, u0_v[2])},
    /* Gravity check */
    {0x2022U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 6U},
    {0x2022U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_gravity_check_t, max_abs_fit_g)},
    {0x2022U, 2U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_gravity_check_t, max_abs_check_g)},
    {0x2022U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_procedure_config_t, gravity_limit_g)},
    {0x2022U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_gravity_check_t, fit_positions)},
    {0x2022U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_gravity_check_t, check_positions)},
    {0x2022U, 6U, TUMBLE_TYPE_BOOLEAN, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_gravity_check_t, pass)},
    /* Bus counters */
    {0x2030U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 5U},
    {0x2030U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, link.sent)},
    {0x2030U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, link.received)},
    {0x2030U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, link.busy)},
    {0x2030U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, link.down)},
    {0x2030U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, link.invalid)},
    /* Node counters */
    {0x2031U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 8U},
    {0x2031U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.frames_ignored)},
    {0x2031U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.source_corrupted)},
    {0x2031U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.source_faults)},
    {0x2031U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.commands_refused)},
    {0x2031U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.heartbeats_lost)},
    {0x2031U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.boot_ups)},
    {0x2031U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.starts)},
    {0x2031U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, events.emergencies)},
    /* Block counters */
    {0x2032U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 8U},
    {0x2032U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.samples)},
    {0x2032U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.lost)},
    {0x2032U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.repeated)},
    {0x2032U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.reordered)},
    {0x2032U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.wrong_length)},
    {0x2032U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.wrong_crc)},
    {0x2032U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.wrong_pair)},
    {0x2032U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, block.lone_halves)},
    /* Averaging counters */
    {0x2033U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 5U},
    {0x2033U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, averaging.saturated)},
    {0x2033U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, averaging.deviating)},
    {0x2033U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, averaging.repeated)},
    {0x2033U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, averaging.reordered)},
    {0x2033U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, averaging.lost)},
    /* Procedure counters */
    {0x2034U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 14U},
    {0x2034U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.samples)},
    {0x2034U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.corrupted)},
    {0x2034U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.lost)},
    {0x2034U, 4U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.averaged)},
    {0x2034U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.positions)},
    {0x2034U, 6U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.refused)},
    {0x2034U, 7U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.retries)},
    {0x2034U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.timeouts)},
    {0x2034U, 9U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.moves)},
    {0x2034U, 10U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.unwinds)},
    {0x2034U, 11U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.homings)},
    {0x2034U, 12U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.faults)},
    {0x2034U, 13U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.resumes)},
    {0x2034U, 14U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_navcomp_counters_t, procedure.commands_refused)},
    /* Drive */
    {0x2040U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 8U},
    {0x2040U, 1U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_OTHER, 2U, 0U, offsetof(tumble_drive_mirror_t, controlword)},
    {0x2040U, 2U, TUMBLE_TYPE_INTEGER32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_OTHER, 4U, 0U, offsetof(tumble_drive_mirror_t, target_position)},
    {0x2040U, 3U, TUMBLE_TYPE_INTEGER8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_OTHER, 1U, 0U, offsetof(tumble_drive_mirror_t, mode)},
    {0x2040U, 4U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 2U, 0U, offsetof(tumble_drive_mirror_t, statusword)},
    {0x2040U, 5U, TUMBLE_TYPE_INTEGER32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 4U, 0U, offsetof(tumble_drive_mirror_t, actual_position)},
    {0x2040U, 6U, TUMBLE_TYPE_INTEGER8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 1U, 0U, offsetof(tumble_drive_mirror_t, mode_display)},
    {0x2040U, 7U, TUMBLE_TYPE_INTEGER32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 4U, 0U, offsetof(tumble_drive_mirror_t, actual_velocity)},
    {0x2040U, 8U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE,
     TUMBLE_HOME_OTHER, 2U, 0U, offsetof(tumble_drive_mirror_t, error_code)},
    /* Configuration */
    {0x2050U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_IMMEDIATE, 1U, 0U, 5U},
    {0x2050U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 5U, offsetof(tumble_procedure_config_t, samples)},
    {0x2050U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 1U, 0U},
    {0x2050U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 2U, 3U, offsetof(tumble_procedure_config_t, settle_ms)},
    {0x2050U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 2U, offsetof(tumble_procedure_config_t, retries)},
    {0x2050U, 5U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 8U, 4U, offsetof(tumble_procedure_config_t, gravity_limit_g)},
};

const tumble_object_table_t tumble_navcomp_table = {
    .entries = entries,
    .limits = limits,
    .constants = &constants,
    .count = sizeof entries / sizeof entries[0],
};

static const tumble_pdo_setup_t receive[] = {
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U,
     .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U,
     .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U}},
};
static_assert(sizeof receive / sizeof receive[0] <= TUMBLE_MAX_RECEIVE_PDOS, "receive");

static const tumble_pdo_setup_t transmit[] = {
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U,
     .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U,
     .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U}},
    {.cob_id = 0x180U, .type = 255U, .count = 5U,
     .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x20000008U, 0x20010008U, 0x20030108U, 0x20030308U, 0x20030720U}},
};
static_assert(sizeof transmit / sizeof transmit[0] <= TUMBLE_MAX_TRANSMIT_PDOS, "transmit");

const tumble_node_defaults_t tumble_navcomp_defaults = {
    .receive = receive,
    .transmit = transmit,
    .receive_count = 2U,
    .transmit_count = 3U,
    .heartbeat_ms = 100U,
    .consumers = {0x000201F4U, 0x000301F4U, 0x00000000U, 0x00000000U},
    .on_error = 1U,
};
