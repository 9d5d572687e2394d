#include "simulation/sensor.h"

#include "simulation/maths.h"

#include <math.h> /* fabs, ldexp: exact; sqrt: rounded as IEEE 754 says */
#include <string.h>

void sim_sensor_init(sim_sensor_t *sensor, const sim_sensor_config_t *config, uint64_t seed)
{
    memset(sensor, 0, sizeof *sensor);
    sensor->config = config;
    sensor->used = SIM_NOISE_AHEAD;
    sensor->counts_per_v = 1.0 / sim_sensor_v_per_count(config);
    sensor->full_scale = (double)((1U << (config->converter_bits - 1U)) - 1U);
    for (uint32_t i = 0; i < TUMBLE_CHANNELS; i++) {
        sim_random_open(&sensor->noise[i], seed, SIM_CAUSE_NOISE, i);
        sim_random_open(&sensor->fault_noise[i], seed, SIM_CAUSE_FAULT_NOISE, i);
    }
}

double sim_sensor_v_per_count(const sim_sensor_config_t *config)
{
    return ldexp(config->range_v, 1 - config->converter_bits);
}

double sim_sensor_temperature_c(const sim_sensor_t *sensor, double time_s)
{
    const sim_temperature_t *const t = &sensor->config->temperature;
    const double gone = (t->tau_s > 0.0) ? sim_exp(-time_s / t->tau_s) : 0.0;
    const double soaked = t->end_c + (t->start_c - t->end_c) * gone + sensor->faults[SIM_FAULT_WARM].value;
    return soaked + t->ramp_c_per_h * (time_s / 3600.0);
}

/* It has the same variance, but for the very first samples after power-on. */
static void correlate(sim_sensor_t *sensor, int channel)
{
    const double rho = sensor->config->noise_correlation[channel];
    const double fresh = sqrt(1.0 - rho * rho);
    for (int n = 0; rho != 0.0 && n < SIM_NOISE_AHEAD; n++) {
        sensor->before[channel] = rho * sensor->before[channel] + fresh * sensor->ahead[channel][n];
        sensor->ahead[channel][n] = sensor->before[channel];
    }
}

static void draw_ahead(sim_sensor_t *sensor)
{
    const sim_sensor_config_t *const config = sensor->config;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double *const ahead = sensor->ahead[i];
        if (config->noise_law == SIM_LAW_UNIFORM) {
            for (int n = 0; n < SIM_NOISE_AHEAD; n++) {
                ahead[n] = config->noise_v[i] * sim_random_symmetric(&sensor->noise[i]);
            }
            correlate(sensor, i);
            continue;
        }
        const double sigma = (config->noise_law == SIM_LAW_SIGMA3) ? config->noise_v[i] / 3.0 : config->noise_v[i];
        sim_random_normals(&sensor->noise[i], ahead, SIM_NOISE_AHEAD);
        for (int n = 0; n < SIM_NOISE_AHEAD; n++) {
            ahead[n] *= sigma;
        }
        correlate(sensor, i);
    }
    sensor->used = 0;
}

/* What d degrees above the reference add to a channel, but for its own scale and slope of the bias. */
static double warmed_v(const sim_temperature_t *t, int channel, const double a_g[TUMBLE_CHANNELS], double d)
{
    double change = t->bias_v_per_c2[channel] * (d * d);
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        change += (t->k_per_c[channel][j] + t->k_per_c2[channel][j] * d) * d * a_g[j];
    }
    return change;
}

static double output_v(const sim_sensor_t *sensor, int channel, const double a_g[TUMBLE_CHANNELS], double time_s,
                       double above_reference_c)
{
    const sim_sensor_config_t *const config = sensor->config;
    const double *const k = config->k_v_per_g[channel];
    const double along_g = a_g[channel];
    const double response =
        k[0] * a_g[0] + k[1] * a_g[1] + k[2] * a_g[2] + k[channel] * config->k2_per_g[channel] * (along_g * along_g);
    const double scale = 1.0 + config->temperature.scale_per_c[channel] * above_reference_c;
    const double bias = config->u0_v[channel] + config->drift_v_per_h[channel] * (time_s / 3600.0) +
                        config->temperature.bias_v_per_c[channel] * above_reference_c;
    return bias + response * scale + warmed_v(&config->temperature, channel, a_g, above_reference_c);
}

/* To the nearest count, not beyond the range. */
static int32_t convert(const sim_sensor_t *sensor, double u_v)
{
    const double counts = u_v * sensor->counts_per_v;
    const double below = (counts < sensor->full_scale) ? counts : sensor->full_scale;
    return sim_nearest((below > -sensor->full_scale) ? below : -sensor->full_scale);
}

static bool has(const sim_sensor_t *sensor, sim_fault_kind_t kind, uint32_t channel)
{
    return (sensor->faults[kind].channels >> channel & 1U) != 0U;
}

static void apply_analogue_faults(sim_sensor_t *sensor, double u_v[TUMBLE_CHANNELS])
{
    for (uint32_t i = 0; i < TUMBLE_CHANNELS; i++) {
        if (has(sensor, SIM_FAULT_STEP, i)) {
            u_v[i] += sensor->faults[SIM_FAULT_STEP].value;
        }
        if (has(sensor, SIM_FAULT_NOISY, i) && sensor->faults[SIM_FAULT_NOISY].value > 0.0) {
            u_v[i] += sensor->faults[SIM_FAULT_NOISY].value * sim_random_normal(&sensor->fault_noise[i]);
        }
        if (has(sensor, SIM_FAULT_INVERTED, i)) {
            u_v[i] = -u_v[i];
        }
        if (has(sensor, SIM_FAULT_SATURATED, i)) {
            u_v[i] = 2.0 * sensor->config->range_v;
        }
    }
}

static void swap_channels(uint8_t mask, int32_t counts[TUMBLE_CHANNELS])
{
    const int first = ((mask & 1U) != 0U) ? 0 : 1;
    const int second = ((mask & 4U) != 0U) ? 2 : 1;
    const int32_t kept = counts[first];
    counts[first] = counts[second];
    counts[second] = kept;
}

static void apply_digital_faults(sim_sensor_t *sensor, int32_t counts[TUMBLE_CHANNELS])
{
    for (uint32_t i = 0; i < TUMBLE_CHANNELS; i++) {
        if (has(sensor, SIM_FAULT_STUCK, i)) {
            counts[i] = sensor->last[i];
        }
        sensor->last[i] = counts[i];
    }
    if (sensor->faults[SIM_FAULT_SWAPPED].channels != 0U) {
        swap_channels(sensor->faults[SIM_FAULT_SWAPPED].channels, counts);
    }
}

bool sim_sensor_sample(sim_sensor_t *sensor, const double a_g[TUMBLE_CHANNELS], double time_s,
                       int32_t counts[TUMBLE_CHANNELS])
{
    const sim_sensor_config_t *const config = sensor->config;
    if (sensor->used == SIM_NOISE_AHEAD) {
        draw_ahead(sensor);
    }
    const double above_c = sim_sensor_temperature_c(sensor, time_s) - config->temperature.reference_c;
    double u_v[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        u_v[i] = output_v(sensor, i, a_g, time_s, above_c) + sensor->ahead[i][sensor->used];
    }
    sensor->used++;
    apply_analogue_faults(sensor, u_v);
    bool at_end = false;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        counts[i] = convert(sensor, u_v[i]);
        at_end = at_end || fabs((double)counts[i]) == sensor->full_scale;
    }
    apply_digital_faults(sensor, counts);
    return at_end;
}
