/* The table's mechanics: settling, angle error, encoder, jam and slip. */
#include "simulation/axis.h"
#include "simulation/maths.h"
#include "support.h"

#include <math.h>

static const sim_axis_config_t CONFIG = {
    .swing_deg = 0.02, .swing_hz = 8.0, .settling_s = 0.5, .resolution_deg = 0.001};
static const sim_axis_dynamics_t DYNAMICS = {90.0, 180.0, 180.0};
static const double ERROR_LIMIT = 1e-3;

static sim_angle_error_t error;
static sim_axis_t axis;

static void set_up(void)
{
    sim_angle_error_init(&error, 11, &tumble_schedule_paper, SIM_LAW_SIGMA1, ERROR_LIMIT);
    sim_axis_init(&axis, &CONFIG, &error, 0.0);
}

static double first_draw(uint32_t position)
{
    sim_random_t stream;
    sim_random_open(&stream, 11, SIM_CAUSE_ANGLE, position);
    return sim_law_draw(SIM_LAW_SIGMA1, ERROR_LIMIT, &stream);
}

/* A exp(-t/tau) sin(2 pi f t) from the moment the motion ends, tau = settling / ln 1000. */
static void test_settling_is_the_stated_oscillation(void)
{
    sim_axis_move(&axis, 0, 45.0, &DYNAMICS);
    const uint64_t end_us = sim_axis_end_us(&axis);
    TEST_ASSERT_EQUAL_UINT64(1000000, end_us);
    const double tau = 0.5 / log(1000.0);
    for (uint64_t t_us = 0; t_us < 2000000; t_us += 12345) {
        const double t = (double)t_us * 1e-6;
        const double swing = 0.02 * exp(-t / tau) * sin(2.0 * SIM_PI * 8.0 * t);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 45.0 + swing, sim_axis_encoder_deg(&axis, end_us + t_us));
    }
    TEST_ASSERT_FALSE(sim_axis_is_still(&axis, end_us + 1999999));
    TEST_ASSERT_TRUE(sim_axis_is_still(&axis, end_us + 2000000));
    ASSERT_SAME_DOUBLE(45.0, sim_axis_encoder_deg(&axis, end_us + 2000000));
}

/* From quiet_us on the encoder never leaves the window again, and shortly before it the envelope is still outside. */
static void test_quiet_is_when_the_window_is_not_left_any_more(void)
{
    sim_axis_move(&axis, 0, 90.0, &DYNAMICS);
    static const double WINDOWS[] = {0.01, 0.003, 0.0005, 1e-5};
    for (size_t w = 0; w < COUNT_OF(WINDOWS); w++) {
        const uint64_t quiet_us = sim_axis_quiet_us(&axis, WINDOWS[w]);
        for (uint64_t t_us = quiet_us; t_us < quiet_us + 1000000; t_us += 777) {
            TEST_ASSERT_TRUE(fabs(sim_axis_encoder_deg(&axis, t_us) - 90.0) <= WINDOWS[w]);
        }
        const double tau = 0.5 / log(1000.0);
        const double envelope = 0.02 * exp(-(double)(quiet_us - sim_axis_end_us(&axis)) * 1e-6 / tau);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * WINDOWS[w], WINDOWS[w], envelope);
    }
    TEST_ASSERT_EQUAL_UINT64(sim_axis_end_us(&axis), sim_axis_quiet_us(&axis, 0.02));
}

static void test_the_angle_error_is_one_draw_per_arrival(void)
{
    const uint64_t late_us = 20000000;
    error.position = 1; /* 45 degrees */
    sim_axis_move(&axis, 0, 45.0, &DYNAMICS);
    const double drawn = first_draw(1);
    ASSERT_SAME_DOUBLE(drawn, sim_axis_error_rad(&axis));
    TEST_ASSERT_DOUBLE_WITHIN(1e-13, 45.0 + drawn * SIM_DEG_PER_RAD, sim_axis_actual_deg(&axis, late_us));
    ASSERT_SAME_DOUBLE(45.0, sim_axis_encoder_deg(&axis, late_us)); /* the encoder does not see it */
    sim_axis_move(&axis, late_us, 45.0, &DYNAMICS);                 /* nowhere to go: nothing drawn */
    ASSERT_SAME_DOUBLE(drawn, sim_axis_error_rad(&axis));
    sim_axis_move(&axis, late_us, 40.0, &DYNAMICS); /* in between: another stream */
    TEST_ASSERT_TRUE(sim_axis_error_rad(&axis) != drawn);
    sim_axis_move(&axis, 2 * late_us, 45.0, &DYNAMICS); /* again: the stream's second draw */
    sim_random_t stream;
    sim_random_open(&stream, 11, SIM_CAUSE_ANGLE, 1);
    (void)sim_random_u64(&stream);
    ASSERT_SAME_DOUBLE(sim_law_draw(SIM_LAW_SIGMA1, ERROR_LIMIT, &stream), sim_axis_error_rad(&axis));
}

/* One draw more elsewhere shifts nothing; whole turns do not matter. */
static void test_positions_have_streams_of_their_own(void)
{
    error.position = 0;
    sim_axis_move(&axis, 0, -5.0, &DYNAMICS);
    sim_axis_move(&axis, 10000000, 3.0, &DYNAMICS);
    error.position = 8; /* 360 degrees */
    sim_axis_move(&axis, 20000000, 720.0, &DYNAMICS);
    ASSERT_SAME_DOUBLE(first_draw(8), sim_axis_error_rad(&axis));
    error.position = 6;                                  /* 270 degrees */
    sim_axis_move(&axis, 40000000, -90.0005, &DYNAMICS); /* within half a count */
    ASSERT_SAME_DOUBLE(first_draw(6), sim_axis_error_rad(&axis));
}

/* Between two stops the error passes from the one's to the other's without a jump. */
static void test_the_angle_error_changes_on_the_way(void)
{
    error.position = 1;
    sim_axis_move(&axis, 0, 45.0, &DYNAMICS);
    error.position = 2;
    sim_axis_move(&axis, 10000000, 90.0, &DYNAMICS);
    double velocity;
    const double commanded = sim_axis_commanded_deg(&axis, 10500000, &velocity);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 67.5, commanded);
    const double between = 0.5 * (first_draw(1) + first_draw(2)) * SIM_DEG_PER_RAD;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, commanded + between, sim_axis_actual_deg(&axis, 10500000));
}

static void assert_extent(uint64_t now_us, double lowest_deg, double highest_deg)
{
    double lowest;
    double highest;
    sim_axis_extent(&axis, now_us, &lowest, &highest);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, lowest_deg, lowest);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, highest_deg, highest);
}

static void test_a_stop_leaves_the_table_where_it_is(void)
{
    sim_axis_move(&axis, 0, 360.0, &DYNAMICS);
    sim_axis_stop(&axis, 1000000, 360.0);
    double velocity;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 67.5 + 90.0 * 90.0 / 720.0, axis.motion.end_position);
    TEST_ASSERT_EQUAL_UINT64(1250000, sim_axis_end_us(&axis));
    (void)sim_axis_commanded_deg(&axis, 1250000, &velocity);
    ASSERT_SAME_DOUBLE(0.0, velocity);
    assert_extent(1250000, 0.0, axis.motion.end_position); /* it had been told to go to 360 */
}

/* On the way as far as it has come; back past the start with its turning point; and not what was only planned. */
static void test_the_extent_is_what_the_table_has_passed(void)
{
    double velocity;
    assert_extent(0, 0.0, 0.0);
    sim_axis_move(&axis, 0, 360.0, &DYNAMICS);
    assert_extent(1000000, 0.0, sim_axis_commanded_deg(&axis, 1000000, &velocity));
    sim_axis_move(&axis, 1000000, -90.0, &DYNAMICS); /* at 67.5 with 90 degrees/s: brakes until 90 */
    assert_extent(1250000, 0.0, sim_axis_commanded_deg(&axis, 1250000, &velocity));
    assert_extent(2000000, 0.0, 90.0);
    assert_extent(60000000, -90.0, 90.0);
    sim_axis_move(&axis, 60000000, -180.0, &DYNAMICS);
    sim_axis_move(&axis, 60000000, 0.0, &DYNAMICS);
    assert_extent(120000000, -90.0, 90.0);
}

static void test_what_the_motor_does_in_a_jam_is_no_extent(void)
{
    sim_axis_move(&axis, 0, 90.0, &DYNAMICS);
    sim_axis_jam(&axis, 500000, true);
    assert_extent(9000000, 0.0, 22.5);
    sim_axis_move(&axis, 9000000, -90.0, &DYNAMICS);
    assert_extent(20000000, 0.0, 22.5);
    sim_axis_jam(&axis, 20000000, false);
    assert_extent(20000000, -90.0, 22.5);
}

static void test_a_jam_holds_the_table_and_lets_go(void)
{
    sim_axis_move(&axis, 0, 90.0, &DYNAMICS);
    sim_axis_jam(&axis, 500000, true);
    const double held = sim_axis_encoder_deg(&axis, 500000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 22.5, held);
    ASSERT_SAME_DOUBLE(held, sim_axis_encoder_deg(&axis, 5000000));
    TEST_ASSERT_DOUBLE_WITHIN(0.2, held, sim_axis_actual_deg(&axis, 5000000));
    sim_axis_jam(&axis, 6000000, false);
    ASSERT_SAME_DOUBLE(90.0, sim_axis_encoder_deg(&axis, 9000000));
}

/* A way of one rounding is no rule to extrapolate the angle error by. */
static void test_a_jam_off_the_way_has_the_error_of_the_nearer_stop(void)
{
    sim_axis_move(&axis, 0, 90.0, &DYNAMICS);
    sim_axis_jam(&axis, 500000, true);
    sim_axis_move(&axis, 9000000, nextafter(90.0, 180.0), &DYNAMICS);
    const double held = sim_axis_encoder_deg(&axis, 9000000);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * ERROR_LIMIT * SIM_DEG_PER_RAD, held, sim_axis_actual_deg(&axis, 9000000));
    sim_axis_move(&axis, 10000000, 45.0, &DYNAMICS);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * ERROR_LIMIT * SIM_DEG_PER_RAD, held, sim_axis_actual_deg(&axis, 20000000));
}

static void test_slip_moves_the_table_and_perhaps_the_encoder(void)
{
    const double before = sim_axis_actual_deg(&axis, 0);
    sim_axis_slip(&axis, 0.5, false);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, before + 0.5, sim_axis_actual_deg(&axis, 0));
    ASSERT_SAME_DOUBLE(0.0, sim_axis_encoder_deg(&axis, 0));
    sim_axis_slip(&axis, 0.25, true);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, before + 0.75, sim_axis_actual_deg(&axis, 0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25, sim_axis_encoder_deg(&axis, 0));
}

/* Against the play followed in small steps: the motor takes the table along at either end of it, and nowhere else. */
static void test_backlash_is_the_way_lost_at_every_reversal(void)
{
    sim_axis_config_t config = CONFIG;
    config.backlash_deg = 0.3;
    config.swing_deg = 0.0;
    sim_angle_error_init(&error, 11, &tumble_schedule_paper, SIM_LAW_SIGMA1, 0.0);
    sim_axis_init(&axis, &config, &error, 0.0);
    static const double TARGETS_DEG[] = {90.0, 89.9, 89.95, 40.0, 40.2, 41.0, -5.0, 0.0};
    double table_deg = 0.0;
    uint64_t now_us = 0;
    for (size_t i = 0; i < COUNT_OF(TARGETS_DEG); i++) {
        sim_axis_move(&axis, now_us, TARGETS_DEG[i], &DYNAMICS);
        const uint64_t end_us = (i == 3U) ? now_us + 300000U : sim_axis_end_us(&axis); /* one is replaced on its way */
        for (; now_us < end_us; now_us += 50) {
            const double motor_deg = sim_axis_encoder_deg(&axis, now_us);
            table_deg = (table_deg < motor_deg) ? motor_deg : table_deg;
            table_deg = (table_deg > motor_deg + 0.3) ? motor_deg + 0.3 : table_deg;
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, table_deg, sim_axis_actual_deg(&axis, now_us));
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, sim_axis_actual_deg(&axis, now_us));
    sim_axis_move(&axis, now_us, -9.0, &DYNAMICS);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -8.7, sim_axis_actual_deg(&axis, sim_axis_end_us(&axis)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -9.0, sim_axis_encoder_deg(&axis, sim_axis_end_us(&axis)));
}
