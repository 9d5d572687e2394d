/* K and U0 over temperature: evaluated, inverted, moved by a run. Numbers are chosen so that every result is exact. */
#include "core/coefficient.h"
#include "model.h"
#include "tumble/core.h"

#define T0 16.0

static tumble_thermal_t thermal;
static tumble_uncertainty_t uncertainty;
static tumble_uncertainty_t growth;
static tumble_coefficients_t measured;
static tumble_uncertainty_t u_measured;
static tumble_thermal_run_t run;

static void put(void *twelve, int c, double value)
{
    memcpy((uint8_t *)twelve + ((size_t)c * sizeof value), &value, sizeof value);
}

static void fill(void *twelve, double value)
{
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        put(twelve, c, value);
    }
}

static void set_up(void)
{
    thermal = (tumble_thermal_t){.reference_c = T0, .lowest_c = -40.0, .highest_c = 63.5};
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        put(&thermal.power[0], c, ((c % 4) == 0) ? 1.0 + (c / 64.0) : c / 1024.0);
        put(&thermal.power[1], c, (c - 5) / 65536.0);
        put(&thermal.power[2], c, (7 - c) / 1048576.0);
    }
    fill(&uncertainty, 3.0 / 1024.0);
    fill(&growth, 4.0 / 1024.0);
    fill(&u_measured, 5.0 / 1024.0);
    (void)tumble_thermal_at(&thermal, 20.0, &measured);
    run = (tumble_thermal_run_t){20.0, &measured, &u_measured};
}

static void assert_at(double temperature_c, tumble_status_t expected)
{
    tumble_coefficients_t found;
    tumble_coefficients_t before;
    memset(&found, 0x5A, sizeof found);
    before = found;
    assert_status(expected, tumble_thermal_at(&thermal, temperature_c, &found));
    if (expected != TUMBLE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &found, sizeof found);
    }
}

static void assert_update(tumble_status_t expected)
{
    const tumble_thermal_t thermal_before = thermal;
    const tumble_uncertainty_t before = uncertainty;
    assert_status(expected, tumble_thermal_update(&thermal, &uncertainty, &growth, &run));
    if (expected != TUMBLE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&thermal_before, &thermal, sizeof thermal);
        TEST_ASSERT_EQUAL_MEMORY(&before, &uncertainty, sizeof uncertainty);
    }
}

/* Dyadic fractions throughout: no term is rounded. */
static void test_every_coefficient_is_its_polynomial(void)
{
    static const double kelvins[] = {0.0, 1.0, -1.0, 0.5, 8.0, -56.0, 47.5};
    for (size_t t = 0; t < COUNT_OF(kelvins); t++) {
        const double kelvin = kelvins[t];
        tumble_coefficients_t found;
        assert_status(TUMBLE_OK, tumble_thermal_at(&thermal, T0 + kelvin, &found));
        for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
            const double expected = tumble_coefficient(&thermal.power[0], c) + (((c - 5) / 65536.0) * kelvin) +
                                    (((7 - c) / 1048576.0) * kelvin * kelvin);
            TEST_ASSERT_TRUE(expected == tumble_coefficient(&found, c));
        }
    }
}

static void test_without_slopes_the_coefficients_are_the_same_everywhere(void)
{
    const tumble_coefficients_t constant = thermal.power[0];
    tumble_coefficients_t found;
    thermal.power[1] = (tumble_coefficients_t){.u0_v = {0.0}};
    thermal.power[2] = thermal.power[1];
    assert_status(TUMBLE_OK, tumble_thermal_at(&thermal, -39.0, &found));
    TEST_ASSERT_EQUAL_MEMORY(&constant, &found, sizeof found);
}

static void test_the_range_has_its_ends_and_nothing_beyond(void)
{
    assert_at(-40.0, TUMBLE_OK);
    assert_at(63.5, TUMBLE_OK);
    assert_at(one_ulp_beyond(-40.0), TUMBLE_E_ARGUMENT);
    assert_at(one_ulp_beyond(63.5), TUMBLE_E_ARGUMENT);
    assert_at(-1e300, TUMBLE_E_ARGUMENT);
    assert_at(NOT_A_NUMBER, TUMBLE_E_NOT_FINITE);
    assert_at(INFINITE, TUMBLE_E_NOT_FINITE);
}

static void test_what_is_no_number_is_refused(void)
{
    double *const numbers[] = {&thermal.reference_c, &thermal.lowest_c, &thermal.highest_c,
                               &thermal.power[0].k_v_per_g[1][2], &thermal.power[2].u0_v[2]};
    for (size_t n = 0; n < COUNT_OF(numbers); n++) {
        const double held = *numbers[n];
        *numbers[n] = NOT_A_NUMBER;
        assert_at(20.0, TUMBLE_E_NOT_FINITE);
        *numbers[n] = -INFINITE;
        assert_at(20.0, TUMBLE_E_NOT_FINITE);
        *numbers[n] = held;
    }
    thermal.power[1].k_v_per_g[0][0] = 1e308;
    assert_at(20.0, TUMBLE_E_NOT_FINITE);
}

static void test_null_is_refused(void)
{
    tumble_coefficients_t found;
    tumble_calibration_t calibration;
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_at(NULL, 20.0, &found));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_at(&thermal, 20.0, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_calibration(NULL, 20.0, &calibration));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_calibration(&thermal, 20.0, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_update(NULL, &uncertainty, &growth, &run));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_update(&thermal, NULL, &growth, &run));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_update(&thermal, &uncertainty, NULL, &run));
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_update(&thermal, &uncertainty, &growth, NULL));
    run.coefficients = NULL;
    assert_update(TUMBLE_E_ARGUMENT);
    run = (tumble_thermal_run_t){20.0, &measured, NULL};
    assert_update(TUMBLE_E_ARGUMENT);
}

/* As the coefficients of that temperature by themselves. */
static void test_the_calibration_is_that_of_the_temperature(void)
{
    tumble_coefficients_t there;
    tumble_calibration_t expected;
    tumble_calibration_t found;
    (void)tumble_thermal_at(&thermal, -8.0, &there);
    assert_status(TUMBLE_OK, tumble_calibration_invert(&there, &expected));
    assert_status(TUMBLE_OK, tumble_thermal_calibration(&thermal, -8.0, &found));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &found, sizeof found);
    assert_status(TUMBLE_E_ARGUMENT, tumble_thermal_calibration(&thermal, 64.0, &found));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &found, sizeof found);
    fill(&thermal.power[0], 0.0);
    assert_status(TUMBLE_E_SINGULAR, tumble_thermal_calibration(&thermal, T0, &found));
}

/* 3, 4 and 5: w is a half, and the uncertainty is that of each. */
static void test_a_run_moves_offset_and_scale_and_keeps_the_slopes(void)
{
    const tumble_thermal_t before = thermal;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        put(&measured, c, tumble_coefficient(&measured, c) + ((c - 6) / 4096.0));
    }
    assert_update(TUMBLE_OK);
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double expected = tumble_coefficient(&before.power[0], c) + ((c - 6) / 8192.0);
        TEST_ASSERT_TRUE(expected == tumble_coefficient(&thermal.power[0], c));
        TEST_ASSERT_TRUE(tumble_coefficient(&uncertainty, c) == 5.0 / 1024.0);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before.power[1], &thermal.power[1], 2U * sizeof before.power[1]);
    TEST_ASSERT_TRUE((thermal.reference_c == T0) && (thermal.lowest_c == -40.0) && (thermal.highest_c == 63.5));
}

static void test_what_is_not_uncertain_counts_alone(void)
{
    const tumble_coefficients_t before = thermal.power[0];
    measured.k_v_per_g[0][0] += 1.0 / 4096.0;
    fill(&uncertainty, 0.0);
    fill(&growth, 0.0);
    assert_update(TUMBLE_OK); /* the polynomials */
    TEST_ASSERT_EQUAL_MEMORY(&before, &thermal.power[0], sizeof before);
    TEST_ASSERT_TRUE(uncertainty.k_v_per_g[0][0] == 0.0);
    fill(&growth, 1.0 / 1024.0);
    fill(&u_measured, 0.0);
    assert_update(TUMBLE_OK); /* the run */
    TEST_ASSERT_TRUE(thermal.power[0].k_v_per_g[0][0] == before.k_v_per_g[0][0] + (1.0 / 4096.0));
    TEST_ASSERT_TRUE(uncertainty.k_v_per_g[0][0] == 0.0);
}

/* Were both off by the same error e of their stand, so would be what is found: no less than is stated. */
static void test_the_uncertainty_is_not_below_a_common_error(void)
{
    fill(&growth, 0.0);
    fill(&uncertainty, 5.0 / 1024.0);
    assert_update(TUMBLE_OK);
    TEST_ASSERT_TRUE(uncertainty.u0_v[2] == 5.0 / 1024.0);
}

static void test_what_no_run_can_update_stays(void)
{
    run.temperature_c = 64.0;
    assert_update(TUMBLE_E_ARGUMENT);
    run.temperature_c = NOT_A_NUMBER;
    assert_update(TUMBLE_E_NOT_FINITE);
    run.temperature_c = 20.0;
    void *const numbers[] = {&uncertainty, &growth, &u_measured};
    for (size_t n = 0; n < COUNT_OF(numbers); n++) {
        const double held = tumble_coefficient(numbers[n], 11);
        put(numbers[n], 11, -1.0);
        assert_update(TUMBLE_E_ARGUMENT);
        put(numbers[n], 11, NOT_A_NUMBER);
        assert_update(TUMBLE_E_NOT_FINITE);
        put(numbers[n], 11, 1e200);
        assert_update(TUMBLE_E_NOT_FINITE);
        put(numbers[n], 11, held);
    }
    measured.u0_v[2] = INFINITE;
    assert_update(TUMBLE_E_NOT_FINITE);
    measured.u0_v[2] = 0.0;
    fill(&uncertainty, 0.0);
    fill(&growth, 0.0);
    fill(&u_measured, 0.0);
    assert_update(TUMBLE_E_ARGUMENT);
}
