#include "simulation/scenario.h"

#include <string.h>

static void default_block(sim_block_config_t *block)
{
    block->scale_spread = 0.01;
    block->misalignment_rad = 0.02;
    block->sample_period_us = 10000;
    block->first_sample_us = 5000;
    block->sensor.noise_law = SIM_LAW_SIGMA1;
    block->sensor.range_v = 10.0;
    block->sensor.converter_bits = 24;
    block->sensor.temperature = (sim_temperature_t){.start_c = 25.0, .end_c = 25.0, .reference_c = 25.0};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        block->scale_v_per_g[i] = -2.0;
        block->bias_v[i] = 0.1;
        block->sensor.noise_v[i] = 3e-4;
    }
}

static void default_drive(sim_drive_config_t *drive)
{
    *drive = (sim_drive_config_t){
        .axis = {.swing_deg = 0.02, .swing_hz = 8.0, .settling_s = 0.5},
        .counts_per_turn = 360000,
        .sign = 1,
        .velocity_per_deg_s = 1000.0,
        .acceleration_per_deg_s2 = 1000.0,
        .speed_deg_s = 90.0,
        .acceleration_deg_s2 = 180.0,
        .power_on_deg = 30.0,
        .reaction_us = 1000,
        .report_us = 20000,
        .software_limits = true,
        .latches_stale_target = true,
    };
}

void sim_scenario_defaults(sim_scenario_t *scenario)
{
    memset(scenario, 0, sizeof *scenario);
    scenario->stand = (sim_stand_t){
        .axis_tilt_rad = 2e-5, .level_rad = 2e-5, .remount_rad = 4e-4, .angle_rad = 4e-5, .law = SIM_LAW_SIGMA1};
    default_block(&scenario->block);
    default_drive(&scenario->drive);
    scenario->operator = (sim_operator_config_t){.mount_s = 1.0, .incline_s = 1.0, .turn_s = 2.0, .mend_s = -1.0};
    scenario->bits_per_second = 500000;
    scenario->schedule = tumble_schedule_paper;
}

sim_fault_of_t sim_fault_of(sim_fault_kind_t kind)
{
#define FAULT_OF(name, of, word, sentence) SIM_OF_##of,
    static const sim_fault_of_t OF[] = {SIM_FAULT_LIST(FAULT_OF)};
#undef FAULT_OF
    return OF[kind];
}

const char *sim_fault_word(sim_fault_kind_t kind)
{
#define FAULT_WORD(name, of, word, sentence) word,
    static const char *const WORDS[] = {SIM_FAULT_LIST(FAULT_WORD)};
#undef FAULT_WORD
    return WORDS[kind];
}
