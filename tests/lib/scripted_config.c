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
