/* The stand and block that a seed makes: within their limits, by their laws, one draw shifting no other. */
#include "simulation/truth.h"
#include "support.h"

#include <math.h>
#include <string.h>

static sim_scenario_t scenario;

static void set_up(void)
{
    sim_scenario_defaults(&scenario);
}

static void test_errors_have_the_declared_size(void)
{
    enum { SEEDS = 20000 };
    double square[4] = {0};
    double product = 0.0;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        sim_truth_t truth;
        sim_truth_draw(&truth, &scenario, seed);
        square[0] += truth.alpha1_rad * truth.alpha1_rad / (double)SEEDS;
        square[1] += truth.alpha2_rad * truth.alpha2_rad / (double)SEEDS;
        square[2] += truth.alpha3_rad[0] * truth.alpha3_rad[0] / (double)SEEDS;
        square[3] += truth.alpha3_rad[1] * truth.alpha3_rad[1] / (double)SEEDS;
        product += truth.alpha3_rad[0] * truth.alpha3_rad[1] / (double)SEEDS;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 2e-5, 2e-5, sqrt(square[0]));
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 2e-5, 2e-5, sqrt(square[1]));
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 4e-4, 4e-4, sqrt(square[2]));
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 4e-4, 4e-4, sqrt(square[3]));
    TEST_ASSERT_TRUE(fabs(product) < 4.0 * 16e-8 / sqrt((double)SEEDS)); /* independent yaws */
}

static void test_one_yaw_for_all_mountings_if_asked_for(void)
{
    sim_truth_t truth;
    scenario.stand.remount = SIM_REMOUNT_COMMON;
    sim_truth_draw(&truth, &scenario, 4);
    ASSERT_SAME_DOUBLE(truth.alpha3_rad[0], truth.alpha3_rad[1]);
    const double yaw = truth.alpha3_rad[0];
    sim_truth_remount(&truth, &scenario, 1);
    ASSERT_SAME_DOUBLE(yaw, truth.alpha3_rad[1]);
}

static void test_a_remounting_draws_again_for_its_mounting_alone(void)
{
    sim_truth_t truth;
    sim_truth_draw(&truth, &scenario, 4);
    const sim_truth_t before = truth;
    sim_truth_remount(&truth, &scenario, 1);
    ASSERT_SAME_DOUBLE(before.alpha3_rad[0], truth.alpha3_rad[0]);
    TEST_ASSERT_TRUE(before.alpha3_rad[1] != truth.alpha3_rad[1]);
}

static void test_drawn_blocks_lie_within_their_limits(void)
{
    double widest = 0.0;
    for (uint64_t seed = 0; seed < 2000; seed++) {
        sim_truth_t truth;
        sim_truth_draw(&truth, &scenario, seed);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const double k = truth.block.k_v_per_g[i][j];
                const double off = (i == j) ? fabs(k / -2.0 - 1.0) / 0.01 : fabs(k) / 0.04;
                TEST_ASSERT_TRUE(off < 1.0);
                widest = (off > widest) ? off : widest;
            }
            TEST_ASSERT_TRUE(fabs(truth.block.u0_v[i]) < 0.1);
        }
    }
    TEST_ASSERT_TRUE(widest > 0.99);
}

static void test_a_given_block_is_taken_as_it_is(void)
{
    sim_truth_t truth;
    scenario.block.given = true;
    scenario.block.sensor.k_v_per_g[1][2] = 0.125;
    scenario.block.sensor.u0_v[2] = -0.5;
    sim_truth_draw(&truth, &scenario, 9);
    TEST_ASSERT_EQUAL_MEMORY(scenario.block.sensor.k_v_per_g, truth.block.k_v_per_g, sizeof truth.block.k_v_per_g);
    ASSERT_SAME_DOUBLE(-0.5, truth.block.u0_v[2]);
}

/* Another block, another stand: what one is drawn from says nothing about the other. */
static void test_causes_are_independent(void)
{
    sim_truth_t truth;
    sim_truth_t other;
    sim_truth_draw(&truth, &scenario, 77);
    scenario.stand.level_rad *= 3.0;
    scenario.block.misalignment_rad *= 2.0;
    sim_truth_draw(&other, &scenario, 77);
    ASSERT_SAME_DOUBLE(truth.alpha1_rad, other.alpha1_rad);
    TEST_ASSERT_DOUBLE_WITHIN(1e-18, 3.0 * truth.alpha2_rad, other.alpha2_rad);
    ASSERT_SAME_DOUBLE(truth.alpha3_rad[1], other.alpha3_rad[1]);
    ASSERT_SAME_DOUBLE(truth.block.k_v_per_g[2][2], other.block.k_v_per_g[2][2]);
    ASSERT_SAME_DOUBLE(2.0 * truth.block.k_v_per_g[2][1], other.block.k_v_per_g[2][1]);
}

static const around_t around_each = {set_up, NULL};
