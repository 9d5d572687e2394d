/* sensor.h - the accelerometer block's analogue side: from specific force to the converter's counts.
 *
 *     U = U0 + K a + K_ii k2 a_i^2, then noise, drift, temperature; then the converter rounds to its step and stops at
 *     its range
 *
 * and everything that may be wrong with it. One call makes one sample; nothing here knows of time but what it is told.
 */
#ifndef TUMBLE_SIMULATION_SENSOR_H
#define TUMBLE_SIMULATION_SENSOR_H

#include "simulation/fault.h"
#include "simulation/random.h"
#include "tumble/core.h"

#include <stdbool.h>
#include <stdint.h>

/* The temperature goes from start to end as end + (start - end) exp(-t/tau), and rises besides by the ramp. At the
 * reference the block has its K, U0; d degrees above it K + d (scale K + k_per_c) + d^2 k_per_c2, and U0 likewise.
 */
typedef struct {
    double start_c;
    double end_c;
    double tau_s; /* 0: at the end from the beginning */
    double ramp_c_per_h;
    double reference_c;
    double bias_v_per_c[TUMBLE_CHANNELS];
    double bias_v_per_c2[TUMBLE_CHANNELS];
    double scale_per_c[TUMBLE_CHANNELS]; /* relative change of a channel's row of K */
    double k_per_c[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    double k_per_c2[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
} sim_temperature_t;

typedef struct {
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    double u0_v[TUMBLE_CHANNELS];
    double k2_per_g[TUMBLE_CHANNELS];
    double noise_v[TUMBLE_CHANNELS]; /* limit of one sample's noise, read by `noise_law` */
    sim_law_t noise_law;
    double noise_correlation[TUMBLE_CHANNELS]; /* AR(1), of neighbouring samples: above -1, below 1; 0: white */
    double range_v;                            /* the converter measures from - to + this */
    uint8_t converter_bits;                    /* 8 to 24 */
    double drift_v_per_h[TUMBLE_CHANNELS];
    sim_temperature_t temperature;
} sim_sensor_config_t;

#define SIM_NOISE_AHEAD 32

typedef struct {
    const sim_sensor_config_t *config;
    double counts_per_v;
    double full_scale; /* counts */
    sim_random_t noise[TUMBLE_CHANNELS];
    sim_random_t fault_noise[TUMBLE_CHANNELS];
    double ahead[TUMBLE_CHANNELS][SIM_NOISE_AHEAD]; /* noise drawn in advance (V): in stock it is cheaper */
    double before[TUMBLE_CHANNELS];                 /* the last one of these */
    uint32_t used;
    sim_fault_effects_t faults; /* in force */
    int32_t last[TUMBLE_CHANNELS];
} sim_sensor_t;

void sim_sensor_init(sim_sensor_t *sensor, const sim_sensor_config_t *config, uint64_t seed);

/* Size of one count (V). */
double sim_sensor_v_per_count(const sim_sensor_config_t *config);

/* One sample `time_s` after power-on under specific force `a_g`. True when a channel is at the end of its range. */
bool sim_sensor_sample(sim_sensor_t *sensor, const double a_g[TUMBLE_CHANNELS], double time_s,
                       int32_t counts[TUMBLE_CHANNELS]);

/* Temperature (degrees Celsius) `time_s` after power-on. */
double sim_sensor_temperature_c(const sim_sensor_t *sensor, double time_s);

#endif
