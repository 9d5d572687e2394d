/* The board is configured as tumble-bench is without a scenario, and hears whom it must hear. */
#include "bench/config.h"
#include "configuration.h"
#include "unity.h"

static bench_config_t bench;

void setUp(void)
{
    bench_config_defaults(&bench);
    TEST_ASSERT_NULL(bench_config_complete(&bench));
}

void tearDown(void)
{
}

/* Numbers by their bits. */
#define SAME(field) TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&expected->field, &found->field, sizeof found->field, #field)

static void test_averaging(void)
{
    const tumble_averaging_config_t *const expected = &bench.averaging;
    const tumble_averaging_config_t *const found = &zcu102_averaging;
    SAME(saturation_counts);
    SAME(min_samples);
    SAME(max_lost);
    SAME(stuck_run);
    SAME(noise_counts);
    SAME(stillness_ratio);
}

static void test_procedure(void)
{
    const tumble_procedure_config_t *const expected = &bench.procedure;
    const tumble_procedure_config_t *const found = &zcu102_procedure;
    TEST_ASSERT_EQUAL_PTR(&tumble_schedule_paper, found->schedule);
    TEST_ASSERT_EQUAL_PTR(&zcu102_averaging, found->averaging);
    SAME(estimate);
    SAME(samples);
    SAME(v_per_count);
    SAME(nominal_scale_v_per_g);
    SAME(gravity_limit_g);
    SAME(closure_limit_g);
    SAME(position_tolerance_deg);
    SAME(approach_deg);
    SAME(cable_min_deg);
    SAME(cable_max_deg);
    SAME(settle_ms);
    SAME(max_corrupted);
    SAME(retries);
    SAME(warm_up_band_half_c);
    SAME(warm_up_samples);
    SAME(preflight_timeout_ms);
    SAME(warm_up_timeout_ms);
    SAME(mounting_timeout_ms);
    SAME(home_timeout_ms);
    SAME(move_timeout_ms);
    SAME(settle_timeout_ms);
    SAME(average_timeout_ms);
    SAME(sample_timeout_ms);
}

static void same_pdo(const tumble_drive_pdo_t *expected, const tumble_drive_pdo_t *found)
{
    SAME(number);
    SAME(setup.cob_id);
    SAME(setup.type);
    SAME(setup.count);
    SAME(setup.inhibit_100us);
    SAME(setup.event_ms);
    SAME(setup.map);
}

static void test_drive(void)
{
    const tumble_drive_profile_t *const expected = &bench.profile;
    const tumble_drive_profile_t *const found = &zcu102_drive;
    SAME(counts_per_revolution);
    SAME(velocity_units_per_deg_s);
    SAME(acceleration_units_per_deg_s2);
    SAME(sign);
    SAME(wrap_counts);
    SAME(window_counts);
    SAME(velocity_deg_s);
    SAME(acceleration_deg_s2);
    SAME(deceleration_deg_s2);
    SAME(quick_stop_deg_s2);
    SAME(homing_fast_deg_s);
    SAME(homing_slow_deg_s);
    SAME(homing_acceleration_deg_s2);
    SAME(homing_method);
    SAME(stop);
    SAME(write_count);
    SAME(heartbeat_ms);
    SAME(heartbeat_timeout_ms);
    SAME(start_timeout_ms);
    SAME(power_timeout_ms);
    SAME(handshake_timeout_ms);
    SAME(home_timeout_ms);
    SAME(move_timeout_ms);
    SAME(stop_timeout_ms);
    TEST_ASSERT_EQUAL_UINT8(1, expected->receive_count);
    TEST_ASSERT_EQUAL_UINT8(1, found->receive_count);
    TEST_ASSERT_EQUAL_UINT8(1, expected->transmit_count);
    TEST_ASSERT_EQUAL_UINT8(1, found->transmit_count);
    same_pdo(&expected->receive[0], &found->receive[0]);
    same_pdo(&expected->transmit[0], &found->transmit[0]);
}

static void test_heartbeats(void)
{
    TEST_ASSERT_EQUAL_UINT16(bench.heartbeat_ms, zcu102_navcomp.heartbeat_ms);
    TEST_ASSERT_EQUAL_UINT16(bench.heartbeat_timeout_ms, zcu102_navcomp.heartbeat_timeout_ms);
}

static bool is_heard(uint16_t id)
{
    bool heard = false;
    for (uint8_t n = 0; n < zcu102_can.filter_count; n++) {
        const zcu102_can_filter_t *const filter = &zcu102_can.filters[n];
        heard = heard || ((id & filter->mask) == (filter->id & filter->mask));
    }
    return heard;
}

static void test_the_filters_let_in_what_is_needed_and_little_else(void)
{
    static const uint16_t NEEDED[] = {0x000, 0x082, 0x083, 0x182, 0x582, 0x601, 0x683, 0x693, 0x702, 0x703};
    uint32_t heard = 0;
    for (unsigned i = 0; i < sizeof NEEDED / sizeof NEEDED[0]; i++) {
        TEST_ASSERT_TRUE(is_heard(NEEDED[i]));
    }
    for (uint16_t id = 0; id <= TUMBLE_CAN_MAX_ID; id++) {
        heard += is_heard(id) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(22, heard);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_averaging);
    RUN_TEST(test_procedure);
    RUN_TEST(test_drive);
    RUN_TEST(test_heartbeats);
    RUN_TEST(test_the_filters_let_in_what_is_needed_and_little_else);
    return UNITY_END();
}
