#include "scripted_config.h"

const tumble_averaging_config_t scripted_averaging = {
    .saturation_counts = 8388607,
    .min_samples = 2,
    .max_lost = 2,
    .stuck_run = 8,
    .noise_counts = 3.0F,
    .stillness_ratio = 5.0F,
};

const tumble_procedure_config_t scripted_procedure = {
    .schedule = &tumble_schedule_paper,
    .estimate = TUMBLE_ESTIMATE_REFINED,
    .samples = 12,
    .v_per_count = 1e-6,
    .nominal_scale_v_per_g = -2.0,
    .gravity_limit_g = 3e-4,
    .closure_limit_g = 1e-3,
    .position_tolerance_deg = 0.1,
    .approach_deg = 5.0,
    .cable_min_deg = -20.0,
    .cable_max_deg = 380.0,
    .settle_ms = 100,
    .max_corrupted = 3,
    .retries = 1,
    .preflight_timeout_ms = 5000,
    .warm_up_timeout_ms = 60000,
    .mounting_timeout_ms = 600000,
    .home_timeout_ms = 40000,
    .move_timeout_ms = 20000,
    .settle_timeout_ms = 5000,
    .average_timeout_ms = 10000,
    .sample_timeout_ms = 500,
};

static const tumble_drive_pdo_t scripted_drive_receive[] = {
    {.number = 0,
     .setup = {.cob_id = 0x202, .type = TUMBLE_PDO_EVENT_PROFILE, .count = 2, .map = {0x60400010, 0x607A0020}}},
};
static const tumble_drive_pdo_t scripted_drive_transmit[] = {
    {.number = 0,
     .setup = {.cob_id = 0x182,
               .type = TUMBLE_PDO_EVENT_PROFILE,
               .count = 2,
               .event_ms = 20,
               .map = {0x60410010, 0x60640020}}},
};
const tumble_drive_profile_t scripted_drive_profile = {
    .counts_per_revolution = SCRIPTED_COUNTS_PER_REVOLUTION,
    .velocity_units_per_deg_s = 1000.0,
    .acceleration_units_per_deg_s2 = 1000.0,
    .sign = 1,
    .window_counts = 50,
    .velocity_deg_s = 1000.0, /* any move takes 0.2 s */
    .acceleration_deg_s2 = 180.0,
    .deceleration_deg_s2 = 180.0,
    .quick_stop_deg_s2 = 720.0,
    .homing_fast_deg_s = 20.0,
    .homing_slow_deg_s = 2.0,
    .homing_acceleration_deg_s2 = 90.0,
    .homing_method = 35,
    .stop = TUMBLE_STOP_BY_QUICK_STOP,
    .receive = scripted_drive_receive,
    .transmit = scripted_drive_transmit,
    .receive_count = 1,
    .transmit_count = 1,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .start_timeout_ms = 1000,
    .power_timeout_ms = 1000,
    .handshake_timeout_ms = 500,
    .home_timeout_ms = 30000,
    .move_timeout_ms = 15000,
    .stop_timeout_ms = 2000,
};

const tumble_navcomp_config_t scripted_navcomp = {
    .stand = &tumble_drive402_kind,
    .stand_profile = &scripted_drive_profile,
    .block_period_us = 10000,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .node = 1,
    .stand_node = SCRIPTED_DRIVE_NODE,
    .block_node = SCRIPTED_BLOCK_NODE,
};
