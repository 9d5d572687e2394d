/* An active set with slopes: what a run at one temperature makes of it, when it is held, and what a computer does that does
 * not read such sets. The scripted block follows its polynomials in the bias alone, and is free of noise. */
#include "keeper_bench.h"

#include "core/coefficient.h"

#define T0 20.0
#define CHANGE TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE)
#define TEMPERATURE TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_TEMPERATURE)

static tumble_thermal_sets_t thermal_sets;
static tumble_thermal_t given; /* as the memory holds them */
static tumble_set_t given_set;

static double number(const void *twelve, int c)
{
    return tumble_coefficient(twelve, c);
}

static tumble_thermal_t thermal_of(tumble_which_set_t which, tumble_set_t *set)
{
    tumble_thermal_t thermal;
    ASSERT_STATUS(TUMBLE_OK, tumble_store_read_thermal(&keeper.store, which, set, &thermal));
    return thermal;
}

static void power_on(tumble_thermal_sets_t *sets)
{
    tumble_thermal_sets_init(&thermal_sets);
    keeper_config.sets.thermal = sets;
    keeper_power_cycle();
    settle_memory();
}

/* The block at a temperature: 4e-4 V per K and 1e-5 V per K^2 of bias, far more than a rule allows to change. */
static void warm_to(double temperature_c)
{
    const double kelvin = temperature_c - T0;
    bench.block.temperature_half_c = (int8_t)(2.0 * temperature_c);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        bench.block.u0_v[i] = given.power[0].u0_v[i] + ((4e-4 + (1e-5 * kelvin)) * kelvin);
    }
}

/* A set of the block, then the same with slopes, which become active. */
static void set_up(void)
{
    keeper_power_on();
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
    tumble_thermal_t made = {T0, -10.0, 50.0, {set.coefficients}};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        made.power[1].u0_v[i] = 4e-4;
        made.power[2].u0_v[i] = 1e-5;
    }
    power_on(&thermal_sets);
    ASSERT_STATUS(TUMBLE_OK, tumble_store_write_thermal(&keeper.store, TUMBLE_SET_ACTIVE, &set, &made));
    settle_memory();
    power_on(&thermal_sets);
    given = thermal_of(TUMBLE_SET_ACTIVE, &given_set);
    TEST_ASSERT_EQUAL_UINT32(2, state_of_keeper().counter);
}

static void assert_slopes_kept(const tumble_thermal_t *thermal)
{
    TEST_ASSERT_EQUAL_MEMORY(&given.power[1], &thermal->power[1], 2U * sizeof given.power[1]);
    TEST_ASSERT_TRUE((thermal->reference_c == T0) && (thermal->lowest_c == -10.0) && (thermal->highest_c == 50.0));
}

/* The formula of core.h, by itself: months 1, for nothing is dated. */
static void assert_is_combined(const tumble_thermal_t *found, const tumble_set_t *set, double temperature_c)
{
    const double kelvin = temperature_c - T0;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double *row = keeper.set.coefficients.k_v_per_g[(c < 9) ? (c / 3) : (c - 9)];
        const double length = sqrt((row[0] * row[0]) + (row[1] * row[1]) + (row[2] * row[2]));
        const double growth = (double)1e-4F * length;
        const double u = number(&given_set.uncertainty, c);
        const double u_run = number(&keeper.set.uncertainty, c);
        const double prior = (u * u) + (growth * growth);
        const double w = prior / (prior + (u_run * u_run));
        const double there = number(&given.power[0], c) + (number(&given.power[1], c) * kelvin) +
                             (number(&given.power[2], c) * kelvin * kelvin);
        const double expected = number(&given.power[0], c) + (w * (number(&keeper.set.coefficients, c) - there));
        const double bound = ((1.0 - w) * sqrt(prior)) + (w * u_run);
        TEST_ASSERT_TRUE((w > 0.5) && (w < 1.0));
        TEST_ASSERT_TRUE(fabs(number(&found->power[0], c) - expected) <= 0x1p-23 * (fabs(expected) + 1e-6));
        TEST_ASSERT_TRUE(fabs(number(&set->uncertainty, c) - bound) <= 0x1p-23 * bound);
    }
}

static void test_a_run_at_another_temperature_updates_offset_and_scale(void)
{
    tumble_set_t set;
    warm_to(45.0);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    assert_objects(0);
    const tumble_thermal_t found = thermal_of(TUMBLE_SET_ACTIVE, &set);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_COMMITTED, set.origin);
    assert_slopes_kept(&found);
    assert_is_combined(&found, &set, 45.0);
    power_on(&thermal_sets);
    const tumble_thermal_t again = thermal_of(TUMBLE_SET_ACTIVE, &set);
    TEST_ASSERT_EQUAL_MEMORY(&found, &again, sizeof found);
}

/* Beyond the rules at the run's temperature: offset and scale are then those of the run, in a proposal. */
static void test_a_run_that_disagrees_is_held_and_counts_alone(void)
{
    tumble_set_t set;
    tumble_coefficients_t there;
    warm_to(45.0);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    assert_objects((uint16_t)CHANGE);
    const tumble_thermal_t found = thermal_of(TUMBLE_SET_PROPOSAL, &set);
    assert_slopes_kept(&found);
    ASSERT_STATUS(TUMBLE_OK, tumble_thermal_at(&found, 45.0, &there));
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        TEST_ASSERT_TRUE(fabs(number(&there, c) - number(&keeper.set.coefficients, c)) < 2e-7);
        TEST_ASSERT_TRUE(fabs(number(&set.uncertainty, c) / number(&keeper.set.uncertainty, c) - 1.0) < 0x1p-23);
    }
    TEST_ASSERT_EQUAL_HEX32(CHANGE, set.reasons);
    decide(TUMBLE_COMMAND_ACCEPT);
    const tumble_thermal_t accepted = thermal_of(TUMBLE_SET_ACTIVE, &set);
    TEST_ASSERT_EQUAL_MEMORY(&found, &accepted, sizeof found);
    decide(TUMBLE_COMMAND_ROLLBACK);
    const tumble_thermal_t restored = thermal_of(TUMBLE_SET_ACTIVE, &set);
    TEST_ASSERT_EQUAL_MEMORY(&given, &restored, sizeof given);
}

static void test_a_run_outside_the_range_is_held_without_slopes(void)
{
    warm_to(50.5);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_HELD);
    TEST_ASSERT_EQUAL_HEX16(TEMPERATURE >> TUMBLE_OBJECTION_MORE, state_of_keeper().more_objections);
    const tumble_set_t held = set_of(TUMBLE_SET_PROPOSAL);
    TEST_ASSERT_BITS_LOW(TUMBLE_SET_HAS_SLOPES, held.flags);
    TEST_ASSERT_EQUAL_MEMORY(&keeper.set.coefficients, &held.coefficients, sizeof held.coefficients);
    TEST_ASSERT_TRUE(held.temperature_c == 50.5);
    tumble_set_t set;
    const tumble_thermal_t active = thermal_of(TUMBLE_SET_ACTIVE, &set);
    TEST_ASSERT_EQUAL_MEMORY(&given, &active, sizeof given);
}

static void test_a_run_at_an_end_of_the_range_is_not(void)
{
    warm_to(50.0);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
}

static void test_a_run_of_unknown_temperature_objects(void)
{
    tumble_set_t active = given_set;
    tumble_set_t measured = given_set;
    measured.flags &= (uint16_t)~TUMBLE_SET_HAS_TEMPERATURE;
    set_of(TUMBLE_SET_ACTIVE); /* the store has just read it */
    TEST_ASSERT_EQUAL_HEX32(TEMPERATURE,
                            thermal_sets.consult(&thermal_sets, &keeper.store, &measured, &settings.limits, &active));
    TEST_ASSERT_FALSE(thermal_sets.moves);
}

static void test_the_same_run_again_is_repeated(void)
{
    warm_to(30.0);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    const uint32_t counter = state_of_keeper().counter;
    assert_verdict_after(0.0, TUMBLE_VERDICT_REPEATED);
    TEST_ASSERT_EQUAL_UINT32(counter, state_of_keeper().counter);
}

/* One of the run's own, when what is held is offered again. */
static void test_the_same_run_again_is_repeated_beside_the_proposal(void)
{
    warm_to(30.0);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    assert_verdict_after(0.0, TUMBLE_VERDICT_REPEATED);
}

/* Without the uncertainties of one of them nothing can be weighed. */
static void test_without_uncertainties_the_run_counts_alone(void)
{
    tumble_set_t set;
    keeper_config.uncertainty = NULL;
    warm_to(45.0);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_HELD);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN));
    const tumble_thermal_t found = thermal_of(TUMBLE_SET_PROPOSAL, &set);
    tumble_coefficients_t there;
    ASSERT_STATUS(TUMBLE_OK, tumble_thermal_at(&found, 45.0, &there));
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        TEST_ASSERT_TRUE(fabs(number(&there, c) - number(&keeper.set.coefficients, c)) < 2e-7);
    }
    TEST_ASSERT_BITS_LOW(TUMBLE_SET_HAS_UNCERTAINTY, set.flags);
    assert_slopes_kept(&found);
}

/* They hold at every temperature of their range. */
static void test_no_run_is_due_by_the_temperature(void)
{
    settings.temperature_half_c = 6;
    power_on(&thermal_sets);
    bench.block.temperature_half_c = 80;
    bench_pass(&bench, 20.0);
    TEST_ASSERT_EQUAL_HEX8(0, state_of_keeper().due);
}

static void test_without_the_option_the_set_is_of_a_newer_version(void)
{
    power_on(NULL);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_NEWER, state_of_keeper().due);
    TEST_ASSERT_EQUAL_UINT32(1, state_of_keeper().counter);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_HELD);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NEWER_SET));
    power_on(&thermal_sets);
    tumble_set_t set;
    const tumble_thermal_t active = thermal_of(TUMBLE_SET_ACTIVE, &set);
    TEST_ASSERT_EQUAL_MEMORY(&given, &active, sizeof given);
}

/* As long as the active set has none, nothing changes. */
static void test_without_slopes_a_run_makes_a_set_of_version_1(void)
{
    keeper_prepare();
    keeper_config.sets.thermal = &thermal_sets;
    bench_power_on(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_BITS_LOW(TUMBLE_SET_HAS_SLOPES, set.flags);
    TEST_ASSERT_EQUAL_MEMORY(&keeper.set.coefficients, &set.coefficients, sizeof set.coefficients);
}
