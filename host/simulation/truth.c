#include "simulation/truth.h"

#include <string.h>

static double draw_once(const sim_stand_t *stand, double limit, uint64_t seed, sim_cause_t cause)
{
    sim_random_t stream;
    sim_random_open(&stream, seed, cause, 0);
    return sim_law_draw(stand->law, limit, &stream);
}

static double draw_coefficient(uint64_t seed, uint32_t number, double middle, double half_width)
{
    sim_random_t stream;
    sim_random_open(&stream, seed, SIM_CAUSE_BLOCK, number);
    return middle + half_width * sim_random_symmetric(&stream);
}

static void draw_block(tumble_coefficients_t *block, const sim_block_config_t *config, uint64_t seed)
{
    for (uint32_t i = 0; i < TUMBLE_CHANNELS; i++) {
        const double scale = config->scale_v_per_g[i];
        for (uint32_t j = 0; j < TUMBLE_CHANNELS; j++) {
            const bool own = i == j;
            block->k_v_per_g[i][j] = draw_coefficient(seed, TUMBLE_CHANNELS * i + j, own ? scale : 0.0,
                                                      scale * (own ? config->scale_spread : config->misalignment_rad));
        }
        block->u0_v[i] = draw_coefficient(seed, TUMBLE_CHANNELS * TUMBLE_CHANNELS + i, 0.0, config->bias_v[i]);
    }
}

static void draw_seat(sim_truth_t *truth, const sim_stand_t *stand, uint8_t m)
{
    truth->theta_h_rad[m] = truth->platform_rad + sim_law_draw(stand->law, stand->seat_rad, &truth->seat[m]);
    truth->theta_n_rad[m] = sim_law_draw(stand->law, stand->seat_rad, &truth->seat[m]);
}

static void draw_encoder(sim_truth_t *truth, const sim_stand_t *stand, uint64_t seed)
{
    sim_random_t stream;
    sim_random_open(&stream, seed, SIM_CAUSE_ENCODER, 0);
    for (int i = 0; i < TUMBLE_WAVES; i++) {
        truth->encoder_rad[i] = sim_law_draw(stand->law, stand->encoder_rad, &stream);
    }
}

static void draw_drift(sim_truth_t *truth, const sim_stand_t *stand, uint64_t seed)
{
    sim_random_t stream;
    sim_random_open(&stream, seed, SIM_CAUSE_DRIFT, 0);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        truth->drift_v[i] = sim_law_draw(stand->law, stand->drift_v[i], &stream);
    }
}

void sim_truth_draw(sim_truth_t *truth, const sim_scenario_t *scenario, uint64_t seed)
{
    const sim_stand_t *const stand = &scenario->stand;
    memset(truth, 0, sizeof *truth);
    truth->alpha1_rad = draw_once(stand, stand->axis_tilt_rad, seed, SIM_CAUSE_AXIS_TILT);
    truth->alpha2_rad = draw_once(stand, stand->level_rad, seed, SIM_CAUSE_LEVEL);
    truth->platform_rad = draw_once(stand, stand->platform_rad, seed, SIM_CAUSE_PLATFORM);
    draw_encoder(truth, stand, seed);
    draw_drift(truth, stand, seed);
    if (scenario->block.given) {
        memcpy(truth->block.k_v_per_g, scenario->block.sensor.k_v_per_g, sizeof truth->block.k_v_per_g);
        memcpy(truth->block.u0_v, scenario->block.sensor.u0_v, sizeof truth->block.u0_v);
    } else {
        draw_block(&truth->block, &scenario->block, seed);
    }
    for (uint8_t m = 0; m < scenario->schedule.mounting_count; m++) {
        const uint32_t index = (stand->remount == SIM_REMOUNT_COMMON) ? 0U : scenario->schedule.mountings[m].number;
        sim_random_open(&truth->remount[m], seed, SIM_CAUSE_REMOUNT, index);
        truth->alpha3_rad[m] = sim_law_draw(stand->law, stand->remount_rad, &truth->remount[m]);
        sim_random_open(&truth->seat[m], seed, SIM_CAUSE_SEAT, scenario->schedule.mountings[m].number);
        draw_seat(truth, stand, m);
    }
}

void sim_truth_remount(sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index)
{
    const sim_stand_t *const stand = &scenario->stand;
    draw_seat(truth, stand, mounting_index);
    if (stand->remount == SIM_REMOUNT_INDEPENDENT) {
        truth->alpha3_rad[mounting_index] =
            sim_law_draw(stand->law, stand->remount_rad, &truth->remount[mounting_index]);
    }
}

void sim_truth_bias(const sim_truth_t *truth, const tumble_schedule_t *schedule, uint8_t position,
                    double u0_v[TUMBLE_CHANNELS])
{
    int before = 0;
    int all = 0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const int fits = (schedule->positions[p].use == TUMBLE_USE_FIT) ? 1 : 0;
        before += (p < position) ? fits : 0;
        all += fits;
    }
    const double place = before - ((schedule->positions[position].use == TUMBLE_USE_FIT) ? 0.0 : 0.5);
    const double course = place / ((all > 1) ? all - 1.0 : 1.0) - 0.5;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        u0_v[i] = truth->block.u0_v[i] + truth->drift_v[i] * course;
    }
}
