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

/* Block, axis, platform and encoder of one seed, in runs of others: all else is drawn anew, and as without it. */
static void test_what_stays_from_run_to_run_is_of_its_own_seed(void)
{
    sim_truth_t own;
    sim_truth_t lasting;
    sim_truth_t mixed;
    scenario.stand.platform_rad = scenario.stand.encoder_rad = scenario.stand.seat_rad = 1e-4;
    sim_truth_draw(&own, &scenario, 4);
    sim_truth_draw(&lasting, &scenario, 9);
    scenario.of_seed = 9;
    sim_truth_draw(&mixed, &scenario, 4);
    TEST_ASSERT_EQUAL_MEMORY(&lasting.block, &mixed.block, sizeof mixed.block);
    TEST_ASSERT_EQUAL_MEMORY(lasting.encoder_rad, mixed.encoder_rad, sizeof mixed.encoder_rad);
    ASSERT_SAME_DOUBLE(lasting.alpha1_rad, mixed.alpha1_rad);
    ASSERT_SAME_DOUBLE(lasting.platform_rad, mixed.platform_rad);
    ASSERT_SAME_DOUBLE(own.alpha2_rad, mixed.alpha2_rad);
    TEST_ASSERT_EQUAL_MEMORY(own.alpha3_rad, mixed.alpha3_rad, sizeof mixed.alpha3_rad);
    TEST_ASSERT_EQUAL_MEMORY(own.theta_n_rad, mixed.theta_n_rad, sizeof mixed.theta_n_rad);
    TEST_ASSERT_TRUE(own.alpha1_rad != mixed.alpha1_rad);
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

/* A block that is bolted on once has one yaw and one seat; each of its inclinations has errors of its own, of beta and of
 * the zero of the table angle with it. */
static void test_inclinations_have_errors_of_the_declared_size(void)
{
    enum { SEEDS = 20000, INCLINATIONS = 3, ERRORS = 2 * INCLINATIONS };
    double sum[ERRORS][ERRORS] = {{0.0}};
    scenario.schedule = tumble_schedule_inclined;
    scenario.stand.inclination_rad = 3.0 * 5e-3;
    scenario.stand.seat_rad = 1e-3;
    scenario.stand.law = SIM_LAW_SIGMA3;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        sim_truth_t truth;
        sim_truth_draw(&truth, &scenario, seed);
        double error[ERRORS];
        for (int m = 0; m < INCLINATIONS; m++) {
            error[m] = truth.inclination_rad[m];
            error[INCLINATIONS + m] = truth.tau_rad[m];
            ASSERT_SAME_DOUBLE(truth.alpha3_rad[0], truth.alpha3_rad[m]);
            ASSERT_SAME_DOUBLE(truth.theta_h_rad[0], truth.theta_h_rad[m]);
            ASSERT_SAME_DOUBLE(truth.theta_n_rad[0], truth.theta_n_rad[m]);
        }
        for (int i = 0; i < ERRORS; i++) {
            for (int j = 0; j < ERRORS; j++) {
                sum[i][j] += error[i] * error[j] / (double)SEEDS;
            }
        }
    }
    for (int i = 0; i < ERRORS; i++) {
        for (int j = 0; j < ERRORS; j++) {
            const bool varies = (i == j) && (i != INCLINATIONS); /* the zero at the first one is the table's: alpha2 */
            TEST_ASSERT_DOUBLE_WITHIN(4.0 * 25e-6 / sqrt(SEEDS / 2.0), varies ? 25e-6 : 0.0, sum[i][j]);
        }
    }
}

/* That mountings are inclinations changes no number but their own errors: streams are named by the first of a bolting. */
static void test_inclinations_shift_no_other_number(void)
{
    sim_truth_t plain;
    sim_truth_t inclined;
    sim_truth_draw(&plain, &scenario, 31);
    scenario.schedule = tumble_schedule_inclined_closed;
    scenario.stand.inclination_rad = 5e-3;
    sim_truth_draw(&inclined, &scenario, 31);
    ASSERT_SAME_DOUBLE(plain.alpha1_rad, inclined.alpha1_rad);
    ASSERT_SAME_DOUBLE(plain.alpha2_rad, inclined.alpha2_rad);
    ASSERT_SAME_DOUBLE(plain.alpha3_rad[0], inclined.alpha3_rad[3]);
    TEST_ASSERT_EQUAL_MEMORY(&plain.block, &inclined.block, sizeof plain.block);
    ASSERT_SAME_DOUBLE(0.0, plain.inclination_rad[1]);
    ASSERT_SAME_DOUBLE(0.0, plain.tau_rad[1]);
    sim_truth_t again = inclined;
    sim_truth_incline(&again, &scenario, 2);
    TEST_ASSERT_TRUE(again.inclination_rad[2] != inclined.inclination_rad[2] &&
                     again.tau_rad[2] != inclined.tau_rad[2]);
    ASSERT_SAME_DOUBLE(inclined.inclination_rad[3], again.inclination_rad[3]);
    ASSERT_SAME_DOUBLE(inclined.alpha3_rad[2], again.alpha3_rad[2]);
}

static void cross(const double a[3], const double b[3], double product[3])
{
    for (int i = 0; i < 3; i++) {
        product[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
}

/* The force on the axes of a block that turns by the small angles `w`: to second order. */
static void turn_block(const double w[3], double force[3])
{
    double once[3];
    double twice[3];
    cross(force, w, once);
    cross(once, w, twice);
    for (int i = 0; i < 3; i++) {
        force[i] += once[i] + twice[i] / 2.0;
    }
}

static void force_at(const sim_truth_t *truth, const tumble_position_t *position, double force[3])
{
    const uint8_t m = (uint8_t)(position->mounting - 1U);
    const sim_seat_t seat = sim_truth_seat(truth, &scenario, m);
    sim_geometry_t geometry;
    sim_geometry_init(&geometry, &tumble_schedule_inclined.mountings[m], &seat);
    sim_geometry_force(&geometry, position->angle.deg, force);
}

/* The block's weight at the end of an arm, in h, n, v: its torque turns the block, by so much for each g. Across the axis
 * the arm is along the axis, from the table to the near end; along the axis it is v, from the platform to the block. */
static void test_the_block_sags_by_the_torque_of_its_weight(void)
{
    static const struct {
        double across;
        double along;
        double arm[3];
        double weighs[3];
    } CASES[] = {{1e-4, 0.0, {0.0, -1e-4, 0.0}, {-1.0, 0.0, -1.0}}, {0.0, 2e-4, {0.0, 0.0, 2e-4}, {0.0, -1.0, 0.0}}};
    scenario.schedule = tumble_schedule_inclined;
    scenario.stand.remount_rad = 0.0; /* the block's axes are the table's then */
    scenario.stand.inclination_rad = 5e-2;
    for (size_t n = 0; n < COUNT_OF(CASES) * tumble_schedule_inclined.position_count; n++) {
        const size_t c = n % COUNT_OF(CASES);
        const tumble_position_t *const position = &tumble_schedule_inclined.positions[n / COUNT_OF(CASES)];
        sim_truth_t truth;
        double expected[3];
        double sagging[3];
        double weight[3];
        double w[3];
        scenario.stand.sag_across_rad_per_g = scenario.stand.sag_along_rad_per_g = 0.0;
        sim_truth_draw(&truth, &scenario, 5);
        force_at(&truth, position, expected);
        scenario.stand.sag_across_rad_per_g = CASES[c].across;
        scenario.stand.sag_along_rad_per_g = CASES[c].along;
        force_at(&truth, position, sagging);
        for (int i = 0; i < 3; i++) {
            weight[i] = CASES[c].weighs[i] * expected[i];
        }
        cross(CASES[c].arm, weight, w);
        turn_block(w, expected);
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(2e-12, expected[i], sagging[i]);
        }
    }
}
