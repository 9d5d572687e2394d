/* What in the standard configuration follows from other numbers is what the simulated world finds from the stand and the block
 * that it simulates without a scenario. */
#include "navcomp/standard.h"
#include "suite.h"
#include "world/config.h"

static bench_config_t bench;

static void set_up(void)
{
    bench_config_defaults(&bench);
    TEST_ASSERT_NULL(bench_config_complete(&bench));
}

/* Numbers by their bits. */
#define SAME(field) TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&expected->field, &found->field, sizeof found->field, #field)

static void test_averaging(void)
{
    const tumble_averaging_config_t *const expected = &bench.averaging;
    const tumble_averaging_config_t *const found = &tumble_standard_averaging;
    SAME(saturation_counts);
    SAME(min_samples);
    SAME(noise_counts);
    SAME(stillness_ratio);
}

static void test_procedure(void)
{
    const tumble_procedure_config_t *const expected = &bench.procedure;
    const tumble_procedure_config_t *const found = &tumble_standard_procedure;
    SAME(v_per_count);
    SAME(nominal_scale_v_per_g);
    SAME(closure_limit_g);
    SAME(average_timeout_ms);
    SAME(sample_timeout_ms);
}

static void test_drive(void)
{
    const tumble_drive_profile_t *const expected = &bench.profile;
    const tumble_drive_profile_t *const found = &tumble_standard_drive;
    SAME(counts_per_revolution);
    SAME(velocity_units_per_deg_s);
    SAME(acceleration_units_per_deg_s2);
    SAME(sign);
    SAME(wrap_counts);
    SAME(velocity_deg_s);
    SAME(acceleration_deg_s2);
    SAME(deceleration_deg_s2);
    SAME(quick_stop_deg_s2);
    SAME(homing_acceleration_deg_s2);
    SAME(stop);
    TEST_ASSERT_EQUAL_UINT8(found->receive_count, expected->receive_count);
    TEST_ASSERT_EQUAL_UINT8(found->transmit_count, expected->transmit_count);
}

static void test_block(void)
{
    TEST_ASSERT_EQUAL_UINT32(bench.scenario.block.sample_period_us, tumble_standard_navcomp.block_period_us);
}

static const around_t around_each = {set_up, NULL};
