#include "navcomp/standard.h"

#define SAMPLES 50U

const tumble_averaging_config_t tumble_standard_averaging = {
    .saturation_counts = 8388607, /* 24 bits */
    .min_samples = SAMPLES,       /* for fewer the ratio below would be too strict */
    .max_lost = 5,
    .stuck_run = 20,
    .noise_counts = 251.6584F,     /* 0.3 mV, and rounding to a count */
    .stillness_ratio = 1.6060915F, /* 1 + 6 / sqrt(2 (samples - 1)): six standard deviations of a scatter */
};

const tumble_procedure_config_t tumble_standard_procedure = {
    .schedule = &tumble_schedule_paper,
    .averaging = &tumble_standard_averaging,
    .estimate = TUMBLE_ESTIMATE_REFINED,
    .samples = SAMPLES,
    .v_per_count = 20.0 / 16777216.0, /* +-10 V in 24 bits */
    .nominal_scale_v_per_g = -2.0,
    .gravity_limit_g = 3e-4,
    .closure_limit_g = 2e-3, /* 23 standard deviations of it with angles good to 4e-5 rad and the means' noise */
    .position_tolerance_deg = 0.05,
    .approach_deg = 5.0,
    .cable_min_deg = -30.0,
    .cable_max_deg = 400.0,
    .settle_ms = 500,
    .max_corrupted = 5,
    .retries = 2,
    .warm_up_band_half_c = 2,
    .warm_up_samples = 50,
    .preflight_timeout_ms = 10000,
    .warm_up_timeout_ms = 600000,
    .mounting_timeout_ms = 600000,
    .home_timeout_ms = 60000,
    .move_timeout_ms = 30000,
    .settle_timeout_ms = 5000,
    .average_timeout_ms = 11000, /* 10 s, and twice what 50 samples take at 100 a second */
    .sample_timeout_ms = 1000,   /* 100 samples */
};

static const tumble_drive_pdo_t RECEIVE[] = {
    {.number = 0,
     .setup = {.cob_id = 0x202,
               .type = TUMBLE_PDO_EVENT_PROFILE,
               .count = 2,
               .map = {TUMBLE_MAP(0x6040, 0, 16), TUMBLE_MAP(0x607A, 0, 32), 0, 0, 0, 0, 0, 0}}},
};

static const tumble_drive_pdo_t TRANSMIT[] = {
    {.number = 0,
     .setup = {.cob_id = 0x182,
               .type = TUMBLE_PDO_EVENT_PROFILE,
               .count = 2,
               .inhibit_100us = 50,
               .event_ms = 100,
               .map = {TUMBLE_MAP(0x6041, 0, 16), TUMBLE_MAP(0x6064, 0, 32), 0, 0, 0, 0, 0, 0}}},
};

const tumble_drive_profile_t tumble_standard_drive = {
    .counts_per_revolution = 360000.0,
    .velocity_units_per_deg_s = 1000.0,
    .acceleration_units_per_deg_s2 = 1000.0,
    .sign = 1,
    .velocity_deg_s = 90.0,
    .acceleration_deg_s2 = 180.0,
    .deceleration_deg_s2 = 180.0,
    .quick_stop_deg_s2 = 180.0,
    .homing_fast_deg_s = 45.0,
    .homing_slow_deg_s = 4.5,
    .homing_acceleration_deg_s2 = 180.0,
    .homing_method = 34,
    .stop = TUMBLE_STOP_BY_QUICK_STOP,
    .software_limits = true,
    .receive = RECEIVE,
    .transmit = TRANSMIT,
    .receive_count = 1,
    .transmit_count = 1,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .start_timeout_ms = 3000,
    .power_timeout_ms = 3000,
    .handshake_timeout_ms = 1000,
    .home_timeout_ms = 60000,
    .move_timeout_ms = 30000,
    .stop_timeout_ms = 5000,
};

const tumble_navcomp_config_t tumble_standard_navcomp = {
    .procedure = &tumble_standard_procedure,
    .stand = &tumble_drive402_kind,
    .stand_profile = &tumble_standard_drive,
    .block_period_us = 10000,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .node = 1,
    .stand_node = 2,
    .block_node = 3,
};
