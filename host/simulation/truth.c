#include "simulation/truth.h"

#include "simulation/maths.h"

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

uint8_t sim_first_of_bolting(const tumble_schedule_t *schedule, uint8_t mounting_index)
{
    const uint8_t bolting = schedule->mountings[mounting_index].bolting;
    uint8_t first = (bolting == 0U) ? mounting_index : 0U;
    while (schedule->mountings[first].bolting != bolting) {
        first++;
    }
    return first;
}

static void draw_yaw(sim_truth_t *truth, const sim_stand_t *stand, uint8_t m, sim_random_t *stream)
{
    truth->alpha3_rad[m] = sim_law_draw(stand->law, stand->remount_rad, stream);
}

static void draw_seat(sim_truth_t *truth, const sim_stand_t *stand, uint8_t m, sim_random_t *stream)
{
    truth->theta_h_rad[m] = truth->platform_rad + sim_law_draw(stand->law, stand->seat_rad, stream);
    truth->theta_n_rad[m] = sim_law_draw(stand->law, stand->seat_rad, stream);
}

static void draw_mounting(sim_truth_t *truth, const sim_scenario_t *scenario, uint64_t seed, uint8_t m)
{
    const sim_stand_t *const stand = &scenario->stand;
    const uint32_t number = scenario->schedule.mountings[m].number;
    const uint8_t first = sim_first_of_bolting(&scenario->schedule, m);
    sim_random_open(&truth->incline[m], seed, SIM_CAUSE_INCLINATION, number);
    sim_truth_incline(truth, scenario, m);
    if (first < m) {
        sim_truth_keep_bolting(truth, first, m);
        return;
    }
    const uint32_t index = (stand->remount == SIM_REMOUNT_COMMON) ? 0U : number;
    sim_random_open(&truth->remount[m], seed, SIM_CAUSE_REMOUNT, index);
    draw_yaw(truth, stand, m, &truth->remount[m]);
    sim_random_open(&truth->seat[m], seed, SIM_CAUSE_SEAT, number);
    draw_seat(truth, stand, m, &truth->seat[m]);
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
    const uint64_t lasting = (scenario->of_seed > 0U) ? scenario->of_seed : seed; /* of what stays from run to run */
    memset(truth, 0, sizeof *truth);
    truth->alpha1_rad = draw_once(stand, stand->axis_tilt_rad, lasting, SIM_CAUSE_AXIS_TILT);
    truth->alpha2_rad = draw_once(stand, stand->level_rad, seed, SIM_CAUSE_LEVEL);
    truth->platform_rad = draw_once(stand, stand->platform_rad, lasting, SIM_CAUSE_PLATFORM);
    draw_encoder(truth, stand, lasting);
    draw_drift(truth, stand, seed);
    if (scenario->block.given) {
        memcpy(truth->block.k_v_per_g, scenario->block.sensor.k_v_per_g, sizeof truth->block.k_v_per_g);
        memcpy(truth->block.u0_v, scenario->block.sensor.u0_v, sizeof truth->block.u0_v);
    } else {
        draw_block(&truth->block, &scenario->block, lasting);
    }
    for (uint8_t m = 0; m < scenario->schedule.mounting_count; m++) {
        draw_mounting(truth, scenario, seed, m);
    }
}

void sim_truth_remount(sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index)
{
    const sim_stand_t *const stand = &scenario->stand;
    const uint8_t first = sim_first_of_bolting(&scenario->schedule, mounting_index);
    draw_seat(truth, stand, mounting_index, &truth->seat[first]);
    if (stand->remount == SIM_REMOUNT_INDEPENDENT) {
        draw_yaw(truth, stand, mounting_index, &truth->remount[first]);
    }
}

void sim_truth_keep_bolting(sim_truth_t *truth, uint8_t before, uint8_t mounting_index)
{
    truth->alpha3_rad[mounting_index] = truth->alpha3_rad[before];
    truth->theta_h_rad[mounting_index] = truth->theta_h_rad[before];
    truth->theta_n_rad[mounting_index] = truth->theta_n_rad[before];
}

void sim_truth_incline(sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index)
{
    const sim_stand_t *const stand = &scenario->stand;
    sim_random_t *const stream = &truth->incline[mounting_index];
    if (scenario->schedule.mountings[mounting_index].bolting > 0U) {
        truth->inclination_rad[mounting_index] = sim_law_draw(stand->law, stand->inclination_rad, stream);
        const double tau_rad = sim_law_draw(stand->law, stand->inclination_rad, stream);
        const bool is_first = sim_first_of_bolting(&scenario->schedule, mounting_index) == mounting_index;
        truth->tau_rad[mounting_index] = is_first ? 0.0 : tau_rad; /* the zero there is the table's: alpha2 */
    }
}

double sim_truth_beta_rad(const sim_truth_t *truth, const tumble_schedule_t *schedule, uint8_t mounting_index)
{
    const double nominal_rad = schedule->mountings[mounting_index].tilt.deg / SIM_DEG_PER_RAD;
    return nominal_rad + truth->alpha1_rad + truth->inclination_rad[mounting_index];
}

/* Gravity pulls the near end of the block down, which raises its n axis; and along the axis it pulls at the middle of the
 * block, which is above its platform where v points up: v follows n's lower end. */
sim_seat_t sim_truth_seat(const sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index)
{
    const sim_stand_t *const stand = &scenario->stand;
    double along_g;
    double across_g;
    sim_sincos_deg(sim_truth_beta_rad(truth, &scenario->schedule, mounting_index) * SIM_DEG_PER_RAD, &along_g,
                   &across_g);
    sim_seat_t seat = {.alpha1_rad = truth->alpha1_rad + truth->inclination_rad[mounting_index] +
                                     stand->sag_across_rad_per_g * across_g,
                       .alpha2_rad = truth->alpha2_rad + truth->tau_rad[mounting_index],
                       .alpha3_rad = truth->alpha3_rad[mounting_index],
                       .theta_h_rad = truth->theta_h_rad[mounting_index] + stand->sag_along_rad_per_g * along_g,
                       .theta_n_rad = truth->theta_n_rad[mounting_index]};
    memcpy(seat.encoder_rad, truth->encoder_rad, sizeof seat.encoder_rad);
    return seat;
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
