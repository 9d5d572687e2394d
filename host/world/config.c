#include "world/config.h"

#include "navcomp/standard.h"
#include "simulation/sensor.h"
#include "tumble/core.h"

#include <math.h>
#include <string.h>

/* With an error budget, unless the configuration says otherwise: the scatter of so few samples is known to a fifth. */
#define LEAST_SAMPLES 16U

#define LEAST_NOISE 1e-4 /* of the largest, that a channel without noise counts as */

#define OPEN (-1.0) /* not given, of what may be 0 */

/* The flags, by the switches. */
static void complete_keeping(bench_keeping_t *keeping)
{
    tumble_sets_settings_t *const settings = &keeping->settings;
    settings->limits.flags =
        (uint8_t)((keeping->commits ? TUMBLE_COMMIT_BY_ITSELF : 0) | (keeping->first ? TUMBLE_COMMIT_FIRST : 0));
    settings->flags = keeping->starts ? TUMBLE_SETS_STARTS : 0U;
}

/* Limits for a good stand: 1e-3 (ratio, rad or g) for uncertainties, 1e-4 a month for drift, three standard
 * uncertainties; sets commit themselves, but the first waits; nothing is ever due. No serial number:
 * who keeps coefficients must be told whose they are. */
static void default_keeping(bench_keeping_t *keeping)
{
    *keeping = (bench_keeping_t){
        .commits = true,
        .settings = {.limits = {.coverage = 3.0F}, .pause_s = 3600, .temperature_samples = 100},
    };
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        keeping->settings.limits.uncertainty[c] = 1e-3F;
        keeping->settings.limits.drift_per_month[c] = 1e-4F;
    }
    complete_keeping(keeping);
}

/* As standard.h has it, but what follows from the scenario is left open (0). */
static void default_averaging(tumble_averaging_config_t *averaging)
{
    *averaging = tumble_standard_averaging;
    averaging->min_samples = 0;
    averaging->noise_counts = 0.0F;
    averaging->stillness_ratio = 0.0F;
}

static void default_procedure(tumble_procedure_config_t *procedure)
{
    *procedure = tumble_standard_procedure;
    procedure->nominal_scale_v_per_g = 0.0;
    procedure->closure_limit_g = 0.0;
    procedure->average_timeout_ms = 0;
    procedure->sample_timeout_ms = 0;
}

static void default_profile(tumble_drive_profile_t *profile)
{
    *profile = tumble_standard_drive;
    profile->counts_per_revolution = 0.0;
    profile->velocity_units_per_deg_s = 0.0;
    profile->acceleration_units_per_deg_s2 = 0.0;
    profile->sign = 0;
    profile->velocity_deg_s = 0.0;
    profile->acceleration_deg_s2 = 0.0;
    profile->deceleration_deg_s2 = OPEN; /* 0 is an answer: not written */
    profile->quick_stop_deg_s2 = OPEN;
    profile->homing_acceleration_deg_s2 = OPEN;
    profile->receive_count = 0;
    profile->transmit_count = 0;
}

void bench_config_defaults(bench_config_t *config)
{
    memset(config, 0, sizeof *config);
    sim_scenario_defaults(&config->scenario);
    config->present = (bench_present_t){true, true, true};
    default_averaging(&config->averaging);
    default_procedure(&config->procedure);
    default_profile(&config->profile);
    config->operator = (tumble_operator_config_t){.tolerance_deg = 0.1, .timeout_ms = 600000};
    default_keeping(&config->keeping);
    config->heartbeat_ms = tumble_standard_navcomp.heartbeat_ms;
    config->heartbeat_timeout_ms = tumble_standard_navcomp.heartbeat_timeout_ms;
    config->starts = true;
    config->loop_us = 1000;
    config->virtual_limit_s = 36000.0;
}

static void set_if_open(double *value, double otherwise)
{
    if (*value == 0.0) {
        *value = otherwise;
    }
}

static void set_unless_given(double *value, double otherwise)
{
    if (*value == OPEN) {
        *value = otherwise;
    }
}

static double sigmas_per_limit(sim_law_t law)
{
    switch (law) {
    case SIM_LAW_SIGMA3:
        return 3.0;
    case SIM_LAW_UNIFORM:
        return sqrt(3.0);
    default:
        return 1.0;
    }
}

/* The standard deviation that a limit stands for. */
static double sigma_of(double limit, sim_law_t law)
{
    return limit / sigmas_per_limit(law);
}

static bool is_alike(const double by_channel[TUMBLE_CHANNELS])
{
    return by_channel[0] == by_channel[1] && by_channel[0] == by_channel[2];
}

static double largest_of(const double by_channel[TUMBLE_CHANNELS])
{
    return fmax(fmax(fabs(by_channel[0]), fabs(by_channel[1])), fabs(by_channel[2]));
}

static double least_of(const double by_channel[TUMBLE_CHANNELS])
{
    return fmin(fmin(fabs(by_channel[0]), fabs(by_channel[1])), fabs(by_channel[2]));
}

/* Of the means of so many samples, over the nominal scales of the channels, g. */
static double largest_noise_g(const sim_block_config_t *block, uint32_t samples)
{
    double noise_g[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double sigma_v = sigma_of(block->sensor.noise_v[i], block->sensor.noise_law);
        noise_g[i] = sigma_v / (fabs(block->scale_v_per_g[i]) * sqrt((double)samples));
    }
    return largest_of(noise_g);
}

/* A still block must not fail by chance: six standard deviations of a scatter found from n samples. */
static float still_ratio(uint32_t samples)
{
    const double freedom = (samples > 1U) ? (double)samples - 1.0 : 1.0;
    return (float)(1.0 + 6.0 / sqrt(2.0 * freedom));
}

static void complete_averaging(bench_config_t *config)
{
    const sim_sensor_config_t *const sensor = &config->scenario.block.sensor;
    tumble_averaging_config_t *const averaging = &config->averaging;
    const double v_per_count = sim_sensor_v_per_count(sensor);
    const double noise_counts = sigma_of(largest_of(sensor->noise_v), sensor->noise_law) / v_per_count;
    const double least_counts = sigma_of(least_of(sensor->noise_v), sensor->noise_law) / v_per_count;
    averaging->saturation_counts = (int32_t)((1U << (sensor->converter_bits - 1U)) - 1U);
    if (averaging->min_samples == 0U) {
        const bool all = config->procedure.error_budget_v == 0.0 || config->procedure.samples < LEAST_SAMPLES;
        averaging->min_samples = all ? config->procedure.samples : LEAST_SAMPLES;
    }
    if (averaging->noise_counts == 0.0F) {
        averaging->noise_counts = (float)sqrt(noise_counts * noise_counts + 1.0 / 12.0);
    }
    if (averaging->stillness_ratio == 0.0F) {
        averaging->stillness_ratio = still_ratio(averaging->min_samples);
    }
    if (least_counts < 1.0) {
        averaging->stuck_run = 0; /* with less noise than a count the same value may come for ever */
    }
}

static void complete_procedure(bench_config_t *config)
{
    const sim_scenario_t *const scenario = &config->scenario;
    tumble_procedure_config_t *const procedure = &config->procedure;
    const double *scale_v_per_g = scenario->block.scale_v_per_g;
    const double noise_g = largest_noise_g(&scenario->block, procedure->samples);
    const double budget_g = procedure->error_budget_v / least_of(scale_v_per_g);
    const double mean_g = (budget_g > noise_g) ? budget_g : noise_g;
    const double expected_g = sqrt(2.0) * (scenario->stand.angle_rad + mean_g);
    procedure->schedule = &scenario->schedule;
    procedure->averaging = &config->averaging;
    procedure->v_per_count = sim_sensor_v_per_count(&scenario->block.sensor);
    if (procedure->nominal_scale_v_per_g == 0.0 && !is_alike(scale_v_per_g)) {
        memcpy(procedure->channel_scale_v_per_g, scale_v_per_g, sizeof procedure->channel_scale_v_per_g);
    }
    set_if_open(&procedure->nominal_scale_v_per_g, scale_v_per_g[0]);
    set_if_open(&procedure->closure_limit_g, (10.0 * expected_g > 2e-3) ? 10.0 * expected_g : 2e-3);
    if (procedure->average_timeout_ms == 0U) {
        const double expected_ms = procedure->samples * (scenario->block.sample_period_us * 1e-3);
        const double allowed_ms = 10000.0 + 2.0 * expected_ms;
        procedure->average_timeout_ms = (allowed_ms < 4e9) ? (uint32_t)allowed_ms : UINT32_MAX;
    }
}

static bool needs_gains(const bench_config_t *config)
{
    return config->present.navcomp && config->procedure.estimate == TUMBLE_ESTIMATE_OPTIMAL;
}

/* How the firmware reaches the gains; null, or why it will not. */
static const char *complete_gains(bench_config_t *config)
{
    config->gains.work = &config->optimal;
    const bool needed = needs_gains(config);
    if (needed != (config->gains.record != NULL)) {
        return needed ? "procedure.estimator = optimal needs a gain record"
                      : "a gain record is for procedure.estimator = optimal alone";
    }
    const tumble_status_t status =
        needed ? tumble_optimal_check(&config->gains, &config->scenario.schedule) : TUMBLE_OK;
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

static double converter_noise_v(const bench_config_t *config)
{
    return fabs(config->procedure.v_per_count) / sqrt(12.0);
}

/* Weights of the channels go as 1 / noise, in multiples of the smallest one: bit for bit those by which the result is
 * checked (tumble/stand.py). */
static void weigh_channels(bench_config_t *config)
{
    const sim_sensor_config_t *const sensor = &config->scenario.block.sensor;
    const double limit_v = converter_noise_v(config) * sigmas_per_limit(sensor->noise_law);
    double noise_v[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        noise_v[i] = fmax(sensor->noise_v[i], limit_v);
    }
    const double largest_v = largest_of(noise_v);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        config->weights[i] = largest_v / fmax(noise_v[i], LEAST_NOISE * largest_v);
    }
}

static void lend_estimators(bench_config_t *config)
{
    const bool weighted = !is_alike(config->scenario.block.sensor.noise_v);
    weigh_channels(config);
    config->inclined = (tumble_inclined_source_t){weighted ? config->weights : NULL, &config->seen};
    config->lent[0] = (tumble_lent_t){TUMBLE_ESTIMATE_OPTIMAL,    tumble_optimal_check, tumble_optimal_estimate,
                                      tumble_optimal_uncertainty, &config->gains,       &config->lent[1]};
    config->lent[1] = (tumble_lent_t){TUMBLE_ESTIMATE_INCLINED,    tumble_inclined_check, tumble_inclined_estimate,
                                      tumble_inclined_uncertainty, &config->inclined,     NULL};
    config->procedure.lent = &config->lent[0];
}

/* The noise as the weights have it: never less than the converter's, and that of a mean at least 1e-9 g. */
static void declare_weighted_noise(bench_config_t *config)
{
    const tumble_gain_record_t *const made = config->gains.record;
    const double converter_v = converter_noise_v(config);
    tumble_stand_record_t *const record = &config->record;
    record->noise_v = fmax(record->noise_v, converter_v);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double own_v = record->channel_noise_v[i];
        record->channel_noise_v[i] = (own_v > 0.0) ? fmax(own_v, converter_v) : own_v;
    }
    for (int i = 0; i < TUMBLE_CHANNELS * TUMBLE_CHANNELS; i++) {
        const double floor_v = 1e-9 * fabs(made->k_v_per_g[i / TUMBLE_CHANNELS][i % TUMBLE_CHANNELS]);
        record->least_noise_v = (floor_v > record->least_noise_v) ? floor_v : record->least_noise_v;
    }
}

/* The stand that the firmware states its uncertainties for: as the scenario declares it. */
static void declare_stand(bench_config_t *config)
{
    const sim_stand_t *const stand = &config->scenario.stand;
    const sim_sensor_config_t *const sensor = &config->scenario.block.sensor;
    config->record = (tumble_stand_record_t){
        .axis_tilt_rad = sigma_of(stand->axis_tilt_rad, stand->law),
        .level_rad = sigma_of(stand->level_rad, stand->law),
        .remount_rad = sigma_of(stand->remount_rad, stand->law),
        .angle_rad = sigma_of(stand->angle_rad, stand->law),
        .noise_v = is_alike(sensor->noise_v) ? sigma_of(sensor->noise_v[0], sensor->noise_law) : 0.0,
        .samples = config->procedure.samples,
        .common_yaw = stand->remount == SIM_REMOUNT_COMMON,
        .seat_rad = sigma_of(stand->seat_rad, stand->law),
        .platform_rad = sigma_of(stand->platform_rad, stand->law),
        .encoder_rad = sigma_of(stand->encoder_rad, stand->law),
        .drift_v = is_alike(stand->drift_v) ? sigma_of(stand->drift_v[0], stand->law) : 0.0,
    };
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        config->record.channel_noise_v[i] =
            is_alike(sensor->noise_v) ? 0.0 : sigma_of(sensor->noise_v[i], sensor->noise_law);
        config->record.channel_drift_v[i] = is_alike(stand->drift_v) ? 0.0 : sigma_of(stand->drift_v[i], stand->law);
    }
    if (needs_gains(config)) {
        declare_weighted_noise(config);
    }
    config->declared = (tumble_declared_t){&config->record, tumble_navcomp_take_noise, &config->noise};
}

/* Silence of the block that is a fault: by default a hundred samples, never more than its eight-bit counter tells from a
 * step back. */
static const char *complete_sample_timeout(bench_config_t *config)
{
    uint32_t *const timeout_ms = &config->procedure.sample_timeout_ms;
    const double period_ms = config->scenario.block.sample_period_us * 1e-3;
    const double most_ms = floor(TUMBLE_BLOCK_MAX_GAP * period_ms) - config->heartbeat_ms;
    if (*timeout_ms == 0U && most_ms >= 1.0) {
        *timeout_ms = (uint32_t)((100.0 * period_ms < most_ms) ? 100.0 * period_ms : most_ms);
    }
    if (*timeout_ms == 0U || (double)*timeout_ms > most_ms) {
        return "procedure.sample_timeout_ms and firmware.heartbeat_ms together may last 127 samples of the block at most: "
               "beyond that its eight-bit counter does not tell how many were lost";
    }
    return NULL;
}

/* What the profile leaves open is as the simulated drive has it. */
static void complete_profile(bench_config_t *config)
{
    const sim_drive_config_t *const drive = &config->scenario.drive;
    tumble_drive_profile_t *const profile = &config->profile;
    bench_profile_lists_t *const lists = &config->lists;
    set_if_open(&profile->counts_per_revolution, (double)drive->counts_per_turn);
    set_if_open(&profile->velocity_units_per_deg_s, drive->velocity_per_deg_s);
    set_if_open(&profile->acceleration_units_per_deg_s2, drive->acceleration_per_deg_s2);
    set_if_open(&profile->velocity_deg_s, drive->speed_deg_s);
    set_if_open(&profile->acceleration_deg_s2, drive->acceleration_deg_s2);
    set_unless_given(&profile->deceleration_deg_s2, profile->acceleration_deg_s2);
    set_unless_given(&profile->quick_stop_deg_s2, profile->acceleration_deg_s2);
    set_unless_given(&profile->homing_acceleration_deg_s2, profile->acceleration_deg_s2);
    if (profile->sign == 0) {
        profile->sign = (int8_t)drive->sign;
        profile->wrap_counts = drive->wrap_counts;
    }
    if (profile->receive_count == 0U) {
        lists->receive[profile->receive_count++] = tumble_standard_drive.receive[0];
    }
    if (profile->transmit_count == 0U) {
        lists->transmit[profile->transmit_count++] = tumble_standard_drive.transmit[0];
    }
    profile->software_limits = profile->software_limits && drive->software_limits;
    profile->receive = lists->receive;
    profile->transmit = lists->transmit;
    profile->writes = lists->writes;
}

static void complete_schedule(sim_scenario_t *scenario)
{
    if (scenario->schedule.mountings != tumble_schedule_paper.mountings) {
        scenario->schedule.mountings = scenario->mountings;
        scenario->schedule.positions = scenario->positions;
    }
    scenario->drive.axis.resolution_deg = 360.0 / (double)scenario->drive.counts_per_turn;
}

static const char *check_faults(const bench_config_t *config)
{
    const sim_scenario_t *const scenario = &config->scenario;
    for (uint32_t i = 0; i < scenario->fault_count; i++) {
        const sim_fault_t *const fault = &scenario->faults[i];
        const uint8_t count = scenario->schedule.position_count;
        if (!fault->at_time && tumble_schedule_find(&scenario->schedule, fault->mounting, fault->position) == count) {
            return "a fault names a position that the schedule does not have";
        }
        const sim_fault_of_t of = sim_fault_of(fault->kind);
        if (of == SIM_OF_DRIVE && !(config->stand == BENCH_STAND_DRIVE && config->present.drive)) {
            return "a fault of the drive needs the simulated drive";
        }
        if (of == SIM_OF_BLOCK && !config->present.block) {
            return "a fault of the block needs the simulated block";
        }
        if (fault->kind == SIM_FAULT_SWAPPED && fault->channels != 3U && fault->channels != 5U &&
            fault->channels != 6U) {
            return "a fault \"swapped\" needs two channels";
        }
    }
    return NULL;
}

const char *bench_config_complete(bench_config_t *config)
{
    const sim_scenario_t *const scenario = &config->scenario;
    sim_wire_init(&config->wire);
    complete_schedule(&config->scenario);
    if (tumble_schedule_validate(&scenario->schedule, NULL) != TUMBLE_OK) {
        return tumble_status_sentence(tumble_schedule_validate(&scenario->schedule, NULL));
    }
    complete_averaging(config);
    complete_procedure(config);
    complete_profile(config);
    complete_keeping(&config->keeping);
    if (config->stand == BENCH_STAND_DRIVE && tumble_drive402_validate(&config->profile, 1) != TUMBLE_OK) {
        return "the drive profile is not usable: units, times, or a PDO that lacks an object it must carry "
               "or has an identifier that is taken";
    }
    const char *wrong = complete_sample_timeout(config);
    wrong = (wrong != NULL) ? wrong : check_faults(config);
    wrong = (wrong != NULL) ? wrong : complete_gains(config);
    if (wrong == NULL) {
        declare_stand(config);
        lend_estimators(config);
    }
    return wrong;
}

const char *bench_config_refused(const bench_config_t *config)
{
    tumble_reason_t reason;
    const tumble_status_t status = tumble_procedure_validate(&config->procedure, &reason);
    return (status == TUMBLE_OK || !config->present.navcomp) ? NULL : tumble_reason_sentence(reason);
}
