/* The analogue side of the block: response, noise, converter, drift, temperature, and its faults. */
#include "simulation/sensor.h"
#include "support.h"

#include <math.h>
#include <string.h>

static sim_sensor_config_t config;
static sim_sensor_t sensor;
static const double FORCE_G[3] = {0.3, -0.5, 0.8};

static void set_up(void)
{
    config = (sim_sensor_config_t){
        .k_v_per_g = {{-2.0, 0.03, 0.01}, {-0.02, -1.9, 0.04}, {0.05, -0.01, -2.1}},
        .u0_v = {0.1, -0.2, 0.05},
        .range_v = 10.0,
        .converter_bits = 24,
        .temperature = {.start_c = 25.0, .end_c = 25.0, .reference_c = 25.0},
    };
}

static double ideal_v(int channel)
{
    const double *const k = config.k_v_per_g[channel];
    return config.u0_v[channel] + k[0] * FORCE_G[0] + k[1] * FORCE_G[1] + k[2] * FORCE_G[2];
}

static void start(void)
{
    sim_sensor_init(&sensor, &config, 21);
}

static bool sample(double time_s, int32_t counts[3])
{
    return sim_sensor_sample(&sensor, FORCE_G, time_s, counts);
}

/* 24 bits over -10 to 10 V: a step of 20 / 2^24 V, rounded to the nearest. */
static void test_the_response_is_rounded_to_the_nearest_count(void)
{
    const double step_v = 20.0 / 16777216.0;
    int32_t counts[3];
    ASSERT_SAME_DOUBLE(step_v, sim_sensor_v_per_count(&config));
    start();
    TEST_ASSERT_FALSE(sample(0.0, counts));
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_TRUE(fabs(counts[i] * step_v - ideal_v(i)) <= 0.5 * step_v * (1.0 + 1e-6));
    }
    config.converter_bits = 12;
    start();
    (void)sample(0.0, counts);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_TRUE(fabs(counts[i] * 20.0 / 4096.0 - ideal_v(i)) <= 10.0 / 4096.0 * (1.0 + 1e-6));
    }
}

static void test_the_converter_stops_at_its_range(void)
{
    int32_t counts[3];
    config.u0_v[0] = 100.0;
    config.u0_v[1] = -100.0;
    config.converter_bits = 16;
    start();
    TEST_ASSERT_TRUE(sample(0.0, counts));
    TEST_ASSERT_EQUAL_INT32(32767, counts[0]);
    TEST_ASSERT_EQUAL_INT32(-32767, counts[1]);
}

/* Each channel has the noise it declares, independent of the others, read by its law. */
static void test_noise_has_the_declared_size(void)
{
    static const double SIGMAS[] = {1.0, 1.0 / 3.0, 0.57735026918962576};
    enum { SAMPLES = 40000 };
    for (int law = SIM_LAW_SIGMA1; law <= SIM_LAW_UNIFORM; law++) {
        config.noise_law = (sim_law_t)law;
        config.noise_v[0] = 1e-3;
        config.noise_v[1] = 3e-3;
        config.noise_v[2] = 0.0;
        start();
        double square[3] = {0};
        double product = 0.0;
        for (int n = 0; n < SAMPLES; n++) {
            int32_t counts[3];
            double off_v[3];
            (void)sample(0.0, counts);
            for (int i = 0; i < 3; i++) {
                off_v[i] = counts[i] * sim_sensor_v_per_count(&config) - ideal_v(i);
                square[i] += off_v[i] * off_v[i] / (double)SAMPLES;
            }
            product += off_v[0] * off_v[1] / (double)SAMPLES;
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * SIGMAS[law] * 1e-3, SIGMAS[law] * 1e-3, sqrt(square[0]));
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * SIGMAS[law] * 3e-3, SIGMAS[law] * 3e-3, sqrt(square[1]));
        TEST_ASSERT_TRUE(sqrt(square[2]) < 1e-6);
        TEST_ASSERT_TRUE(fabs(product) < 4.0 * SIGMAS[law] * SIGMAS[law] * 3e-6 / sqrt((double)SAMPLES));
    }
}

/* Noise is a stream per channel: what happens to one channel changes nothing in another. */
static void test_channels_do_not_disturb_each_other(void)
{
    int32_t alone[50][3];
    for (int i = 0; i < 3; i++) {
        config.noise_v[i] = 1e-3;
    }
    start();
    for (int n = 0; n < 50; n++) {
        (void)sample(0.0, alone[n]);
    }
    config.noise_v[1] = 5e-2;
    start();
    sensor.faults[SIM_FAULT_NOISY] = (sim_fault_effect_t){.channels = 4, .value = 0.1};
    for (int n = 0; n < 50; n++) {
        int32_t counts[3];
        (void)sample(0.0, counts);
        TEST_ASSERT_EQUAL_INT32(alone[n][0], counts[0]);
        TEST_ASSERT_TRUE(alone[n][1] != counts[1]);
    }
}

static void test_drift_and_temperature(void)
{
    int32_t counts[3];
    config.drift_v_per_h[0] = 0.36;
    config.temperature = (sim_temperature_t){.start_c = 15.0,
                                             .end_c = 35.0,
                                             .tau_s = 600.0,
                                             .reference_c = 20.0,
                                             .bias_v_per_c = {0.0, 1e-3, 0.0},
                                             .scale_per_c = {0.0, 0.0, 1e-3}};
    start();
    const double warm_c = 35.0 - 20.0 * exp(-1.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, warm_c, sim_sensor_temperature_c(&sensor, 900.0));
    (void)sample(900.0, counts);
    const double step_v = sim_sensor_v_per_count(&config);
    TEST_ASSERT_DOUBLE_WITHIN(step_v, ideal_v(0) + 0.09, counts[0] * step_v);
    TEST_ASSERT_DOUBLE_WITHIN(step_v, ideal_v(1) + 1e-3 * (warm_c - 20.0), counts[1] * step_v);
    const double response = ideal_v(2) - config.u0_v[2];
    TEST_ASSERT_DOUBLE_WITHIN(step_v, config.u0_v[2] + response * (1.0 + 1e-3 * (warm_c - 20.0)), counts[2] * step_v);
    config.temperature.tau_s = 0.0;
    ASSERT_SAME_DOUBLE(35.0, sim_sensor_temperature_c(&sensor, 0.0));
}

/* K and U0 are polynomials of the temperature, and a chamber may go on warming at a rate. */
static void test_quadratic_in_temperature(void)
{
    int32_t counts[3];
    config.temperature = (sim_temperature_t){.start_c = -40.0,
                                             .end_c = -40.0,
                                             .ramp_c_per_h = 36.0,
                                             .reference_c = 20.0,
                                             .bias_v_per_c2 = {1e-6, 0.0, 0.0},
                                             .scale_per_c = {0.0, 0.0, 1e-4},
                                             .k_per_c = {{0.0, 0.0, 0.0}, {1e-4, 2e-4, 3e-4}, {0.0, 0.0, 0.0}},
                                             .k_per_c2 = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {4e-6, 5e-6, 6e-6}}};
    start();
    ASSERT_SAME_DOUBLE(-40.0, sim_sensor_temperature_c(&sensor, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -30.0, sim_sensor_temperature_c(&sensor, 1000.0));
    (void)sample(1000.0, counts);
    const double step_v = sim_sensor_v_per_count(&config);
    const double d = -50.0;
    TEST_ASSERT_DOUBLE_WITHIN(step_v, ideal_v(0) + 1e-6 * d * d, counts[0] * step_v);
    const double slope = d * (1e-4 * FORCE_G[0] + 2e-4 * FORCE_G[1] + 3e-4 * FORCE_G[2]);
    TEST_ASSERT_DOUBLE_WITHIN(step_v, ideal_v(1) + slope, counts[1] * step_v);
    const double square = d * d * (4e-6 * FORCE_G[0] + 5e-6 * FORCE_G[1] + 6e-6 * FORCE_G[2]);
    const double response = ideal_v(2) - config.u0_v[2];
    TEST_ASSERT_DOUBLE_WITHIN(step_v, ideal_v(2) + response * 1e-4 * d + square, counts[2] * step_v);
}

static void put_in_force(sim_fault_kind_t kind, sim_fault_effect_t effect)
{
    memset(sensor.faults, 0, sizeof sensor.faults);
    sensor.faults[kind] = effect;
}

static void test_faults_of_the_output(void)
{
    int32_t plain[3];
    int32_t counts[3];
    start();
    (void)sample(0.0, plain);
    put_in_force(SIM_FAULT_INVERTED, (sim_fault_effect_t){.channels = 2});
    (void)sample(0.0, counts);
    TEST_ASSERT_EQUAL_INT32(plain[0], counts[0]);
    TEST_ASSERT_EQUAL_INT32(-plain[1], counts[1]);
    put_in_force(SIM_FAULT_SATURATED, (sim_fault_effect_t){.channels = 4});
    TEST_ASSERT_TRUE(sample(0.0, counts));
    TEST_ASSERT_EQUAL_INT32(8388607, counts[2]);
    put_in_force(SIM_FAULT_STEP, (sim_fault_effect_t){.channels = 2, .value = 0.5});
    (void)sample(0.0, counts);
    TEST_ASSERT_INT32_WITHIN(1, plain[1] + (int32_t)(0.5 * 16777216.0 / 20.0), counts[1]);
    put_in_force(SIM_FAULT_WARM, (sim_fault_effect_t){.value = 12.5});
    ASSERT_SAME_DOUBLE(37.5, sim_sensor_temperature_c(&sensor, 0.0));
}

static void test_a_stuck_channel_repeats_and_swapped_ones_change_places(void)
{
    int32_t before[3];
    int32_t counts[3];
    config.noise_v[0] = config.noise_v[1] = config.noise_v[2] = 1e-2;
    start();
    (void)sample(0.0, before);
    sensor.faults[SIM_FAULT_STUCK].channels = 1;
    for (int n = 0; n < 10; n++) {
        (void)sample(0.0, counts);
        TEST_ASSERT_EQUAL_INT32(before[0], counts[0]);
        TEST_ASSERT_TRUE(before[1] != counts[1]);
    }
    sensor.faults[SIM_FAULT_STUCK].channels = 0;
    static const uint8_t MASKS[] = {3, 5, 6};
    static const int PLACES[][3] = {{1, 0, 2}, {2, 1, 0}, {0, 2, 1}};
    config.noise_v[0] = config.noise_v[1] = config.noise_v[2] = 0.0;
    start();
    (void)sample(0.0, before);
    for (size_t m = 0; m < COUNT_OF(MASKS); m++) {
        sensor.faults[SIM_FAULT_SWAPPED].channels = MASKS[m];
        (void)sample(0.0, counts);
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_EQUAL_INT32(before[PLACES[m][i]], counts[i]);
        }
    }
}
